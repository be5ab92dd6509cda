//! Programs that run cases and tell of them.

use crate::{Case, Check, Extent, Findings, Table};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Runs the cases that the program's arguments choose (`[--readme] [--pictures DIRECTORY] [part of a
/// name]...`) and prints a table, or with `--readme` a page that opens with `introduction`.
pub fn program(cases: &[Case], introduction: &str) -> ExitCode {
    let (mut readme, mut pictures, mut parts) = (false, None, Vec::new());
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--readme" => readme = true,
            "--pictures" => match arguments.next() {
                Some(directory) => pictures = Some(PathBuf::from(directory)),
                None => {
                    eprintln!("--pictures needs a directory");
                    return ExitCode::FAILURE;
                }
            },
            part => parts.push(part.to_owned()),
        }
    }
    let named = |case: &&Case| parts.is_empty() || parts.iter().any(|part| case.name.contains(part));
    let chosen: Vec<&Case> = cases.iter().filter(named).collect();
    if chosen.is_empty() {
        eprintln!("no case is called so; there are:");
        cases.iter().for_each(|case| eprintln!("  {}", case.name));
        return ExitCode::FAILURE;
    }

    println!("{}", if readme { introduction } else { TABLE });
    let failures: usize = chosen.into_iter().map(|case| tell(case, readme, pictures.as_deref())).sum();
    if failures == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

const TABLE: &str = "| case | what is compared | error | tolerance | | remark |\n|---|---|---|---|---|---|";

/// Prints the rows of a case, or its section of the README, and draws its pictures; returns the
/// number of failures.
fn tell(case: &Case, readme: bool, pictures: Option<&Path>) -> usize {
    if readme {
        println!("\n## {}\n", case.name);
        println!("*Goal.* {}\n\n*Setup.* {}\n\n*Reference.* {}\n", case.goal, case.setup, case.reference);
        println!("| what is compared | error | tolerance | | remark |\n|---|---|---|---|---|");
    }
    let before = if readme { String::new() } else { format!("| {} ", case.name) };
    let clock = Instant::now();
    let found = (case.run)(Extent::Full);
    eprintln!("{}: {:.1} s", case.name, clock.elapsed().as_secs_f64());
    let Findings { checks, tables, pictures: drawn } = match found {
        Ok(findings) => findings,
        Err(broken) => {
            println!("{before}| could not be carried out: {broken} | | | FAIL | |");
            return 1;
        }
    };
    checks.iter().for_each(|check| println!("{before}{}", row(check)));
    let mut failures = checks.iter().filter(|check| !check.passes()).count();
    if readme {
        tables.iter().for_each(print_table);
        for picture in &drawn {
            println!("\n![{}](../docs/pictures/{})\n\n{}", picture.caption, picture.file, picture.caption);
        }
    }
    if let Some(directory) = pictures {
        for picture in &drawn {
            if let Err(reason) = picture.save(directory) {
                eprintln!("{}: {reason}", picture.file);
                failures += 1;
            }
        }
    }
    failures
}

fn row(check: &Check) -> String {
    let Check { what, error, tolerance, remark } = check;
    let verdict = if check.passes() { "pass" } else { "FAIL" };
    format!("| {what} | {error:.1e} | {tolerance:.0e} | {verdict} | {remark} |")
}

fn print_table(table: &Table) {
    println!("\n{}\n\n| {} |\n|{}", table.text, table.heads.join(" | "), "---|".repeat(table.heads.len()));
    table.rows.iter().for_each(|row| println!("| {} |", row.join(" | ")));
}

//! Programs that run cases and tell of them.

use crate::html::{self, Told};
use crate::{Case, Check, Extent, Findings, Table};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Runs the cases that the program's arguments choose (`[--readme] [--quick] [--list] [--pictures DIRECTORY]
/// [--report FILE] [part of a name]...`) and prints a table, or with `--readme` a page that opens with
/// `introduction`.
pub fn program(cases: &'static [Case], introduction: &str) -> ExitCode {
    let (mut readme, mut pictures, mut report, mut parts) = (false, None, None, Vec::new());
    let mut extent = Extent::Full;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--readme" => readme = true,
            "--quick" => extent = Extent::Tests,
            "--list" => {
                cases.iter().for_each(|case| println!("{}", case.name));
                return ExitCode::SUCCESS;
            }
            "--report" => match arguments.next() {
                Some(file) => report = Some(PathBuf::from(file)),
                None => {
                    eprintln!("--report needs a file");
                    return ExitCode::from(2);
                }
            },
            option if option.starts_with("--") && option != "--pictures" => {
                eprintln!("unknown option {option}; there are --readme, --quick, --list, --pictures, --report");
                return ExitCode::from(2);
            }
            "--pictures" => match arguments.next() {
                Some(directory) => pictures = Some(PathBuf::from(directory)),
                None => {
                    eprintln!("--pictures needs a directory");
                    return ExitCode::from(2);
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
        return ExitCode::from(2);
    }
    // What takes an hour should not be lost to a wrong path.
    if let Some(Err(error)) = report.as_ref().map(std::fs::File::create) {
        eprintln!("cannot write the report: {error}");
        return ExitCode::from(2);
    }

    println!("{}", if readme { introduction } else { TABLE });
    let mut failures = 0;
    let mut told = Vec::new();
    for case in chosen {
        let (failed, it) = tell(case, extent, readme, pictures.as_deref());
        failures += failed;
        told.push(it);
    }
    if let Some(file) = report {
        let page = html::page(title(introduction), &told, extent).map_err(|error| error.to_string());
        let written = page.and_then(|page| std::fs::write(&file, page).map_err(|error| error.to_string()));
        match written {
            Ok(()) => eprintln!("{}", file.display()),
            Err(reason) => {
                eprintln!("{}: {reason}", file.display());
                failures += 1;
            }
        }
    }
    if failures == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// The head of a page in Markdown.
fn title(introduction: &str) -> &str {
    introduction.lines().next().unwrap_or_default().trim_start_matches(['#', ' '])
}

const TABLE: &str = "| case | what is compared | error | tolerance | | remark |\n|---|---|---|---|---|---|";

/// Carries out a case, prints its rows or its section of the README, and draws its pictures; returns the
/// number of failures and what is to be told.
fn tell(case: &'static Case, extent: Extent, readme: bool, pictures: Option<&Path>) -> (usize, Told) {
    if readme {
        println!("\n## {}\n", case.name);
        println!("*Goal.* {}\n\n*Setup.* {}\n\n*Reference.* {}\n", case.goal, case.setup, case.reference);
        println!("| what is compared | error | tolerance | | remark |\n|---|---|---|---|---|");
    }
    let before = if readme { String::new() } else { format!("| {} ", case.name) };
    let clock = Instant::now();
    let found = (case.run)(extent);
    let time = clock.elapsed();
    eprintln!("{}: {:.1} s", case.name, time.as_secs_f64());
    let found = match found {
        Ok(findings) => findings,
        Err(broken) => {
            println!("{before}| could not be carried out: {broken} | | | FAIL | |");
            return (1, Told { case, found: Err(broken.to_string()), time });
        }
    };
    let Findings { checks, tables, pictures: drawn } = &found;
    checks.iter().for_each(|check| println!("{before}{}", row(check)));
    let mut failures = checks.iter().filter(|check| !check.passes()).count();
    if readme {
        tables.iter().for_each(print_table);
        for picture in drawn {
            println!("\n![{}](../docs/pictures/{})\n\n{}", picture.caption, picture.file, picture.caption);
        }
    }
    if let Some(directory) = pictures {
        for picture in drawn {
            if let Err(reason) = picture.save(directory) {
                eprintln!("{}: {reason}", picture.file);
                failures += 1;
            }
        }
    }
    (failures, Told { case, found: Ok(found), time })
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

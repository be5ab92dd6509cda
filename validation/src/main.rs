//! Runs the validation cases: `mpm-validation [--readme] [--pictures DIRECTORY] [part of a name]...`
//! prints a table, or with `--readme` the text of the README, and draws the pictures.

use mpm_validation::{CASES, Case, Check, Extent, Findings, Table};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

fn main() -> ExitCode {
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
    let chosen: Vec<&Case> = CASES.iter().filter(named).collect();
    if chosen.is_empty() {
        eprintln!("no case is called so; there are:");
        CASES.iter().for_each(|case| eprintln!("  {}", case.name));
        return ExitCode::FAILURE;
    }

    println!("{}", if readme { INTRODUCTION } else { TABLE });
    let failures: usize = chosen.into_iter().map(|case| tell(case, readme, pictures.as_deref())).sum();
    if failures == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

const INTRODUCTION: &str = "# Validation

What the code computes, against what it should. `cargo run --release -p mpm-validation` runs all
cases and prints one table (with words as arguments: the cases whose names hold one of them);
`--pictures docs/pictures` draws the pictures as well. `cargo test --release -p mpm-validation` runs
the same functions as tests, the coarse meshes only, and checks that this page tells of every
comparison. The page is printed by `cargo run --release -p mpm-validation -- --readme`.

Tables of reference values are in `reference/`, each saying how it was obtained; closed forms are
in `src/analytic.rs`. Scenes are in `../scenes/` and, where they serve no other purpose, in
`scenes/`; variants (basis, points, mesh, load steps) are made of them in `src/variants.rs`. Where an
error counts exceptions the tolerance is zero. \"Patch test\" needs a word: with standard MPM the
points are the integration points, so it can only be passed where the points of neighbouring cells
balance, that is while each full cell holds an even grid of them.";

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

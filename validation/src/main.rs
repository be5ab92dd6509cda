//! Runs the validation cases and prints the table: `mpm-validation [part of a name]...`, or with
//! `--readme` prints the text of the README.

use mpm_validation::{CASES, Case, Check};
use std::process::ExitCode;
use std::time::Instant;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let readme = arguments == ["--readme"];
    let chosen: Vec<&Case> = CASES
        .iter()
        .filter(|case| readme || arguments.is_empty() || arguments.iter().any(|part| case.name.contains(part)))
        .collect();
    if chosen.is_empty() {
        eprintln!("no case is called so; there are:");
        CASES.iter().for_each(|case| eprintln!("  {}", case.name));
        return ExitCode::FAILURE;
    }

    println!("{}", if readme { INTRODUCTION } else { TABLE });
    let failures: usize = chosen.into_iter().map(if readme { tell } else { show }).sum();
    if failures == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

const INTRODUCTION: &str = "# Validation

What the code computes, against what it should. `cargo run --release -p mpm-validation` runs all
cases and prints one table (with words as arguments: the cases whose names hold one of them);
`cargo test --release -p mpm-validation` runs the same functions as tests and checks that this page
tells of every comparison. The page is printed by `cargo run --release -p mpm-validation -- --readme`.

Tables of reference values are in `reference/`, each saying how it was obtained; closed forms are
in `src/analytic.rs`. Scenes are in `../scenes/` and, where they serve no other purpose, in
`scenes/`. Where an error counts exceptions the tolerance is zero. \"Patch test\" needs a word: with
standard MPM the points are the integration points, so it can only be passed where the points of
neighbouring cells balance, that is while each full cell holds an even grid of them.";

const TABLE: &str = "| case | what is compared | error | tolerance | | remark |\n|---|---|---|---|---|---|";

/// Prints the rows of a case; returns the number of failures.
fn show(case: &Case) -> usize {
    print(case, &format!("| {} ", case.name))
}

/// Prints the section of a case; returns the number of failures.
fn tell(case: &Case) -> usize {
    println!("\n## {}\n", case.name);
    println!("*Goal.* {}\n\n*Setup.* {}\n\n*Reference.* {}\n", case.goal, case.setup, case.reference);
    println!("| what is compared | error | tolerance | | remark |\n|---|---|---|---|---|");
    print(case, "")
}

fn print(case: &Case, before: &str) -> usize {
    let clock = Instant::now();
    let checks = (case.run)();
    eprintln!("{}: {:.1} s", case.name, clock.elapsed().as_secs_f64());
    match checks {
        Ok(checks) => {
            checks.iter().for_each(|check| println!("{before}{}", row(check)));
            checks.iter().filter(|check| !check.passes()).count()
        }
        Err(broken) => {
            println!("{before}| could not be carried out: {broken} | | | FAIL | |");
            1
        }
    }
}

fn row(check: &Check) -> String {
    let Check { what, error, tolerance, remark } = check;
    let verdict = if check.passes() { "pass" } else { "FAIL" };
    format!("| {what} | {error:.1e} | {tolerance:.0e} | {verdict} | {remark} |")
}

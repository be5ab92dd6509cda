//! Runs the validation cases and prints the table: `mpm-validation [part of a name]...`.

use mpm_validation::{CASES, Case};
use std::process::ExitCode;
use std::time::Instant;

fn main() -> ExitCode {
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    let chosen: Vec<&Case> = CASES
        .iter()
        .filter(|case| wanted.is_empty() || wanted.iter().any(|part| case.name.contains(part.as_str())))
        .collect();
    if chosen.is_empty() {
        eprintln!("no case is called so; there are:");
        CASES.iter().for_each(|case| eprintln!("  {}", case.name));
        return ExitCode::FAILURE;
    }

    println!("| case | what is compared | error | tolerance | | remark |");
    println!("|---|---|---|---|---|---|");
    let failures: usize = chosen.into_iter().map(show).sum();
    if failures == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Runs a case and prints its rows; returns the number of failures.
fn show(case: &Case) -> usize {
    let clock = Instant::now();
    let checks = match (case.run)() {
        Ok(checks) => checks,
        Err(broken) => {
            println!("| {} | could not be carried out: {broken} | | | FAIL | |", case.name);
            return 1;
        }
    };
    for check in &checks {
        let verdict = if check.passes() { "pass" } else { "FAIL" };
        println!(
            "| {} | {} | {:.1e} | {:.0e} | {verdict} | {} |",
            case.name, check.what, check.error, check.tolerance, check.remark
        );
    }
    eprintln!("{}: {:.1} s", case.name, clock.elapsed().as_secs_f64());
    checks.iter().filter(|check| !check.passes()).count()
}

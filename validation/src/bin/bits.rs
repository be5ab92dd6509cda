//! Compares two builds of `mpm` bit for bit: `bits OLD NEW [part of a scene's name]...`.
//!
//! Exit codes: 0 all results are equal, 1 some differ, 2 an argument is wrong or a program cannot run a scene.

use mpm_validation::Broken;
use mpm_validation::bits::{HEAD, LEFT_OUT, compare, plans};
use std::path::PathBuf;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match run(&arguments) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}

/// Whether all results are equal.
fn run(arguments: &[String]) -> Result<bool, Broken> {
    let [old, new, parts @ ..] = arguments else {
        return Err("expected two programs: bits OLD NEW [part of a scene's name]...".into());
    };
    let program =
        |path: &String| PathBuf::from(path).canonicalize().map_err(|error| format!("program {path}: {error}"));
    let (old, new) = (program(old)?, program(new)?);
    println!("{HEAD}");
    let (mut differing, mut runs) = (Vec::new(), 0);
    for plan in plans(parts)? {
        let compared = compare(&plan, &old, &new)?;
        println!("{}", compared.row());
        runs += 1;
        if !compared.differences.is_empty() {
            differing.push(compared);
        }
    }
    let left_out = LEFT_OUT.map(|(name, what)| format!("{name} ({what})")).join(", ");
    println!("\nNot compared: {left_out}.");
    for compared in &differing {
        println!("\n{}", compared.name);
        for difference in &compared.differences {
            println!("  {difference}");
        }
    }
    match differing.len() {
        0 => println!("All {runs} runs are equal, bit for bit."),
        count => println!("\n{count} of {runs} runs differ."),
    }
    Ok(differing.is_empty())
}

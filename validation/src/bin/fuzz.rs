//! Feeds hostile input: `fuzz [--cases N] [--seed S] [--processes P] [--keep FOLDER] [scenes|checkpoints|results]...`.

use mpm_validation::Broken;
use mpm_validation::fuzz::{Plan, Target, fuzz, work};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let ended = match arguments.split_first() {
        Some((first, rest)) if first == "--work" => work(rest),
        _ => run(arguments),
    };
    ended.unwrap_or_else(|error| {
        eprintln!("{error}");
        ExitCode::from(2)
    })
}

fn run(arguments: Vec<String>) -> Result<ExitCode, Broken> {
    let (mut cases, mut seed, mut processes) = (10_000, 1, 1);
    let (mut keep, mut targets) = (PathBuf::from("target/fuzz"), Vec::new());
    let mut arguments = arguments.into_iter();
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--cases" => cases = value()?.parse()?,
            "--seed" => seed = value()?.parse()?,
            "--processes" => processes = value()?.parse()?,
            "--keep" => keep = value()?.into(),
            name => targets.push(Target::of_name(name).ok_or(format!("no target is called {name}"))?),
        }
    }
    if targets.is_empty() {
        targets.extend(Target::ALL);
    }
    let worker = std::env::current_exe()?;
    let mut clean = true;
    for target in targets {
        let clock = Instant::now();
        let report = fuzz(&Plan { target, seed, cases, processes, keep: keep.clone() }, &worker)?;
        println!("{}, seed {seed}, {:.0} s: {report}", target.name(), clock.elapsed().as_secs_f64());
        clean &= report.findings.is_empty();
    }
    Ok(if clean { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

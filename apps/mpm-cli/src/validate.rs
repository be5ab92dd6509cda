//! `mpm validate`: the validation suite, a program of its own beside this one.
//!
//! It holds scenes and references that a user of `mpm` does not need, so that `mpm` starts it instead of containing it.

use crate::complaint::Complaint;
use clap::Args;
use std::path::PathBuf;
use std::process::{Command, ExitStatus};

#[derive(Args)]
pub struct ValidateArguments {
    /// Only cases whose names hold one of these.
    names: Vec<String>,
    /// Write one HTML page of all that was found, with its curves and pictures.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Coarse meshes only: minutes instead of hours.
    #[arg(long)]
    quick: bool,
    /// List the cases.
    #[arg(long)]
    list: bool,
}

const PROGRAM: &str = "mpm-validation";

/// Runs the suite, which prints its table itself.
pub fn validate(arguments: &ValidateArguments) -> Result<(), Complaint> {
    let beside =
        std::env::current_exe().ok().map(|path| path.with_file_name(PROGRAM)).filter(|path| path.is_file());
    let mut command = Command::new(beside.unwrap_or_else(|| PROGRAM.into()));
    for (wanted, option) in [(arguments.quick, "--quick"), (arguments.list, "--list")] {
        if wanted {
            command.arg(option);
        }
    }
    if let Some(report) = &arguments.report {
        command.arg("--report").arg(report);
    }
    let status = command.args(&arguments.names).status().map_err(|error| {
        Complaint::input(format!(
            "cannot start the validation suite {PROGRAM}: {error}. It is a program of its own: build it by \
             `cargo build --release -p {PROGRAM}`, which puts it beside mpm"
        ))
    })?;
    outcome(status)
}

fn outcome(status: ExitStatus) -> Result<(), Complaint> {
    match status.code() {
        Some(0) => Ok(()),
        Some(2) => Err(Complaint::input("the validation suite refused its arguments".into())),
        _ => Err(Complaint::unfinished("a comparison of the validation failed".into())),
    }
}

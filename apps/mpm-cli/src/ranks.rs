//! The program of several ranks that share a run.

use crate::check::{self, CheckArguments};
use crate::complaint::Complaint;
use crate::crew::Crew;
use crate::reading;
use crate::run::{self, ResumeArguments, RunArguments};
use clap::{Parser, Subcommand};
use std::path::PathBuf;
use std::process::ExitCode;

/// Starts the ranks with options of their linear solver.
pub type CrewOf<'a> = &'a dyn Fn(&[String]) -> Result<Box<dyn Crew>, String>;

/// Implicit Material Point Method on many machines: `mpirun -n 4 mpm-mpi run scene.ron`.
#[derive(Parser)]
#[command(name = "mpm-mpi", version, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run a scene and write its results.
    Run {
        #[command(flatten)]
        run: RunArguments,
        /// Options of PETSc, as `-- -pc_type gamg -ksp_monitor`.
        #[arg(last = true, allow_hyphen_values = true, value_name = "PETSC")]
        petsc: Vec<String>,
    },
    /// Go on with an interrupted run, on any number of ranks, and with its results file.
    Resume {
        #[command(flatten)]
        resume: ResumeArguments,
        /// Options of PETSc, as `-- -pc_type gamg -ksp_monitor`.
        #[arg(last = true, allow_hyphen_values = true, value_name = "PETSC")]
        petsc: Vec<String>,
    },
    /// Read a scene, say how large it is and what every rank has of it; run nothing.
    Check(CheckArguments),
    /// Read a file in full and print nothing, for another process that wants to know whether HDF5 survives it.
    #[command(hide = true)]
    ReadBack {
        /// What it holds.
        kind: reading::Kind,
        /// The file.
        file: PathBuf,
    },
}

/// The program of ranks, which `start` makes one.
pub fn main_of_ranks(start: CrewOf<'_>) -> ExitCode {
    let cli = Cli::try_parse();
    if let Ok(Cli { command: Command::ReadBack { kind, file } }) = &cli {
        return ended(reading::read_back(*kind, file));
    }
    let none = Vec::new();
    let options = match &cli {
        Ok(Cli { command: Command::Run { petsc, .. } | Command::Resume { petsc, .. } }) => petsc,
        _ => &none,
    };
    let crew = match start(options) {
        Ok(crew) => crew,
        Err(reason) => return Complaint::unfinished(reason).deliver(),
    };
    match cli {
        Ok(Cli { command }) => ended(carry_out(command, &*crew)),
        Err(error) => {
            if crew.leads() {
                // If standard output or error is closed, there is nowhere to say it.
                let _ = error.print();
            }
            ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2))
        }
    }
}

fn carry_out(command: Command, crew: &dyn Crew) -> Result<(), Complaint> {
    match command {
        Command::Run { run, .. } => run::run(&run, crew),
        Command::Resume { resume, .. } => run::resume(&resume, crew),
        Command::Check(arguments) => check::check(&arguments, crew),
        Command::ReadBack { .. } => unreachable!("done before the ranks start"),
    }
}

fn ended(done: Result<(), Complaint>) -> ExitCode {
    done.map_or_else(|complaint| complaint.deliver(), |()| ExitCode::SUCCESS)
}

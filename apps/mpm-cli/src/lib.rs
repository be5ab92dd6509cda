//! The command line of the implicit Material Point Method.
//!
//! Scenes in (`new`, `check`, `run`, `resume`, `sweep`), results out (`inspect`, `plot`, `export`).
//! [`main`] is the program `mpm`, [`main_of_ranks`] that of several ranks which share a run: the same commands, messages and
//! exit codes.
//!
//! Exit codes: 0 done, 1 the simulation could not finish, 2 the scene, a path or an argument is wrong.

mod check;
mod complaint;
mod crew;
mod drive;
mod export;
mod input;
mod inspect;
mod keeper;
mod offered;
mod plot;
mod previous;
mod ranks;
mod reading;
mod reference;
mod report;
mod run;
mod say;
mod sweep;
mod templates;
mod terminal;
mod validate;
mod watch;

use clap::{CommandFactory, Parser, Subcommand};
use crew::Alone;
use say::say;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

pub use complaint::Complaint;
pub use crew::Crew;
pub use ranks::{CrewOf, main_of_ranks};

/// Implicit Material Point Method: finite-strain statics of solids that deform without bound.
#[derive(Parser)]
#[command(name = "mpm", version, max_term_width = 100, after_long_help = include_str!("manual.txt"))]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Write a scene to begin with, from a template.
    New(templates::NewArguments),
    /// Run a scene and write its results.
    Run(run::RunArguments),
    /// Go on with an interrupted run, bit for bit, and with its results file.
    Resume(run::ResumeArguments),
    /// Read a scene, say how large it is and what it will not need; run nothing.
    Check(check::CheckArguments),
    /// Run a scene over a grid of values, in parallel, and print one table of results.
    Sweep(sweep::SweepArguments),
    /// Drive one material point of a law along a path, and print it.
    Drive(drive::DriveArguments),
    /// Say what a results file holds: status, load steps, ranges of columns and fields, time, what was skipped.
    Inspect {
        /// The results file, of a finished, running, failed or killed run.
        results: PathBuf,
        /// Print it as JSON for machines.
        #[arg(long)]
        json: bool,
    },
    /// Draw a results file: the body coloured by a field, reactions, moments, convergence.
    Plot(plot::PlotArguments),
    /// Write results as CSV tables or as VTU files.
    Export(export::ExportArguments),
    /// Run the validation suite: closed forms, references, what must not change; print its table.
    Validate(validate::ValidateArguments),
    /// Read a file in full and print nothing, for another process that wants to know whether HDF5 survives it.
    #[command(hide = true)]
    ReadBack {
        /// What it holds.
        kind: reading::Kind,
        /// The file.
        file: PathBuf,
    },
    /// Print the language of scenes as a JSON schema.
    Schema {
        /// Print it as Markdown for people.
        #[arg(long)]
        markdown: bool,
        /// Print that of the files of `mpm drive` instead.
        #[arg(long)]
        drive: bool,
    },
    /// Print a script that completes the program's arguments in a shell.
    Completions {
        /// The shell.
        shell: clap_complete::Shell,
    },
    /// Print the manual page of the program, or write those of all its commands.
    Man {
        /// Folder for the pages, which must be there.
        #[arg(short, long, value_name = "FOLDER")]
        output: Option<PathBuf>,
    },
}

/// The program `mpm`.
pub fn main() -> ExitCode {
    let done = match Cli::parse().command {
        Command::Run(arguments) => run::run(&arguments, &Alone),
        Command::Resume(arguments) => run::resume(&arguments, &Alone),
        Command::New(arguments) => templates::new(&arguments).and_then(|text| say(&text)),
        Command::Check(arguments) => check::check(&arguments, &Alone),
        Command::Sweep(arguments) => sweep::sweep(&arguments),
        Command::Drive(arguments) => drive::drive(&arguments),
        Command::Inspect { results, json } => {
            reading::apart(&results, || inspect::inspect(&results, json).and_then(|text| say(&text)))
        }
        Command::Plot(arguments) => {
            reading::apart(&arguments.results[0], || plot::plot(&arguments).and_then(|text| say(&text)))
        }
        Command::Export(arguments) => {
            reading::apart(&arguments.results, || export::export(&arguments).and_then(|text| say(&text)))
        }
        Command::ReadBack { kind, file } => reading::read_back(kind, &file),
        Command::Validate(arguments) => validate::validate(&arguments),
        Command::Completions { shell } => completions(shell),
        Command::Man { output } => manual(output.as_deref()),
        Command::Schema { markdown, drive } => say(&match (markdown, drive) {
            (true, false) => reference::markdown(),
            (true, true) => reference::markdown_of_drive(),
            (false, false) => reference::json(),
            (false, true) => reference::json_of_drive(),
        }),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(complaint) => complaint.deliver(),
    }
}

fn completions(shell: clap_complete::Shell) -> Result<(), Complaint> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "mpm", &mut script);
    say(&String::from_utf8_lossy(&script))
}

fn manual(folder: Option<&Path>) -> Result<(), Complaint> {
    if let Some(folder) = folder {
        return clap_mangen::generate_to(Cli::command(), folder).map_err(|error| {
            Complaint::input(format!("cannot write manual pages to {}: {error}", folder.display()))
        });
    }
    let mut page = Vec::new();
    clap_mangen::Man::new(Cli::command())
        .render(&mut page)
        .map_err(|error| Complaint::unfinished(format!("cannot print the manual page: {error}")))?;
    say(&String::from_utf8_lossy(&page))
}

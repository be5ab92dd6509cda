//! The command line: `mpm run`, `mpm check` and `mpm schema`.
//!
//! Exit codes: 0 done, 1 the simulation could not finish, 2 the scene, a path or an argument is wrong.

mod check;
mod complaint;
mod input;
mod reference;
mod report;
mod run;
mod watch;

use clap::{Args, Parser, Subcommand};
use complaint::Complaint;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Implicit Material Point Method: finite-strain statics of solids that deform without bound.
#[derive(Parser)]
#[command(name = "mpm", version, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run a scene and write its results.
    Run(RunArguments),
    /// Read a scene, say how large it is and what it will not need; run nothing.
    Check {
        /// The scene, a RON file (its language: scenes/README.md, or `mpm schema --markdown`).
        scene: PathBuf,
    },
    /// Print the language of scenes as a JSON schema.
    Schema {
        /// Print it as Markdown for people.
        #[arg(long)]
        markdown: bool,
    },
}

#[derive(Args)]
struct RunArguments {
    /// The scene, a RON file (its language: scenes/README.md, or `mpm schema --markdown`).
    scene: PathBuf,
    /// Results file; an .xdmf file is written beside it [default: the scene's name with .h5, in this directory].
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Number of threads; never changes a result [default: one per core].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Print nothing unless something is wrong.
    #[arg(short, long)]
    quiet: bool,
}

fn main() -> ExitCode {
    let done = match Cli::parse().command {
        Command::Run(arguments) => run::run(&arguments),
        Command::Check { scene } => check::check(&scene),
        Command::Schema { markdown: true } => say(&reference::markdown()),
        Command::Schema { markdown: false } => say(&reference::json()),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(complaint) => complaint.deliver(),
    }
}

/// Prints to standard output; a reader that has gone away ends the program's talk, not its work.
fn say(text: &str) -> Result<(), Complaint> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Complaint::unfinished(format!("cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}

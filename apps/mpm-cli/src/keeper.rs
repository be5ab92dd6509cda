//! Arguments of checkpoints, and signals that stop a run.

use crate::complaint::Complaint;
use clap::Args;
use mpm_io::{CheckpointHead, CheckpointInterval, Keeper};
use mpm_solver::observe::Cancellation;
use std::path::PathBuf;

/// Replace what the scene, or the checkpoint, says of checkpoints.
#[derive(Args)]
pub struct CheckpointArguments {
    /// Checkpoint file [default: beside the results, with .checkpoint.h5, or the one to go on from].
    #[arg(long, value_name = "FILE")]
    pub checkpoint: Option<PathBuf>,
    /// Keep a checkpoint after every so many load steps.
    #[arg(long, value_name = "STEPS", value_parser = clap::value_parser!(u32).range(1..))]
    pub checkpoint_every: Option<u32>,
    /// Keep a checkpoint whenever so many seconds have passed since the last.
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub checkpoint_seconds: Option<f64>,
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse::<f64>().ok().filter(|seconds| (0.001..=1e15).contains(seconds));
    seconds.ok_or_else(|| format!("expected seconds from 0.001 to 1e15, got {text}"))
}

impl CheckpointArguments {
    /// Keeps checkpoints at `path`, when the arguments or the head say.
    ///
    /// # Errors
    /// Checkpoints are asked for and cannot be written.
    pub fn keeper(&self, path: PathBuf, mut head: CheckpointHead) -> Result<Keeper, Complaint> {
        if self.checkpoint_every.is_some() || self.checkpoint_seconds.is_some() {
            head.interval =
                CheckpointInterval { steps: self.checkpoint_every, seconds: self.checkpoint_seconds };
        }
        let keeper = Keeper::new(path, head, self.checkpoint.is_some());
        keeper.map_err(|error| Complaint::input(error.to_string()))
    }
}

/// How to go on from the last checkpoint, if there is one.
pub fn advice(keeper: &Keeper) -> String {
    let command = format!("mpm resume {}", keeper.path().display());
    keeper.kept().map_or(String::new(), |step| format!("\nGo on from load step {step} with: {command}"))
}

/// Lets SIGINT and SIGTERM stop the run at its next iteration; a second signal ends the program at once.
///
/// # Errors
/// The system refuses to install the handler.
pub fn listen(cancellation: Cancellation) -> Result<(), Complaint> {
    let handler = move || {
        if cancellation.is_cancelled() {
            std::process::exit(1);
        }
        cancellation.cancel();
    };
    ctrlc::set_handler(handler)
        .map_err(|error| Complaint::unfinished(format!("cannot listen to signals: {error}")))
}

//! Writes checkpoints during a run, and when it is interrupted.

use crate::complaint::Complaint;
use clap::Args;
use mpm_io::{Checkpoint, CheckpointError, CheckpointHead, CheckpointInterval};
use mpm_scene::Scene;
use mpm_solver::State;
use mpm_solver::observe::{Cancellation, Moment};
use std::path::{Path, PathBuf};
use std::time::Instant;

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

/// When and where checkpoints are kept.
pub struct Keeper {
    path: PathBuf,
    head: CheckpointHead,
    /// Whether checkpoints were asked for. If not, one is written only when the run is interrupted.
    asked: bool,
    /// When the last one was written, or the run began.
    last: Instant,
    cancellation: Cancellation,
    /// Load step of the last one.
    kept: Option<usize>,
}

impl Keeper {
    /// Keeps checkpoints at `path`, when the arguments or the head say.
    ///
    /// # Errors
    /// Checkpoints are asked for and cannot be written.
    pub fn new(
        path: PathBuf,
        mut head: CheckpointHead,
        arguments: &CheckpointArguments,
    ) -> Result<Self, Complaint> {
        let CheckpointArguments { checkpoint, checkpoint_every, checkpoint_seconds } = arguments;
        if checkpoint_every.is_some() || checkpoint_seconds.is_some() {
            head.interval = CheckpointInterval { steps: *checkpoint_every, seconds: *checkpoint_seconds };
        }
        let asked = checkpoint.is_some() || head.interval != CheckpointInterval::default();
        if asked {
            Checkpoint::check_writable(&path).map_err(|error| Complaint::input(error.to_string()))?;
        }
        let cancellation = Cancellation::default();
        Ok(Self { path, head, asked, last: Instant::now(), cancellation, kept: None })
    }

    /// Records that the checkpoint of this load step exists already, as at the start of a resumed run.
    pub fn has_kept(&mut self, step: usize) {
        self.kept = Some(step);
    }

    /// The flag that stops the run.
    pub fn cancellation(&self) -> Cancellation {
        self.cancellation.clone()
    }

    /// Whether the state of the run is wanted now.
    pub fn wants(&self, at: Moment) -> bool {
        let CheckpointInterval { steps, seconds } = self.head.interval;
        match at {
            Moment::StageEnd(step) => self.asked && self.kept != Some(step),
            Moment::End => self.asked || self.cancellation.is_cancelled(),
            Moment::Step(step) => {
                steps.is_some_and(|every| step.is_multiple_of(every as usize))
                    || seconds.is_some_and(|least| self.last.elapsed().as_secs_f64() >= least)
            }
        }
    }

    /// Writes a checkpoint.
    ///
    /// # Errors
    /// The one before is untouched.
    pub fn write(&mut self, state: &State) -> Result<(), CheckpointError> {
        self.last = Instant::now();
        Checkpoint::write(&self.path, &self.head, state)?;
        self.kept = Some(state.progress.rows().saturating_sub(1));
        Ok(())
    }

    /// How to go on from the last checkpoint, if there is one.
    pub fn advice(&self) -> String {
        let command = format!("mpm resume {}", self.path.display());
        self.kept.map_or(String::new(), |step| format!("\nGo on from load step {step} with: {command}"))
    }
}

/// When the scene wants checkpoints.
pub fn interval(scene: &Scene) -> CheckpointInterval {
    let input = scene.output().checkpoint.as_ref();
    CheckpointInterval {
        steps: input.and_then(|it| it.every).map(|count| count.0),
        seconds: input.and_then(|it| it.seconds).map(|seconds| seconds.0),
    }
}

/// The checkpoint of the results at `path`, beside them.
pub fn beside(path: &Path) -> PathBuf {
    path.with_extension("checkpoint.h5")
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

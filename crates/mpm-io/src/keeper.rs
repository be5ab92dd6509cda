//! Writes checkpoints during a run, and when it is interrupted.

use crate::checkpoint::{Checkpoint, CheckpointHead, CheckpointInterval};
use crate::error::CheckpointError;
use mpm_scene::Scene;
use mpm_solver::State;
use mpm_solver::observe::{Cancellation, Moment};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// When and where checkpoints of a run are kept.
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
    /// Keeps checkpoints at `path` when the head says, and at the end of a run that stops early: always if the file was named
    /// by whoever runs it or the head says when, else only of a run that is interrupted.
    ///
    /// # Errors
    /// [`CheckpointError::Write`] where checkpoints are asked for and cannot be written.
    pub fn new(path: PathBuf, head: CheckpointHead, is_named: bool) -> Result<Self, CheckpointError> {
        let asked = is_named || head.interval != CheckpointInterval::default();
        if asked {
            Checkpoint::check_writable(&path)?;
        }
        let cancellation = Cancellation::default();
        Ok(Self { path, head, asked, last: Instant::now(), cancellation, kept: None })
    }

    /// The checkpoint of the results at `path`, beside them.
    pub fn beside(path: &Path) -> PathBuf {
        path.with_extension("checkpoint.h5")
    }

    /// Records that the checkpoint of this load step exists already, as at the start of a resumed run.
    pub fn has_kept(&mut self, step: usize) {
        self.kept = Some(step);
    }

    /// Load step of the last checkpoint, if there is one.
    pub fn kept(&self) -> Option<usize> {
        self.kept
    }

    /// Where checkpoints are kept.
    pub fn path(&self) -> &Path {
        &self.path
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
}

impl CheckpointInterval {
    /// When a scene wants checkpoints.
    pub fn of(scene: &Scene) -> Self {
        let input = scene.output().checkpoint.as_ref();
        Self {
            steps: input.and_then(|it| it.every).map(|count| count.0),
            seconds: input.and_then(|it| it.seconds).map(|seconds| seconds.0),
        }
    }
}

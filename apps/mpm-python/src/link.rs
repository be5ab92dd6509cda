//! What goes between the thread of a run and Python.

use crate::errors::Failure;
use mpm_solver::observe::{Column, Entry, Field};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Sender, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};

/// What the run tells.
pub(crate) enum Event {
    /// It is about to begin, with these columns of the history.
    Started(Vec<Column>),
    /// It waits after this load step.
    Step(Shown),
    /// Something that does not stop it.
    Warning(String),
    /// It is over.
    Ended(Result<Ended, Failure>),
}

/// How a run ended that did not fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ended {
    Completed,
    Stopped,
}

/// A load step, without the points.
pub(crate) struct Shown {
    /// Row of the history.
    pub index: usize,
    /// Load fraction at its end.
    pub fraction: f64,
    /// The row.
    pub row: Vec<Entry>,
    /// Relative out-of-balance force of every iterate.
    pub residuals: Vec<f64>,
    /// Number of material points.
    pub points: usize,
}

/// What Python wants.
pub(crate) enum Request {
    /// The next load step.
    Next,
    /// The end of the run.
    Stop,
    /// Numbers of the points at a load step.
    Numbers { step: usize, of: Numbers, answer: SyncSender<Vec<f64>> },
}

/// Numbers of the points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Numbers {
    /// Positions.
    Positions,
    /// A field.
    Field(Field),
}

/// The load step at which no run waits.
const NONE: usize = usize::MAX;

/// Python's end of a run: shared by the run and its load steps.
pub(crate) struct Link {
    requests: Mutex<Sender<Request>>,
    /// The load step at which the run waits.
    at: AtomicUsize,
}

impl Link {
    pub(crate) fn new(requests: Sender<Request>) -> Arc<Self> {
        Arc::new(Self { requests: Mutex::new(requests), at: AtomicUsize::new(NONE) })
    }

    /// Records that the run waits at a load step.
    pub(crate) fn waits_at(&self, step: usize) {
        self.at.store(step, Ordering::Release);
    }

    /// Lets the run go on, or end; a run that is over hears nothing.
    pub(crate) fn send(&self, request: Request) {
        self.at.store(NONE, Ordering::Release);
        let _ = self.requests.lock().unwrap_or_else(PoisonError::into_inner).send(request);
    }

    /// Numbers of the points at a load step; none if the run has gone on.
    pub(crate) fn numbers(&self, step: usize, of: Numbers) -> Option<Vec<f64>> {
        if self.at.load(Ordering::Acquire) != step {
            return None;
        }
        let (answer, numbers) = sync_channel(1);
        let request = Request::Numbers { step, of, answer };
        self.requests.lock().unwrap_or_else(PoisonError::into_inner).send(request).ok()?;
        numbers.recv().ok()
    }
}

//! Counts calls into HDF5, so that a call that never returns (on a damaged file) can be detected from another thread.

use hdf5::File;
use std::ops::Deref;
use std::sync::atomic::{AtomicU64, Ordering};

static BEGUN: AtomicU64 = AtomicU64::new(0);
static ENDED: AtomicU64 = AtomicU64::new(0);

/// Calls into HDF5 that read results files, checkpoints and tables of points since the program began.
///
/// While neither number changes and they differ, a call into HDF5 has not returned. A program that reads files of others can watch
/// both numbers from another thread, and end itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Calls {
    /// Calls begun.
    pub begun: u64,
    /// Calls that came back.
    pub ended: u64,
}

impl Calls {
    /// What they are now.
    pub fn now() -> Self {
        // Read in this order, so that a call that ends in between never seems to have ended before it began.
        let ended = ENDED.load(Ordering::SeqCst);
        Self { begun: BEGUN.load(Ordering::SeqCst), ended }
    }

    /// Whether HDF5 is at work.
    pub fn is_inside(self) -> bool {
        self.begun != self.ended
    }
}

/// A call, for as long as this lives.
#[derive(Debug)]
pub(crate) struct Call(());

impl Call {
    pub(crate) fn begin() -> Self {
        BEGUN.fetch_add(1, Ordering::SeqCst);
        Self(())
    }
}

impl Drop for Call {
    fn drop(&mut self) {
        ENDED.fetch_add(1, Ordering::SeqCst);
    }
}

/// A file whose closing counts as a call, too: fields are dropped in their order.
#[derive(Debug)]
pub(crate) struct Closing {
    _begins: Begins,
    file: File,
    _ends: Call,
}

impl Closing {
    pub(crate) fn new(file: File) -> Self {
        Self { _begins: Begins, file, _ends: Call(()) }
    }
}

impl Deref for Closing {
    type Target = File;

    fn deref(&self) -> &File {
        &self.file
    }
}

/// Begins a call where it is dropped.
#[derive(Debug)]
struct Begins;

impl Drop for Begins {
    fn drop(&mut self) {
        BEGUN.fetch_add(1, Ordering::SeqCst);
    }
}

//! What can go wrong with a results file or a checkpoint.

use std::path::{Path, PathBuf};

/// A results file that cannot be written or read, and why.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ResultsError {
    /// The file cannot be created; whatever stood at its path is untouched.
    #[error("cannot create results file {}: {reason}", path.display())]
    Create {
        /// Path of the file.
        path: PathBuf,
        /// What the operating system or HDF5 says.
        reason: String,
    },
    /// Writing failed (a full disk, say).
    #[error("cannot write {item} to results file {}: {reason}", path.display())]
    Write {
        /// Path of the file, or of the XDMF file beside it.
        path: PathBuf,
        /// What was being written.
        item: String,
        /// What the operating system or HDF5 says.
        reason: String,
    },
    /// The file cannot be opened for reading.
    #[error("cannot open results file {}: {reason}", path.display())]
    Open {
        /// Path of the file.
        path: PathBuf,
        /// What the operating system or HDF5 says.
        reason: String,
    },
    /// The file is not what it should be.
    #[error("results file {}: {item}: {reason}", path.display())]
    Malformed {
        /// Path of the file.
        path: PathBuf,
        /// The attribute, group or dataset.
        item: String,
        /// What is wrong with it.
        reason: String,
    },
    /// The file holds no such column, field, row or recorded step.
    #[error("results file {} has no {item}", path.display())]
    Missing {
        /// Path of the file.
        path: PathBuf,
        /// What was asked for.
        item: String,
    },
}

impl ResultsError {
    pub(crate) fn create(path: &Path, reason: impl ToString) -> Self {
        Self::Create { path: path.into(), reason: reason.to_string() }
    }

    pub(crate) fn write(path: &Path, item: impl ToString, reason: impl ToString) -> Self {
        Self::Write { path: path.into(), item: item.to_string(), reason: reason.to_string() }
    }

    pub(crate) fn open(path: &Path, reason: impl ToString) -> Self {
        Self::Open { path: path.into(), reason: reason.to_string() }
    }

    pub(crate) fn malformed(path: &Path, item: impl ToString, reason: impl ToString) -> Self {
        Self::Malformed { path: path.into(), item: item.to_string(), reason: reason.to_string() }
    }

    pub(crate) fn missing(path: &Path, item: impl ToString) -> Self {
        Self::Missing { path: path.into(), item: item.to_string() }
    }
}

/// A checkpoint that cannot be written or read, and why.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// The file cannot be written; whatever stood at its path is untouched.
    #[error("cannot write checkpoint {}: {reason}", path.display())]
    Write {
        /// Path of the file.
        path: PathBuf,
        /// What the operating system or HDF5 says.
        reason: String,
    },
    /// The file cannot be opened for reading.
    #[error("cannot open checkpoint {}: {reason}", path.display())]
    Open {
        /// Path of the file.
        path: PathBuf,
        /// What the operating system or HDF5 says.
        reason: String,
    },
    /// The file is not what it should be.
    #[error("checkpoint {}: {item}: {reason}", path.display())]
    Malformed {
        /// Path of the file.
        path: PathBuf,
        /// The attribute, group or dataset.
        item: String,
        /// What it is, and what was expected.
        reason: String,
    },
}

impl CheckpointError {
    pub(crate) fn malformed(path: &Path, item: &str, reason: impl ToString) -> Self {
        Self::Malformed { path: path.into(), item: item.into(), reason: reason.to_string() }
    }
}

/// The operating system's own words if HDF5 passes them on at the bottom of its error stack,
/// else HDF5's.
pub(crate) fn reason(error: &hdf5::Error) -> String {
    let stack = error.stack();
    let system = stack.iter().flat_map(|stack| stack.iter()).find_map(|frame| {
        let (_, tail) = frame.desc().split_once("error message = '")?;
        tail.split_once('\'').map(|(message, _)| message.to_owned())
    });
    system.unwrap_or_else(|| error.to_string())
}

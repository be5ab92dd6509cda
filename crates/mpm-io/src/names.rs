//! Names and versions of the formats, and of what is stored under a name.

use hdf5::types::FixedUnicode;

/// Value of the root attribute `format` of a results file.
pub(crate) const RESULTS: &str = "mpm-results";

/// Value of the root attribute `version` of a results file: a reader refuses any other.
pub(crate) const RESULTS_VERSION: i64 = 1;

/// First word of a checkpoint.
pub(crate) const CHECKPOINT: &str = "mpm-checkpoint";

/// Second word of a checkpoint: a reader refuses any other.
pub(crate) const CHECKPOINT_VERSION: u32 = 4;

/// Name of a phase as stored, NUL-padded UTF-8.
pub(crate) type PhaseName = FixedUnicode<32>;

/// The stored name of a phase.
pub(crate) fn phase_name(name: &str) -> PhaseName {
    name.parse().expect("phase names have at most 32 bytes and no NUL")
}

//! What contributions tell of the last load step.

use crate::model::NamedContribution;
use crate::observe::Entry;
use crate::ranks::{Ranks, count};
use mpm_assembly::{Recorded, RecordedValues};

/// What a contribution tells, as an entry of its column.
pub(super) fn entry(recorded: Recorded) -> Entry {
    match recorded.values {
        RecordedValues::Count(count) => Entry::Count(vec![count]),
        RecordedValues::Real(values) => Entry::Real(values),
    }
}

/// What the parts of a contribution tell together that ranks share.
pub(super) fn sum_of_ranks<const D: usize>(entry: Entry, ranks: &dyn Ranks<D>) -> Entry {
    match entry {
        Entry::Count(counts) => Entry::Count(counts.into_iter().map(|n| count(ranks, n)).collect()),
        Entry::Real(mut values) => {
            ranks.sum(&mut values);
            Entry::Real(values)
        }
    }
}

/// Entries of a contribution's columns.
pub(super) fn contribution_entries<const D: usize>(named: &NamedContribution<D>) -> Vec<Entry> {
    named.contribution.history().into_iter().map(entry).collect()
}

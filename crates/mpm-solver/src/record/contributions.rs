//! What contributions tell of the last load step.

use crate::model::NamedContribution;
use crate::observe::Entry;
use crate::ranks::{Ranks, count, largest};
use mpm_assembly::{OfParts, Recorded, RecordedValues};

/// What a contribution tells, as an entry of its column.
pub(super) fn entry(recorded: Recorded) -> Entry {
    match recorded.values {
        RecordedValues::Count(count) => Entry::Count(vec![count]),
        RecordedValues::Real(values) => Entry::Real(values),
    }
}

/// What the parts of a contribution tell together that ranks share.
fn of_ranks<const D: usize>(recorded: Recorded, ranks: &dyn Ranks<D>) -> Entry {
    let of_parts = recorded.of_parts;
    match (entry(recorded), of_parts) {
        (entry, OfParts::Same) => entry,
        (Entry::Count(counts), OfParts::Sum) => {
            Entry::Count(counts.into_iter().map(|n| count(ranks, n)).collect())
        }
        (Entry::Real(mut values), OfParts::Sum) => {
            ranks.sum(&mut values);
            Entry::Real(values)
        }
        (Entry::Count(counts), OfParts::Largest) => {
            Entry::Count(counts.into_iter().map(|n| largest(ranks, n as f64) as u64).collect())
        }
        (Entry::Real(values), OfParts::Largest) => {
            Entry::Real(values.into_iter().map(|x| largest(ranks, x)).collect())
        }
    }
}

/// Entries of a contribution's columns.
pub(super) fn contribution_entries<const D: usize>(
    named: &NamedContribution<D>,
    ranks: &dyn Ranks<D>,
) -> Vec<Entry> {
    named.contribution.history().into_iter().map(|recorded| of_ranks(recorded, ranks)).collect()
}

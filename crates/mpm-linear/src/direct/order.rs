//! An order of elimination that outlives a run.

use crate::matrix::SymmetricPattern;

/// An order of elimination and a fingerprint of the pattern that it was found for.
///
/// A pattern keeps its order while the material moves across the grid, although the order that would be
/// found for it anew may be another: a run that goes on bit for bit needs the one it had.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoredOrder {
    /// Fingerprint of the pattern.
    pub fingerprint: u64,
    /// Equations in the order of their elimination.
    pub order: Vec<usize>,
}

impl StoredOrder {
    pub(super) fn of(pattern: SymmetricPattern<'_>, order: &[usize]) -> Self {
        Self { fingerprint: fingerprint(pattern, &[]), order: order.to_vec() }
    }

    /// Whether it is the order of this pattern.
    pub(super) fn suits(&self, pattern: SymmetricPattern<'_>) -> bool {
        self.order.len() + 1 == pattern.column_start.len() && self.fingerprint == fingerprint(pattern, &[])
    }

    /// Whether every equation has one place.
    pub fn is_permutation(&self) -> bool {
        let mut seen = vec![false; self.order.len()];
        self.order
            .iter()
            .all(|&equation| seen.get_mut(equation).is_some_and(|seen| !std::mem::replace(seen, true)))
    }
}

/// FNV-1a, a number at a time, of a pattern and where its nodes stand. Two patterns with one fingerprint would share an order that suits both, only
/// one of them well.
pub(crate) fn fingerprint(pattern: SymmetricPattern<'_>, index: &[[u32; 3]]) -> u64 {
    let join = |hash: u64, number: u64| (hash ^ number).wrapping_mul(0x0100_0000_01b3);
    let numbers = pattern.column_start.iter().chain(pattern.row);
    let of_pattern = numbers.fold(0xcbf2_9ce4_8422_2325, |hash, &number| join(hash, number as u64));
    index.iter().flatten().fold(of_pattern, |hash, &number| join(hash, number.into()))
}

//! An order of elimination that outlives a run.

use crate::matrix::Pattern;
use crate::solver::{NotSavedHere, Saved};
use rayon::prelude::*;

/// An order of elimination and a fingerprint of the pattern that it was found for.
///
/// A pattern keeps its order while the material moves across the grid, although the order that would be
/// found for it anew may be another: a run that goes on bit for bit needs the one it had.
#[derive(Clone, Debug)]
pub(super) struct StoredOrder {
    fingerprint: u64,
    /// Equations in the order of their elimination.
    pub(super) order: Vec<usize>,
}

impl StoredOrder {
    pub(super) fn of(pattern: Pattern<'_>, order: &[usize]) -> Self {
        Self { fingerprint: fingerprint(pattern, &[]), order: order.to_vec() }
    }

    /// Whether it is the order of this pattern.
    pub(super) fn suits(&self, pattern: Pattern<'_>) -> bool {
        self.order.len() == pattern.n_equations() && self.fingerprint == fingerprint(pattern, &[])
    }

    pub(super) fn save(&self) -> Saved {
        let numbers = self.order.iter().map(|&equation| equation as u64).collect();
        Saved { fingerprint: self.fingerprint, numbers }
    }

    /// Refuses numbers among which an equation has no place, or two.
    pub(super) fn restore(saved: Saved) -> Result<Self, NotSavedHere> {
        let Saved { fingerprint, numbers } = saved;
        let n = numbers.len();
        let mut seen = vec![false; n];
        let mut order = Vec::with_capacity(n);
        for number in numbers {
            let equation = usize::try_from(number).unwrap_or(usize::MAX);
            match seen.get_mut(equation) {
                Some(seen) if !*seen => *seen = true,
                _ => return Err(NotSavedHere { reason: format!("is no order of {n} equations") }),
            }
            order.push(equation);
        }
        Ok(Self { fingerprint, order })
    }
}

/// FNV-1a, a number at a time, of a pattern and where its nodes stand. Two patterns with one fingerprint
/// would share an order that suits both, only one of them well.
pub(crate) fn fingerprint(pattern: Pattern<'_>, index: &[[u32; 3]]) -> u64 {
    /// Numbers that are worth a task.
    const CHUNK: usize = 1 << 15;
    const START: u64 = 0xcbf2_9ce4_8422_2325;
    let join = |hash: u64, number: u64| (hash ^ number).wrapping_mul(0x0100_0000_01b3);
    let of_chunk = |numbers: &[usize]| numbers.iter().fold(START, |hash, &number| join(hash, number as u64));
    let of_list = |hash: u64, numbers: &[usize]| -> u64 {
        let of_chunks: Vec<u64> = if numbers.len() <= CHUNK {
            numbers.chunks(CHUNK).map(of_chunk).collect()
        } else {
            numbers.par_chunks(CHUNK).map(of_chunk).collect()
        };
        of_chunks.into_iter().fold(hash, join)
    };
    let of_pattern = of_list(of_list(START, pattern.column_start), pattern.row);
    index.iter().flatten().fold(of_pattern, |hash, &number| join(hash, number.into()))
}

//! The points that a rank makes, where several share a scene.

use std::ops::Range;

/// One of several ranks that make the points of a scene together: of every body each makes those of a part of the numbers that one
/// process gives its points. Every rank walks through the places of all points, in the order of one process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShareOfPoints {
    /// Number of this rank, from 0.
    pub rank: usize,
    /// Number of ranks.
    pub ranks: usize,
    /// How many of them, with this one, share the memory of its machine.
    pub on_machine: usize,
}

impl ShareOfPoints {
    /// One process makes all.
    pub(crate) const ALL: Self = Self { rank: 0, ranks: 1, on_machine: 1 };

    pub(crate) fn is_all(self) -> bool {
        self.ranks == 1
    }

    /// Numbers of the points that this rank makes of so many.
    pub(crate) fn range(self, points: f64) -> Range<usize> {
        let first = |rank: usize| (points as u128 * rank as u128 / self.ranks as u128) as usize;
        first(self.rank)..first(self.rank + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_point_is_made_by_one_rank() {
        for (points, ranks) in [(10.0, 3), (2.0, 5), (4e9, 7), (0.0, 2)] {
            let range = |rank| ShareOfPoints { rank, ranks, on_machine: 1 }.range(points);
            assert_eq!((range(0).start, range(ranks - 1).end), (0, points as usize));
            assert!((1..ranks).all(|rank| range(rank - 1).end == range(rank).start));
            let most = (0..ranks).map(|rank| range(rank).len()).max().unwrap_or(0);
            assert!(most as f64 <= points / ranks as f64 + 1.0);
        }
    }
}

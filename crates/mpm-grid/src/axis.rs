//! One direction of a grid: strictly increasing node coordinates.

use std::hint::select_unpredictable;
use std::ops::Range;

use crate::index::{to_usize, whole};

/// Local coordinates this close to ±1 are set to ±1, so that a point meant to lie on a
/// grid line does, whatever the rounding of its position; in cells it is half of it, 1e-9.
pub(crate) const SNAP: f64 = 2e-9;

/// Node coordinates `[L]` of one lattice direction, strictly increasing, at least two.
///
/// A uniform axis stores no coordinates, whatever its number of cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    spacing: Spacing,
}

#[derive(Clone, Debug, PartialEq)]
enum Spacing {
    Uniform { from: f64, to: f64, cells: u32, per_length: f64 },
    Graded { nodes: Vec<f64>, cells: u32 },
}

/// What an axis cannot be made of.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AxisError {
    /// No cells.
    #[error("an axis needs at least one cell")]
    Empty,
    /// More cells than 32 bits can number.
    #[error("{cells} cells exceed the 32-bit numbering of cells")]
    TooLong {
        /// Number of cells asked for.
        cells: usize,
    },
    /// Neighbouring coordinates that do not increase (or are not finite).
    #[error("node coordinates must be finite and increase strictly: {next:?} follows {previous:?}")]
    Order {
        /// The lower node's coordinate.
        previous: f64,
        /// The upper node's coordinate.
        next: f64,
    },
    /// Coordinates between which there are none that can be computed.
    #[error("an axis from {from:?} to {to:?} is too long for its nodes to be computed")]
    Length {
        /// The first coordinate.
        from: f64,
        /// The last coordinate.
        to: f64,
    },
    /// A size ratio that is not a positive number.
    #[error("the ratio of last to first cell size must be positive and finite, not {ratio}")]
    Ratio {
        /// The offending ratio.
        ratio: f64,
    },
}

impl Axis {
    /// `cells` equal cells between `from` and `to`.
    pub fn uniform(from: f64, to: f64, cells: u32) -> Result<Self, AxisError> {
        if cells == 0 {
            return Err(AxisError::Empty);
        }
        if cells == u32::MAX {
            return Err(AxisError::TooLong { cells: to_usize(cells) });
        }
        check_order(from, to)?;
        if !((to - from) * f64::from(cells)).is_finite() {
            return Err(AxisError::Length { from, to });
        }
        let per_length = f64::from(cells) / (to - from);
        if !per_length.is_finite() || per_length == 0.0 {
            return Err(AxisError::Order { previous: from, next: to });
        }
        Ok(Self { spacing: Spacing::Uniform { from, to, cells, per_length } })
    }

    /// The axis through the given coordinates.
    pub fn graded(nodes: Vec<f64>) -> Result<Self, AxisError> {
        if nodes.len() < 2 {
            return Err(AxisError::Empty);
        }
        for pair in nodes.windows(2) {
            check_order(pair[0], pair[1])?;
        }
        let (from, to) = (nodes[0], nodes[nodes.len() - 1]);
        if !(to - from).is_finite() {
            return Err(AxisError::Length { from, to });
        }
        let count = nodes.len() - 1;
        match u32::try_from(count) {
            Ok(cells) if cells < u32::MAX => Ok(Self { spacing: Spacing::Graded { nodes, cells } }),
            _ => Err(AxisError::TooLong { cells: count }),
        }
    }

    /// Cell sizes in geometric progression, the last `ratio` times the first.
    pub fn geometric(from: f64, to: f64, cells: u32, ratio: f64) -> Result<Self, AxisError> {
        if !(ratio.is_finite() && ratio > 0.0) {
            return Err(AxisError::Ratio { ratio });
        }
        if ratio == 1.0 || cells <= 1 {
            return Self::uniform(from, to, cells);
        }
        check_order(from, to)?;
        // x_i = from + L (qⁱ - 1)/(qⁿ - 1) with q = ratio^(1/(n-1)); expm1 keeps digits near q = 1.
        let ln_q = ratio.ln() / f64::from(cells - 1);
        let whole = (f64::from(cells) * ln_q).exp_m1();
        let inner = (1..cells).map(|i| from + (to - from) * ((f64::from(i) * ln_q).exp_m1() / whole));
        let nodes = std::iter::once(from).chain(inner).chain(std::iter::once(to));
        Self::graded(nodes.collect())
    }

    /// The same axis with its inner nodes moved towards its end by a part of the cells before them, above 0 and below 1; itself
    /// where numbers are too close together for that.
    #[must_use]
    pub fn with_lines_moved(&self, part: f64) -> Self {
        let inner = (1..self.cells()).map(|i| self.node(i) + part * self.size(i));
        let nodes = std::iter::once(self.first()).chain(inner).chain([self.last()]);
        Self::graded(nodes.collect()).unwrap_or_else(|_| self.clone())
    }

    /// Number of cells.
    #[inline]
    pub fn cells(&self) -> u32 {
        match self.spacing {
            Spacing::Uniform { cells, .. } | Spacing::Graded { cells, .. } => cells,
        }
    }

    /// Coordinate `[L]` of node `i`, 0 to `cells()` inclusive.
    #[inline]
    pub fn node(&self, i: u32) -> f64 {
        match &self.spacing {
            &Spacing::Uniform { from, to, cells, .. } => {
                debug_assert!(i <= cells, "node {i} of an axis of {cells} cells");
                if i == cells { to } else { from + (to - from) * f64::from(i) / f64::from(cells) }
            }
            Spacing::Graded { nodes, .. } => nodes[to_usize(i)],
        }
    }

    /// Coordinate `[L]` of the first node.
    pub fn first(&self) -> f64 {
        self.node(0)
    }

    /// Coordinate `[L]` of the last node.
    pub fn last(&self) -> f64 {
        self.node(self.cells())
    }

    /// Size `[L]` of a cell.
    #[inline]
    pub fn size(&self, cell: u32) -> f64 {
        match &self.spacing {
            &Spacing::Uniform { from, to, cells, .. } => (to - from) / f64::from(cells),
            Spacing::Graded { .. } => self.node(cell + 1) - self.node(cell),
        }
    }

    /// Reciprocal of the size `[1/L]` of a cell.
    #[inline]
    pub(crate) fn per_size(&self, cell: u32) -> f64 {
        match &self.spacing {
            &Spacing::Uniform { per_length, .. } => per_length,
            Spacing::Graded { .. } => 1.0 / self.size(cell),
        }
    }

    /// Whether all cells are equal by construction (closed-form location).
    pub fn is_uniform(&self) -> bool {
        matches!(self.spacing, Spacing::Uniform { .. })
    }

    /// Size `[L]` of the smaller cell at node `i`.
    pub(crate) fn finest_at(&self, i: u32) -> f64 {
        let above = self.size(i.min(self.cells() - 1));
        let below = self.size(i.saturating_sub(1));
        above.min(below)
    }

    /// The cell holding `x`, and the local coordinate there, in [-1, 1].
    ///
    /// A coordinate on a node belongs to the lower of its two cells; within 2e-9 of ±1 the local
    /// coordinate is ±1. Beyond an end of the axis the end cell is continued: |local| > 1.
    #[inline]
    pub fn locate(&self, x: f64) -> (u32, f64) {
        let mut found = (0, 0.0);
        self.locate_each(std::iter::once(x), |_, cell, local| found = (cell, local));
        found
    }

    /// As [`Self::locate`] for several coordinates in turn; `put` takes their number, cell, and local coordinate.
    #[inline]
    pub(crate) fn locate_each(&self, x: impl Iterator<Item = f64>, mut put: impl FnMut(usize, u32, f64)) {
        // A coordinate on a node belongs to the lower cell.
        let lower = |cell: u32, local: f64| {
            let local = snap(local);
            if local == -1.0 && cell > 0 { (cell - 1, 1.0) } else { (cell, local) }
        };
        match &self.spacing {
            &Spacing::Uniform { from, cells, per_length, .. } => {
                for (k, x) in x.enumerate() {
                    let t = (x - from) * per_length;
                    let cell = whole(t, cells);
                    let (cell, local) = lower(cell, 2.0 * (t - f64::from(cell)) - 1.0);
                    put(k, cell, local);
                }
            }
            Spacing::Graded { nodes, cells } => {
                for (k, x) in x.enumerate() {
                    let cell = lower_cell(nodes, *cells, x);
                    let (a, b) = (nodes[to_usize(cell)], nodes[to_usize(cell) + 1]);
                    let (cell, local) = lower(cell, 2.0 * ((x - a) / (b - a)) - 1.0);
                    put(k, cell, local);
                }
            }
        }
    }

    /// Number of the node at coordinate `x` `[L]`, up to 1e-9 of a cell or what rounding leaves of coordinates so
    /// large, if one is there.
    pub fn line_at(&self, x: f64) -> Option<u32> {
        let (cell, local) = self.locate(x.clamp(self.first(), self.last()));
        let line = if local > 0.0 { cell + 1 } else { cell };
        let size = self.size(cell);
        let near = (1e-9 * size).max((4.0 * f64::EPSILON * x.abs()).min(1e-3 * size));
        ((self.node(line) - x).abs() <= near).then_some(line)
    }

    /// Numbers of the nodes in [from, to], widened by 1e-9 of the cell at either end.
    pub(crate) fn nodes_within(&self, from: f64, to: f64) -> Range<u32> {
        let (lower, lower_local) = self.locate(from);
        let (upper, upper_local) = self.locate(to);
        if lower_local.is_nan() || upper_local.is_nan() {
            return 0..0;
        }
        let start = match lower_local {
            l if l <= -1.0 => lower,
            l if l <= 1.0 => lower + 1,
            _ => lower + 2,
        };
        let end = match upper_local {
            l if l < -1.0 => upper,
            l if l < 1.0 => upper + 1,
            _ => upper + 2,
        };
        start..end.max(start)
    }
}

/// Sets a local coordinate within [`SNAP`] of ±1 to ±1.
#[inline]
pub(crate) fn snap(local: f64) -> f64 {
    if (local.abs() - 1.0).abs() <= SNAP { local.signum() } else { local }
}

fn check_order(previous: f64, next: f64) -> Result<(), AxisError> {
    if previous.is_finite() && next.is_finite() && previous < next {
        Ok(())
    } else {
        Err(AxisError::Order { previous, next })
    }
}

/// The last cell whose lower node lies below `x`; 0 where none does, or `x` is not a number.
#[inline]
fn lower_cell(nodes: &[f64], cells: u32, x: f64) -> u32 {
    let (mut low, mut count) = (0, cells);
    while count > 1 {
        let half = count / 2;
        // Binary search whose branch no processor could predict.
        low = select_unpredictable(nodes[to_usize(low + half)] < x, low + half, low);
        count -= half;
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    fn uniform() -> Axis {
        Axis::uniform(-1.0, 3.0, 4).unwrap()
    }

    fn graded() -> Axis {
        Axis::graded(vec![-1.0, 0.0, 1.0, 2.0, 3.0]).unwrap()
    }

    #[test]
    fn grid_lines_belong_to_the_lower_cell() {
        let table = [
            (-1.0, (0, -1.0)),
            (-0.75, (0, -0.5)),
            (0.0, (0, 1.0)),
            (0.9e-9, (0, 1.0)),
            (-0.9e-9, (0, 1.0)),
            (2.0, (2, 1.0)),
            (3.0, (3, 1.0)),
            (3.0 + 0.9e-9, (3, 1.0)),
            (-1.0 - 0.9e-9, (0, -1.0)),
            (3.5, (3, 2.0)),
            (-1.5, (0, -2.0)),
        ];
        for axis in [uniform(), graded()] {
            for (x, expected) in table {
                assert_eq!(axis.locate(x), expected, "{x} on {axis:?}");
            }
            let (cell, local) = axis.locate(1.1e-9);
            assert!(cell == 1 && local > -1.0 && local < -1.0 + 3e-9);
        }
    }

    #[test]
    fn every_node_is_found_from_below() {
        let axes = [Axis::uniform(0.1, 0.7, 1000).unwrap(), Axis::geometric(0.1, 0.7, 1000, 30.0).unwrap()];
        for axis in axes {
            assert_eq!(axis.locate(axis.node(0)), (0, -1.0));
            for i in 1..=axis.cells() {
                assert_eq!(axis.locate(axis.node(i)), (i - 1, 1.0));
            }
        }
    }

    #[test]
    fn geometric_sizes_grow_evenly() {
        for ratio in [0.1, 1.0 + 1e-12, 50.0] {
            let axis = Axis::geometric(2.0, 5.0, 9, ratio).unwrap();
            assert_eq!((axis.first(), axis.last()), (2.0, 5.0));
            assert!((axis.size(8) / axis.size(0) - ratio).abs() < 1e-12 * ratio.max(1.0));
            let q = axis.size(1) / axis.size(0);
            for i in 0..8 {
                assert!((axis.size(i + 1) / axis.size(i) / q - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn nodes_within_uses_the_tolerance() {
        for axis in [uniform(), graded()] {
            assert_eq!(axis.nodes_within(0.0, 2.0), 1..4);
            assert_eq!(axis.nodes_within(0.5e-9, 2.0 - 0.5e-9), 1..4);
            assert_eq!(axis.nodes_within(2e-9, 2.0 - 2e-9), 2..3);
            assert_eq!(axis.nodes_within(1.0, 1.0), 2..3);
            assert!(axis.nodes_within(1.5, 1.5).is_empty());
            assert_eq!(axis.nodes_within(f64::NEG_INFINITY, f64::INFINITY), 0..5);
            assert!(axis.nodes_within(3.5, 9.0).is_empty());
            assert!(axis.nodes_within(-9.0, -1.5).is_empty());
            assert!(axis.nodes_within(f64::NAN, 1.0).is_empty());
        }
    }

    #[test]
    fn bad_axes_are_refused() {
        assert_eq!(Axis::uniform(0.0, 1.0, 0), Err(AxisError::Empty));
        assert!(Axis::uniform(1.0, 1.0, 2).is_err());
        assert!(Axis::uniform(0.0, f64::INFINITY, 2).is_err());
        assert!(Axis::uniform(0.0, 1.0, u32::MAX).is_err());
        // The third node would be at infinity.
        let length = AxisError::Length { from: -1e308, to: 4.0 };
        assert_eq!(Axis::uniform(-1e308, 4.0, 4), Err(length));
        assert!(Axis::graded(vec![-1e308, 0.0, 1e308]).is_err());
        assert!(Axis::graded(vec![0.0]).is_err());
        let order = AxisError::Order { previous: 2.0, next: 1.0 };
        assert_eq!(Axis::graded(vec![0.0, 2.0, 1.0]), Err(order));
        assert!(Axis::geometric(0.0, 1.0, 4, -2.0).is_err());
        assert!(Axis::geometric(0.0, 1.0, 4, f64::NAN).is_err());
    }
}

//! B-splines as functions of a mesh: which of them a cell has, and their values there.
//!
//! Along an axis of n cells there are n + p polynomial splines of degree p on open knots (the ends repeated p + 1
//! times), p + 1 of them in each cell, by the triangle of Cox and de Boor (de Boor, *A Practical Guide to Splines*,
//! 2001, chapter IX). Round a ring of n sectors of the angle Δ there are n splines of class C¹ with pieces in
//! `span{1, cos θ, sin θ}`, three of them in each sector; with the angle t from the start of sector i
//!
//! ```text
//! T_i = A (1 − cos(Δ − t))     T_{i+2} = A (1 − cos t)     T_{i+1} = 1 − T_i − T_{i+2}     A = 1/(2(1 − cos Δ))
//! ```
//!
//! They are positive, sum to one and contain cos θ and sin θ, so that circles are exact: the control point of T_i stands
//! at the angle iΔ − Δ/2 and at `1/cos(Δ/2)` times the radius.
//!
//! Outside the mesh the functions continue linearly, because cubic polynomials would grow too fast.

use crate::axis::Axis;
use crate::lattice::{Lattice, LatticeError};
use crate::{NodeId, Vector};
use std::array::from_fn;
use std::fmt;
use std::ops::Range;

/// Functions along one direction of a cell, at most.
pub(crate) const MOST: usize = 4;

/// The highest degree of the splines of a mesh.
pub(crate) const HIGHEST: u32 = 3;

/// The kind of nodes on which functions live.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NodeKind {
    /// The vertices of the mesh.
    #[default]
    Vertices,
    /// The control points of tensor-product B-splines on the cells of a mesh, with open knots.
    ControlPoints {
        /// p, at least 1.
        degree: u32,
    },
}

impl fmt::Display for NodeKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Vertices => f.write_str("vertices"),
            Self::ControlPoints { degree } => write!(f, "control points of degree {degree}"),
        }
    }
}

/// The functions along one direction of a cell at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Line {
    /// Number of functions, the first entries of the arrays.
    pub count: usize,
    pub values: [f64; MOST],
    /// Derivatives by the coordinate `[1/L]`, round a ring by the angle `[1/rad]`.
    pub slopes: [f64; MOST],
}

/// Distances from a place in a cell to the knots below and above it: entry j of `left` is `x − t_{i+1−j}`, of `right`
/// `t_{i+j} − x`, where x lies between the knots i and i + 1; and the length of their unit `[1/L]`.
struct Knots {
    left: [f64; MOST],
    right: [f64; MOST],
    per_unit: f64,
}

impl Knots {
    /// Around the place at `share` of the cell.
    #[inline]
    fn around(axis: &Axis, cell: u32, share: f64) -> Self {
        let mut knots = Self { left: [0.0; MOST], right: [0.0; MOST], per_unit: 1.0 };
        let above = axis.cells() - cell - 1;
        if axis.is_uniform() {
            knots.per_unit = axis.per_size(cell);
            for j in 1..MOST {
                let steps = j as u32 - 1;
                knots.left[j] = share + f64::from(steps.min(cell));
                knots.right[j] = (1.0 - share) + f64::from(steps.min(above));
            }
        } else {
            let (low, high) = (axis.node(cell), axis.node(cell + 1));
            for j in 1..MOST {
                let steps = j as u32 - 1;
                knots.left[j] = (high - low) * share + (low - axis.node(cell - steps.min(cell)));
                knots.right[j] = (high - low) * (1.0 - share) + (axis.node(cell + 1 + steps.min(above)) - high);
            }
        }
        knots
    }
}

impl Line {
    /// The P + 1 splines of degree P of a cell at a local coordinate.
    #[inline]
    fn polynomial<const P: usize>(axis: &Axis, cell: u32, local: f64) -> Self {
        let share = 0.5 * (1.0 + local);
        let inside = share.clamp(0.0, 1.0);
        let Knots { left, right, per_unit } = Knots::around(axis, cell, inside);
        let (mut values, mut slopes) = ([0.0; MOST], [0.0; MOST]);
        values[0] = 1.0;
        for j in 1..=P {
            let mut carried = 0.0;
            for r in 0..j {
                let part = values[r] / (right[r + 1] + left[j - r]);
                if j == P {
                    let slope = P as f64 * part;
                    slopes[r] -= slope;
                    slopes[r + 1] += slope;
                }
                values[r] = carried + right[r + 1] * part;
                carried = left[j - r] * part;
            }
            values[j] = carried;
        }
        if inside != share {
            let beyond = (share - inside) * if axis.is_uniform() { 1.0 } else { axis.size(cell) };
            for (value, slope) in values.iter_mut().zip(slopes) {
                *value += beyond * slope;
            }
        }
        Self { count: P + 1, values, slopes: slopes.map(|slope| slope * per_unit) }
    }

    /// The functions of the degree of a mesh.
    #[inline]
    pub(crate) fn on_axis(degree: u32, axis: &Axis, cell: u32, local: f64) -> Self {
        match degree {
            2 => Self::polynomial::<2>(axis, cell, local),
            3 => Self::polynomial::<3>(axis, cell, local),
            _ => Self::polynomial::<1>(axis, cell, local),
        }
    }

    /// The three functions of a sector of the angle `step`.
    #[inline]
    pub(crate) fn round_ring(step: f64, local: f64) -> Self {
        let (from_start, to_end) = (0.5 * step * (1.0 + local), 0.5 * step * (1.0 - local));
        // 1 − cos a = 2 sin²(a/2).
        let versine = |angle: f64| 2.0 * (0.5 * angle).sin().powi(2);
        let scale = 0.5 / versine(step);
        let (first, last) = (scale * versine(to_end), scale * versine(from_start));
        let slopes = [-scale * to_end.sin(), scale * from_start.sin()];
        Self {
            count: 3,
            values: [first, 1.0 - first - last, last, 0.0],
            slopes: [slopes[0], -(slopes[0] + slopes[1]), slopes[1], 0.0],
        }
    }
}

/// Derivatives of the highest order along one direction of a cell, by the coordinate of the direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HighestDerivatives {
    /// Order of the derivatives: the degree, and 2 round a ring.
    pub order: u32,
    /// Number of functions.
    pub count: usize,
    /// The derivatives, the first `count` entries `[1/L^order]`, round a ring `[1/rad²]`.
    pub values: [f64; MOST],
    /// Extent of the cell in the coordinate of the direction `[L]`, round a ring `[rad]`.
    pub extent: f64,
}

impl HighestDerivatives {
    /// Of polynomial splines: constant in the cell.
    pub(crate) fn on_axis(degree: u32, axis: &Axis, cell: u32) -> Self {
        let Knots { left, right, per_unit } = Knots::around(axis, cell, 0.0);
        let mut values = [0.0; MOST];
        values[0] = 1.0;
        for j in 1..=degree as usize {
            let mut next = [0.0; MOST];
            for r in 0..j {
                let part = values[r] * j as f64 / (right[r + 1] + left[j - r]);
                next[r] -= part;
                next[r + 1] += part;
            }
            values = next;
        }
        let scale = per_unit.powi(degree as i32);
        let (order, count) = (degree, degree as usize + 1);
        Self { order, count, values: values.map(|it| it * scale), extent: axis.size(cell) }
    }

    /// Of the splines of a sector of the angle `step`, at its end or its start.
    pub(crate) fn round_ring(step: f64, at_end: bool) -> Self {
        let scale = 0.25 / (0.5 * step).sin().powi(2);
        let near = scale * step.cos();
        let (first, last) = if at_end { (scale, near) } else { (near, scale) };
        Self { order: 2, count: 3, values: [first, -(first + last), last, 0.0], extent: step }
    }
}

/// The splines of a mesh: their degree, and the arrangement of their control points.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Splines<const D: usize> {
    pub degree: u32,
    pub nodes: Lattice<D>,
}

impl<const D: usize> Splines<D> {
    /// Splines on the cells of a lattice: n + p control points along an open direction, n along a closed one.
    pub(crate) fn on(lattice: &Lattice<D>, degree: u32) -> Result<Self, LatticeError> {
        let (cells, periodic) = (lattice.cells(), lattice.periodic());
        // A lattice of one cell less than nodes along open directions, as for vertices.
        let mut control = cells;
        for d in 0..D {
            if !periodic[d] {
                control[d] = cells[d].checked_add(degree - 1).ok_or(LatticeError::TooLarge)?;
            }
        }
        Ok(Self { degree, nodes: Lattice::new(control, periodic)? })
    }

    pub(crate) fn kind(&self) -> NodeKind {
        NodeKind::ControlPoints { degree: self.degree }
    }

    /// Calls `each` with node, value and parameter gradient (by the coordinates of the directions) of the functions
    /// of a cell, the first direction fastest.
    #[inline]
    pub(crate) fn product(
        &self,
        cell: &[u32; D],
        lines: &[Line; D],
        mut each: impl FnMut(NodeId, f64, Vector<D>),
    ) {
        let total: usize = lines.iter().map(|line| line.count).product();
        let mut k = [0; D];
        for _ in 0..total {
            let index = from_fn(|d| cell[d] + k[d] as u32);
            let values: [f64; D] = from_fn(|d| lines[d].values[k[d]]);
            let slope = |d: usize| {
                (0..D).fold(
                    lines[d].slopes[k[d]],
                    |product, e| if e == d { product } else { product * values[e] },
                )
            };
            each(self.node(index), values.iter().product(), Vector::from_fn(|d, _| slope(d)));
            for d in 0..D {
                k[d] += 1;
                if k[d] < lines[d].count {
                    break;
                }
                k[d] = 0;
            }
        }
    }

    /// The node at an index that may have passed the seam of a closed direction.
    #[inline]
    pub(crate) fn node(&self, mut index: [u32; D]) -> NodeId {
        let nodes = self.nodes.nodes();
        for d in 0..D {
            if index[d] >= nodes[d] {
                index[d] -= nodes[d];
            }
        }
        self.nodes.node(index)
    }
}

/// The values of the splines at a place, as products along the directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplineProduct<const D: usize> {
    /// Index of the first function along each direction; past the seam of a closed direction indices go on.
    pub first: [u32; D],
    /// Number of functions along each direction.
    pub count: [usize; D],
    /// Values along each direction, the first `count` entries.
    pub values: [[f64; MOST]; D],
    /// Share of each direction in the numbers of the nodes.
    offsets: [[u32; MOST]; D],
}

impl<const D: usize> SplineProduct<D> {
    #[inline]
    pub(crate) fn new(splines: &Splines<D>, cell: &[u32; D], lines: &[Line; D]) -> Self {
        let nodes = splines.nodes.nodes();
        let mut stride = 1;
        let offsets = from_fn(|d| {
            let along = from_fn(|k| {
                let index = cell[d] + k as u32;
                (if index >= nodes[d] { index - nodes[d] } else { index }) * stride
            });
            stride = stride.wrapping_mul(nodes[d]);
            along
        });
        Self { first: *cell, count: from_fn(|d| lines[d].count), values: from_fn(|d| lines[d].values), offsets }
    }

    /// Number of functions.
    #[inline]
    pub fn len(&self) -> usize {
        self.count.iter().product()
    }

    /// Never: a cell has functions.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Node and value of a function, the first direction fastest.
    #[inline]
    pub fn entry(&self, mut k: usize) -> (NodeId, f64) {
        let (mut number, mut value) = (0, 1.0);
        for d in 0..D {
            let along = k % self.count[d];
            k /= self.count[d];
            number += self.offsets[d][along];
            value *= self.values[d][along];
        }
        (NodeId::new(number), value)
    }

    /// Nodes and values of all functions, as [`Self::entry`].
    pub fn entries(&self) -> impl Iterator<Item = (NodeId, f64)> + '_ {
        (0..self.len()).map(|k| self.entry(k))
    }
}

/// The nodes along an axis: its n + p control points of degree p, which are its vertices for p = 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NodeLine<'a> {
    pub axis: &'a Axis,
    pub degree: u32,
}

impl NodeLine<'_> {
    /// Number of nodes.
    pub(crate) fn len(self) -> u32 {
        self.axis.cells() + self.degree
    }

    /// Coordinate `[L]` of a node.
    pub(crate) fn at(self, i: u32) -> f64 {
        let (p, n) = (self.degree, self.axis.cells());
        if p == 1 {
            return self.axis.node(i);
        }
        // Exactly on the faces: the mean of equal numbers may round.
        if i == 0 {
            return self.axis.first();
        }
        if i + 1 == self.len() {
            return self.axis.last();
        }
        let knot = |k: u32| self.axis.node((i + k).saturating_sub(p).min(n));
        (1..=p).map(knot).sum::<f64>() / f64::from(p)
    }

    /// Smallest distance `[L]` to a neighbouring node.
    pub(crate) fn finest_at(self, i: u32) -> f64 {
        if self.degree == 1 {
            return self.axis.finest_at(i);
        }
        let x = self.at(i);
        let below = i.checked_sub(1).map_or(f64::INFINITY, |below| x - self.at(below));
        let above = if i + 1 < self.len() { self.at(i + 1) - x } else { f64::INFINITY };
        below.min(above)
    }

    /// Numbers of the nodes in [from, to], widened by `tolerance` times the distance to the next node.
    pub(crate) fn within(self, from: f64, to: f64, tolerance: f64) -> Range<u32> {
        if self.degree == 1 {
            return self.axis.nodes_within(from, to);
        }
        if from.is_nan() || to.is_nan() {
            return 0..0;
        }
        let slack = |i: u32| tolerance * self.finest_at(i);
        let start = self.count_while(|i| self.at(i) + slack(i) < from);
        let end = self.count_while(|i| self.at(i) - slack(i) <= to);
        start..end.max(start)
    }

    /// Number of first nodes for which a condition holds that fails for all after them.
    fn count_while(self, holds: impl Fn(u32) -> bool) -> u32 {
        let (mut low, mut high) = (0, self.len());
        while low < high {
            let middle = low + (high - low) / 2;
            if holds(middle) {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        low
    }
}

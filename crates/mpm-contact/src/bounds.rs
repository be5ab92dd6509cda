//! Boxes along the axes that enclose shapes.

use crate::pose::Pose;
use mpm_grid::Vector;

/// A box along the axes `[L]`; a shape without end has infinite bounds, and what encloses nothing has `from > to`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds<const D: usize> {
    /// Lowest coordinates.
    pub from: Vector<D>,
    /// Highest coordinates.
    pub to: Vector<D>,
}

impl<const D: usize> Bounds<D> {
    /// The box of no point.
    pub fn empty() -> Self {
        Self { from: Vector::repeat(f64::INFINITY), to: Vector::repeat(f64::NEG_INFINITY) }
    }

    /// The whole space.
    pub fn everything() -> Self {
        Self { from: Vector::repeat(f64::NEG_INFINITY), to: Vector::repeat(f64::INFINITY) }
    }

    /// The smallest box around points.
    pub fn around<'a>(points: impl IntoIterator<Item = &'a Vector<D>>) -> Self {
        points.into_iter().fold(Self::empty(), |it, x| Self { from: it.from.inf(x), to: it.to.sup(x) })
    }

    /// The smallest box around both.
    #[must_use]
    pub fn with(&self, other: &Self) -> Self {
        Self { from: self.from.inf(&other.from), to: self.to.sup(&other.to) }
    }

    /// The box with `by` `[L]` more on every side.
    #[must_use]
    pub fn grown(&self, by: f64) -> Self {
        Self { from: self.from.add_scalar(-by), to: self.to.add_scalar(by) }
    }

    /// Whether a point lies in the box or on its faces.
    pub fn contains(&self, x: &Vector<D>) -> bool {
        (0..D).all(|d| self.from[d] <= x[d] && x[d] <= self.to[d])
    }

    /// Whether two boxes have a point in common.
    pub fn meets(&self, other: &Self) -> bool {
        (0..D).all(|d| self.from[d] <= other.to[d] && other.from[d] <= self.to[d])
    }

    /// Whether every coordinate is finite.
    pub fn is_finite(&self) -> bool {
        self.from.iter().chain(self.to.iter()).all(|x| x.is_finite())
    }

    /// The 2^D corners, first direction fastest.
    pub fn corners(&self) -> impl Iterator<Item = Vector<D>> + '_ {
        (0..1_usize << D)
            .map(|c| Vector::from_fn(|d, _| if c >> d & 1 == 0 { self.from[d] } else { self.to[d] }))
    }

    /// The smallest box along the axes around this one, carried by a pose; the whole space where it has no end.
    #[must_use]
    pub fn placed(&self, pose: &Pose<D>) -> Self {
        self.carried(|x| pose.place(x))
    }

    /// The box in the tool's frame around this one in space, the inverse of [`Self::placed`] but for its size.
    #[must_use]
    pub fn recalled(&self, pose: &Pose<D>) -> Self {
        self.carried(|x| pose.recall(x))
    }

    fn carried(&self, by: impl Fn(&Vector<D>) -> Vector<D>) -> Self {
        if !self.is_finite() {
            return Self::everything();
        }
        let corners: Vec<Vector<D>> = self.corners().map(|x| by(&x)).collect();
        Self::around(&corners)
    }

    /// How far a rigid motion from one pose to another carries any point of the box `[L]`.
    pub fn farthest(&self, from: &Pose<D>, to: &Pose<D>) -> f64 {
        // The distance is a convex function of the point, hence largest in a corner.
        self.corners().map(|x| (to.place(&x) - from.place(&x)).norm()).fold(0.0, f64::max)
    }
}

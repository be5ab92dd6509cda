//! Where a position lies in a mesh: its cell, and its local coordinates there.

use crate::axis::SNAP;
use crate::{Axis, Vector, six_digits};
use std::fmt;

/// A position in the mesh: cell and local coordinates, [-1, 1]^D inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place<const D: usize> {
    /// Multi-index of the cell.
    pub cell: [u32; D],
    /// Local coordinates ξ in it; beyond ±1 only outside the mesh.
    pub local: Vector<D>,
}

/// A position farther outside the mesh than accepted.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{} lies {} cells outside the mesh", Position(position), six_digits(*distance))]
pub struct OutsideMesh<const D: usize> {
    /// The position `[L]`.
    pub position: Vector<D>,
    /// How far outside, in cells of the boundary cell nearest to it; at least 0, or not a number
    /// where the position is none.
    pub distance: f64,
}

/// How a position is told: `(x, y, z)`, with six digits each.
#[derive(Clone, Copy, Debug)]
pub struct Position<'a, const D: usize>(pub &'a Vector<D>);

impl<const D: usize> fmt::Display for Position<'_, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let coordinates: Vec<String> = self.0.iter().map(|x| six_digits(*x)).collect();
        write!(f, "({})", coordinates.join(", "))
    }
}

/// Cell and local coordinates along each axis.
#[inline]
pub(crate) fn place_on<const D: usize>(axes: &[Axis; D], x: &Vector<D>) -> Place<D> {
    let (mut cell, mut local) = ([0; D], Vector::zeros());
    for d in 0..D {
        (cell[d], local[d]) = axes[d].locate(x[d]);
    }
    Place { cell, local }
}

/// How far outside its cell a local coordinate is, in cells.
#[inline]
pub(crate) fn outside<const D: usize>(local: &Vector<D>) -> f64 {
    let mut farthest = 1.0;
    for coordinate in local.iter().map(|c| c.abs()) {
        // Once not a number, it stays so: nothing compares greater.
        if coordinate > farthest || coordinate.is_nan() {
            farthest = coordinate;
        }
    }
    0.5 * (farthest - 1.0)
}

/// The place where it lies up to `beyond` cells outside the mesh.
#[inline]
pub(crate) fn within<const D: usize>(
    x: &Vector<D>,
    place: Place<D>,
    beyond: f64,
) -> Result<Place<D>, OutsideMesh<D>> {
    let distance = outside(&place.local);
    // Local coordinates within the tolerance have been snapped; the slack is for `beyond` > 0.
    if distance <= beyond * (1.0 + SNAP) { Ok(place) } else { Err(OutsideMesh { position: *x, distance }) }
}

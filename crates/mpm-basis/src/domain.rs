//! What the domain of a point is: a part of space that deforms, and that is kept in files.

use mpm_grid::{Block, Vector};

/// The part of space that a point stands for, apart from the basis that uses it; `()` where there is none.
pub trait Domain<const D: usize>: Clone + Send + Sync {
    /// Numbers per domain in a checkpoint.
    const NUMBERS: usize;

    /// Appends exactly `NUMBERS` numbers, from which [`Self::restore`] makes the same domain bit for bit.
    fn store(&self, to: &mut Vec<f64>);

    /// The domain of `NUMBERS` finite numbers.
    ///
    /// # Errors
    /// What no domain of this kind can be.
    fn restore(from: &[f64]) -> Result<Self, String>;

    /// How far the shape of a domain is from one that this basis can be trusted with `[-]`: its
    /// own objective measure, 0 where the domain cannot go bad. [`crate::Fallback`] acts on it.
    fn distortion(&self) -> f64 {
        0.0
    }

    /// Second moment of the domain, `3/V ∫ (x - x̄) ⊗ (x - x̄) dV` (of a box, squares of the half lengths),
    /// which [`crate::domain_control`] takes for its size; `None` where there is no domain `[L²]`.
    fn spread(&self) -> Option<Block<D>> {
        None
    }

    /// Maps the domain about its point `x` by `map` `[-]`, symmetric with a positive determinant:
    /// `x_c → x + A (x_c - x)`. It goes on deforming from there.
    fn scale(&mut self, _x: &Vector<D>, _map: &Block<D>) {}

    /// Gives the domain other sides with the same second moment: the first along the direction in which it is
    /// thinnest in cells no longer than it must be, and so on, so that its corners reach as little into other
    /// rows of cells as may be. `to_cells` takes half the edges of a cell to length 1. Nothing where the
    /// shape is more than its second moment.
    fn align(&mut self, _to_cells: &Block<D>) {}

    /// Corners of the domain `[L]` for drawing: round the outline in the plane, a list in space
    /// (lexicographic for boxes and hexahedra); none where there is no domain.
    fn outline(&self, _x: &Vector<D>) -> Vec<Vector<D>> {
        Vec::new()
    }
}

impl<const D: usize> Domain<D> for () {
    const NUMBERS: usize = 0;

    fn store(&self, _to: &mut Vec<f64>) {}

    fn restore(_from: &[f64]) -> Result<Self, String> {
        Ok(())
    }
}

/// A signed volume at rest.
pub(crate) fn extent(volume: f64) -> Result<f64, String> {
    if volume == 0.0 { Err("a domain has no volume at rest".into()) } else { Ok(volume) }
}

/// The first D numbers.
pub(crate) fn vector<const D: usize>(from: &[f64]) -> Vector<D> {
    Vector::from_column_slice(&from[..D])
}

/// The first D² numbers, column by column.
pub(crate) fn block<const D: usize>(from: &[f64]) -> Block<D> {
    Block::from_column_slice(&from[..D * D])
}

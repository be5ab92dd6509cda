//! What a wall does to a marker.

use mpm_grid::{Block, Vector};

/// A marker at a wall.
pub(super) struct Held<const D: usize> {
    /// Its number.
    pub marker: usize,
    /// Force of the body on the wall, `L q` `[F]`.
    pub force: Vector<D>,
    /// Its derivative by the marker's position `[F/L]`.
    pub stiffness: Block<D>,
    /// Where the wall has what holds the marker `[L]`.
    pub foot: Vector<D>,
    /// The wall's normal there, where it holds along that alone.
    pub normal: Option<Vector<D>>,
    /// q, one component or D `[F/L^(D-1)]`.
    pub q: Vec<f64>,
    /// |g| `[L]`.
    pub gap: f64,
}

impl<const D: usize> Held<D> {
    /// A pull of these components per area there `[F/L^(D-1)]`.
    pub fn pull(&self, q: &[f64]) -> Vector<D> {
        match self.normal {
            Some(normal) => normal * q[0],
            None => Vector::from_column_slice(q),
        }
    }
}

//! Points that fill cells of a mesh, for models that are made without a scene.

use crate::{Basis, Seed};
use mpm_grid::{Mesh, Vector};

/// Seeds that fill `cells` of a mesh at rest, cell by cell: each is cut into `across` equal pieces along every local
/// axis, the first axis fastest, and the basis seeds every piece.
///
/// ```
/// use mpm_basis::{Smpm, seed_cells};
/// use mpm_grid::{Axis, Layout, Mesh};
/// let axis = Axis::uniform(0.0, 2.0, 2)?;
/// let mesh = Mesh::at_rest(&Layout::<2>::on_axes([axis.clone(), axis])?);
/// let seeds = seed_cells(&Smpm, &mesh, mesh.cells(), 2);
/// assert_eq!((seeds.len(), seeds[1].position[0], seeds[1].position[1]), (16, 0.75, 0.25));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn seed_cells<const D: usize, B: Basis<D>>(
    basis: &B,
    mesh: &Mesh<D>,
    cells: impl IntoIterator<Item = [u32; D]>,
    across: u32,
) -> Vec<Seed<D, B::Domain>> {
    let mut seeds = Vec::new();
    let width = 2.0 / f64::from(across);
    for cell in cells {
        for piece in 0..across.pow(D as u32) {
            let low = |d: usize| -1.0 + width * f64::from(piece / across.pow(d as u32) % across);
            let (from, to) = (Vector::from_fn(|d, _| low(d)), Vector::from_fn(|d, _| low(d) + width));
            basis.seed(&mesh.piece(cell, &from, &to), &mut |seed| seeds.push(seed));
        }
    }
    seeds
}

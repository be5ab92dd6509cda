//! The cells that a body occupies.

use mpm_basis::{ActiveNodes, Connectivity};
use mpm_grid::{CellId, Lattice, OutsideMesh};

/// Material in one cell of the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OccupiedCell {
    /// The cell.
    pub cell: CellId,
    /// Volume at rest of the points that influence all of its nodes, with splines of those that have a corner in it
    /// `[L^D]`; points that reach into several cells count in each.
    pub volume: f64,
    /// That times their Young's modulus `[F L^(D-2)]`.
    pub stiffness: f64,
}

/// Adds the cells all of whose nodes a point of the body influences; `young` `[F/L²]`. Of a layer, those at the lower side
/// are looked at, which are those of a section of two `dimensions`.
pub(crate) fn occupied<const D: usize>(
    connectivity: &Connectivity<D>,
    lattice: &Lattice<D>,
    active: &ActiveNodes<D>,
    (volume, dimensions): (&[f64], usize),
    young: f64,
    out: &mut Vec<OccupiedCell>,
) {
    let cells = lattice.cells();
    for group in (0..connectivity.n_groups()).map(|group| connectivity.group(group)) {
        let volume: f64 = volume[group.first_point..group.first_point + group.points].iter().sum();
        for &node in group.nodes {
            // The node as the lower corner of a cell.
            let index = lattice.node_index(active.nodes()[node as usize]);
            if (0..D).any(|d| index[d] >= cells[d]) {
                continue;
            }
            let corners = lattice.corners(index);
            let holds =
                |corner| active.number(corner).is_some_and(|v| group.nodes.binary_search(&(v as u32)).is_ok());
            if corners[..1 << dimensions].iter().all(|&corner| holds(corner)) {
                out.push(OccupiedCell { cell: lattice.cell(index), volume, stiffness: young * volume });
            }
        }
    }
}

/// Adds the cells whose functions the points sample, however little of a point's domain is in them: a function without
/// stiffness would be left otherwise. `sampled` hands out those of a point; `young` `[F/L²]`.
pub(crate) fn sampled_cells<const D: usize>(
    lattice: &Lattice<D>,
    sampled: impl Fn(usize, &mut dyn FnMut([u32; D])) -> Result<(), OutsideMesh<D>>,
    volume: &[f64],
    young: f64,
    out: &mut Vec<OccupiedCell>,
) -> Result<(), OutsideMesh<D>> {
    for (point, &volume) in volume.iter().enumerate() {
        let first = out.len();
        sampled(point, &mut |cell| {
            let cell = lattice.cell(cell);
            if out[first..].iter().all(|it| it.cell != cell) {
                out.push(OccupiedCell { cell, volume, stiffness: young * volume });
            }
        })?;
    }
    Ok(())
}

//! The nodes that carry a marker.

use crate::contribution::{Refused, StepStart};
use mpm_grid::{NodeId, NodeKind, Place, Position, Vector};

/// Values of functions below this are those of rounding at the edge of a cell.
const NOTHING: f64 = 1e-12;

/// Cells outside the mesh up to which markers are carried.
pub(super) const BEYOND: f64 = 0.5;

/// Active numbers of the nodes that carry a marker at `x` `[L]`, and `N_v(x)`.
///
/// A marker can leave the cells that points reach, as where the points of a basis without domains stand behind the boundary.
/// Then the functions of the nearest cell whose nodes are all active go on outside it: they still sum to one and hold
/// linear fields.
///
/// # Errors
/// No such cell is beside the marker's.
pub(super) fn carriers<const D: usize>(
    step: &StepStart<'_, D>,
    x: &Vector<D>,
) -> Result<Vec<(u32, f64)>, Refused> {
    let mesh = step.mesh;
    let place = mesh.locate(x, BEYOND).map_err(|it| Refused::here(format!("has a marker outside: {it}")))?;
    if let Some(carriers) = of_place(step, &place) {
        return Ok(carriers);
    }
    let found = beside(step, x, &place).and_then(|place| of_place(step, &place));
    found.ok_or_else(|| {
        Refused::here(format!("has a marker at {} that has left the cells of its body", Position(x)))
    })
}

/// The nodes of a place, if all that count are active.
fn of_place<const D: usize>(step: &StepStart<'_, D>, place: &Place<D>) -> Option<Vec<(u32, f64)>> {
    let (mut carriers, mut are_active) = (Vec::new(), true);
    step.mesh.values(place, |node: NodeId, value| match step.active.number(node) {
        Some(number) => carriers.push((number as u32, value)),
        None => are_active &= value.abs() <= NOTHING,
    });
    are_active.then_some(carriers)
}

/// The place of `x` as seen from the cell beside its own, with active nodes, that it is outside by least.
fn beside<const D: usize>(step: &StepStart<'_, D>, x: &Vector<D>, place: &Place<D>) -> Option<Place<D>> {
    let (mesh, lattice) = (step.mesh, step.mesh.lattice());
    // Cells of a ring of splines lie between circles.
    if mesh.functions() != NodeKind::Vertices && mesh.rectilinear().is_none() {
        return None;
    }
    let mut nearest: Option<(f64, Place<D>)> = None;
    for number in 0..3_usize.pow(D as u32) {
        let steps: [usize; D] = std::array::from_fn(|d| number / 3_usize.pow(d as u32) % 3);
        let mut cell = Some(place.cell);
        for (d, step) in steps.into_iter().enumerate() {
            cell = cell.and_then(|cell| match step {
                0 => Some(cell),
                1 => lattice.below(cell, d),
                _ => lattice.above(cell, d),
            });
        }
        let Some(cell) = cell else { continue };
        let mut are_active = true;
        mesh.values(&Place { cell, local: Vector::zeros() }, |node, _| {
            are_active &= step.active.number(node).is_some();
        });
        let Some(local) = mesh.linear_cell(cell).local(x).filter(|_| are_active) else { continue };
        let outside = local.amax();
        if nearest.as_ref().is_none_or(|(least, _)| outside < *least) {
            nearest = Some((outside, Place { cell, local }));
        }
    }
    nearest.map(|(_, place)| place)
}

//! Cells that points have crowded or left, where volume changes are those of cells.
//!
//! With [`MeanDilatation::Cell`](super::MeanDilatation) the pressure in a cell's points does work on the volume of the
//! cell. A uniform pressure p then acts as `p ΣV_p/V`, with the volumes V_p of the points in a cell of volume V: as
//! itself while they fill it. Where points pass from cell to cell they do not, and p (ΣV_p/V - 1) pushes nodes amid the
//! body against the shear stress of the flowing points.

use super::dilatation::MeanDilatation;
use super::interface::{Body, of_points};
use super::point_view::PointView;
use super::pressed::{mean_pressure, shear_stress};
use super::space::Space;
use mpm_grid::{Mesh, Vector};
use mpm_material::SymmetricTensor;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// What the points of a cell add up to.
#[derive(Clone, Copy, Default)]
struct Content {
    /// `Σ V_p` `[L^D]`, of a body of revolution `[L³]`.
    volume: f64,
    /// `-Σ V⁰_p tr τ_p / 3`, which is `Σ V_p p` `[F L]`.
    work: f64,
    /// Largest `√J₂` of points that flow; 0 where none does `[F/L²]`.
    shear: f64,
}

/// Largest `|p (ΣV_p/V - 1)|` over the shear stress `√J₂` in cells with points that yield, where volume changes are those
/// of the cells of `mesh` `[-]`; none elsewhere, and where no point yields. Cells at the edge of the body count only where
/// they hold more than their volume.
pub fn crowding_over_shear<const D: usize>(body: &dyn Body<D>, mesh: &Mesh<D>) -> Option<f64> {
    let is_judged = body.mean_dilatation() == Some(MeanDilatation::Cell) && body.can_yield();
    let points = || of_points(body, |point| (body.point(point), body.kirchhoff(point)));
    is_judged.then(|| largest(points(), mesh, body.space())).flatten()
}

fn largest<const D: usize>(
    points: impl Iterator<Item = (PointView<D>, SymmetricTensor)>,
    mesh: &Mesh<D>,
    space: Space,
) -> Option<f64> {
    let mut cells: BTreeMap<[u32; D], Content> = BTreeMap::new();
    for (view, kirchhoff) in points {
        let Ok(place) = mesh.locate(&view.position, 0.0) else { continue };
        let content = cells.entry(place.cell).or_default();
        content.volume += view.reference_volume * view.volume_ratio;
        content.work += view.reference_volume * mean_pressure(&kirchhoff);
        if view.plastic {
            content.shear = content.shear.max(shear_stress(&kirchhoff));
        }
    }
    let is_amid = |cell: [u32; D]| {
        let lattice = mesh.lattice();
        let beside = (0..D).flat_map(|d| [lattice.above(cell, d), lattice.below(cell, d)]);
        beside.flatten().all(|cell| cells.contains_key(&cell))
    };
    let judged = cells.iter().filter(|(_, content)| content.shear > 0.0).filter_map(|(&cell, content)| {
        let filled = content.volume / cell_volume(mesh, cell, space);
        let pressure = content.work / content.volume;
        (filled > 1.0 || is_amid(cell)).then(|| (pressure * (filled - 1.0)).abs() / content.shear)
    });
    judged.reduce(f64::max)
}

/// Volume of a cell, of that of bodies of revolution the ring's.
fn cell_volume<const D: usize>(mesh: &Mesh<D>, cell: [u32; D], space: Space) -> f64 {
    let shape = mesh.linear_cell(cell);
    if !space.is_axisymmetric() {
        return shape.volume().abs();
    }
    // 2² Gauss points integrate r det exactly.
    let a = 1.0 / 3.0_f64.sqrt();
    let ring = |q: usize| {
        let local = Vector::<D>::from_fn(|d, _| if q >> d & 1 == 0 { -a } else { a });
        shape.determinant(&local).abs() * TAU * shape.position(&local)[0]
    };
    (0..1 << D).map(ring).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use mpm_grid::{Axis, Block, Layout};

    /// Three cells of width 1 from `from` on, with points at these places, of these volumes, that flow or do not: pressure
    /// 50, √J₂ = 2.
    fn crowding(from: f64, space: Space, points: &[(f64, f64, bool)]) -> Option<f64> {
        let axis = |from: f64, cells: u32| Axis::uniform(from, from + f64::from(cells), cells).unwrap();
        let mesh = Mesh::at_rest(&Layout::on_axes([axis(from, 3), axis(0.0, 1)]).unwrap());
        let kirchhoff = SymmetricTensor { xx: 2.0 - 50.0, yy: -2.0 - 50.0, zz: -50.0, ..SymmetricTensor::ZERO };
        let view = |&(x, volume, plastic): &(f64, f64, bool)| PointView {
            position: Vector::<2>::new(x, 0.5),
            reference_position: None,
            reference_volume: volume,
            reference_size: 1.0,
            deformation_gradient: Block::identity(),
            hoop_stretch: None,
            angle: None,
            volume_ratio: 1.0,
            elastic_excess: SymmetricTensor::ZERO,
            plastic,
        };
        largest(points.iter().map(|point| (view(point), kirchhoff)), &mesh, space)
    }

    const FULL: [(f64, f64, bool); 3] = [(0.5, 1.0, true), (1.5, 1.0, true), (2.5, 1.0, true)];

    #[test]
    fn cells_that_points_fill_misjudge_nothing() {
        assert_eq!(crowding(0.0, Space::Cartesian, &FULL), Some(0.0));
        let rings = FULL.map(|(x, _, plastic)| (x + 4.0, TAU * (x + 4.0), plastic));
        assert!(crowding(4.0, Space::Axisymmetric, &rings).unwrap() < 1e-12);
        // The edge of the body is filled in part, as it may be.
        assert_eq!(crowding(0.0, Space::Cartesian, &[FULL[0], (1.25, 0.5, true)]), Some(0.0));
        assert_eq!(crowding(0.0, Space::Cartesian, &FULL.map(|(x, ..)| (x, 2.0, false))), None);
    }

    #[test]
    fn points_that_passed_from_cell_to_cell_are_told_of() {
        let [first, amid, last] = FULL;
        let close = |points: &[(f64, f64, bool)], expected: f64| {
            let found = crowding(0.0, Space::Cartesian, points).unwrap();
            assert!((found - expected).abs() < 1e-12, "{found}");
        };
        // The middle cell has lost a fifth of its material, or has a fifth too much: 0.2 · 50 / 2.
        close(&[first, (1.5, 0.8, true), last], 5.0);
        close(&[first, amid, (1.2, 0.2, true), last], 5.0);
        // An edge that is crowded.
        close(&[first, amid, (2.5, 1.4, true)], 10.0);
    }
}

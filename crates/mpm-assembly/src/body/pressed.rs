//! Pressure in flowing points, where volume changes are averaged over the points of cells.
//!
//! The sum of `w_q det ΔF_q` over the points of a cell is the volume of no part of space once points stand elsewhere
//! than where the cells' quadrature would have them. A uniform pressure p then does work on motions of the nodes amid a
//! body, which change no volume. What resists these motions is the shear stress of the flowing points: where p is many
//! times that, they grow from load step to load step. Volumes of the cells themselves
//! ([`MeanDilatation::Cell`](super::MeanDilatation)) leave no such work.

use super::dilatation::MeanDilatation;
use super::interface::{Body, views};
use super::point_view::PointView;
use mpm_material::SymmetricTensor;
use std::f64::consts::FRAC_1_SQRT_2;

/// Pressures below this part of the largest do not count: points at the apex of a law bear neither pressure nor shear.
const BORNE: f64 = 1e-3;

/// Largest pressure over the shear stress `√J₂` of a body's points that yield, where volume changes are averaged over
/// the points of cells: from some tens on, pressure drives motions of the nodes `[-]`. None elsewhere, and where no point
/// yields under pressure.
pub fn pressure_over_shear<const D: usize>(body: &dyn Body<D>) -> Option<f64> {
    let is_judged = body.mean_dilatation() == Some(MeanDilatation::Points) && body.can_yield();
    is_judged.then(|| largest(views(body))).flatten()
}

fn largest<const D: usize>(points: impl Iterator<Item = PointView<D>>) -> Option<f64> {
    let flowing = points
        .filter(|view| view.plastic)
        .map(|view| (mean_pressure(&view.kirchhoff), shear_stress(&view.kirchhoff)));
    let flowing: Vec<(f64, f64)> = flowing.collect();
    let most = flowing.iter().fold(0.0, |most: f64, (pressure, _)| most.max(*pressure));
    let borne = flowing.iter().filter(|(pressure, _)| *pressure > BORNE * most);
    borne.map(|(pressure, shear)| pressure / shear).reduce(f64::max)
}

/// `-tr τ / 3` `[F/L²]`.
pub(super) fn mean_pressure(tau: &SymmetricTensor) -> f64 {
    -tau.trace() / 3.0
}

/// `√J₂` `[F/L²]`.
pub(super) fn shear_stress(tau: &SymmetricTensor) -> f64 {
    let pressure = mean_pressure(tau);
    let (xx, yy, zz) = (tau.xx + pressure, tau.yy + pressure, tau.zz + pressure);
    let deviator = SymmetricTensor { xx, yy, zz, ..*tau };
    deviator.norm() * FRAC_1_SQRT_2
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use mpm_grid::{Block, Vector};

    /// A point under this stress.
    pub(in super::super) fn view(stress: [f64; 3], plastic: bool) -> PointView<2> {
        PointView {
            position: Vector::zeros(),
            reference_position: None,
            reference_volume: 1.0,
            deformation_gradient: Block::identity(),
            hoop_stretch: None,
            angle: None,
            reference_size: 1.0,
            volume_ratio: 1.0,
            elastic_excess: SymmetricTensor::default(),
            stored_energy: 0.0,
            kirchhoff: SymmetricTensor {
                xx: stress[0],
                yy: stress[1],
                zz: stress[2],
                ..SymmetricTensor::default()
            },
            plastic,
        }
    }

    #[test]
    fn flowing_points_under_pressure_count() {
        // Pure shear of 2 under pressures of 60 and 20; elastic points, tension, and an apex.
        let sheared = |pressure: f64, plastic| view([2.0 - pressure, -2.0 - pressure, -pressure], plastic);
        let points = [
            sheared(60.0, true),
            sheared(20.0, true),
            sheared(900.0, false),
            sheared(-50.0, true),
            view([0.0; 3], true),
        ];
        let found = largest(points.into_iter()).expect("some flow under pressure");
        assert!((found - 30.0).abs() < 1e-12, "{found}");
        assert_eq!(largest(points[2..].iter().copied()), None);
    }
}

//! Pressure in flowing points, where volume changes are averaged over the points of cells.
//!
//! The sum of `w_q det ΔF_q` over the points of a cell is the volume of no part of space once points stand elsewhere
//! than where the cells' quadrature would have them. A uniform pressure p then does work on motions of the nodes amid a
//! body, which change no volume. What resists these motions is the shear stress of the flowing points: where p is many
//! times that, they grow from load step to load step. Volumes of the cells themselves
//! ([`MeanDilatation::Cell`](super::MeanDilatation)) leave no such work.

use super::dilatation::MeanDilatation;
use super::interface::{Body, of_points};
use mpm_material::SymmetricTensor;
use std::f64::consts::FRAC_1_SQRT_2;

/// Pressures below this part of the largest do not count: points at the apex of a law bear neither pressure nor shear.
const BORNE: f64 = 1e-3;

/// Largest pressure over the shear stress `√J₂` of a body's points that yield, where volume changes are averaged over
/// the points of cells: from some tens on, pressure drives motions of the nodes `[-]`. None elsewhere, and where no point
/// yields under pressure.
pub fn pressure_over_shear<const D: usize>(body: &dyn Body<D>) -> Option<f64> {
    let is_judged = body.mean_dilatation() == Some(MeanDilatation::Points) && body.can_yield();
    let flowing = || of_points(body, |point| body.point(point).plastic.then(|| body.kirchhoff(point)));
    is_judged.then(|| largest(flowing().flatten())).flatten()
}

/// Of points that flow, by their stresses.
fn largest(flowing: impl Iterator<Item = SymmetricTensor>) -> Option<f64> {
    let flowing: Vec<(f64, f64)> = flowing.map(|tau| (mean_pressure(&tau), shear_stress(&tau))).collect();
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
mod tests {
    use super::*;

    #[test]
    fn flowing_points_under_pressure_count() {
        // Pure shear of 2 under pressures of 60 and 20; tension, and an apex.
        let sheared = |pressure: f64| SymmetricTensor {
            xx: 2.0 - pressure,
            yy: -2.0 - pressure,
            zz: -pressure,
            ..SymmetricTensor::ZERO
        };
        let points = [sheared(60.0), sheared(20.0), sheared(-50.0), SymmetricTensor::ZERO];
        let found = largest(points.into_iter()).expect("some flow under pressure");
        assert!((found - 30.0).abs() < 1e-12, "{found}");
        assert_eq!(largest(points[2..].iter().copied()), None);
    }
}

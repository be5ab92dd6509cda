//! A stressed body is turned once around.

use super::largest;
use crate::probe::{Probe, plane, solid};
use crate::scenes::load_own;
use crate::{Broken, Case, Check, Extent, Findings};
use mpm_assembly::PointView;
use mpm_grid::{Block, Vector};
use mpm_material::{SymmetricTensor, log_strain};
use mpm_solver::Model;
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

pub(super) const CASE: Case = Case {
    name: "rigid rotation",
    goal: "Stress turns with the body, and neither stress nor energy is made by rotation, however large the increments.",
    setup: "Blocks in the plane and in space (about (1, 1, 1)) are first strained unevenly, partly beyond yield, then turned by 360° through a mesh that stays, in increments of 30° and of 120°.",
    reference: "The stress before, turned; the energy before; no point may yield.",
    run,
};

fn run(_: Extent) -> Result<Findings, Broken> {
    let mut checks = Vec::new();
    for increments in [12, 3] {
        checks.extend(turn::<2>("plane", plane(&load_own("rotated_plane")?)?, increments)?);
        checks.extend(turn::<3>("space", solid(&load_own("rotated_solid")?)?, increments)?);
    }
    Ok(checks.into())
}

fn turn<const D: usize>(space: &str, model: Model<D>, increments: u32) -> Result<Vec<Check>, Broken> {
    let mut probe = Probe::of(model)?;
    probe
        .advance(&probe.field(|x| Vector::from_fn(|i, _| 0.15 * (1.3 * x[(i + 1) % D] + 0.7 * x[i]).sin())))?;
    let before = probe.points();
    let plastic = before.iter().filter(|point| point.plastic).count();
    let stress_before = probe.stresses();
    let energy_before = energy(&before, &stress_before);
    let size = largest(stress_before.iter().map(|tau| tau.norm()));

    let (mut stress, mut energy_drift, mut yielding) = (0.0, 0.0, 0);
    let increment = rotation::<D>(std::f64::consts::TAU / f64::from(increments));
    for k in 1..=increments {
        let step = Block::from_fn(|i, j| increment[(i, j)]) - Block::<D>::identity();
        probe.advance(&probe.field(|x| step * x))?;
        let turned = rotation::<D>(std::f64::consts::TAU * f64::from(k) / f64::from(increments));
        let (now, stress_now) = (probe.points(), probe.stresses());
        stress = largest(
            stress_now
                .iter()
                .zip(&stress_before)
                .map(|(now, before)| {
                    let expected = turned * before.to_matrix() * turned.transpose();
                    (now.to_matrix() - expected).norm() / size
                })
                .chain([stress]),
        );
        energy_drift = largest([energy_drift, (energy(&now, &stress_now) / energy_before - 1.0).abs()]);
        yielding += now.iter().filter(|point| point.plastic).count();
    }
    let degrees = 360 / increments;
    Ok(vec![
        Check::new(format!("stress, {space}, increments of {degrees}°"), stress, 1e-10)
            .remark(format!("{plastic} of {} points had yielded", before.len())),
        Check::new(format!("energy, {space}, increments of {degrees}°"), energy_drift, 1e-10),
        Check::none(format!("points that yield while turned, {space}, increments of {degrees}°"), yielding),
    ])
}

/// Rotation about the third axis in the plane, about (1, 1, 1) in space.
fn rotation<const D: usize>(angle: f64) -> Matrix3<f64> {
    let axis = if D == 2 { Vector3::z() } else { Vector3::repeat(1.0) };
    Rotation3::from_axis_angle(&Unit::new_normalize(axis), angle).into_inner()
}

/// `Σ_p V⁰_p ½ τ_p : ε_e,p`.
fn energy<const D: usize>(points: &[PointView<D>], stresses: &[SymmetricTensor]) -> f64 {
    let density = |point: &PointView<D>, tau: &SymmetricTensor| {
        tau.to_matrix().dot(&log_strain(&point.elastic_excess).to_matrix()) / 2.0
    };
    points.iter().zip(stresses).map(|(point, tau)| point.reference_volume * density(point, tau)).sum()
}

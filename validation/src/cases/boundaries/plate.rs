//! A plate with a free hole.

use super::super::{scientific, sweep};
use super::{axis, functions};
use crate::history::History;
use crate::probe::plane;
use crate::scenes::{changed, text};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_assembly::{BodySide, MarkerForce, MarkerLoad};
use mpm_grid::{Ramp, Vector};
use mpm_linear::Symmetry;
use mpm_solver::observe::Field;
use std::f64::consts::TAU;

pub(in crate::cases) const PLATE: Case = Case {
    name: "plate with a hole",
    goal: "A free hole that cuts the mesh, and tractions that vary along a circle which does: stress is of second order on splines of degree 2, of first order on linear functions.",
    setup: "A quarter of a ring, R 1 to 4, E = 1000, ν = 0.3, in 9², 18² (36² in the full run) cells on [0, 4.5]², polar tiles half a cell wide, CPDI2q, ghost faces. On the outer circle Kirsch's tractions of a plate under a hundredth of a unit of tension, which edges give to their ends.",
    reference: "Kirsch's stress of small strains, at the points at rest. The order is to be at least 0.9 of degree 1, and 1.9 of the others (1.8 on the two coarser meshes).",
    run: plates,
};

/// Kirsch's stress (xx, xy, yy) around a hole of radius 1 in a plate under unit tension along x.
fn kirsch(x: f64, y: f64) -> [f64; 3] {
    let (r2, angle) = (x * x + y * y, y.atan2(x));
    let (a, b) = (1.0 / r2, 1.0 / (r2 * r2));
    let (sine, cosine) = (2.0 * angle).sin_cos();
    let radial = 0.5 * (1.0 - a) + 0.5 * (1.0 - 4.0 * a + 3.0 * b) * cosine;
    let hoop = 0.5 * (1.0 + a) - 0.5 * (1.0 + 3.0 * b) * cosine;
    let shear = -0.5 * (1.0 + 2.0 * a - 3.0 * b) * sine;
    let (s, c) = angle.sin_cos();
    [
        radial * c * c - 2.0 * shear * c * s + hoop * s * s,
        (radial - hoop) * c * s + shear * (c * c - s * s),
        radial * s * s + 2.0 * shear * c * s + hoop * c * c,
    ]
}

/// Tension of the plate `[F/L²]`, and its outer radius `[L]`.
const TENSION: f64 = 1e-2;
const OUTER: f64 = 4.0;

/// A quarter of the outer circle in `n` edges, and the forces of Kirsch's tractions on its markers.
fn loaded_circle(n: u32) -> (BodySide<2>, Vec<Vector<2>>) {
    let at = |k: u32| {
        let (sine, cosine) = (0.25 * TAU * f64::from(k) / f64::from(n)).sin_cos();
        Vector::<2>::new(OUTER * cosine, OUTER * sine)
    };
    let markers: Vec<Vector<2>> = (0..=n).map(at).collect();
    let facets: Vec<[u32; 2]> = (0..n).map(|k| [k, k + 1]).collect();
    let mut forces = vec![Vector::<2>::zeros(); markers.len()];
    for &[a, b] in &facets {
        let [from, to] = [a, b].map(|k| markers[k as usize]);
        let outward = Vector::<2>::new(to[1] - from[1], from[0] - to[0]);
        // Gauss's two places share the edge's force by its linear functions.
        for place in [0.5 - 0.75_f64.sqrt() / 3.0, 0.5 + 0.75_f64.sqrt() / 3.0] {
            let x = from + (to - from) * place;
            let [xx, xy, yy] = kirsch(x[0], x[1]).map(|stress| 0.5 * TENSION * stress);
            let force = Vector::<2>::new(xx * outward[0] + xy * outward[1], xy * outward[0] + yy * outward[1]);
            forces[a as usize] += force * (1.0 - place);
            forces[b as usize] += force * place;
        }
    }
    (BodySide { body: "tube".into(), name: "outer".into(), markers, facets, layers: 1 }, forces)
}

/// Relative mean-square error of the stress.
fn plate(degree: u32, cells: u32) -> Result<f64, Broken> {
    let changes = [
        ("mesh.axes[0]", axis(0.0, 4.5, f64::from(cells))),
        ("mesh.axes[1]", axis(0.0, 4.5, f64::from(cells))),
        ("mesh.functions", functions(degree)),
        ("bodies[0].shape", format!("Ring(inner: 1, outer: {OUTER:?})")),
        ("loads", "[]".into()),
        ("schedule.steps", "1".into()),
    ];
    let mut model = plane(&changed(text("cylinder_pressure")?, &changes)?)?;
    // Two pieces a cell, as the ring is cut.
    let sectors = ((0.5 * TAU * (1.0 + OUTER) / (4.5 / f64::from(cells)) - 1e-9).ceil() / 4.0).ceil() as u32;
    let (side, forces) = loaded_circle(2 * sectors);
    let load = MarkerLoad::new(side, MarkerForce::Dead(forces), Ramp::linear(1.0), Symmetry::Symmetric);
    model.add_contribution("Kirsch's tractions", Box::new(load));
    let mut history = History::of(&[Field::CAUCHY_STRESS]);
    mpm_solver::run(&mut model, &mut history)?;
    let stress = history.field(Field::CAUCHY_STRESS, history.rows().len() - 1).chunks_exact(9);
    let (mut error, mut size) = (0.0, 0.0);
    for (s, x) in stress.zip(history.rows()[0].positions.chunks_exact(3)) {
        let expected = kirsch(x[0], x[1]).map(|stress| TENSION * stress);
        for (found, expected, weight) in
            [(s[0], expected[0], 1.0), (s[1], expected[1], 2.0), (s[4], expected[2], 1.0)]
        {
            error += weight * x[0].hypot(x[1]) * (found - expected).powi(2);
            size += weight * x[0].hypot(x[1]) * expected.powi(2);
        }
    }
    Ok((error / size).sqrt())
}

fn plates(extent: Extent) -> Result<Findings, Broken> {
    let meshes: &[u32] = extent.pick(&[9, 18], &[9, 18, 36]);
    let runs: Vec<(u32, u32)> =
        [1, 2, 3].into_iter().flat_map(|p| meshes.iter().map(move |&n| (p, n))).collect();
    let found = sweep(&runs, |&(degree, cells)| plate(degree, cells))?;
    let mut findings = Findings::default();
    let mut errors =
        Table::new("Relative errors of the stress in the mean square.", &["degree", "cells", "stress"]);
    for ((degree, cells), error) in runs.iter().zip(&found) {
        errors.push([degree.to_string(), format!("{cells}²"), scientific(*error, 2)]);
    }
    findings.tables.push(errors);
    for (degree, found) in [1, 2, 3].into_iter().zip(found.chunks_exact(meshes.len())) {
        let [.., coarse, fine] = found else { continue };
        let least = if degree == 1 { 0.9 } else { extent.pick(1.8, 1.9) };
        let order = (coarse / fine).log2();
        let what = format!("degree {degree}: what the order of the two finest meshes lacks");
        findings.checks.push(Check::new(what, (least - order).max(0.0), 0.0).remark(format!("{order:.2}")));
    }
    Ok(findings)
}

//! A thick cylinder under pressure.

use super::super::{scientific, sweep};
use super::{axis, functions};
use crate::history::History;
use crate::reference::Reference;
use crate::scenes::{changed, run, text};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_solver::observe::Field;
use nalgebra::{Matrix3, Vector3};

pub(in crate::cases) const CYLINDER: Case = Case {
    name: "pressurised cylinder",
    goal: "A pressure that follows a circle which cuts the mesh, at finite strain: radius and stress are of second order on splines of degree 2.",
    setup: "A quarter of a thick cylinder, R 5 to 10, E = 1000, ν = 0.3, under a pressure of 60 inside in 5 load steps; 12², 24² (48² in the full run) cells, polar tiles half a cell wide, CPDI2q, ghost faces.",
    reference: "The solution in one dimension: inner radius of `reference/cylinder_pressure.csv`, and the stress of an integration across the wall from there.",
    run: cylinders,
};

/// Lamé's λ and μ of E = 1000, ν = 0.3.
const LAME: f64 = 1000.0 * 0.3 / (1.3 * 0.4);
const SHEAR: f64 = 1000.0 / 2.6;

/// The solution across the wall: present radius and Cauchy stresses (radial, hoop) at rest radii from 5 to 10 in equal steps.
fn across_the_wall(inner: f64, pressure: f64, steps: usize) -> Vec<(f64, [f64; 2])> {
    // ln λ_r of a nominal radial stress P = τ_r/λ_r and a hoop stretch, by Newton's method.
    let radial = |nominal: f64, hoop: f64| {
        let mut log = 0.0_f64;
        for _ in 0..30 {
            let out = (LAME + 2.0 * SHEAR) * log + LAME * hoop.ln() - nominal * log.exp();
            log -= out / (LAME + 2.0 * SHEAR - nominal * log.exp());
        }
        log
    };
    let stresses = |nominal: f64, hoop: f64| {
        let (log, round) = (radial(nominal, hoop), hoop.ln());
        let tau = [log, round].map(|own| LAME * (log + round) + 2.0 * SHEAR * own);
        (log.exp(), tau)
    };
    // d(r, P)/dR: λ_r, and (P_θ − P)/R.
    let rate = |at: f64, [r, nominal]: [f64; 2]| {
        let hoop = r / at;
        let (stretch, tau) = stresses(nominal, hoop);
        [stretch, (tau[1] / hoop - nominal) / at]
    };
    let (h, mut y) = (5.0 / steps as f64, [inner, -pressure * inner / 5.0]);
    let mut found = Vec::with_capacity(steps + 1);
    for k in 0..=steps {
        let at = 5.0 + h * k as f64;
        let (hoop, nominal) = (y[0] / at, y[1]);
        let (stretch, tau) = stresses(nominal, hoop);
        found.push((y[0], tau.map(|tau| tau / (stretch * hoop))));
        let step = |rate: [f64; 2], by: f64| [y[0] + by * rate[0], y[1] + by * rate[1]];
        let a = rate(at, y);
        let b = rate(at + 0.5 * h, step(a, 0.5 * h));
        let c = rate(at + 0.5 * h, step(b, 0.5 * h));
        let d = rate(at + h, step(c, h));
        y = [0, 1].map(|i| y[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
    }
    found
}

/// Steps of the integration across the wall.
const STEPS: usize = 5000;

/// Relative errors of the inner radius' change, and mean-square of the stress.
fn cylinder(degree: u32, cells: u32, inner: f64) -> Result<[f64; 2], Broken> {
    let changes = [
        ("mesh.axes[0]", axis(0.0, 12.0, f64::from(cells))),
        ("mesh.axes[1]", axis(0.0, 12.0, f64::from(cells))),
        ("mesh.functions", functions(degree)),
        ("output.fields", "[CauchyStress, Outline]".into()),
    ];
    let history = run(&changed(text("cylinder_pressure")?, &changes)?)?.completed()?;
    let last = history.rows().len() - 1;
    let corners = history.field(Field::OUTLINE, last).chunks_exact(2).map(|x| x[0].hypot(x[1]));
    let rest = history.field(Field::OUTLINE, 0).chunks_exact(2).map(|x| x[0].hypot(x[1]));
    let of_inner: Vec<f64> = corners.zip(rest).filter(|(_, rest)| *rest < 5.0 + 1e-6).map(|it| it.0).collect();
    let mean = of_inner.iter().sum::<f64>() / of_inner.len() as f64;
    Ok([((mean - inner) / (inner - 5.0)).abs(), stress_error(&history, inner)])
}

/// Mean-square error of the stress over itself, of a cylinder along z.
pub(super) fn stress_error(history: &History, inner: f64) -> f64 {
    stress_error_about(history, inner, &Matrix3::identity())
}

/// The same of a cylinder about the z axis of a frame, whose axes are the columns of `frame`; without the stress along it.
pub(super) fn stress_error_about(history: &History, inner: f64, frame: &Matrix3<f64>) -> f64 {
    let exact = across_the_wall(inner, 60.0, STEPS);
    let stress = history.field(Field::CAUCHY_STRESS, history.rows().len() - 1).chunks_exact(9);
    let (mut error, mut size) = (0.0, 0.0);
    for (s, x) in stress.zip(history.rows()[0].positions.chunks_exact(3)) {
        let s = frame.transpose() * Matrix3::from_row_slice(s) * frame;
        let x = frame.transpose() * Vector3::from_column_slice(x);
        let radius = x[0].hypot(x[1]);
        let at = (radius - 5.0) / 5.0 * STEPS as f64;
        let (k, part) = (at.floor() as usize, at.fract());
        let [radial, hoop] = [0, 1].map(|i| exact[k].1[i] * (1.0 - part) + exact[k + 1].1[i] * part);
        let [c, d] = [x[0] / radius, x[1] / radius];
        let expected = [radial * c * c + hoop * d * d, (radial - hoop) * c * d, radial * d * d + hoop * c * c];
        for (found, expected, twice) in
            [(s[(0, 0)], expected[0], 1.0), (s[(0, 1)], expected[1], 2.0), (s[(1, 1)], expected[2], 1.0)]
        {
            error += twice * radius * (found - expected).powi(2);
            size += twice * radius * expected.powi(2);
        }
    }
    (error / size).sqrt()
}

/// Inner radius under a pressure of 60.
pub(super) fn inner_radius() -> Result<f64, Broken> {
    let table = Reference::read("cylinder_pressure")?;
    let (pressure, inner) = (table.column("pressure")?, table.column("inner_radius")?);
    Ok(pressure.iter().position(|p| *p == 60.0).map(|k| inner[k]).ok_or("no row of the pressure 60")?)
}

fn cylinders(extent: Extent) -> Result<Findings, Broken> {
    let inner = inner_radius()?;
    let mut findings = Findings::default();
    let outer = across_the_wall(inner, 60.0, STEPS).last().map_or(f64::NAN, |it| it.1[0]);
    findings.checks.push(Check::new(
        "the reference: radial stress outside over the pressure",
        outer.abs() / 60.0,
        1e-6,
    ));
    let meshes: &[u32] = extent.pick(&[12, 24], &[12, 24, 48]);
    let runs: Vec<(u32, u32)> =
        [1, 2, 3].into_iter().flat_map(|degree| meshes.iter().map(move |&n| (degree, n))).collect();
    let found = sweep(&runs, |&(degree, cells)| cylinder(degree, cells, inner))?;
    let heads = ["degree", "cells", "inner radius", "stress"];
    let mut errors = Table::new(
        "Relative errors of the change of the inner radius, and of the stress in the mean square.",
        &heads,
    );
    for ((degree, cells), found) in runs.iter().zip(&found) {
        let [radius, stress] = found.map(|it| scientific(it, 2));
        errors.push([degree.to_string(), format!("{cells}²"), radius, stress]);
    }
    findings.tables.push(errors);
    let of = |degree: u32, cells: u32| {
        runs.iter().position(|it| *it == (degree, cells)).map_or([f64::NAN; 2], |k| found[k])
    };
    for (name, at, most) in [("inner radius", 0, 4e-5), ("stress", 1, 4e-3)] {
        findings.checks.push(Check::new(format!("degree 2, 12² cells: {name}"), of(2, 12)[at], most));
        let order = (of(2, 12)[at] / of(2, 24)[at]).log2();
        findings.checks.push(
            Check::new(
                format!("degree 2, {name}: order from 12² to 24² cells below 1.9"),
                (1.9 - order).max(0.0),
                0.0,
            )
            .remark(format!("{order:.2}")),
        );
    }
    Ok(findings)
}

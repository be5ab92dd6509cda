//! Thick walls against closed forms.

use super::Rays;
use crate::cases::{fixed, scientific, sweep};
use crate::scenes::run;
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::Scene;
use std::f64::consts::TAU;

pub(in crate::cases) const CASE: Case = Case {
    name: "thick walls of revolution",
    goal: "In the half plane (r, z) the pressure in a cylinder and in a sphere converges to that of the closed forms, elastic and plastic, for every basis with domains.",
    setup: "A cylinder 1 < r < 3 between plates, its outside held, its inside driven by 0.3 in 6 load steps while the mesh follows, 8, 16 and 32 cells; a quarter ring 1 < R < 3 of 6², 12² and 24² cells, whose rotation is a hollow sphere with a free outside, its inside driven by 0.01 while the mesh follows, elastic in 1 load step and with ρ_y = 4 in 20. E = 10³, ν = 0.3, 2² points a cell.",
    reference: "Equilibrium in logarithmic strains, integrated to eleven digits: 321.750314652756 in the cylinder; 14.2795847801202 and, plastic to R = 2.02, 7.07869109172407 in the sphere.",
    run: walls,
};

/// Pressure inside the cylinder.
const CYLINDER: f64 = 321.750_314_652_756;

/// Pressures inside the sphere: elastic, and with ρ_y = 4.
const SPHERE: [f64; 2] = [14.279_584_780_120_2, 7.078_691_091_724_07];

fn cylinder(basis: &str, cells: u32) -> Result<f64, Broken> {
    let height = 2.0 / f64::from(cells);
    let history = run(&Scene::from_ron(&format!(
        r#"Axisymmetric(
            mesh: Box(axes: [Uniform(from: 1, to: 3, cells: {cells}), Uniform(from: 0, to: {height}, cells: 1)]),
            motion: Stretch([(axis: R, anchor: 3, driven: 1, displacement: 0.3)]),
            basis: {basis}, materials: {{ "m": Hencky(young: 1000, poisson: 0.3) }},
            bodies: [(name: "wall", material: "m", shape: Box(from: (1, 0), to: (3, {height})), points_per_cell: 2)],
            supports: [
                (name: "plates", region: Everywhere, fix: [Z]),
                (name: "inner", region: Plane(axis: R, at: 1), follow_mesh: [R]),
                (name: "outer", region: Plane(axis: R, at: 3), fix: [R]),
            ],
            schedule: (steps: 6), output: (fields: []),
        )"#
    ))?)?
    .completed()?;
    let force = history.series("reaction/inner", 0).last().copied().unwrap_or(f64::NAN);
    Ok(force / (TAU * 1.3 * height))
}

fn sphere((basis, mean, is_plastic): (&str, bool, bool), cells: u32) -> Result<f64, Broken> {
    let law = if is_plastic {
        "VonMises(young: 1000, poisson: 0.3, yield_radius: 4)"
    } else {
        "Hencky(young: 1000, poisson: 0.3)"
    };
    let mean = if mean { ", mean_dilatation: Points" } else { "" };
    let rays = Rays::new(cells);
    let (supports, steps) = (rays.supports(), if is_plastic { 20 } else { 1 });
    let history = run(&Scene::from_ron(&format!(
        r#"Axisymmetric(
            mesh: Ring(radii: Uniform(from: 1, to: 3, cells: {cells}), sectors: {cells}, angles: (0, 90)),
            motion: Expand(anchor: 3, driven: 1, displacement: 0.01),
            basis: {basis}, materials: {{ "m": {law} }},
            bodies: [(name: "ball", material: "m", shape: Ring(inner: 1, outer: 3), points_per_cell: 2{mean})],
            supports: [(name: "floor", region: Plane(axis: Z, at: 0), fix: [Z]), {supports}],
            schedule: (steps: {steps}), output: (fields: []),
        )"#
    ))?)?
    .completed()?;
    let force = rays.force(&history).last().copied().unwrap_or(f64::NAN);
    Ok(force / (TAU * 1.01 * 1.01))
}

/// Errors on the meshes and the order of the last two.
fn converge(
    what: &str,
    errors: &[f64],
    (cells, finest, order): (&[u32], f64, f64),
    table: &mut Table,
    findings: &mut Findings,
) {
    for (k, (cells, error)) in cells.iter().zip(errors).enumerate() {
        let shown = if k == 0 { "".into() } else { fixed((errors[k - 1] / error).abs().log2(), 2) };
        table.push([what.to_owned(), cells.to_string(), scientific(*error, 3), shown]);
    }
    // The same cells in both extents.
    let (coarse, fine) = (errors[0].abs(), errors[1].abs());
    findings.checks.push(Check::new(format!("{what}, {} cells: pressure (relative)", cells[1]), fine, finest));
    let lack = (order - (coarse / fine).log2()).max(0.0);
    findings.checks.push(Check::new(
        format!("{what}: order from {} and {} cells, lack below {order}", cells[0], cells[1]),
        lack,
        0.0,
    ));
}

fn walls(extent: Extent) -> Result<Findings, Broken> {
    let mut findings = Findings::default();
    let heads = ["what", "cells", "error of the pressure", "order"];
    let mut table = Table::new("Pressures inside against the closed forms:", &heads);
    let bases = ["Gimp", "Cpdi1", "Cpdi2q", "Cpdi2t"];
    let cells = extent.pick(&[8, 16][..], &[8, 16, 32]);
    let jobs: Vec<(&str, u32)> =
        bases.iter().flat_map(|basis| cells.iter().map(move |&cells| (*basis, cells))).collect();
    let runs = sweep(&jobs, |(basis, cells)| cylinder(basis, *cells))?;
    for (basis, runs) in bases.iter().zip(runs.chunks(cells.len())) {
        let errors: Vec<f64> = runs.iter().map(|pressure| pressure / CYLINDER - 1.0).collect();
        // GIMP's boxes do not follow the shape of the points at the inside as parallelograms do.
        converge(&format!("cylinder, {basis}"), &errors, (cells, 1e-3, 1.8), &mut table, &mut findings);
    }
    let kinds: Vec<(&str, bool, bool)> = ["Cpdi1", "Cpdi2q"]
        .iter()
        .flat_map(|basis| [(*basis, false, false), (*basis, true, false), (*basis, true, true)])
        .collect();
    let cells = extent.pick(&[6, 12][..], &[6, 12, 24]);
    let jobs: Vec<((&str, bool, bool), u32)> =
        kinds.iter().flat_map(|kind| cells.iter().map(move |&cells| (*kind, cells))).collect();
    let runs = sweep(&jobs, |(kind, cells)| sphere(*kind, *cells))?;
    for ((basis, mean, is_plastic), runs) in kinds.iter().zip(runs.chunks(cells.len())) {
        let exact = SPHERE[usize::from(*is_plastic)];
        let errors: Vec<f64> = runs.iter().map(|pressure| pressure / exact - 1.0).collect();
        let law = if *is_plastic { "plastic" } else { "elastic" };
        let what = format!("sphere, {basis}, {law}{}", if *mean { ", mean dilatation" } else { "" });
        converge(&what, &errors, (cells, 0.01, 1.4), &mut table, &mut findings);
    }
    findings.tables.push(table);
    Ok(findings)
}

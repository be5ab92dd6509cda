//! Bodies of revolution: thick walls against closed forms, and circular footings against limit loads.

use super::{fixed, scientific, sweep};
use crate::scenes::run;
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::Scene;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

pub(super) const WALLS: Case = Case {
    name: "thick walls of revolution",
    goal: "In the half plane (r, z) the pressure in a cylinder and in a sphere converges to that of the closed forms, elastic and plastic, for every basis with domains.",
    setup: "A cylinder 1 < r < 3 between plates, its outside held, its inside driven by 0.3 in 6 load steps while the mesh follows, 8, 16 and 32 cells; a quarter ring 1 < R < 3 of 6², 12² and 24² cells, whose rotation is a hollow sphere with a free outside, its inside driven by 0.01 while the mesh follows, elastic in 1 load step and with ρ_y = 4 in 20. E = 10³, ν = 0.3, 2² points a cell.",
    reference: "Equilibrium in logarithmic strains, integrated to eleven digits: 321.750314652756 in the cylinder; 14.2795847801202 and, plastic to R = 2.02, 7.07869109172407 in the sphere.",
    run: walls,
};

pub(super) const FOOTING: Case = Case {
    name: "circular footing",
    goal: "The pressure under a rigid circular footing converges to the limit loads of Tresca's law, and under von Mises' law to loads within its bounds.",
    setup: "Footing of radius 1, smooth and rough, on ground of 5 × 5 whose cells grow by 1.25 beyond it, E = 10⁵, ν = 0.49, undrained strength s_u = 1 in pure shear, settlement 3·10⁻⁴ in 30 load steps; 4, 8 and 16 cells under the footing, CPDI1 with mean dilatation.",
    reference: "Bearing capacity factors of Tresca's law: 5.689 smooth (Eason & Shield 1960), 6.048 rough (Eason & Shield 1960; Houlsby & Martin 2003). Von Mises' circle of the same strength in pure shear lies within the hexagon of 2/√3 times that strength and holds that of the strength itself: √3/2 to 1 times these factors. Values are of first order in the cells: the footing's last node carries half a cell more than its radius.",
    run: footing,
};

/// Pressure inside the cylinder.
const CYLINDER: f64 = 321.750_314_652_756;

/// Pressures inside the sphere: elastic, and with ρ_y = 4.
const SPHERE: [f64; 2] = [14.279_584_780_120_2, 7.078_691_091_724_07];

/// Factors of Tresca's law: smooth, rough.
const FACTORS: [f64; 2] = [5.689, 6.048];

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
    // Rays of the inner nodes: angle, and the direction in which they are driven.
    let rays: Vec<(f64, [f64; 2])> = (0..=cells)
        .map(|k| {
            let part = f64::from(k) / f64::from(cells);
            let (sin, cos) = (FRAC_PI_2 * part).sin_cos();
            (90.0 * part, [if k == cells { 0.0 } else { cos }, sin])
        })
        .collect();
    let supports: Vec<String> = rays
        .iter()
        .enumerate()
        .map(|(k, (angle, along))| {
            let driven: Vec<&str> =
                ["R", "Z"].iter().zip(along).filter(|(_, part)| **part != 0.0).map(|(axis, _)| *axis).collect();
            let driven = driven.join(", ");
            format!("(name: \"i{k}\", region: All([Circle(radius: 1), Ray(angle: {angle})]), follow_mesh: [{driven}]),")
        })
        .collect();
    let (supports, steps) = (supports.concat(), if is_plastic { 20 } else { 1 });
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
    let last = |k: usize, c: usize| history.series(&format!("reaction/i{k}"), c).last().copied();
    let work = |(k, (_, along)): (usize, &(f64, [f64; 2]))| {
        last(k, 0).unwrap_or(f64::NAN) * along[0] + last(k, 1).unwrap_or(f64::NAN) * along[1]
    };
    Ok(rays.iter().enumerate().map(work).sum::<f64>() / (TAU * 1.01 * 1.01))
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

/// Lines from the footing's middle to the side: even under it, then growing.
fn lines(cells: u32) -> Vec<f64> {
    let mut lines: Vec<f64> = (0..=cells).map(|k| f64::from(k) / f64::from(cells)).collect();
    let (mut at, mut size) = (1.0, 1.0 / f64::from(cells));
    while at < 5.0 {
        size *= 1.25;
        at += size;
        lines.push(at.min(5.0));
    }
    // The last cell is not much smaller than the one before.
    let n = lines.len();
    if lines[n - 1] - lines[n - 2] < 0.5 * (lines[n - 2] - lines[n - 3]) {
        lines.remove(n - 2);
    }
    lines
}

/// Force at the end over `π s_u`.
fn press((law, is_rough): (&str, bool), cells: u32) -> Result<f64, Broken> {
    let lines = lines(cells);
    let heights: Vec<f64> = lines.iter().rev().map(|x| -x).collect();
    let rough = if is_rough { ", fix: [R]" } else { "" };
    let history = run(&Scene::from_ron(&format!(
        r#"Axisymmetric(
            mesh: Box(axes: [Nodes({lines:?}), Nodes({heights:?})]),
            basis: Cpdi1, materials: {{ "clay": {law} }},
            bodies: [(name: "ground", material: "clay", shape: Box(from: (0, -5), to: (5, 0)), points_per_cell: 2,
                mean_dilatation: Points)],
            supports: [
                (name: "base", region: Plane(axis: Z, at: -5), fix: [Z]), (name: "side", region: Plane(axis: R, at: 5), fix: [R]),
                (name: "footing", region: Box(from: (0, 0), to: (1, 0)), displace: [(axis: Z, by: -3e-4)]{rough}),
            ],
            schedule: (steps: 30, cuts: 6), output: (fields: []),
        )"#
    ))?)?
    .completed()?;
    Ok(-history.series("reaction/footing", 1).last().copied().unwrap_or(f64::NAN) / PI)
}

fn footing(extent: Extent) -> Result<Findings, Broken> {
    const TRESCA: &str = "Tresca(young: 1e5, poisson: 0.49, undrained_strength: 1)";
    const MISES: &str = "VonMises(young: 1e5, poisson: 0.49, yield_radius: 1.4142135623730951)";
    let cells = extent.pick(&[4, 8][..], &[4, 8, 16]);
    let kinds = [(TRESCA, false), (TRESCA, true), (MISES, false), (MISES, true)];
    let jobs: Vec<((&str, bool), u32)> =
        kinds.iter().flat_map(|kind| cells.iter().map(move |&cells| (*kind, cells))).collect();
    let runs = sweep(&jobs, |(kind, cells)| press(*kind, *cells))?;
    let mut findings = Findings::default();
    let heads = ["law", "footing", "cells", "N_c", "N_c, half a cell more"];
    let mut table =
        Table::new("Force at the end over π s_u, and over that of half a cell more than the radius:", &heads);
    for ((law, is_rough), runs) in kinds.iter().zip(runs.chunks(cells.len())) {
        let name = if *law == TRESCA { "Tresca" } else { "von Mises" };
        let surface = if *is_rough { "rough" } else { "smooth" };
        for (cells, factor) in cells.iter().zip(runs) {
            let radius = 1.0 + 0.5 / f64::from(*cells);
            table.push([
                name.to_owned(),
                surface.to_owned(),
                cells.to_string(),
                fixed(*factor, 3),
                fixed(factor / (radius * radius), 3),
            ]);
        }
        let exact = FACTORS[usize::from(*is_rough)];
        for (pair, runs) in cells.windows(2).zip(runs.windows(2)) {
            let limit = 2.0 * runs[1] - runs[0];
            let from = format!("{name}, {surface}: N_c from {} and {} cells", pair[0], pair[1]);
            if *law == TRESCA {
                let error = (limit / exact - 1.0).abs();
                findings
                    .checks
                    .push(Check::new(format!("{from} (relative)"), error, 0.02).remark(fixed(limit, 3)));
            } else {
                let within = (0.75_f64.sqrt() * exact..=exact).contains(&limit);
                let what = format!("{from}, within its bounds");
                findings.checks.push(Check::none(what, usize::from(!within)).remark(fixed(limit, 3)));
            }
        }
    }
    findings.tables.push(table);
    Ok(findings)
}

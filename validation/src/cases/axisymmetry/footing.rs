//! Circular footings against limit loads.

use super::{lines, list};
use crate::cases::{fixed, sweep};
use crate::scenes::run;
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::Scene;
use std::f64::consts::PI;

pub(in crate::cases) const CASE: Case = Case {
    name: "circular footing",
    goal: "The pressure under a rigid circular footing converges to the limit loads of Tresca's law, and under von Mises' law to loads within its bounds.",
    setup: "Footing of radius 1, smooth and rough, on ground of 5 × 5 whose cells grow by 1.25 beyond it, E = 10⁵, ν = 0.49, undrained strength s_u = 1 in pure shear, settlement 3·10⁻⁴ in 30 load steps; 4, 8 and 16 cells under the footing, CPDI1 with mean dilatation.",
    reference: "Bearing capacity factors of Tresca's law: 5.689 smooth (Eason & Shield 1960), 6.048 rough (Eason & Shield 1960; Houlsby & Martin 2003). Von Mises' circle of the same strength in pure shear lies within the hexagon of 2/√3 times that strength and holds that of the strength itself: √3/2 to 1 times these factors. Values are of first order in the cells: the footing's last node carries half a cell more than its radius.",
    run: footing,
};

/// Factors of Tresca's law: smooth, rough.
const FACTORS: [f64; 2] = [5.689, 6.048];

/// Force at the end over `π s_u`.
fn press((law, is_rough): (&str, bool), cells: u32) -> Result<f64, Broken> {
    let lines = lines(cells, 1.0, 1.25, 5.0);
    let heights = list(lines.iter().rev().map(|x| -x));
    let lines = list(lines);
    let rough = if is_rough { ", fix: [R]" } else { "" };
    let history = run(&Scene::from_ron(&format!(
        r#"Axisymmetric(
            mesh: Box(axes: [Nodes({lines}), Nodes({heights})]),
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

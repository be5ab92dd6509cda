//! A circular footing in space, by a quarter.

use super::footing::graded;
use super::{iterations, scene};
use crate::cases::{fixed, sweep};
use crate::history::History;
use crate::scenes::run;
use crate::{Broken, Case, Check, Extent, Findings, Table};
use std::f64::consts::PI;

pub(in crate::cases) const CASE: Case = Case {
    name: "circular footing in space",
    goal: "In space, by a quarter, the pressure under a circular footing converges to the limit loads of Tresca's law, as it does in the half plane of a body of revolution.",
    setup: "A quarter of a footing of radius 1, smooth and rough, on weightless clay of radius 5 and depth 5, Tresca, s_u = 1, E = 10⁵, ν = 0.49; a ring mesh of a quarter turn about a hole of radius 0.1, whose nodes may only move along it; c cells under the footing, 2c beyond and in the depth, growing, and c around; standard MPM, 2³ points a cell, mean dilatation over cells; settlement 3·10⁻⁴ in 15 load steps.",
    reference: "N_c = 5.689 smooth, 6.048 rough (Eason & Shield 1960; Houlsby & Martin 2003), met from above with order one: the cell under the edge counts in part to the radius.",
    run: circle,
};

/// The mesh with `cells` under the footing.
fn mesh(cells: u32) -> String {
    let size = (1.0 - HOLE) / f64::from(cells);
    let inside = (0..cells).map(|k| HOLE + size * f64::from(k));
    let outside = graded(size, 4.0, 2 * cells);
    let radii = inside.chain(outside.iter().map(|r| 1.0 + r));
    let up = graded(size, 5.0, 2 * cells).into_iter().rev().map(|depth| -depth).chain([size]);
    let list = |nodes: Vec<f64>| nodes.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
    let (radii, up) = (list(radii.collect()), list(up.collect()));
    format!("Ring(radii: Nodes([{radii}]), sectors: {cells}, angles: (0, 90), height: Nodes([{up}]))")
}

/// Radius of the hole about the axis.
const HOLE: f64 = 0.1;

/// Force on a quarter over π/4 s_u, row by row.
fn factors(history: &History) -> Vec<f64> {
    history.series("reaction/footing", 2).iter().map(|force| -force / (0.25 * PI)).collect()
}

fn circle(extent: Extent) -> Result<Findings, Broken> {
    let meshes: &[u32] = extent.pick(&[4, 8], &[4, 8, 12]);
    let footings = [("smooth", "[]", 5.689), ("rough", "[X, Y]", 6.048)];
    let jobs: Vec<(&str, u32)> =
        footings.iter().flat_map(|it| meshes.iter().map(move |&cells| (it.1, cells))).collect();
    let runs = sweep(&jobs, |(fix, cells)| {
        let changes =
            [("mesh", mesh(*cells)), ("supports[5].fix", (*fix).to_owned()), ("output.fields", "[]".into())];
        run(&scene("footing_circle", &changes)?)?.completed()
    })?;
    let mut findings = Findings::default();
    let heads = ["footing", "cells", "N_c", "over the limit", "growth", "Newton iterations"];
    let text = "Force at the end over π s_u, its growth in the last fifth of the settlement, and Newton iterations in 15 load steps:";
    let mut table = Table::new(text, &heads);
    for ((name, _, limit), runs) in footings.iter().zip(runs.chunks(meshes.len())) {
        let mut ends = Vec::new();
        for (cells, history) in meshes.iter().zip(runs) {
            let factors = factors(history);
            let (end, before) = (factors[factors.len() - 1], factors[factors.len() - 4]);
            ends.push(end);
            table.push([
                (*name).into(),
                cells.to_string(),
                fixed(end, 4),
                fixed(end / limit, 4),
                format!("{} %", fixed(100.0 * (end / before - 1.0), 2)),
                iterations(history).to_string(),
            ]);
        }
        for (ends, meshes) in ends.windows(2).zip(meshes.windows(2)) {
            // The error is of order one in the size of a cell.
            let [coarse, fine] = [meshes[0], meshes[1]].map(f64::from);
            let factor = (fine * ends[1] - coarse * ends[0]) / (fine - coarse);
            let what = format!("{name}: N_c from {} and {} cells (relative)", meshes[0], meshes[1]);
            let error = (factor / limit - 1.0).abs();
            findings.checks.push(Check::new(what, error, 0.01).remark(fixed(factor, 3)));
        }
    }
    findings.tables.push(table);
    Ok(findings)
}

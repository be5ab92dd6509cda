//! Strip footings at their limit load.

use super::{iterations, newton_at_limit, scene};
use crate::cases::{fixed, sweep};
use crate::history::History;
use crate::picture::{Curve, Curves, Legend, Panel, Picture, Stroke};
use crate::scenes::run;
use crate::{Broken, Case, Check, Extent, Findings, Table};
use std::f64::consts::PI;

pub(in crate::cases) const CLAY: Case = Case {
    name: "strip footing on clay",
    goal: "The pressure under a strip footing levels off at the limit load of uniform clay and of clay whose strength grows with depth, and converges to it.",
    setup: "Half of a rigid footing of width B = 1 on weightless clay, 5 wide and 4 deep, s_u = 1 (+ k z), E = 10⁵ s_u, ν = 0.495, mean dilatation over points, standard MPM, 2² points a cell; c cells under half of the footing, three times as many beyond and below, growing from the same size; settlement 3·10⁻⁴ (on s_u0 + k z, 2·10⁻⁴) in 20 load steps, the mesh follows.",
    reference: "Smooth and rough: (2 + π) s_u (Prandtl). Smooth on s_u0 + k z: characteristics (method of Davis & Booker 1973). Met from above with order one: a cell under the edge counts in part to the width.",
    run: clay,
};

pub(in crate::cases) const SAND: Case = Case {
    name: "strip footing on sand",
    goal: "The bearing capacity factors N_q and N_c of weightless ground with friction are met from above.",
    setup: "As on clay, with Mohr–Coulomb and associated flow, ν = 0.3, E = 5·10⁴ times the limit pressure, settlement 0.001: N_q with c = 0, a surcharge of 1 beside the footing and σ₀ = −I; N_c with c = 1. φ = 35° and 40°: 10 wide and 6 deep.",
    reference: "Prandtl and Reissner: N_q = tan²(45° + φ/2) exp(π tan φ), N_c = (N_q − 1) cot φ.",
    run: sand,
};

pub(in crate::cases) const HEAVY: Case = Case {
    name: "strip footing on heavy sand",
    goal: "The bearing capacity factor N_γ of ground with weight and friction is met from above.",
    setup: "As on clay, with Mohr–Coulomb and associated flow, c = 10⁻⁴ γB, ν = 0.3, E = 5·10⁵ times the limit pressure, K₀ = 1 at the start; settlement 10⁻⁴.",
    reference: "Mean pressure over ½ γB under a smooth footing, by characteristics: 1.579 at φ = 20° and 7.653 at 30°.",
    run: heavy,
};

/// Nodes from 0 to `length`: so many cells that grow by a common factor from the first, of `size`.
pub(super) fn graded(size: f64, length: f64, cells: u32) -> Vec<f64> {
    let reach = |growth: f64, n: u32| size * (0..n).map(|k| growth.powf(f64::from(k))).sum::<f64>();
    let (mut low, mut high) = (0.5, 4.0);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        *(if reach(middle, cells) > length { &mut high } else { &mut low }) = middle;
    }
    (0..cells).map(|k| reach(low, k)).chain([length]).collect()
}

/// The mesh of a footing with `cells` under its half, on ground so `wide` and `deep`, and a row above the surface.
fn mesh(cells: u32, wide: f64, deep: f64) -> String {
    let size = 0.5 / f64::from(cells);
    let across = (0..cells).map(|k| size * f64::from(k));
    let across = across.chain(graded(size, wide - 0.5, 3 * cells).into_iter().map(|x| 0.5 + x));
    let up = graded(size, deep, 3 * cells).into_iter().rev().map(|depth| -depth).chain([size]);
    let list = |nodes: Vec<f64>| nodes.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
    format!("Box(axes: [Nodes([{}]), Nodes([{}])])", list(across.collect()), list(up.collect()))
}

/// Pressure over the limit against settlement.
struct Pushed {
    path: Vec<(f64, f64)>,
    history: History,
}

impl Pushed {
    fn of(scene_name: &str, changes: &[(&str, String)], limit: f64) -> Result<Self, Broken> {
        let mut changes = changes.to_vec();
        changes.push(("output.fields", "[]".to_owned()));
        let history = run(&scene(scene_name, &changes)?)?.completed()?;
        let force = history.series("reaction/footing", 1);
        let path =
            history.rows().iter().zip(force).map(|(row, f)| (row.fraction, -f / (0.5 * limit))).collect();
        Ok(Self { path, history })
    }

    fn end(&self) -> f64 {
        self.path.last().map_or(f64::NAN, |it| it.1)
    }

    /// Change of the pressure in the last fifth of the settlement, of itself.
    fn growth(&self) -> f64 {
        let before = self.path.iter().rev().find(|it| it.0 < 0.801).map_or(f64::NAN, |it| it.1);
        self.end() / before - 1.0
    }
}

/// What stands under a footing.
struct Ground {
    name: String,
    changes: Vec<(&'static str, String)>,
    /// Limit pressure.
    limit: f64,
    /// Excess allowed, times the cells under half of the footing.
    excess: f64,
    /// How far the limit extrapolated from two meshes may be off.
    extrapolated: f64,
    size: (f64, f64),
}

/// Runs every ground on every mesh, one after another below in the table.
fn settle(
    scene_name: &str,
    grounds: &[Ground],
    meshes: &[u32],
    text: &str,
) -> Result<(Findings, Vec<Pushed>), Broken> {
    let jobs: Vec<(&Ground, u32)> =
        grounds.iter().flat_map(|ground| meshes.iter().map(move |&cells| (ground, cells))).collect();
    let runs = sweep(&jobs, |(ground, cells)| {
        let mut changes = ground.changes.clone();
        changes.push(("mesh", mesh(*cells, ground.size.0, ground.size.1)));
        Pushed::of(scene_name, &changes, ground.limit)
    })?;
    let mut findings = Findings::default();
    let heads = ["ground", "cells", "limit", "pressure over the limit", "growth", "Newton iterations"];
    let mut table = Table::new(text, &heads);
    for (ground, runs) in grounds.iter().zip(runs.chunks(meshes.len())) {
        for (&cells, run) in meshes.iter().zip(runs) {
            table.push([
                ground.name.clone(),
                cells.to_string(),
                fixed(ground.limit, 4),
                fixed(run.end(), 4),
                format!("{} %", fixed(100.0 * run.growth(), 2)),
                iterations(&run.history).to_string(),
            ]);
            let of = |what: &str| format!("{}, {cells} cells: {what}", ground.name);
            let excess = (run.end() - 1.0).abs();
            let tolerance = ground.excess / f64::from(cells);
            findings.checks.push(Check::new(of("pressure against the limit"), excess, tolerance));
            findings.checks.push(Check::new(of("growth in the last fifth"), run.growth().abs(), 0.01));
            findings.checks.extend(newton_at_limit(&format!("{}, {cells} cells", ground.name), &run.history));
        }
        for (runs, meshes) in runs.windows(2).zip(meshes.windows(2)) {
            let end = 2.0 * runs[1].end() - runs[0].end();
            let what = format!("{}: limit from {} and {} cells", ground.name, meshes[0], meshes[1]);
            findings
                .checks
                .push(Check::new(what, (end - 1.0).abs(), ground.extrapolated).remark(fixed(end, 4)));
        }
    }
    findings.tables.push(table);
    Ok((findings, runs))
}

fn clay(extent: Extent) -> Result<Findings, Broken> {
    let meshes: &[u32] = extent.pick(&[8], &[8, 16, 32]);
    let ground = |name: &str, changes, limit, excess, extrapolated| Ground {
        name: name.into(),
        changes,
        limit,
        excess,
        extrapolated,
        size: (5.0, 4.0),
    };
    let prandtl = 2.0 + PI;
    let mut grounds = vec![
        ground("smooth", vec![], prandtl, 0.4, 0.01),
        ground("smooth, Tresca", vec![("bodies[0].material", "\"tresca\"".into())], prandtl, 0.4, 0.01),
        ground("rough", vec![("supports[3].fix", "[X]".into())], prandtl, 0.45, 0.01),
    ];
    for (gradient, limit) in [(1, 5.9818), (2, 6.6608), (4, 7.8188), (10, 10.670)] {
        let field =
            |value: f64| format!("Linear(at: 0, value: {value}, gradient: {})", value * f64::from(gradient));
        let changes = vec![
            ("materials.clay.undrained_strength", field(1.0)),
            ("materials.clay.young", field(1e5)),
            ("motion[0].displacement", "-2e-4".to_owned()),
        ];
        grounds.push(ground(&format!("smooth, k B = {gradient} s_u0"), changes, limit, 0.6, 0.02));
    }
    let text = "Pressure at the end over the limit, its growth in the last fifth of the settlement, and Newton iterations in 20 load steps. Without mean dilatation there is no limit (see *rigid footing*):";
    let (mut findings, runs) = settle("footing", &grounds, meshes, text)?;
    if extent == Extent::Full {
        let mut curves = Vec::new();
        for (k, (ground, runs)) in grounds.iter().zip(runs.chunks(meshes.len())).enumerate() {
            for (run, stroke) in runs.iter().step_by(2).zip([Stroke::Dashes, Stroke::Line]) {
                if k == 0 || k == 2 || k == 6 {
                    let name = if stroke == Stroke::Dashes { ground.name.clone() } else { String::new() };
                    let points = run.path.iter().map(|it| (it.0, it.1)).collect();
                    curves.push(Curve { name, colour: k, stroke, points });
                }
            }
        }
        findings.pictures.push(Picture {
            file: "soil_footing.svg",
            caption: "Strip footing on clay: pressure over the limit against settlement; dashes 8, lines 32 cells under half of the footing.".into(),
            panels: vec![Panel::Curves(Curves {
                title: "Strip footing on clay".into(),
                axes: ["part of the settlement", "pressure over the limit"].map(String::from),
                range: [(0.0, 1.0), (0.0, 1.2)],
                logarithmic: [false; 2],
                legend: Legend::LowerRight,
                curves,
            })],
        });
    }
    Ok(findings)
}

/// N_q and N_c `[-]`.
fn factors(friction: f64) -> (f64, f64) {
    let angle = friction.to_radians();
    let n_q = (0.25 * PI + 0.5 * angle).tan().powi(2) * (PI * angle.tan()).exp();
    (n_q, (n_q - 1.0) / angle.tan())
}

fn sand(extent: Extent) -> Result<Findings, Broken> {
    let meshes: &[u32] = extent.pick(&[8], &[8, 16]);
    let angles: &[u32] = extent.pick(&[20, 30], &[20, 25, 30, 35, 40]);
    let mut grounds = Vec::new();
    for &friction in angles {
        let (n_q, n_c) = factors(f64::from(friction));
        // The wider ground has as many cells, which grow faster away from the footing.
        let (size, excess) = if friction < 35 { ((5.0, 4.0), 1.6) } else { ((10.0, 6.0), 2.7) };
        let sand = |limit: f64, cohesion: u32| {
            format!(
                "MohrCoulomb(young: {}, poisson: 0.3, cohesion: {cohesion}, friction: {friction}, dilation: {friction})",
                5e4 * limit
            )
        };
        let surcharge = format!(
            "[Traction(body: \"ground\", axis: Y, at: 0, within: (from: (0.5, -1), to: ({}, 1)), resultant: (0, {}), ramp: [(0, 1)])]",
            size.0,
            0.5 - size.0
        );
        let body = |initial: &str| {
            format!(
                "(name: \"ground\", material: \"sand\", shape: Box(from: (0, {}), to: ({}, 0)), points_per_cell: 2, mean_dilatation: Points{initial})",
                -size.1, size.0
            )
        };
        for (name, limit, cohesion, loads, initial) in [
            ("N_q", n_q, 0, surcharge.clone(), ", initial: Stress(xx: -1, yy: -1, zz: -1)"),
            ("N_c", n_c, 1, "[]".to_owned(), ""),
        ] {
            let changes = vec![
                ("materials.sand", sand(limit, cohesion)),
                ("bodies[0]", body(initial)),
                ("loads", loads),
                (
                    "motion",
                    format!("Stretch([(axis: Y, anchor: {}, driven: 0, displacement: -0.001)])", -size.1),
                ),
                ("supports[1].region.at", size.0.to_string()),
                ("supports[2].region.at", (-size.1).to_string()),
            ];
            let name = format!("{name}, φ = {friction}°");
            grounds.push(Ground { name, changes, limit, excess, extrapolated: 0.02, size });
        }
    }
    let text = "Pressure at the end over the limit, its growth in the last fifth of the settlement, and Newton iterations in 20 load steps:";
    Ok(settle("footing_sand", &grounds, meshes, text)?.0)
}

fn heavy(extent: Extent) -> Result<Findings, Broken> {
    let meshes: &[u32] = extent.pick(&[8], &[8, 16]);
    let factors: &[(u32, f64)] = extent.pick(&[(30, 7.653)], &[(20, 1.579), (30, 7.653)]);
    let ground = |&(friction, factor): &(u32, f64)| {
        let limit = 0.5 * factor;
        let sand = format!(
            "MohrCoulomb(young: {}, poisson: 0.3, cohesion: 1e-4, friction: {friction}, dilation: {friction}, density: 1)",
            5e5 * limit
        );
        let changes = vec![
            ("materials.sand", sand),
            ("bodies[0].initial", "Geostatic(surface: 0, unit_weight: 1, k0: 1)".to_owned()),
            ("loads", "[BodyForce(acceleration: (0, -1), ramp: [(0, 1)])]".to_owned()),
            ("motion[0].displacement", "-1e-4".to_owned()),
            ("schedule.cuts", "8".to_owned()),
        ];
        let name = format!("smooth, φ = {friction}°");
        Ground { name, changes, limit, excess: 8.0, extrapolated: 0.15, size: (5.0, 4.0) }
    };
    let grounds: Vec<Ground> = factors.iter().map(ground).collect();
    let text = "Pressure at the end over the limit, its growth in the last fifth of the settlement, and Newton iterations. A little less than half of the excess goes with each halving of the cells. It is large because the stress is zero at the edge and grows from there: what the cell under the edge adds to the width adds to the pressure beside it, too:";
    Ok(settle("footing_sand", &grounds, meshes, text)?.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_have_the_digits_of_the_table() {
        for (friction, n_q, n_c) in
            [(20.0, 6.39939, 14.83471), (30.0, 18.40112, 30.13963), (40.0, 64.19521, 75.31311)]
        {
            let found = factors(friction);
            assert!((found.0 - n_q).abs() < 1e-5 && (found.1 - n_c).abs() < 1e-5, "{friction}: {found:?}");
        }
    }

    #[test]
    fn meshes_begin_with_equal_cells() {
        let nodes = graded(0.0625, 4.5, 24);
        assert_eq!((nodes.len(), nodes[0], nodes[24]), (25, 0.0, 4.5));
        assert!((nodes[1] - 0.0625).abs() < 1e-15 && nodes.windows(2).all(|it| it[1] > it[0]));
    }
}

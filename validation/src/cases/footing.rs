//! Volumetric locking under a rigid footing.

use super::{fixed, sweep};
use crate::picture::{Curve, Curves, Legend, Panel, Picture, Stroke};
use crate::scenes::{load, run};
use crate::variants::{CPDI1, CPDI1_ON_SPLINES, CPDI2Q, GIMP, Method, SMPM, plane};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::language::{AxisInput, Finite, MeanDilatationInput, MeshInput, Scene};
use std::f64::consts::{PI, SQRT_2};

pub(super) const CASE: Case = Case {
    name: "rigid footing",
    goal: "With mean dilatation the pressure under a footing levels off and converges to the limit load; without it, it locks.",
    setup: "Half of a smooth strip footing of half width 0.5 on ground of 5 × 5, E = 10¹⁰, ν = 0.48, ρ_y = 10⁶ √(3/2), settlement 0.002 in 40 load steps; 8², 16² and 32² cells, a quarter of each row under the footing, 2² points a cell; standard MPM, GIMP, CPDI1 and CPDI2q. CPDI1 on splines of degree 2, without mean dilatation.",
    reference: "Prandtl's limit pressure (2 + π) ρ_y/√2, met from above with the cells: the footing's last node carries half a cell more than its width. On splines the footing ends half-way between the last control point that is held and the first that is free.",
    run: footing,
};

/// `(2 + π) c` times the half width, `c = ρ_y/√2`, `ρ_y = 10⁶ √(3/2)`.
const LIMIT: f64 = (2.0 + PI) * 1.224_744_871_4e6 / SQRT_2 * 0.5;

/// Growth of the pressure in the last tenth of the settlement up to which it has levelled off `[-]`.
const LEVEL: f64 = 0.01;

/// Settlement in thousandths and pressure over the limit at every load step; Newton iterations.
struct Settling {
    path: Vec<(f64, f64)>,
    iterations: f64,
}

impl Settling {
    fn end(&self) -> f64 {
        self.path.last().map_or(f64::NAN, |it| it.1)
    }

    /// By how much the pressure grows in the last tenth of the settlement, of itself.
    fn growth(&self) -> f64 {
        let before = self.path.iter().rev().find(|it| it.0 < 1.801).map_or(f64::NAN, |it| it.1);
        self.end() / before - 1.0
    }
}

/// Nodes from the footing's middle to the side: `cells` under it, three times as many beyond, growing.
fn nodes(cells: u32) -> Vec<f64> {
    let growth = 1.4_f64.powi(6);
    let under = (0..cells).map(|k| 0.5 * f64::from(k) / f64::from(cells));
    let beyond = (0..3 * cells).map(|k| {
        let part = f64::from(k) / f64::from(3 * cells);
        0.5 + 4.5 * (growth.powf(part) - 1.0) / (growth - 1.0)
    });
    under.chain(beyond).chain([5.0]).collect()
}

fn settle(method: &Method, mean: Option<MeanDilatationInput>, cells: u32) -> Result<Settling, Broken> {
    let mut scene = method.of(plane(load("footing")?)?);
    let across: Vec<f64> = nodes(cells);
    let up = across.iter().rev().map(|x| Finite(5.0 - x)).collect();
    let across = across.into_iter().map(Finite).collect();
    if let MeshInput::Box { axes, .. } = &mut scene.mesh {
        *axes = vec![AxisInput::Nodes(across), AxisInput::Nodes(up)];
    }
    for body in &mut scene.bodies {
        body.mean_dilatation = mean;
    }
    scene.output.fields.clear();
    let history = run(&Scene::PlaneStrain(scene))?.completed()?;
    let force = history.series("reaction/footing", 1);
    let path =
        history.rows().iter().zip(&force).map(|(row, force)| (2.0 * row.fraction, -force / LIMIT)).collect();
    Ok(Settling { path, iterations: history.series("newton_iterations", 0).iter().sum() })
}

fn footing(extent: Extent) -> Result<Findings, Broken> {
    use MeanDilatationInput::{Cell, Points};
    let methods = extent.pick(&[SMPM, GIMP][..], &[SMPM, GIMP, CPDI1, CPDI2Q]);
    let meshes = extent.pick(&[2, 4][..], &[2, 4, 8]);
    let means = [None, Some(Points), Some(Cell)];
    let mut jobs = Vec::new();
    for method in methods {
        for mean in means {
            jobs.extend(meshes.iter().map(|&cells| (method, mean, cells)));
        }
    }
    let runs = sweep(&jobs, |(method, mean, cells)| settle(method, *mean, *cells))?;

    let mut findings = Findings::default();
    let heads = ["basis", "mean dilatation", "cells", "pressure over the limit", "growth", "Newton iterations"];
    let mut table = Table::new(
        "Pressure at the end over the limit, its growth in the last tenth of the settlement, and Newton iterations in 40 load steps:",
        &heads,
    );
    for (jobs, runs) in jobs.chunks(meshes.len()).zip(runs.chunks(meshes.len())) {
        let (method, mean) = (jobs[0].0.name, jobs[0].1);
        let name = mean.map_or(format!("{method}, no mean dilatation"), |mean| format!("{method}, {mean:?}"));
        for (&(_, _, cells), run) in jobs.iter().zip(runs) {
            table.push([
                method.to_owned(),
                mean.map_or("none".into(), |mean| format!("{mean:?}")),
                format!("{0} × {0}", 4 * cells),
                fixed(run.end(), 3),
                format!("{} %", fixed(100.0 * run.growth(), 2)),
                run.iterations.to_string(),
            ]);
            let check = |what: &str| format!("{name}, {} cells: {what}", 4 * cells);
            if mean.is_some() {
                let excess = (run.end() - 1.0).abs();
                findings.checks.push(Check::new(
                    check("pressure against the limit"),
                    excess,
                    0.4 / f64::from(cells),
                ));
                findings.checks.push(Check::new(check("growth in the last tenth"), run.growth(), LEVEL));
            } else {
                let locks = run.growth() > LEVEL && run.end() > 1.2;
                let said = format!("{:.2} of the limit, growing by {:.1} %", run.end(), 100.0 * run.growth());
                findings.checks.push(Check::none(check("does not lock"), usize::from(!locks)).remark(said));
            }
        }
        for (runs, meshes) in runs.windows(2).zip(meshes.windows(2)).filter(|_| mean.is_some()) {
            let (coarse, fine) = (4 * meshes[0], 4 * meshes[1]);
            let what = format!("{name}: limit from {coarse} and {fine} cells, error of first order");
            findings.checks.push(Check::new(what, (2.0 * runs[1].end() - runs[0].end() - 1.0).abs(), 0.02));
        }
    }
    findings.tables.push(table);
    findings.checks.extend(on_splines(meshes)?);
    if extent == Extent::Full {
        let of = |job: &&(&Method, Option<MeanDilatationInput>, u32)| *job.0 == GIMP && job.1 != Some(Cell);
        let shown = jobs.iter().zip(&runs).filter(|(job, _)| of(job)).enumerate();
        let curves = shown.map(|(k, ((_, mean, cells), run))| Curve {
            name: format!("{0} × {0}{1}", 4 * cells, if mean.is_some() { ", mean dilatation" } else { "" }),
            colour: k % meshes.len(),
            stroke: if mean.is_some() { Stroke::Line } else { Stroke::Dashes },
            points: run.path.clone(),
        });
        findings.pictures.push(Picture {
            file: "footing.svg",
            caption: "Rigid footing (GIMP): pressure over the limit against settlement.".into(),
            panels: vec![Panel::Curves(Curves {
                title: "Rigid footing".into(),
                axes: ["settlement (thousandths)", "pressure over the limit"].map(String::from),
                range: [(0.0, 2.0), (0.0, 2.5)],
                logarithmic: [false; 2],
                legend: Legend::UpperLeft,
                curves: curves.collect(),
            })],
        });
    }
    Ok(findings)
}

/// Splines of degree 2 need no mean dilatation: the pressure levels off near the limit.
fn on_splines(meshes: &[u32]) -> Result<Vec<Check>, Broken> {
    let runs = sweep(meshes, |&cells| settle(&CPDI1_ON_SPLINES, None, cells))?;
    let mut checks = Vec::new();
    for (cells, run) in meshes.iter().zip(runs) {
        let pressure = run.end() * 0.5 / width_on_splines(&nodes(*cells));
        let name = format!("{}, no mean dilatation, {} cells", CPDI1_ON_SPLINES.name, 4 * cells);
        let what = format!("{name}: pressure against the limit");
        checks.push(Check::new(what, (pressure - 1.0).abs(), 0.05).remark(fixed(pressure, 3)));
        checks.push(Check::new(format!("{name}: growth in the last tenth"), run.growth(), 0.02));
    }
    Ok(checks)
}

/// Half the width of a footing whose control points of degree 2 are held up to 0.5: up to half-way to the first that is free.
fn width_on_splines(nodes: &[f64]) -> f64 {
    // All but the first and the last control point stand amid cells.
    let middles: Vec<f64> = nodes.windows(2).map(|cell| 0.5 * (cell[0] + cell[1])).collect();
    let free = middles.partition_point(|x| *x <= 0.5);
    0.5 * (middles[free - 1] + middles[free])
}

//! Limit points of the load: past them only a path of given length goes on.

use super::{fixed, largest, sweep};
use crate::picture::{Curve, Curves, Legend, Panel, Picture, Stroke};
use crate::reference::Reference;
use crate::scenes::{Run, load, run};
use crate::variants::{CPDI2Q, Method, SMPM, plane, refined};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::Scene;

pub(super) const SNAP_THROUGH: Case = Case {
    name: "snap-through of an arch",
    goal: "The load is followed past its maximum, down to its minimum and up again.",
    setup: "Half of a clamped arch (radius 100, 12° on either side, thickness 1, E = 10⁶, ν = 0) under a force at its crown, up to 500 for the whole; steps of given displacement. 2, 4 and 8 cells across the thickness, on a mesh that stays.",
    reference: "Geometrically exact beam without shear, by shooting: maximum 437.0, minimum 353.0. Linear cells are too stiff across the thickness and the clamped end turns a little, so the error must fall with the cells.",
    run: arch,
};

pub(super) const SNAP_BACK: Case = Case {
    name: "snap-back of the doughnut",
    goal: "The doughnut twist with the slides' parameters on the finer mesh is followed past first yield, where the angle of its inner edge has to turn back.",
    setup: "10 × 64 cells, CPDI1, ρ_y = E = 10⁶, steps of given dissipation to 90°; beside it, steps of 1°.",
    reference: "The torque of elastic twist up to first yield; no fall of the torque from step to step by more than a tenth of its peak, while steps of the angle jump.",
    run: doughnut,
};

/// Force at the crown of the whole arch at load fraction 1.
const FORCE: f64 = 500.0;

/// A run, and the deflection of the crown and the force at every step.
type Bent = (Run, Vec<(f64, f64)>);

fn bend(method: &Method, factor: u32) -> Result<Bent, Broken> {
    let run = run(&Scene::PlaneStrain(refined(method.of(plane(load("path_arch")?)?), factor)))?;
    let sunk = run.history.series("displacement/apex", 1);
    let path = sunk.iter().zip(run.history.rows()).map(|(y, row)| (-y, FORCE * row.fraction)).collect();
    Ok((run, path))
}

/// Largest and (after it) smallest force of the parabolas through three neighbouring steps.
fn extremes(path: &[(f64, f64)]) -> [Option<f64>; 2] {
    let turn = |up: f64| {
        path.windows(3).find_map(|it| {
            let [(x0, y0), (x1, y1), (x2, y2)] = [it[0], it[1], it[2]];
            (up * (y1 - y0) > 0.0 && up * (y2 - y1) <= 0.0).then(|| {
                let (left, right) = ((y1 - y0) / (x1 - x0), (y2 - y1) / (x2 - x1));
                let bend = (right - left) / (x2 - x0);
                let slope = left + bend * (x1 - x0);
                y1 - 0.25 * slope * slope / bend
            })
        })
    };
    [turn(1.0), turn(-1.0)]
}

fn linear(x: &[f64], y: &[f64], at: f64) -> f64 {
    let k = x.partition_point(|&x| x < at).clamp(1, x.len() - 1);
    y[k - 1] + (y[k] - y[k - 1]) * (at - x[k - 1]) / (x[k] - x[k - 1])
}

fn arch(extent: Extent) -> Result<Findings, Broken> {
    let beam = Reference::read("arch_12deg")?;
    let (deflection, force) = (beam.column("deflection")?, beam.column("force")?);
    let beam: Vec<(f64, f64)> = deflection.iter().copied().zip(force.iter().copied()).collect();
    let [most, least] = extremes(&beam).map(|it| it.unwrap_or(f64::NAN));

    let factors: &[u32] = if extent == Extent::Full { &[1, 2, 4] } else { &[1, 2] };
    let mut jobs = vec![(CPDI2Q, 1)];
    jobs.extend(factors.iter().map(|&factor| (SMPM, factor)));
    if extent == Extent::Full {
        jobs.extend([(CPDI2Q, 2), (CPDI2Q, 4)]);
    }
    let runs = sweep(&jobs, |(method, factor)| bend(method, *factor))?;

    let mut findings = Findings::default();
    let mut table = Table::new(
        "Force at its maximum and minimum against the beam's (relative), largest departure from its curve (over the maximum), and how the run ends:",
        &["basis", "cells across", "steps", "maximum", "minimum", "departure", "ends because"],
    );
    let mut before: Option<f64> = None;
    for ((method, factor), (run, path)) in jobs.iter().zip(&runs) {
        let [top, bottom] = extremes(path);
        let error = |found: Option<f64>, expected: f64| found.map(|found| found / expected - 1.0);
        let (top, bottom) = (error(top, most), error(bottom, least));
        let departure =
            largest(path[1..].iter().map(|&(x, y)| (y - linear(&deflection, &force, x)).abs() / most));
        let percent =
            |error: Option<f64>| error.map_or("not met".into(), |e| format!("{} %", fixed(100.0 * e, 2)));
        table.push([
            method.name.to_owned(),
            (2 * factor).to_string(),
            (path.len() - 1).to_string(),
            percent(top),
            percent(bottom),
            format!("{} %", fixed(100.0 * departure, 2)),
            run.outcome.as_ref().err().map_or(String::new(), ToString::to_string),
        ]);
        if *method == SMPM || *factor == 1 {
            let name = format!("{}, {} cells across", method.name, 2 * factor);
            let reason = run.outcome.as_ref().err().map_or(String::new(), ToString::to_string);
            let unfinished = Check::none(
                format!("{name}: does not reach the far branch"),
                usize::from(run.outcome.is_err()),
            );
            findings.checks.push(unfinished.remark(reason));
            let extreme = |error: Option<f64>| error.map_or(f64::NAN, f64::abs);
            findings.checks.push(Check::new(format!("{name}: maximum against the beam's"), extreme(top), 0.04));
            findings.checks.push(Check::new(
                format!("{name}: minimum against the beam's"),
                extreme(bottom),
                0.07,
            ));
        }
        if *method == SMPM {
            let error = top.map_or(f64::NAN, f64::abs);
            if let Some(before) = before.replace(error) {
                let what = format!(
                    "sMPM, {} cells across: error of the maximum over that of half as many",
                    2 * factor
                );
                findings.checks.push(Check::new(what, error / before, 0.7));
            }
        }
    }
    findings.tables.push(table);
    if extent == Extent::Full {
        findings.pictures.push(arch_picture(&jobs, &runs, beam));
    }
    Ok(findings)
}

/// Force at the crown against its deflection: of the beam, and of every run.
fn arch_picture(jobs: &[(Method, u32)], runs: &[Bent], beam: Vec<(f64, f64)>) -> Picture {
    let mut curves = vec![Curve { name: "beam".into(), colour: 0, stroke: Stroke::Line, points: beam }];
    for (colour, ((method, factor), (_, path))) in jobs.iter().zip(runs).enumerate() {
        curves.push(Curve {
            name: format!("{}, {} cells", method.name, 2 * factor),
            colour: colour + 1,
            stroke: if *method == SMPM { Stroke::Dashes } else { Stroke::Marks },
            points: path.clone(),
        });
    }
    Picture {
        file: "path_arch.svg",
        caption: "Snap-through of a clamped arch: force at the crown against its deflection.".into(),
        panels: vec![Panel::Curves(Curves {
            title: "Snap-through of an arch".into(),
            axes: ["deflection of the crown", "force"].map(String::from),
            range: [(0.0, 3.5), (0.0, 700.0)],
            logarithmic: [false; 2],
            legend: Legend::LowerRight,
            curves,
        })],
    }
}

/// Degrees and torque (10⁷) at every step.
fn twist(scene: &Scene, turn: f64) -> Result<(Run, Vec<(f64, f64)>), Broken> {
    let run = run(scene)?;
    let torque = run.history.series("reaction_moment/inner", 0);
    let path = run.history.rows().iter().zip(torque).map(|(row, torque)| (turn * row.fraction, torque / 1e7));
    let path = path.collect();
    Ok((run, path))
}

/// The largest fall of the torque from one step to the next.
fn fall(path: &[(f64, f64)]) -> f64 {
    largest(path.windows(2).map(|pair| (pair[0].1 - pair[1].1).max(0.0)))
}

fn doughnut(extent: Extent) -> Result<Findings, Broken> {
    let scene = load("path_doughnut")?;
    let (run, path) = twist(&scene, 90.0)?;
    let peak = largest(path.iter().map(|it| it.1));
    let top = path.iter().position(|it| it.1 == peak).unwrap_or(0);
    let yielding = path[top].0;
    let back = path[top..].iter().take(15).map(|it| it.0).fold(f64::INFINITY, f64::min);

    let mut driven = plane(scene)?;
    driven.schedule.control = mpm_scene::language::StepControlInput::default();
    driven.schedule.steps = Some(mpm_scene::language::Count(90));
    let (driven_run, by_angle) = twist(&Scene::PlaneStrain(driven), 90.0)?;

    let elastic = Reference::read("doughnut_elastic_torque")?;
    let (degrees, torque) = (elastic.column("alpha_deg")?, elastic.column("torque")?);
    let before = path.iter().filter(|it| it.0 >= 1.0 && it.0 <= 20.0);
    let departure = largest(before.map(|&(x, y)| (y * 1e7 / linear(&degrees, &torque, x) - 1.0).abs()));
    let reason = |run: &Run| run.outcome.as_ref().err().map_or("to 90°".into(), ToString::to_string);
    let mut findings = Findings::from(vec![
        Check::none("path control: does not reach 90°", usize::from(run.outcome.is_err())).remark(reason(&run)),
        Check::new("torque from 1° to 20° against the elastic reference (relative)", departure, 0.01),
        Check::new("largest fall of the torque in a step over its peak", fall(&path) / peak, 0.1)
            .remark(format!("peak {peak:.3}·10⁷ at {yielding:.2}°, {} steps", path.len() - 1)),
        Check::none("the angle does not turn back past the peak", usize::from(back > yielding - 0.5))
            .remark(format!("back to {back:.2}°")),
        Check::none(
            "steps of the angle neither end nor jump",
            usize::from(driven_run.outcome.is_ok() && fall(&by_angle) < 0.15 * peak),
        )
        .remark(format!(
            "falls by {:.2} of the peak in a step; {}",
            fall(&by_angle) / peak,
            reason(&driven_run)
        )),
    ]);
    if extent == Extent::Full {
        let shown =
            |path: Vec<(f64, f64)>| path.into_iter().filter(|it| (20.0..=40.0).contains(&it.0)).collect();
        let curve =
            |name: &str, colour, stroke, path| Curve { name: name.into(), colour, stroke, points: shown(path) };
        findings.pictures.push(Picture {
            file: "path_doughnut.svg",
            caption: "Doughnut twist on 10 × 64 cells, CPDI1: torque against angle with path control and with steps of 1°.".into(),
            panels: vec![Panel::Curves(Curves {
                title: "Past first yield".into(),
                axes: ["angle (degrees)", "torque (10⁷)"].map(String::from),
                range: [(20.0, 40.0), (0.0, 10.0)],
                logarithmic: [false; 2],
                legend: Legend::UpperRight,
                curves: vec![
                    curve("steps of dissipation", 1, Stroke::Line, path),
                    curve("steps of 1°", 2, Stroke::Marks, by_angle),
                ],
            })],
        });
    }
    Ok(findings)
}

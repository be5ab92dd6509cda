//! The doughnut twist (Wang, Coombs, Augarde & Cortis 2018).

mod carried;
mod extruded;
mod limit;
mod turns;

use super::{fixed, largest, scientific, shapes, sweep};
use crate::history::History;
use crate::picture::{Curve, Curves, Legend, Panel, Picture, Stroke};
use crate::reference::Reference;
use crate::scenes::{Run, load, run};
use crate::variants::{CPDI1, CPDI2Q, CROSS, GENERAL, Method, PlaneScene, SLASH, SMPM, plane, refined};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_solver::scene::Scene;

pub(super) const ELASTIC: Case = Case {
    name: "doughnut twist, elastic",
    goal: "Large rotation and shear with a mesh that turns along: torque and its order of convergence.",
    setup: "A ring 5 to 10 (E = 10⁶, ν = 0, elastic), its outer edge fixed, its inner edge turned by 20° in 20 load steps; every ring of nodes turns with the material. 5 × 32 cells, and finer by 2, 4 and 8; 2² points a cell.",
    reference: "The independent implementation at every degree (5 × 32); the converged one-dimensional solution, 6.7643365·10⁷ at 20°, and its profile.",
    run: elastic,
};

pub(super) const PLASTIC: Case = Case {
    name: "doughnut twist, the slides'",
    goal: "Very large twist with yielding: which bases stay physical?",
    setup: "The same ring with ρ_y = 10⁶, 5 × 32 cells, turned by 90° in 90 load steps; angles larger than a cell are reduced by whole cells. Elastic strains are of order one, so the ring softens and all further twist goes to the innermost cells: torques depend on the mesh, and only those on one mesh may be compared.",
    reference: "The independent implementation at every degree. The finding of the slides: standard MPM and CPDI1 stay near the one-dimensional torque, CPDI2q drifts away, triangles grow without bound.",
    run: plastic,
};

pub(super) const TURNS: Case = turns::CASE;
pub(super) const LIMIT: Case = limit::CASE;
pub(super) const CARRIED: Case = carried::CASE;
pub(super) const EXTRUDED: Case = extruded::CASE;

const EXACT_AT_20: f64 = 6.764_336_5e7;

pub(super) fn torque(history: &History) -> Vec<f64> {
    history.series("reaction_moment/inner", 0)[1..].to_vec()
}

/// Torque of a scene's nominal stations: steps that were cut leave rows between them.
fn at_stations(history: &History, stations: usize) -> Vec<f64> {
    let rows = history.rows()[1..].iter().zip(torque(history));
    let nominal = |fraction: f64| {
        let station = fraction * stations as f64;
        (station - station.round()).abs() < 1e-9
    };
    rows.filter(|(row, _)| nominal(row.fraction)).map(|(_, torque)| torque).collect()
}

pub(super) fn ring(method: &Method, factor: u32) -> Result<PlaneScene, Broken> {
    Ok(refined(method.of(plane(load("doughnut_elastic")?)?), factor))
}

fn elastic(extent: Extent) -> Result<Findings, Broken> {
    let factors: &[u32] = extent.pick(&[1, 2], &[1, 2, 4, 8]);
    let jobs: Vec<(&Method, u32)> =
        GENERAL.iter().flat_map(|method| factors.iter().map(move |&factor| (method, factor))).collect();
    let runs = sweep(&jobs, |(method, factor)| run(&Scene::PlaneStrain(ring(method, *factor)?)))?;
    let of = |method: &Method| {
        let at = GENERAL.iter().position(|it| it == method).expect("a general method");
        &runs[at * factors.len()..(at + 1) * factors.len()]
    };

    let mut findings = Findings::default();
    let table = Reference::read("doughnut_elastic_5x32_twist")?;
    for (method, column) in [(SMPM, "smpm"), (CPDI2Q, "cpdi2q")] {
        let expected = table.column(column)?;
        let error = largest(
            at_stations(&of(&method)[0].history, 20).iter().zip(&expected).map(|(a, b)| (a / b - 1.0).abs()),
        );
        let what = format!("{}, 5 × 32: torque against the table (relative, every degree)", method.name);
        findings.checks.push(Check::new(what, error, 1e-7));
    }

    let heads: Vec<String> =
        ["basis".into()].into_iter().chain(factors.iter().map(|f| format!("{} × {}", 5 * f, 32 * f))).collect();
    let mut measured = Table::new(
        "Relative error of the torque at 20°; in parentheses the order between two meshes:",
        &heads.iter().map(String::as_str).collect::<Vec<_>>(),
    );
    // What the independent implementation found on the two coarse meshes, to two digits.
    let known = [
        [1.19e-2, 1.02e-2],
        [-3.1e-4, -1.3e-4],
        [1.0e-3, 1.3e-4],
        [4.8e-3, 1.2e-3],
        [2.7e-2, 6.7e-3],
        [1.4e-2, 3.6e-3],
    ];
    for (method, known) in GENERAL.iter().zip(known) {
        let errors: Vec<f64> = of(method).iter().map(error_at_the_end).collect();
        for (k, (error, known)) in errors.iter().zip(known).enumerate() {
            let mesh = ["5 × 32", "10 × 64"][k];
            let what =
                format!("{}, {mesh}: error of the torque at 20° against {known:e} (relative)", method.name);
            findings
                .checks
                .push(Check::new(what, (error / known - 1.0).abs(), 0.06).remark(format!("{error:+.2e}")));
        }
        let cell = |k: usize| {
            let order = |k: usize| fixed((errors[k - 1] / errors[k]).abs().log2(), 1);
            if let Err(reason) = &of(method)[k].outcome {
                return reason.to_string();
            }
            format!("{:+.2e}{}", errors[k], if k > 0 { format!(" ({})", order(k)) } else { String::new() })
        };
        measured.push([method.name.to_owned()].into_iter().chain((0..errors.len()).map(cell)));
    }
    findings.tables.push(measured);
    for method in [CPDI1, CPDI2Q] {
        let [radius, angle] = off_profile(&of(&method)[1].history)?;
        findings.checks.push(
            Check::new(
                format!("{}, 10 × 64: radius of the points at 20° against the profile", method.name),
                radius,
                2e-2,
            )
            .remark(scientific(radius, 2)),
        );
        findings.checks.push(
            Check::new(
                format!(
                    "{}, 10 × 64: rotation of the points at 20° against the profile (degrees)",
                    method.name
                ),
                angle,
                0.25,
            )
            .remark(scientific(angle, 2)),
        );
    }
    Ok(findings)
}

/// Relative error of the torque at 20°.
fn error_at_the_end(run: &Run) -> f64 {
    match &run.outcome {
        Ok(_) => torque(&run.history).last().map_or(f64::NAN, |t| t / EXACT_AT_20 - 1.0),
        Err(_) => f64::NAN,
    }
}

/// Largest difference of a point's radius and rotation (degrees) from the profile at 20°.
fn off_profile(history: &History) -> Result<[f64; 2], Broken> {
    let table = Reference::read("doughnut_elastic_profile_20deg")?;
    let (rest, radius, rotation) = (table.column("R")?, table.column("r")?, table.column("rotation_deg")?);
    let (first, last) = (&history.rows()[0].positions, &history.last().positions);
    let mut worst = [0.0_f64; 2];
    for (x, y) in first.chunks_exact(3).zip(last.chunks_exact(3)) {
        let at = x[0].hypot(x[1]);
        let Some(k) = (1..rest.len()).find(|&k| rest[k] >= at) else { continue };
        let t = (at - rest[k - 1]) / (rest[k] - rest[k - 1]);
        if t < 0.0 {
            continue;
        }
        let expected = |column: &[f64]| column[k - 1] + t * (column[k] - column[k - 1]);
        let turned = (x[0] * y[1] - x[1] * y[0]).atan2(x[0] * y[0] + x[1] * y[1]).to_degrees();
        worst[0] = worst[0].max((y[0].hypot(y[1]) - expected(&radius)).abs());
        worst[1] = worst[1].max((turned - expected(&rotation)).abs());
    }
    Ok(worst)
}

fn plastic(extent: Extent) -> Result<Findings, Broken> {
    let methods = [SMPM, CPDI1, CPDI2Q, SLASH, CROSS];
    let columns = ["smpm", "cpdi1", "cpdi2q", "cpdi2t-slash", "cpdi2t-cross"];
    let scene = |method: &Method| -> Result<Scene, Broken> {
        Ok(Scene::PlaneStrain(method.of(plane(load("doughnut")?)?)))
    };
    let runs: Vec<Run> = sweep(&methods, |method| run(&scene(method)?))?;
    let table = Reference::read("doughnut_5x32_reindexed_twist")?;

    let mut findings = Findings::default();
    let mut curves = Vec::new();
    for (colour, ((method, column), run)) in methods.iter().zip(columns).zip(&runs).enumerate() {
        let (found, expected) = (at_stations(&run.history, 90), table.column(column)?);
        let error = super::relative(&found, &expected);
        let what = format!("{}: torque against the table (every degree to 90, over the peak)", method.name);
        findings.checks.push(
            Check::new(what, error, 1e-6)
                .remark(run.outcome.as_ref().err().map_or(String::new(), ToString::to_string)),
        );
        curves.push(Curve {
            name: method.name.into(),
            colour,
            stroke: Stroke::Line,
            points: found.iter().enumerate().map(|(k, t)| (k as f64 + 1.0, t / 1e7)).collect(),
        });
    }
    let at_90 = |k: usize| torque(&runs[k].history).last().copied().unwrap_or(f64::NAN);
    let ordered = (0..4).filter(|&k| at_90(k) >= at_90(k + 1)).count();
    findings.checks.push(Check::none("torques at 90° not in the order of the slides' finding", ordered));

    if extent == Extent::Full {
        findings.pictures.push(Picture {
            file: "doughnut_torque.svg",
            caption: "Doughnut twist with the slides' parameters, 5 × 32 cells: torque against the angle."
                .into(),
            panels: vec![Panel::Curves(Curves {
                title: "Doughnut twist".into(),
                axes: ["angle of the inner edge (degrees)", "torque / 10⁷"],
                range: [(0.0, 90.0), (0.0, 20.0)],
                logarithmic: false,
                legend: Legend::UpperLeft,
                curves,
            })],
        });
        let mut panels = Vec::new();
        for (k, method) in methods.iter().enumerate().filter(|(_, method)| **method != SLASH) {
            let quarter = [(0.0, 10.1), (0.0, 10.1)];
            panels.push(shapes(format!("{}, 90°", method.name), &scene(method)?, &runs[k].history, quarter)?);
        }
        findings.pictures.push(Picture {
            file: "doughnut_domains.svg",
            caption: "Doughnut twist with the slides' parameters at 90°, first quadrant: points (sMPM) or domains, and the mesh in red.".into(),
            panels,
        });
    }
    Ok(findings)
}

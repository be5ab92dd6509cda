//! The doughnut of rubber, turned far.

use super::super::{fixed, largest, scientific, sweep};
use crate::history::History;
use crate::picture::{Curve, Curves, Legend, Panel, Picture, Stroke};
use crate::problems::doughnut::{ring, torque};
use crate::reference::Reference;
use crate::scenes::run;
use crate::variants::{CPDI1, CPDI2Q, Method, PlaneScene};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::Scene;
use mpm_scene::language::{
    Count, Finite, MaterialInput, MeanDilatationInput, MotionInput, Poisson, Positive, ReindexingInput,
};
use std::f64::consts::PI;

pub(in super::super) const CASE: Case = Case {
    name: "doughnut twist, rubber",
    goal: "Hencky's law loses ellipticity in large shear; the compressible neo-Hookean law lets an elastic ring be turned far, also where it is nearly incompressible.",
    setup: "The elastic doughnut (E = 10⁶) of neo-Hookean rubber, its inner edge turned by 180° in 18 load steps, whole cells taken off; ν = 0, 0.3, and 0.499 with mean dilatation of the points. CPDI2q on 5 × 32, 10 × 64 and 20 × 128 cells, CPDI1 beside it with ν = 0.3; 2² points a cell. Shears at the inner edge are 4 at 90° and 7 to 8 at 180°.",
    reference: "One-dimensional solutions by collocation, converged to ten digits. For an incompressible ring, T = 4πGα/(1/R_i² − 1/R_o²) at any angle: 0.1 % off the solution for ν = 0.499 at 90°.",
    run: rubber,
};

/// A method, Poisson's ratio with its column in the reference, and what the torque at 90° may be off by on 10 × 64 cells.
type Job = (Method, f64, &'static str, f64);

const JOBS: [Job; 4] = [
    (CPDI2Q, 0.0, "nu_0", 3e-3),
    (CPDI2Q, 0.3, "nu_0_3", 5e-3),
    (CPDI2Q, 0.499, "nu_0_499", 3e-3),
    (CPDI1, 0.3, "nu_0_3", 2e-2),
];

/// Degrees of a load step.
const STEP: usize = 10;

fn scene(method: &Method, poisson: f64, factor: u32, degrees: usize) -> Result<PlaneScene, Broken> {
    let mut scene = ring(method, factor)?;
    for material in scene.materials.values_mut() {
        let young = Positive(1e6).into();
        *material = MaterialInput::NeoHooke { young, poisson: Poisson(poisson), gradient: None, density: None };
    }
    if poisson > 0.4 {
        scene.bodies.iter_mut().for_each(|body| body.mean_dilatation = Some(MeanDilatationInput::Points));
    }
    if let MotionInput::Twist { inner, reindexing, .. } = &mut scene.motion {
        *inner = Finite(degrees as f64);
        *reindexing = ReindexingInput::WholeCells;
    }
    scene.schedule.steps = Some(Count((degrees / STEP) as u32));
    Ok(scene)
}

fn rubber(extent: Extent) -> Result<Findings, Broken> {
    let (factors, degrees): (&[u32], usize) = extent.pick((&[1, 2], 90), (&[1, 2, 4], 180));
    let jobs: Vec<(&Job, u32)> =
        JOBS.iter().flat_map(|job| factors.iter().map(move |&factor| (job, factor))).collect();
    let histories = sweep(&jobs, |((method, poisson, ..), factor)| {
        run(&Scene::PlaneStrain(scene(method, *poisson, *factor, degrees)?))?.completed()
    })?;
    let table = Reference::read("doughnut_rubber_torque")?;
    let angles = table.column("alpha_deg")?;
    let at = |history: &History, column: &str, degrees: usize| -> Result<f64, Broken> {
        let row = angles.iter().position(|&angle| angle == degrees as f64).ok_or("an angle of the table")?;
        Ok(torque(history)[degrees / STEP - 1] / table.column(column)?[row] - 1.0)
    };

    let mut findings = Findings::default();
    let heads = ["basis", "ν", "cells", "error at 30°", "at 90°", "order", "at 180°", "order"];
    let mut measured = Table::new("Relative error of the torque against the one-dimensional solution.", &heads);
    for ((method, poisson, column, tolerance), histories) in
        JOBS.iter().zip(histories.chunks_exact(factors.len()))
    {
        let errors = |degrees: usize| -> Result<Vec<f64>, Broken> {
            histories.iter().map(|history| at(history, column, degrees)).collect()
        };
        let (early, right, straight) =
            (errors(30)?, errors(90)?, if degrees == 180 { Some(errors(180)?) } else { None });
        for (k, factor) in factors.iter().enumerate() {
            let order = |errors: &[f64]| match k {
                0 => String::new(),
                _ => fixed((errors[k - 1] / errors[k]).abs().log2(), 1),
            };
            measured.push([
                method.name.into(),
                poisson.to_string(),
                format!("{} × {}", 5 * factor, 32 * factor),
                scientific(early[k], 2),
                scientific(right[k], 2),
                order(&right),
                straight.as_ref().map_or(String::new(), |errors| scientific(errors[k], 2)),
                straight.as_ref().map_or(String::new(), |errors| order(errors)),
            ]);
        }
        let what = format!("{}, ν = {poisson}, 10 × 64: torque at 90° (relative)", method.name);
        findings.checks.push(Check::new(what, right[1].abs(), *tolerance).remark(scientific(right[1], 2)));
        let finer = largest(right.windows(2).map(|pair| (pair[1] / pair[0]).abs()));
        let what = format!("{}, ν = {poisson}: error at 90° left by halving the cells", method.name);
        findings.checks.push(Check::new(what, finer, 0.55).remark(fixed(finer, 2)));
    }
    findings.tables.push(measured);

    // G of ν = 0.499.
    let shear = 1e6 / (2.0 * 1.499);
    let incompressible = |degrees: f64| 4.0 * PI * shear * degrees.to_radians() / (1.0 / 25.0 - 1.0 / 100.0);
    let found = torque(&histories[2 * factors.len() + 1])[90 / STEP - 1] / incompressible(90.0) - 1.0;
    findings.checks.push(
        Check::new(
            "CPDI2q, ν = 0.499, 10 × 64: torque at 90° of the incompressible ring (relative)",
            found.abs(),
            4e-3,
        )
        .remark(scientific(found, 2)),
    );
    findings.pictures.push(picture(&table, &histories, factors.len())?);
    Ok(findings)
}

/// Torque against the angle, on the finest meshes.
fn picture(table: &Reference, histories: &[History], meshes: usize) -> Result<Picture, Broken> {
    let angles = table.column("alpha_deg")?;
    let mut curves = Vec::new();
    for (k, (method, poisson, column, _)) in JOBS.iter().enumerate() {
        let exact = angles.iter().zip(table.column(column)?).map(|(angle, torque)| (*angle, torque / 1e8));
        let found = torque(&histories[(k + 1) * meshes - 1]);
        let found = found.iter().enumerate().map(|(step, torque)| ((STEP * (step + 1)) as f64, torque / 1e8));
        if *method == CPDI2Q {
            curves.push(Curve {
                name: format!("ν = {poisson}, one dimension"),
                stroke: Stroke::Line,
                colour: k,
                points: exact.collect(),
            });
        }
        curves.push(Curve {
            name: format!("{}, ν = {poisson}", method.name),
            stroke: Stroke::Marks,
            colour: k,
            points: found.collect(),
        });
    }
    Ok(Picture {
        file: "doughnut_rubber.svg",
        caption:
            "Torque of a ring of rubber against its angle: lines in one dimension, marks on the finest meshes."
                .into(),
        panels: vec![Panel::Curves(Curves {
            title: "Ring of rubber".into(),
            axes: ["angle [degrees]".into(), "torque / 10⁸".into()],
            range: [(0.0, 180.0), (0.0, 5.0)],
            logarithmic: [false; 2],
            legend: Legend::LowerRight,
            curves,
        })],
    })
}

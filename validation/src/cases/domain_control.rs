//! Domains that outgrow their cells in the shear band of a ring at its limit load, and pressures that run
//! away from each other there.

use super::{fixed, largest, sweep};
use crate::history::History;
use crate::picture::{Curve, Curves, Legend, Panel, Picture, Stroke};
use crate::scenes::{load, run};
use crate::variants::{CPDI1, Method, SMPM, plane};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::language::{ControlInput, Count, Finite, MeanDilatationInput, MotionInput, Positive, Scene};
use std::f64::consts::{PI, SQRT_2};

pub(super) const CASE: Case = Case {
    name: "domains under large shear",
    goal: "Domains that outgrow their cells do not add to the limit load, once they are shortened, reshaped or split; with mean dilatation the torque stays at the limit at every degree, however far the ring is turned.",
    setup: "The doughnut twist with ρ_y = 1e4 on 5 × 32 cells to 180° in 180 load steps (halved where they fail): shear of 17 in the innermost row of cells. CPDI1 with `Cap`, `Reshape` and `Split` at 0.7 cells, and none of them; `Reshape` and standard MPM with mean dilatation.",
    reference: "The discrete limit torque 2π (R_i + h/2)² ρ_y/√2 at the degrees from 1 to 180. The ring's polygons have 0.987 of it. Without mean dilatation the torque swings about it with every basis: a point that passes through its cell is compressed and stretched in turn, where the polygons' rotation changes no cell's volume; all 32 sectors do so at once.",
    run: large_shear,
};

/// `2π (R_i + h/2)² ρ_y/√2`.
const LIMIT: f64 = 2.0 * PI * 5.5 * 5.5 * 1e4 / SQRT_2;

const RESHAPE: ControlInput = ControlInput::Reshape { cells: Positive(0.7) };

/// Degrees to which the runs with mean dilatation go in the tests.
const FEW: u32 = 30;

fn large_shear(extent: Extent) -> Result<Findings, Broken> {
    let cells = Positive(0.7);
    let plain = torque(&watched(None)?, 180);
    let reshaped = torque(&watched(Some(RESHAPE))?, 180);
    let capped = torque(&watched(Some(ControlInput::Cap { cells }))?, 180);
    let history = watched(Some(ControlInput::Split { cells, growth: Positive(16.0) }))?;
    let split = torque(&history, 180);
    let points = history.rows().last().map_or(0, |row| row.positions.len() / 3);
    let mut findings = Findings::from(vec![
        Check::new("up to 5 degrees, no control, every degree", swing(&plain[..5]), 0.02),
        Check::none("no control: end torque below twice the limit", usize::from(plain[179] < 2.0))
            .remark(format!("{:.2} of the limit", plain[179])),
        mean("Reshape", &reshaped, 0.05),
        mean("Cap", &capped, 0.05),
        mean("Split", &split, 0.1),
        Check::none("Split: points that are not more than before", usize::from(points <= 640))
            .remark(format!("{points} points")),
    ]);
    locking(extent, &mut findings)?;
    Ok(findings)
}

/// The ring with and without mean dilatation.
fn locking(extent: Extent, findings: &mut Findings) -> Result<(), Broken> {
    use MeanDilatationInput::{Cell, Points};
    let jobs: &[(Method, Option<MeanDilatationInput>)] = match extent {
        Extent::Tests => &[(CPDI1, Some(Cell))],
        Extent::Full => &[
            (CPDI1, Some(Cell)),
            (CPDI1, Some(Points)),
            (CPDI1, None),
            (SMPM, Some(Cell)),
            (SMPM, Some(Points)),
            (SMPM, None),
        ],
    };
    let degrees = extent.pick(FEW, 180);
    let runs = sweep(jobs, |(method, mean)| averaged(method, *mean, degrees))?;

    let mut table = Table::new(
        "Torque over the limit at single degrees; 180 load steps are asked for:",
        &["basis", "mean dilatation", "least", "largest", "mean", "load steps", "Newton iterations"],
    );
    let mut curves = Vec::new();
    for (colour, ((method, mean), history)) in jobs.iter().zip(&runs).enumerate() {
        let torque = torque(history, degrees);
        let over = mean.map_or("none".into(), |mean| format!("{mean:?}"));
        let least = torque.iter().copied().fold(f64::INFINITY, f64::min);
        table.push([
            if *method == CPDI1 { "CPDI1, Reshape".into() } else { method.name.into() },
            over.clone(),
            fixed(least, 3),
            fixed(largest(torque.iter().copied()), 3),
            fixed(torque.iter().sum::<f64>() / torque.len() as f64, 3),
            (history.rows().len() - 1).to_string(),
            history.series("newton_iterations", 0).iter().sum::<f64>().to_string(),
        ]);
        if *mean == Some(Cell) {
            let name = if *method == CPDI1 { "Reshape" } else { method.name };
            let missing = usize::try_from(degrees)? - torque.len();
            findings
                .checks
                .push(Check::none(format!("{name}, mean dilatation: degrees without a torque"), missing));
            let what = format!("{name}, mean dilatation: torque against the limit, every degree");
            findings.checks.push(Check::new(what, swing(&torque), 0.05));
        }
        if *mean != Some(Points) {
            curves.push(Curve {
                name: format!("{}{}", method.name, if mean.is_some() { ", mean dilatation" } else { "" }),
                colour,
                stroke: if mean.is_some() { Stroke::Line } else { Stroke::Dashes },
                points: torque.iter().enumerate().map(|(k, torque)| (k as f64 + 1.0, *torque)).collect(),
            });
        }
    }
    if extent == Extent::Full {
        findings.tables.push(table);
        findings.pictures.push(Picture {
            file: "doughnut_limit.svg",
            caption:
                "The doughnut at its limit load: torque over the limit against the angle of the inner edge."
                    .into(),
            panels: vec![Panel::Curves(Curves {
                title: "Torque of the doughnut at its limit load".into(),
                axes: ["degrees", "torque over the limit"].map(String::from),
                range: [(0.0, 180.0), (0.7, 1.4)],
                logarithmic: [false; 2],
                legend: Legend::UpperLeft,
                curves,
            })],
        });
    }
    Ok(())
}

/// Largest departure from the limit.
fn swing(torque: &[f64]) -> f64 {
    largest(torque.iter().map(|t| (t - 1.0).abs()))
}

fn mean(name: &str, torque: &[f64], tolerance: f64) -> Check {
    let mean = torque.iter().sum::<f64>() / torque.len() as f64;
    Check::new(format!("{name}: mean torque against the limit"), (mean - 1.0).abs(), tolerance)
        .remark(format!("{mean:.3} of the limit"))
}

fn watched(control: Option<ControlInput>) -> Result<History, Broken> {
    let mut scene = plane(load("doughnut_limit")?)?;
    scene.domains.control = control;
    scene.output.fields.clear();
    for body in &mut scene.bodies {
        body.mean_dilatation = None;
    }
    run(&Scene::PlaneStrain(scene))?.completed()
}

/// Turned by so many degrees, one a load step; domains, where there are any, are reshaped.
fn averaged(method: &Method, mean: Option<MeanDilatationInput>, degrees: u32) -> Result<History, Broken> {
    let mut scene = method.of(plane(load("doughnut_limit")?)?);
    scene.domains.control = (*method == CPDI1).then_some(RESHAPE);
    scene.output.fields.clear();
    for body in &mut scene.bodies {
        body.mean_dilatation = mean;
    }
    if let MotionInput::Twist { inner, .. } = &mut scene.motion {
        *inner = Finite(f64::from(degrees));
    }
    scene.schedule.steps = Some(Count(degrees));
    run(&Scene::PlaneStrain(scene))?.completed()
}

/// Torque over the limit at every whole degree from 1 to `end`.
fn torque(history: &History, end: u32) -> Vec<f64> {
    let moments = history.series("reaction_moment/inner", 0);
    let degrees = history.rows().iter().map(|row| row.fraction * f64::from(end));
    let whole =
        degrees.zip(moments).filter(|(degree, _)| *degree > 0.5 && (degree - degree.round()).abs() < 1e-6);
    whole.map(|(_, moment)| moment / LIMIT).collect()
}

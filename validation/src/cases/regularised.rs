//! Rings whose laws a nodal field regularises, against a solution in one dimension and between meshes.

mod strip;

use super::{fixed, largest, sweep};
use crate::history::History;
use crate::picture::{Curve, Curves, Legend, Panel, Picture, Stroke};
use crate::problems::doughnut::torque;
use crate::reference::Reference;
use crate::scenes::{Run, changed, run, text};
use crate::variants::plane;
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::language::{MaterialInput, Scene};

pub(super) use strip::STRIP;

pub(super) const STRAIN: Case = Case {
    name: "doughnut twist, regularised",
    goal: "With a nodal field that follows the shear, the slides' doughnut has one torque-angle curve, whatever the mesh.",
    setup: "The doughnut twist with ρ_y = E = 10⁶ and ν = 0 on a ring of splines at rest, whose inner circle turns through it by 90° in 90 load steps; h = 2 E, l = 0.3; CPDI2q, degree 2 on 10 × 32 cells (in the full run degree 1 and 20 × 64 cells, too); 2² points a cell. Then without the field: that runs end early, or that their torques are those of a mesh, is what is expected there.",
    reference: "A solution in one dimension (unknowns r, θ and k of the radius; 640 quadratic elements, converged to 2e-6) with the same steps.",
    run: strain,
};

pub(super) const SOFTENING: Case = Case {
    name: "ring that softens, regularised",
    goal: "With a nodal field that follows the plastic strain, a ring of a material that softens has one torque-angle curve after its peak.",
    setup: "A ring with ρ = 2·10³ + 8·10³ exp(−κ/0.05), E = 10⁶, ν = 0.3, turned by 3° in 60 load steps; h = E, l = 0.15; CPDI2q on splines of degree 2; 10 × 32 cells (in the full run 20 × 64, too). Then without the field: a band of one row of points unloads the ring faster than it is turned, or its torque is that of the mesh.",
    reference: "A solution in one dimension with the same steps: 640 quadratic elements, converged to 9e-6.",
    run: softening,
};

/// A ring of one of the scenes on a mesh.
struct Job {
    scene: &'static str,
    degree: u32,
    rows: u32,
    field: bool,
}

impl Job {
    fn name(&self) -> String {
        let field = if self.field { "" } else { "no field, " };
        format!("{field}degree {}, {} × {}", self.degree, self.rows, 16 * self.rows / 5)
    }

    fn run(&self) -> Result<Run, Broken> {
        let scene = changed(
            text(self.scene)?,
            &[
                ("mesh.radii.cells", self.rows.to_string()),
                ("mesh.sectors", (16 * self.rows / 5).to_string()),
                ("mesh.functions.degree", self.degree.to_string()),
            ],
        )?;
        let mut scene = plane(scene)?;
        scene.output.fields.clear();
        for law in scene.materials.values_mut().filter(|_| !self.field) {
            if let MaterialInput::VonMises { gradient, .. } = law {
                *gradient = None;
            }
        }
        run(&Scene::PlaneStrain(scene))
    }
}

fn strain(extent: Extent) -> Result<Findings, Broken> {
    let scene = "doughnut_regularised";
    let job = |degree, rows, field| Job { scene, degree, rows, field };
    let jobs = extent.pick(
        vec![job(2, 10, true)],
        vec![job(1, 10, true), job(2, 10, true), job(2, 20, true), job(2, 10, false), job(2, 20, false)],
    );
    let reference = Reference::read("gradient/strain_ring")?;
    let about = About {
        angle: 90.0,
        file: "doughnut_regularised.svg",
        title: "Doughnut twist, ρ_y = E",
        unit: 1e7,
        highest: 14.0,
    };
    compare(&jobs, &reference, &about, &|job| if job.rows >= 20 { 0.01 } else { 0.015 })
}

fn softening(extent: Extent) -> Result<Findings, Broken> {
    let scene = "soil/ring_softening";
    let job = |rows, field| Job { scene, degree: 2, rows, field };
    let jobs =
        extent.pick(vec![job(10, true)], vec![job(10, true), job(20, true), job(10, false), job(20, false)]);
    let reference = Reference::read("gradient/softening_ring")?;
    let about =
        About { angle: 3.0, file: "ring_softening.svg", title: "A ring that softens", unit: 1e6, highest: 1.4 };
    compare(&jobs, &reference, &about, &|job| if job.rows >= 20 { 0.01 } else { 0.02 })
}

/// What a case is about.
struct About {
    /// Angle at the end `[degrees]`.
    angle: f64,
    file: &'static str,
    title: &'static str,
    /// Torques are shown in this unit, up to `highest` of it `[F L]`.
    unit: f64,
    highest: f64,
}

/// Angles and torques of a run, up to where it ended.
fn curve(history: &History, angle: f64) -> (Vec<f64>, Vec<f64>) {
    (history.rows()[1..].iter().map(|row| angle * row.fraction).collect(), torque(history))
}

/// The torque at an angle: of a run that has been there, or between two of its steps.
fn at(angle: f64, (angles, torques): &(Vec<f64>, Vec<f64>)) -> f64 {
    let next = angles.partition_point(|it| *it < angle - 1e-9);
    match (next.checked_sub(1), angles.get(next)) {
        (_, Some(end)) if (end - angle).abs() < 1e-9 => torques[next],
        (Some(before), Some(end)) => {
            let part = (angle - angles[before]) / (end - angles[before]);
            torques[before] + part * (torques[next] - torques[before])
        }
        _ => f64::NAN,
    }
}

fn compare(
    jobs: &[Job],
    reference: &Reference,
    about: &About,
    tolerance: &dyn Fn(&Job) -> f64,
) -> Result<Findings, Broken> {
    let runs = sweep(jobs, Job::run)?;
    let exact = (reference.column("angle_deg")?, reference.column("torque")?);
    let curves: Vec<_> = runs.iter().map(|run| curve(&run.history, about.angle)).collect();
    let mut findings = Findings::default();
    let heads = ["ring", "torque at the end", "largest difference", "at", "ends at"];
    let mut table = Table::new("Torques against the solution in one dimension, over its own.", &heads);
    let mut off = Vec::new();
    for ((job, run), curve) in jobs.iter().zip(&runs).zip(&curves) {
        let end = curve.0.last().copied().unwrap_or(0.0);
        let inside = exact.0.iter().zip(&exact.1).filter(|(angle, _)| **angle <= end + 1e-9);
        let errors: Vec<(f64, f64)> =
            inside.map(|(angle, torque)| (*angle, (at(*angle, curve) / torque - 1.0).abs())).collect();
        let worst =
            errors.iter().copied().fold((0.0, 0.0), |a, b| if b.1 > a.1 || b.1.is_nan() { b } else { a });
        table.push([
            job.name(),
            fixed(curve.1.last().copied().unwrap_or(f64::NAN) / about.unit, 4),
            format!("{} %", fixed(100.0 * worst.1, 2)),
            format!("{}°", fixed(worst.0, 2)),
            format!("{}°", fixed(end, 2)),
        ]);
        if job.field {
            run.outcome.as_ref().map_err(|error| format!("{}: {error}", job.name()))?;
            let what = format!("{}: torque against one dimension, to the end", job.name());
            findings.checks.push(Check::new(what, worst.1, tolerance(job)));
        }
        off.push((job, worst.1, end));
    }
    let regular: Vec<usize> = (0..jobs.len()).filter(|&k| jobs[k].field).collect();
    for pair in regular.windows(2) {
        let apart = largest(exact.0.iter().map(|angle| {
            let [a, b] = [pair[0], pair[1]].map(|k| at(*angle, &curves[k]));
            (a / b - 1.0).abs()
        }));
        let what = format!("{} against {}", jobs[pair[0]].name(), jobs[pair[1]].name());
        findings.checks.push(Check::new(what, apart, 0.015));
    }
    let irregular: Vec<_> = off.iter().filter(|(job, ..)| !job.field).collect();
    if !irregular.is_empty() {
        let agree = irregular.iter().filter(|(_, off, end)| *end > about.angle - 1e-9 && *off < 0.03);
        let what = "runs without the field that agree with the one-dimensional curve all the same";
        findings.checks.push(Check::none(what, agree.count()));
        findings.pictures.push(picture(jobs, &curves, &exact, about));
    }
    findings.tables.push(table);
    Ok(findings)
}

fn picture(
    jobs: &[Job],
    curves: &[(Vec<f64>, Vec<f64>)],
    exact: &(Vec<f64>, Vec<f64>),
    about: &About,
) -> Picture {
    let points = |(angles, torques): &(Vec<f64>, Vec<f64>)| {
        angles.iter().zip(torques).map(|(a, t)| (*a, t / about.unit)).collect()
    };
    let panel = |field: bool| {
        let chosen = jobs.iter().zip(curves).filter(|(job, _)| job.field == field);
        let mut shown = vec![Curve {
            name: "one dimension, with the field".into(),
            colour: 0,
            stroke: Stroke::Dashes,
            points: points(exact),
        }];
        shown.extend(chosen.enumerate().map(|(k, (job, curve))| Curve {
            name: job.name(),
            colour: k + 1,
            stroke: Stroke::Line,
            points: points(curve),
        }));
        Panel::Curves(Curves {
            title: format!("{}: {} field", about.title, if field { "with the" } else { "without a" }),
            axes: ["angle of the inner edge (degrees)", "torque"].map(String::from),
            range: [(0.0, about.angle), (0.0, about.highest)],
            logarithmic: [false; 2],
            legend: Legend::LowerRight,
            curves: shown,
        })
    };
    Picture {
        file: about.file,
        caption: format!("{}: torque against the angle on several meshes.", about.title),
        panels: vec![panel(true), panel(false)],
    }
}

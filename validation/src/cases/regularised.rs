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
    setup: "The doughnut twist with ρ_y = E = 10⁶ and ν = 0 on a ring of splines at rest, whose inner circle turns through it by 90° in 90 load steps; h = 2 E, l = 0.3; CPDI2q, degree 2 on 10 × 32 cells, 2² points a cell. In the full run also 15 × 48 and 20 × 64 cells, degree 1, CPDI1 with and without care for its long domains, and by 180°. Then without the field, and with one that follows the plastic strain (h = E, l = 1), which cannot help where elastic strains are of order one: that runs end early, or that their torques are those of a mesh, is what is expected there.",
    reference: "A solution in one dimension (unknowns r, θ and k of the radius; 640 quadratic elements, converged to 2e-6) with the same steps, up to 90°.",
    run: strain,
};

pub(super) const SOFTENING: Case = Case {
    name: "ring that softens, regularised",
    goal: "With a nodal field that follows the plastic strain, a ring of a material that softens has one torque-angle curve after its peak.",
    setup: "A ring with ρ = 2·10³ + 8·10³ exp(−κ/0.05), E = 10⁶, ν = 0.3, turned by 3° in 60 load steps; h = E, l = 0.15; CPDI2q on splines of degree 2; 10 × 32 cells (in the full run 15 × 48 and 20 × 64, too), the outermost three times as long as the innermost, 3² points a cell; on 10 × 32 equal cells with 2² points the check of the scene says that the points are too large for the band, which is 1.2 wide. Then without the field: a band of one row of points unloads the ring faster than it is turned, or its torque is that of the mesh.",
    reference: "A solution in one dimension with the same steps: 640 quadratic elements, converged to 9e-6.",
    run: softening,
};

/// A ring of one of the scenes, with other values.
struct Job {
    scene: &'static str,
    name: String,
    changes: Vec<(&'static str, String)>,
    field: bool,
    /// Whether its field gives bands a width: the run must reach its end.
    holds: bool,
    /// Angle at the end `[degrees]`.
    angle: f64,
    /// Largest difference from one dimension that passes; none of what is only shown.
    tolerance: Option<f64>,
    /// Whether it is one of the series of meshes that are compared with each other.
    is_series: bool,
}

impl Job {
    fn on(scene: &'static str, rows: u32, angle: f64) -> Self {
        let sectors = 16 * rows / 5;
        Self {
            scene,
            name: format!("{rows} × {sectors}"),
            changes: vec![("mesh.radii.cells", rows.to_string()), ("mesh.sectors", sectors.to_string())],
            field: true,
            holds: true,
            angle,
            tolerance: Some(if rows >= 20 { 0.01 } else { 0.015 }),
            is_series: true,
        }
    }

    /// Beside the series.
    fn with(mut self, name: &str, changes: &[(&'static str, &str)], tolerance: Option<f64>) -> Self {
        self.name = format!("{name}, {}", self.name);
        self.changes.extend(changes.iter().map(|(path, value)| (*path, (*value).to_owned())));
        Self { tolerance, is_series: false, ..self }
    }

    fn without_field(self) -> Self {
        Self { field: false, holds: false, ..self.with("no field", &[], None) }
    }

    /// With a field that cannot help.
    fn with_plastic_strain(self) -> Self {
        let gradient = "(driver: PlasticStrain, modulus: 1e6, length: 1)";
        let driven = self.with("`PlasticStrain`", &[("materials.ring.gradient", gradient)], None);
        Self { holds: false, ..driven }
    }

    fn run(&self) -> Result<Run, Broken> {
        let scene = changed(text(self.scene)?, &self.changes)?;
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
    let job = |rows| Job::on("doughnut_regularised", rows, 90.0);
    let cpdi1 = |name: &str, control: &str, tolerance| {
        job(10).with(name, &[("basis", "Cpdi1"), ("domains", control)], tolerance)
    };
    let far = |rows| {
        let changes = [("supports[1].turn.angle", "180"), ("schedule.steps", "180")];
        Job { angle: 180.0, ..job(rows).with("by 180°", &changes, Some(0.015)) }
    };
    let jobs = extent.pick(
        vec![job(10)],
        vec![
            job(10),
            job(15),
            job(20),
            job(10).with("degree 1", &[("mesh.functions.degree", "1")], Some(0.015)),
            cpdi1("CPDI1", "()", None),
            cpdi1("CPDI1, capped", "(control: Cap(cells: 1))", Some(0.015)),
            cpdi1("CPDI1, split", "(control: Split(cells: 1))", None),
            cpdi1("CPDI1, reshaped", "(control: Reshape(cells: 1))", None),
            far(10),
            far(15),
            job(10).without_field(),
            job(15).without_field(),
            job(20).without_field(),
            job(10).with_plastic_strain(),
        ],
    );
    let reference = Reference::read("gradient/strain_ring")?;
    let about = About {
        angle: 90.0,
        file: "doughnut_regularised.svg",
        title: "Doughnut twist, ρ_y = E",
        unit: 1e7,
        highest: 14.0,
    };
    compare(&jobs, &reference, &about)
}

fn softening(extent: Extent) -> Result<Findings, Broken> {
    let job = |rows: u32| {
        let mut job = Job::on("soil/ring_softening", rows, 3.0);
        job.changes.extend([
            ("mesh.radii", format!("Graded(from: 5, to: 10, cells: {rows}, ratio: 3)")),
            ("bodies[0].points_per_cell", "3".to_owned()),
        ]);
        Job { tolerance: Some(0.01), ..job }
    };
    let jobs = extent.pick(
        vec![job(10)],
        vec![
            job(10),
            job(15),
            job(20),
            job(10).without_field(),
            job(15).without_field(),
            job(20).without_field(),
        ],
    );
    let reference = Reference::read("gradient/softening_ring")?;
    let about =
        About { angle: 3.0, file: "ring_softening.svg", title: "A ring that softens", unit: 1e6, highest: 1.4 };
    compare(&jobs, &reference, &about)
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

fn compare(jobs: &[Job], reference: &Reference, about: &About) -> Result<Findings, Broken> {
    let runs = sweep(jobs, Job::run)?;
    let exact = (reference.column("angle_deg")?, reference.column("torque")?);
    let curves: Vec<_> = jobs.iter().zip(&runs).map(|(job, run)| curve(&run.history, job.angle)).collect();
    let mut findings = Findings::default();
    let heads = ["ring", "torque at the end", "largest difference", "at", "there", "ends at"];
    let title = format!(
        "Torques, and their differences from the solution in one dimension: the largest, and that at {}°.",
        about.angle
    );
    let mut table = Table::new(title, &heads);
    let mut agreeing = 0;
    for ((job, run), curve) in jobs.iter().zip(&runs).zip(&curves) {
        let end = curve.0.last().copied().unwrap_or(0.0);
        let inside = exact.0.iter().zip(&exact.1).filter(|(angle, _)| **angle <= end + 1e-9);
        let errors: Vec<(f64, f64)> =
            inside.map(|(angle, torque)| (*angle, at(*angle, curve) / torque - 1.0)).collect();
        let worst = errors
            .iter()
            .copied()
            .fold((0.0, 0.0_f64), |a, b| if b.1.abs() > a.1.abs() || b.1.is_nan() { b } else { a });
        let percent = |error: f64| format!("{} %", fixed(100.0 * error, 2));
        let there = errors.last().filter(|(angle, _)| *angle > about.angle - 1e-9);
        table.push([
            job.name.clone(),
            fixed(curve.1.last().copied().unwrap_or(f64::NAN) / about.unit, 4),
            percent(worst.1),
            format!("{}°", fixed(worst.0, 2)),
            there.map_or_else(|| "–".to_owned(), |(_, error)| percent(*error)),
            format!("{}°", fixed(end, 2)),
        ]);
        if job.holds {
            run.outcome.as_ref().map_err(|error| format!("{}: {error}", job.name))?;
        }
        if let Some(tolerance) = job.tolerance {
            let what = format!("{}: torque against one dimension", job.name);
            findings.checks.push(Check::new(what, worst.1.abs(), tolerance));
        }
        agreeing += usize::from(!job.holds && end > about.angle - 1e-9 && worst.1.abs() < 0.03);
    }
    let apart = |a: usize, b: usize| {
        let angles = curves[a].0.iter().filter(|angle| **angle <= jobs[b].angle + 1e-9);
        largest(angles.map(|angle| (at(*angle, &curves[a]) / at(*angle, &curves[b]) - 1.0).abs()))
    };
    let far: Vec<usize> = (0..jobs.len()).filter(|&k| jobs[k].angle > about.angle).collect();
    let series: Vec<usize> = (0..jobs.len()).filter(|&k| jobs[k].is_series).collect();
    let coarsest = series.iter().skip(1).map(|&finer| (series[0], finer, 0.01));
    for (a, b, tolerance) in coarsest.chain(far.windows(2).map(|pair| (pair[0], pair[1], 0.1))) {
        let what = format!("{} against {}", jobs[a].name, jobs[b].name);
        findings.checks.push(Check::new(what, apart(a, b), tolerance));
    }
    if jobs.iter().any(|job| !job.holds) {
        let what = "runs without such a field that agree with the one-dimensional curve all the same";
        findings.checks.push(Check::none(what, agreeing));
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
        let chosen = jobs.iter().zip(curves).filter(|(job, _)| if field { job.is_series } else { !job.holds });
        let mut shown = vec![Curve {
            name: "one dimension, with the field".into(),
            colour: 0,
            stroke: Stroke::Dashes,
            points: points(exact),
        }];
        shown.extend(chosen.enumerate().map(|(k, (job, curve))| Curve {
            name: job.name.clone(),
            colour: k + 1,
            stroke: Stroke::Line,
            points: points(curve),
        }));
        Panel::Curves(Curves {
            title: format!("{}: {} field", about.title, if field { "with a" } else { "without such a" }),
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

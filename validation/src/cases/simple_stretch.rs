//! The simple stretch (Wang, Coombs, Augarde & Cortis 2018, "validation").

use super::{largest, relative};
use crate::analytic::{Metal, Sides, Stretched, stretch_strip};
use crate::history::History;
use crate::reference::Reference;
use crate::scenes::{in_steps, load, run, run_compiled, text};
use crate::{Broken, Case, Check, Extent, Findings};
use mpm_io::{Options, Results, ResultsWriter};
use mpm_scene::Scene;
use mpm_scene::compile;
use mpm_solver::observe::Field;

pub(super) const FREE: Case = Case {
    name: "simple stretch, sides free",
    goal: "Large elastic and plastic stretch with a moving mesh; the reaction falls after first yield.",
    setup: "A square of 2 × 2 cells (side 2, E = 1000, ν = 0, ρ_y = 400, 2² points each, sMPM) is pulled by 4 in 40 and in 20 load steps; its sides are free, the mesh stretches with it.",
    reference: "The incremental closed form (backward Euler, homogeneous), and the tabulated one. After the peak the homogeneous state is a bifurcation: the run has to stay on it, or to say that it left.",
    run: free,
};

pub(super) const ROLLERS: Case = Case {
    name: "simple stretch, rollers",
    goal: "The same with rollers on both sides, where the homogeneous state is the only one.",
    setup: "As before, the top held against moving up or down; 40 load steps, written to a results file as well.",
    reference: "The incremental closed form and the tabulated one, at every load step and every point.",
    run: rollers,
};

const METAL: Metal = Metal { young: 1e3, poisson: 0.0, yield_radius: 400.0 };

/// Side of the square `[L]`.
const SIDE: f64 = 2.0;

fn closed_form(sides: Sides, steps: u32) -> Vec<Stretched> {
    let stretches: Vec<f64> = (1..=steps).map(|k| 1.0 + 2.0 * f64::from(k) / f64::from(steps)).collect();
    stretch_strip(&METAL, sides, &stretches)
}

fn free(_: Extent) -> Result<Findings, Broken> {
    let scene = load("simple_stretch")?;
    let history = run(&scene)?.completed()?;
    let exact = closed_form(Sides::Free, 40);
    let force = pull(&history);
    let expected: Vec<f64> = exact.iter().map(|state| SIDE * state.nominal()).collect();
    let table = Reference::read("simple_stretch_free_40_steps")?.column("reaction")?;
    let yields = exact.iter().position(|state| state.plastic).expect("the stretch goes beyond yield");
    let peak = expected.iter().zip(&expected[1..]).position(|(a, b)| b < a).expect("the force has a peak") + 1;

    let mut checks = vec![
        Check::new(
            "reaction, elastic steps, against the closed form (relative, every step)",
            largest((0..yields).map(|k| (force[k] / expected[k] - 1.0).abs())),
            1e-10,
        )
        .remark(format!("{yields} steps")),
        Check::new(
            "reaction up to the peak against the closed form (relative, every step)",
            largest((0..peak).map(|k| (force[k] / expected[k] - 1.0).abs())),
            1e-8,
        )
        .remark(format!("{peak} steps, peak {:.4}", expected[peak - 1])),
        Check::new(
            "reaction up to the peak against the table (relative, every step)",
            largest((0..peak).map(|k| (force[k] / table[k + 1] - 1.0).abs())),
            1e-8,
        ),
        after_the_peak(&history, &force, &expected, peak, "40"),
        Check::new("tabulated closed form against ours, all steps", relative(&expected, &table[1..]), 1e-12),
    ];

    let history = run(&in_steps(scene, 20))?.completed()?;
    let expected: Vec<f64> = closed_form(Sides::Free, 20).iter().map(|state| SIDE * state.nominal()).collect();
    checks.push(after_the_peak(&history, &pull(&history), &expected, peak / 2 + 1, "20"));
    checks.push(Check::new(
        "closed form, 20 steps, end value against 369.4737612",
        (expected[19] - 369.473_761_2).abs(),
        5e-8,
    ));
    Ok(checks.into())
}

/// A run that stays homogeneous has to follow the closed form to the end; one that necks has to
/// have found, in some step up to there, a tangent that is not positive definite.
fn after_the_peak(history: &History, force: &[f64], expected: &[f64], peak: usize, steps: &str) -> Check {
    let what = format!("after the peak, {steps} steps: reaction against the closed form, or necking reported");
    let necked = (1..history.rows().len()).find(|&row| inhomogeneity(history, row) > 1e-6);
    let Some(row) = necked else {
        let error = largest((peak..expected.len()).map(|k| (force[k] / expected[k] - 1.0).abs()));
        let spread = largest((1..history.rows().len()).map(|row| inhomogeneity(history, row)));
        return Check::new(what, error, 1e-6).remark(format!(
            "homogeneous throughout (F differs by {spread:.0e} at most), end value {:.7}",
            force[force.len() - 1]
        ));
    };
    let said = history.series("unstable_node", 0)[..=row].iter().any(|&node| node > 0.0);
    let error = if said { 0.0 } else { f64::INFINITY };
    Check::new(what, error, 1e-6).remark(format!("necked in step {row}, end value {}", force[force.len() - 1]))
}

fn rollers(_: Extent) -> Result<Findings, Broken> {
    let scene = load("simple_stretch_rollers")?;
    let history = run(&scene)?.completed()?;
    let exact = closed_form(Sides::Rollers, 40);
    let force = pull(&history);
    let expected: Vec<f64> = exact.iter().map(|state| SIDE * state.nominal()).collect();
    let table = Reference::read("simple_stretch_rollers_40_steps")?;

    let stress_error = largest(exact.iter().enumerate().flat_map(|(k, state)| {
        let [x, y, z] = state.cauchy();
        let components = [x, 0.0, 0.0, 0.0, y, 0.0, 0.0, 0.0, z];
        let points = history.field(Field::CAUCHY_STRESS, k + 1).chunks_exact(9);
        points.map(move |stress| relative(stress, &components)).collect::<Vec<_>>()
    }));
    let spread = largest((1..=40).map(|row| inhomogeneity(&history, row)));
    Ok(vec![
        Check::new(
            "reaction against the closed form (relative, every step)",
            largest(force.iter().zip(&expected).map(|(a, b)| (a / b - 1.0).abs())),
            1e-10,
        )
        .remark(format!("end value {:.7}", force[39])),
        Check::new(
            "reaction against the table (relative, every step)",
            largest(force.iter().zip(&table.column("reaction")?[1..]).map(|(a, b)| (a / b - 1.0).abs())),
            1e-10,
        ),
        Check::new("Cauchy stress against the closed form (every step, every point)", stress_error, 1e-10),
        Check::new("deformation gradient, difference between points", spread, 1e-11),
        Check::none("numbers of the results file that differ from the run's", differing_in_file(&scene)?),
    ]
    .into())
}

/// Reaction of the pulled edge in every load step `[F per thickness]`.
fn pull(history: &History) -> Vec<f64> {
    history.series("reaction/pulled", 0)[1..].to_vec()
}

/// Largest difference of a deformation gradient from that of the first point.
pub(crate) fn inhomogeneity(history: &History, row: usize) -> f64 {
    let f = history.field(Field::DEFORMATION_GRADIENT, row);
    largest(f.chunks_exact(9).flat_map(|of| of.iter().zip(&f[..9]).map(|(a, b)| (a - b).abs())))
}

/// Runs the scene into a file, reads it back, and counts what is not bit for bit what a run in
/// memory saw.
fn differing_in_file(scene: &Scene) -> Result<usize, Broken> {
    let mut compiled = compile(scene)?;
    let fields = compiled.fields(scene.output())?;
    let run = run_compiled(&mut compiled, scene).completed()?;
    let directory = tempfile::tempdir()?;
    let path = directory.path().join("run.h5");
    let options =
        Options { scene: text("simple_stretch_rollers")?, fields: fields.clone(), ..Options::default() };
    let mut writer = ResultsWriter::create(&path, options)?;
    compile(scene)?.run(&mut writer)?;
    drop(writer);

    let results = Results::open(&path)?;
    let kept = Scene::from_ron(results.scene())?;
    let mut differing = usize::from(results.status() != "completed") + usize::from(kept != *scene);
    let mut compare = |read: &[f64], seen: &[f64]| {
        differing += read.len().abs_diff(seen.len());
        differing += read.iter().zip(seen).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
    };
    for column in run.columns().iter().filter(|column| column.name != "wall_seconds") {
        let table = results.column(&column.name)?;
        for component in 0..column.width {
            let read: Vec<f64> = (0..table.len()).map(|row| table.row(row)[component]).collect();
            compare(&read, &run.series(&column.name, component));
        }
    }
    for (k, row) in run.rows().iter().enumerate() {
        compare(&results.residuals(k)?, &row.residuals);
        compare(results.points(k)?.values(), &row.positions);
        for (field, values) in fields.iter().zip(&row.fields) {
            compare(results.field(field.name(), k)?.values(), values);
        }
    }
    Ok(differing)
}

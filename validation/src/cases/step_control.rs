//! Load steps that fail.

use super::relative;
use crate::history::{History, Row};
use crate::scenes::{Run, load, load_own, own_text, run, run_compiled, with_cuts};
use crate::variants::{CPDI2Q, plane, with_points};
use crate::{Broken, Case, Check, Extent, Findings};
use mpm_io::{Options, Results, ResultsWriter};
use mpm_scene::language::{Count, Finite, RampInput, Scene};
use mpm_scene::{Compiled, compile};
use mpm_solver::observe::Field;
use mpm_solver::{Error, StepFailure};

pub(super) const FAILURE: Case = Case {
    name: "a load step that cannot be solved",
    goal: "A run that has to end says why, and keeps everything up to there.",
    setup: "The slab of crush.ron, whose fourth load step would turn its points inside out, with one halving allowed; and the simple stretch, sides free, with one Newton iteration and one halving, which serves its elastic steps only.",
    reference: "The named reason; the same first three load steps, bit for bit, as in a run that stops pushing there.",
    run: failure,
};

pub(super) const CUTS: Case = Case {
    name: "step control",
    goal: "Load steps that are too long are halved until they can be solved, and then grow again.",
    setup: "The slab of crush.ron with up to ten halvings. The rectilinear corner stretch with quadrilaterals and 8² points: where the mesh is laid anew, forces are left out of balance that no halving makes smaller.",
    reference: "Every nominal station is met exactly; elastic stress under the stretches of the load steps actually taken, in closed form. The corner: balanced in stages the run goes on to D = 4, beyond D = 1.8 where halving alone ends.",
    run: cuts,
};

fn failure(_: Extent) -> Result<Findings, Broken> {
    let scene = load_own("crush")?;
    let mut compiled = compile(&scene)?;
    let Run { history, outcome } = run_compiled(&mut compiled, &scene);
    let error = outcome.err().ok_or("the slab was crushed after all")?;
    let named = matches!(&error, Error::Step { step: 4, level: 1, reason: StepFailure::Inverted { .. }, .. });

    let spared = run(&stop_pushing(scene.clone()))?.completed()?;
    let rows: Vec<Vec<u64>> = history.reproducible().iter().map(Row::bits).collect();
    let expected: Vec<Vec<u64>> = spared.reproducible().iter().take(4).map(Row::bits).collect();

    let starved = starved_of_iterations(load("simple_stretch")?);
    let stopped = run(&starved)?;
    let reason = stopped.outcome.err().ok_or("the run got along with the iterations")?;
    let not_converged = matches!(&reason, Error::Step { reason: StepFailure::NotConverged { .. }, .. });
    Ok(vec![
        Check::none("reason other than the one expected (inversion)", usize::from(!named))
            .remark(error.to_string()),
        Check::none(
            "load steps before that differ from those of a run that goes no further",
            differing(&rows, &expected),
        ),
        Check::none(
            "points of the model that are not those of the last good load step",
            moved(&compiled, &history),
        ),
        Check::none("departures of the results file from that", departures_in_file(&scene, &history)?),
        Check::none("reason other than the one expected (no convergence)", usize::from(!not_converged))
            .remark(reason.to_string()),
        // Twelve nominal ones, and half of the thirteenth: it yields beyond its middle.
        Check::none(
            "elastic load steps missing before it",
            13_usize.abs_diff(stopped.history.rows().len() - 1),
        ),
    ]
    .into())
}

/// Rows that differ between two lists, or are missing in one.
fn differing(rows: &[Vec<u64>], expected: &[Vec<u64>]) -> usize {
    rows.len().abs_diff(expected.len()) + rows.iter().zip(expected).filter(|(a, b)| a != b).count()
}

/// The push of crush.ron up to its third load step only.
fn stop_pushing(mut scene: Scene) -> Scene {
    if let Scene::PlaneStrain(scene) = &mut scene {
        for displace in scene.supports.iter_mut().flat_map(|support| &mut support.displace) {
            let RampInput::Knots(knots) = &mut displace.ramp else { continue };
            let reached = knots[knots.len() - 2].1;
            knots.last_mut().expect("a ramp has knots").1 = Finite(reached.0);
        }
    }
    scene
}

fn starved_of_iterations(mut scene: Scene) -> Scene {
    if let Scene::PlaneStrain(scene) = &mut scene {
        scene.tolerance.iterations = Count(1);
        scene.schedule.cuts = 1;
    }
    scene
}

/// Points of the model that do not stand where the last row of the history shows them.
fn moved(compiled: &Compiled, history: &History) -> usize {
    let Compiled::Plane(model) = compiled else { return usize::MAX };
    let shown = &history.rows().last().expect("the initial state is always shown").positions;
    let body = &model.bodies[0].body;
    let stays = |p: usize| (0..2).all(|i| body.point(p).position[i].to_bits() == shown[3 * p + i].to_bits());
    (0..body.n_points()).filter(|&p| !stays(p)).count()
}

fn departures_in_file(scene: &Scene, history: &History) -> Result<usize, Broken> {
    let directory = tempfile::tempdir()?;
    let path = directory.path().join("crush.h5");
    let mut compiled = compile(scene)?;
    let fields = compiled.fields(scene.output())?;
    let options = Options { scene: own_text("crush")?, fields, ..Options::default() };
    let mut writer = ResultsWriter::create(&path, options)?;
    let ended = compiled.run(&mut writer);
    drop(writer);

    let results = Results::open(&path)?;
    let status = ended.err().map_or("completed".into(), |error| format!("failed: {error}"));
    let last = history.rows().last().expect("the initial state is always shown");
    let points = results.points(results.fractions().len() - 1)?;
    Ok(usize::from(results.status() != status)
        + usize::from(results.rows() != history.rows().len())
        + usize::from(points.values() != last.positions))
}

fn cuts(_: Extent) -> Result<Findings, Broken> {
    let scene = with_cuts(load_own("crush")?, 10);
    let mut compiled = compile(&scene)?;
    // Its top leaves the body.
    if let Compiled::Plane(model) = &mut compiled {
        model.needs_grip = false;
    }
    let history = run_compiled(&mut compiled, &scene).completed()?;
    let fractions: Vec<f64> = history.rows().iter().map(|row| row.fraction).collect();
    let missed = (0..=4).filter(|&k| !fractions.contains(&(f64::from(k) / 4.0))).count();
    let cuts: f64 = history.series("cuts", 0).iter().sum();

    // The slab is one cell high on a mesh that stays: a displacement d of the top stretches what
    // is there by 1 + d, whatever came before.
    let top = history.series("displacement/top", 1);
    let stretch: f64 = top.windows(2).map(|pair| 1.0 + (pair[1] - pair[0])).product();
    let p_wave = 1e3 * (1.0 - 0.3) / ((1.0 + 0.3) * (1.0 - 2.0 * 0.3));
    let lame = 1e3 * 0.3 / ((1.0 + 0.3) * (1.0 - 2.0 * 0.3));
    let stress = history.field(Field::CAUCHY_STRESS, fractions.len() - 1);
    let cauchy = |modulus: f64| modulus * stretch.ln() / stretch;
    let expected = [cauchy(lame), 0.0, 0.0, 0.0, cauchy(p_wave), 0.0, 0.0, 0.0, cauchy(lame)];
    let error = super::largest(stress.chunks_exact(9).map(|stress| relative(stress, &expected)));
    Ok(vec![
        Check::none("nominal stations missed", missed).remark(format!("{} load steps", fractions.len() - 1)),
        Check::none("lack of cuts in the record", usize::from(cuts < 2.0)).remark(format!("{cuts} cuts")),
        Check::new("displacement of the top at the end", (top[top.len() - 1] + 2.7).abs(), 1e-14),
        Check::new("Cauchy stress at the end against the closed form (every point)", error, 1e-10)
            .remark(format!("height {stretch:.4}")),
        staged()?,
    ]
    .into())
}

/// How far the corner stretch falls short of its end where steps that cannot be halved again are balanced in stages.
fn staged() -> Result<Check, Broken> {
    let scene = with_points(CPDI2Q.of(plane(load("corner_stretch_rectilinear")?)?), 8);
    let history = run(&Scene::PlaneStrain(scene))?.history;
    let staged = history.series("stages", 0).iter().filter(|&&stages| stages > 0.0).count();
    let short = 4.0 * (1.0 - history.last().fraction);
    Ok(Check::new("corner stretch: what is missing to D = 4", short, 0.0)
        .remark(format!("{staged} load steps in stages")))
}

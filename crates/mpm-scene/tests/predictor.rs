//! A load step begins where the last one points to: fewer iterations, the same answers.

use mpm_scene::Scene;
use mpm_scene::compile;
use mpm_solver::Summary;
use mpm_solver::observe::{Field, LoadStep, Observer, ObserverError};

#[derive(Default)]
struct Last {
    displacement: Vec<f64>,
}

impl Observer for Last {
    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        self.displacement = step.fields.field(Field::DISPLACEMENT);
        Ok(())
    }
}

fn run(text: &str) -> (Vec<f64>, Summary) {
    let mut last = Last::default();
    let summary = compile(&Scene::from_ron(text).unwrap()).unwrap().run(&mut last).unwrap();
    (last.displacement, summary)
}

/// The scene with and without a guess; largest difference over largest displacement.
fn both(text: &str) -> (f64, Summary, Summary) {
    let (guessed, with) = run(text);
    let (rest, without) = run(&text.replace("schedule: (", "schedule: (predictor: Rest, "));
    let largest = rest.iter().fold(0.0_f64, |most, u| most.max(u.abs()));
    let apart = guessed.iter().zip(&rest).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    (apart / largest, with, without)
}

#[test]
fn steady_loading_needs_fewer_iterations() {
    for (scene, most) in [
        (include_str!("../../../scenes/column.ron"), 0.97),
        (include_str!("../../../scenes/doughnut_elastic.ron"), 0.85),
        (include_str!("../../../scenes/simple_stretch_rollers.ron"), 0.5),
        (include_str!("../../../scenes/column_solid.ron"), 0.95),
    ] {
        let (apart, with, without) = both(scene);
        assert!(apart < 1e-9, "{scene:.60}: {apart:e} apart");
        assert_eq!((with.dropped_iterations, without.dropped_iterations), (0, 0));
        let (with, without) = (with.iterations as f64, without.iterations as f64);
        assert!(with <= most * without, "{with} of {without} iterations");
    }
}

/// A strip that is pulled, and let go again at half of the load: the guess points the wrong way once.
#[test]
fn a_wrong_guess_costs_no_answer() {
    let scene = r#"PlaneStrain(
        mesh: Box(axes: [Uniform(from: 0, to: 4, cells: 4), Uniform(from: 0, to: 2, cells: 2)]),
        basis: Cpdi1,
        materials: { "a": VonMises(young: 1e3, poisson: 0.3, yield_radius: 40) },
        bodies: [(name: "b", material: "a", shape: Box(from: (0, 0), to: (3, 1.5)), points_per_cell: 2)],
        supports: [
            (name: "left", region: Plane(axis: X, at: 0), fix: [X, Y]),
            (name: "right", region: Plane(axis: X, at: 3), displace: [(axis: X, by: 0.45, ramp: [(0, 0), (0.5, 1), (1, 0)])]),
        ],
        schedule: (steps: 10),
    )"#;
    let (apart, with, without) = both(scene);
    assert!(apart < 1e-8, "{apart:e}");
    assert_eq!((with.steps, with.cuts), (without.steps, 0));
}

/// A block that collapses, points crossing cells: some guesses are dropped, and no step is halved for it.
#[test]
fn guesses_that_do_not_converge_are_dropped_and_counted() {
    let (apart, with, without) = both(include_str!("../../../scenes/collapse.ron"));
    assert!(apart < 1e-7, "{apart:e}");
    assert!(with.dropped_iterations > 0 && with.cuts == 0 && without.dropped_iterations == 0);
    assert!(with.iterations < without.iterations);
    let solved = with.timings.iter().find(|it| it.phase == "solve").expect("it is timed").count;
    assert_eq!(solved, with.iterations + with.dropped_iterations);
}

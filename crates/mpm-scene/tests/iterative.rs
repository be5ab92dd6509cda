//! Conjugate gradients and GMRES with multigrid in place of a factorisation: the same answers.

use mpm_scene::Scene;
use mpm_scene::compile;
use mpm_solver::Summary;
use mpm_solver::observe::{Entry, Field, LoadStep, Observer, ObserverError, RunStart};

#[derive(Default)]
struct Seen {
    columns: Vec<String>,
    /// Of the last load step.
    displacement: Vec<f64>,
    /// `factorization` and `linear_iterations` of every load step.
    methods: Vec<u64>,
    iterations: Vec<u64>,
}

impl Observer for Seen {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        self.columns = run.columns.iter().map(|it| it.name.clone()).collect();
        Ok(())
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        self.displacement = step.fields.field(Field::DISPLACEMENT);
        let count = |name: &str| {
            self.columns.iter().position(|it| it == name).map(|column| match &step.row[column] {
                Entry::Count(values) => values[0],
                Entry::Real(_) => panic!("{name} is a count"),
            })
        };
        if step.index > 0 {
            self.methods.push(count("factorization").expect("it is always recorded"));
            self.iterations.extend(count("linear_iterations"));
        }
        Ok(())
    }
}

fn run(text: &str) -> (Seen, Summary) {
    let mut seen = Seen::default();
    let summary = compile(&Scene::from_ron(text).unwrap()).unwrap().run(&mut seen).unwrap();
    (seen, summary)
}

/// A block on a base, squeezed under its own weight; its top is half a cell above a line of nodes.
fn block(basis: &str, law: &str, solver: &str) -> String {
    format!(
        r#"Solid(
            mesh: Box(axes: [Uniform(from: 0, to: 6, cells: 6), Uniform(from: 0, to: 6, cells: 6), Uniform(from: 0, to: 8, cells: 8)]),
            basis: {basis},
            materials: {{ "a": {law} }},
            bodies: [(name: "b", material: "a", shape: Box(from: (0, 0, 0), to: (4.5, 4.5, 5.5)), points_per_cell: 2)],
            supports: [
                (name: "base", region: Plane(axis: Z, at: 0), fix: [X, Y, Z]),
                (name: "x", region: Plane(axis: X, at: 0), fix: [X]),
                (name: "y", region: Plane(axis: Y, at: 0), fix: [Y]),
            ],
            loads: [BodyForce(acceleration: (0, 0, -10))],
            schedule: (steps: 4),
            solver: {solver},
        )"#
    )
}

#[test]
fn the_answers_are_those_of_the_direct_solver() {
    let elastic = "Hencky(young: 1e4, poisson: 0.3, density: 10)";
    let plastic = "VonMises(young: 1e4, poisson: 0.3, yield_radius: 300, density: 10)";
    for (basis, law) in [("Smpm", elastic), ("Gimp", elastic), ("Cpdi1", plastic), ("Smpm", plastic)] {
        let (direct, _) = run(&block(basis, law, "Direct"));
        let (iterative, summary) = run(&block(basis, law, "Iterative"));
        assert_eq!(iterative.methods, [3; 4], "{basis}, {law}: without help");
        assert!(iterative.iterations.iter().all(|&n| n > 0 && n < 150), "{basis}: {:?}", iterative.iterations);
        assert!(direct.iterations.is_empty(), "nobody asked");
        assert_eq!(summary.indefinite_steps, 0);
        let largest = direct.displacement.iter().fold(0.0_f64, |most, u| most.max(u.abs()));
        let apart = direct.displacement.iter().zip(&iterative.displacement);
        let apart = apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(largest > 0.1 && apart < 1e-6 * largest, "{basis}, {law}: {apart:e} of {largest:e}");
    }
}

/// Sand whose friction exceeds its dilatancy flows: tangents that are not symmetric.
#[test]
fn unsymmetric_tangents_are_solved_by_gmres_with_the_same_answers() {
    let sand = "MohrCoulomb(young: 1e4, poisson: 0.3, cohesion: 80, friction: 30, dilation: 5, density: 10)";
    for basis in ["Smpm", "Gimp"] {
        let (direct, _) = run(&block(basis, sand, "Direct"));
        let (iterative, summary) = run(&block(basis, sand, "Iterative"));
        assert_eq!((&direct.methods[..], &iterative.methods[..]), (&[2; 4][..], &[5; 4][..]), "{basis}");
        assert!(iterative.iterations.iter().all(|&n| n > 0 && n < 400), "{basis}: {:?}", iterative.iterations);
        assert_eq!((summary.backward_error, summary.pivot_spread), (None, None), "nothing is made up");
        let largest = direct.displacement.iter().fold(0.0_f64, |most, u| most.max(u.abs()));
        let apart = direct.displacement.iter().zip(&iterative.displacement);
        let apart = apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(largest > 0.05 && apart < 1e-5 * largest, "{basis}: {apart:e} of {largest:e}");
    }
}

#[test]
fn small_systems_are_solved_directly_and_large_ones_are_not() {
    let text = block("Smpm", "Hencky(young: 1e4, poisson: 0.3, density: 10)", "Auto");
    assert_eq!(run(&text).0.methods, [0; 4]);
    let finer = text.replace("cells: 6)", "cells: 24)").replace("cells: 8)", "cells: 32)");
    let finer = finer.replace("points_per_cell: 2", "points_per_cell: 1");
    let estimate = compile(&Scene::from_ron(&finer).unwrap()).unwrap().estimate().unwrap();
    assert!(estimate.is_iterative, "{:?}", estimate.prediction);
}

/// A square that settles and widens.
fn square(cells: u32, basis: &str, poisson: &str, solver: &str) -> String {
    let wide = cells - 8;
    format!(
        r#"PlaneStrain(
            mesh: Box(axes: [Uniform(from: 0, to: {cells}, cells: {cells}), Uniform(from: 0, to: {cells}, cells: {cells})]),
            basis: {basis},
            materials: {{ "a": Hencky(young: 1e4, poisson: {poisson}, density: 1) }},
            bodies: [(name: "b", material: "a", shape: Box(from: (0, 0), to: ({wide}, {wide})), points_per_cell: 2)],
            supports: [
                (name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y]),
                (name: "left", region: Plane(axis: X, at: 0), fix: [X]),
            ],
            loads: [BodyForce(acceleration: (0, -2))],
            schedule: (steps: 1),
            solver: {solver},
        )"#
    )
}

#[test]
fn large_systems_in_the_plane_are_iterated_too() {
    for basis in ["Smpm", "Gimp", "Cpdi2q"] {
        let mut small = compile(&Scene::from_ron(&square(20, basis, "0.3", "Auto")).unwrap()).unwrap();
        assert!(!small.estimate().unwrap().is_iterative);
        let (direct, _) = run(&square(150, basis, "0.3", "Direct"));
        let (auto, _) = run(&square(150, basis, "0.3", "Auto"));
        assert_eq!((direct.methods, &auto.methods[..]), (vec![0], &[3][..]), "{basis}");
        assert!(auto.iterations[0] < 60, "{basis}: {:?}", auto.iterations);
        let largest = direct.displacement.iter().fold(0.0_f64, |most, u| most.max(u.abs()));
        let apart = direct.displacement.iter().zip(&auto.displacement);
        let apart = apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(largest > 0.1 && apart < 1e-7 * largest, "{basis}: {apart:e} of {largest:e}");
    }
}

/// Path control in the plane takes the signs of pivots.
#[test]
fn path_control_in_the_plane_factorises() {
    let is_iterative = |control: &str| {
        let text = square(150, "Smpm", "0.3", "Auto").replace("(steps: 1)", &format!("(steps: 9, {control})"));
        compile(&Scene::from_ron(&text).unwrap()).unwrap().estimate().unwrap().is_iterative
    };
    assert!(is_iterative("control: Load"));
    assert!(!is_iterative("control: Path(first: 0.1)"));
}

/// So does path control in space where tangents are not symmetric, because GMRES tells no signs.
#[test]
fn path_control_of_unsymmetric_tangents_factorises() {
    let sand = "MohrCoulomb(young: 1e4, poisson: 0.3, cohesion: 40, friction: 30, dilation: 5, density: 10)";
    let fine =
        block("Smpm", sand, "Auto").replace("cells: 6)", "cells: 30)").replace("cells: 8)", "cells: 40)");
    let fine = fine.replace("points_per_cell: 2", "points_per_cell: 1");
    let estimate = |control: &str| {
        let text = fine.replace("(steps: 4)", &format!("(steps: 4, {control})"));
        compile(&Scene::from_ron(&text).unwrap()).unwrap().estimate().unwrap()
    };
    let by_load = estimate("control: Load");
    assert!(by_load.is_iterative, "{:?}", by_load.prediction);
    assert!(!estimate("control: Path(first: 0.1)").is_iterative);
}

/// Where iterations cost more than the factorisation that they were to save, it is made.
#[test]
fn what_takes_too_many_iterations_is_factorised() {
    let (auto, _) = run(&square(150, "Smpm", "0.4999", "Auto"));
    assert_eq!(auto.methods, [0]);
    assert!((30..100).contains(&auto.iterations[0]), "spent once: {:?}", auto.iterations);
    let (direct, _) = run(&square(150, "Smpm", "0.4999", "Direct"));
    let apart = auto.displacement.iter().zip(&direct.displacement);
    let apart = apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-7, "{apart:e}");
}

/// A strip pulled until its tangent is indefinite: GMRES goes on where conjugate gradients cannot.
#[test]
fn an_indefinite_tangent_is_left_to_gmres() {
    let strip = |solver: &str| {
        let scene = include_str!("../../../scenes/simple_stretch.ron");
        scene.replace("schedule:", &format!("solver: {solver},\n    schedule:"))
    };
    let (direct, expected) = run(&strip("Direct"));
    let (iterative, summary) = run(&strip("Iterative"));
    assert!(expected.indefinite_steps > 0, "it is meant to be unstable");
    assert_eq!(iterative.methods[0], 3);
    assert!(summary.indefinite_steps > 0 && iterative.methods.contains(&5), "{:?}", iterative.methods);
    let apart = direct.displacement.iter().zip(&iterative.displacement);
    let apart = apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-6, "{apart:e}");
}

#[test]
fn threads_change_no_bit() {
    let text = block("Gimp", "VonMises(young: 1e4, poisson: 0.3, yield_radius: 300, density: 10)", "Iterative");
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (seen, _) = pool.install(|| run(&text));
        (seen.displacement.iter().map(|u| u.to_bits()).collect::<Vec<u64>>(), seen.iterations)
    };
    let alone = with(1);
    for threads in [2, 3, 8] {
        assert!(with(threads) == alone, "{threads} threads");
    }
}

/// Newton's iteration with one factorisation ends where the full one does; where it contracts too little,
/// tangents are taken again.
#[test]
fn a_factorisation_is_kept_while_it_contracts() {
    let keeping = |law: &str, part: &str| {
        let tolerance = format!("tolerance: (keep_factor_below: {part}), solver:");
        block("Smpm", law, "Direct").replace("solver:", &tolerance)
    };
    let elastic = "Hencky(young: 1e4, poisson: 0.3, density: 10)";
    let plastic = "VonMises(young: 1e4, poisson: 0.3, yield_radius: 300, density: 10)";
    let factorised = |summary: &Summary| {
        let of = |name| summary.timings.iter().find(|it| it.phase == name).expect("it is timed").count;
        (
            of("factorise"),
            of("solve"),
            summary.skipped.iter().find(|it| it.0.contains("factorisations")).unwrap().1,
        )
    };
    for (law, part) in [(elastic, "0.2"), (plastic, "0.2"), (plastic, "0.9")] {
        let (full, expected) = run(&block("Smpm", law, "Direct"));
        let (kept, summary) = run(&keeping(law, part));
        let (once, solved, skipped) = factorised(&summary);
        assert_eq!(once + skipped, solved, "{law}, {part}");
        assert!(skipped > 0 && once < factorised(&expected).0, "{law}, {part}: {once} of {solved}");
        if law == elastic {
            assert_eq!(once, 4, "one a load step");
        }
        let apart = full.displacement.iter().zip(&kept.displacement);
        let apart = apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-6, "{law}, {part}: {apart:e}");
    }
    let refused = compile(&Scene::from_ron(&keeping(elastic, "1.0")).unwrap()).err().unwrap().to_string();
    assert!(refused.contains("keep_factor_below") && refused.contains("less than 1"), "{refused}");
}

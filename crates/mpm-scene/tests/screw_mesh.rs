//! A twist of the mesh composed with a stretch: a body that is carried round many times while it is compressed.

use mpm_scene::compile;
use mpm_scene::language::Scene;
use mpm_solver::observe::{Column, Entry, LoadStep, Observer, ObserverError, RunStart};
use std::f64::consts::TAU;

const SECTORS: u32 = 16;
const TURNS: f64 = 3.0;
const DOWN: f64 = -0.25;

/// Both edges turn alike, so that nothing but the plates strains the body.
fn scene(basis: &str, turns: f64) -> Scene {
    let text = format!(
        r#"Solid(
            mesh: Ring(radii: Uniform(from: 1, to: 2, cells: 2), sectors: {SECTORS}, height: Uniform(from: 0, to: 1.5, cells: 3)),
            motion: Twist(inner: {angle}, outer: {angle}, stretch: (axis: Z, anchor: 0, driven: 1, displacement: {DOWN})),
            basis: {basis},
            materials: {{ "m": Hencky(young: 1e3, poisson: 0.25) }},
            bodies: [(name: "b", material: "m", shape: Tube(axis: Z, inner: 1, outer: 2, extent: (0, 1)), points_per_cell: 2)],
            supports: [
                (name: "inner", region: Circle(radius: 1), follow_mesh: [X, Y], moment_about: (0, 0)),
                (name: "outer", region: Circle(radius: 2), follow_mesh: [X, Y]),
                (name: "base", region: Plane(axis: Z, at: 0), fix: [Z]),
                (name: "top", region: Plane(axis: Z, at: 1), follow_mesh: [Z]),
            ],
            schedule: (steps: 60),
            output: (fields: []),
        )"#,
        angle = 360.0 * turns,
    );
    Scene::from_ron(&text).unwrap_or_else(|error| panic!("{error}"))
}

#[derive(Default)]
struct Reactions {
    top: Option<usize>,
    /// Load fraction and force along the axis.
    rows: Vec<(f64, f64)>,
}

impl Observer for Reactions {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        let is_top = |it: &Column| it.name == "reaction/top";
        self.top = run.columns.iter().position(is_top);
        Ok(())
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        let Entry::Real(force) = &step.row[self.top.expect("the support has a column")] else {
            panic!("reactions are reals")
        };
        self.rows.push((step.fraction, force[2]));
        Ok(())
    }
}

fn forces(basis: &str, turns: f64) -> Vec<(f64, f64)> {
    let mut seen = Reactions::default();
    compile(&scene(basis, turns)).unwrap().run(&mut seen).unwrap();
    // The first row is the start.
    assert_eq!(seen.rows.len(), 61);
    seen.rows.split_off(1)
}

/// Confined compression of a Hencky solid: `σ = M ln λ / λ`, whatever turns.
#[test]
fn a_body_turned_many_times_is_compressed_as_one_that_rests() {
    let modulus = 1e3 * 0.75 / (1.25 * 0.5);
    let sector = TAU / f64::from(SECTORS);
    let area = 0.5 * f64::from(SECTORS) * sector.sin() * (4.0 - 1.0);
    for (fraction, force) in forces("Smpm", TURNS) {
        let stretch = 1.0 + DOWN * fraction;
        let expected = area * modulus * stretch.ln() / stretch;
        assert!((force / expected - 1.0).abs() < 1e-9, "at {fraction}: {force} {expected}");
    }
    // Parallelograms do not fill the sectors of a ring: their answer is compared with their own.
    for ((fraction, turned), (_, still)) in forces("Cpdi1", TURNS).into_iter().zip(forces("Cpdi1", 0.0)) {
        assert!((turned / still - 1.0).abs() < 1e-9, "at {fraction}: {turned} {still}");
    }
}

#[test]
fn a_stretch_of_a_twist_is_checked() {
    let with = |stretch: &str| {
        let text = format!(
            r#"Solid(
                mesh: Ring(radii: Uniform(from: 1, to: 2, cells: 2), sectors: 8, height: Uniform(from: 0, to: 1, cells: 2)),
                motion: Twist(inner: 90, stretch: ({stretch})),
                basis: Smpm,
                materials: {{ "m": Hencky(young: 1e3, poisson: 0.25) }},
                bodies: [(name: "b", material: "m", shape: Tube(axis: Z, inner: 1, outer: 2), points_per_cell: 1)],
                supports: [(name: "inner", region: Circle(radius: 1), fix: [X, Y, Z])],
                schedule: (steps: 1),
            )"#
        );
        compile(&Scene::from_ron(&text).unwrap()).map(drop).unwrap_err().to_string()
    };
    let across = with("axis: X, anchor: 0, driven: 1, displacement: 0.1");
    assert!(across.contains("motion.stretch.axis") && across.contains("expected Z, got X"), "{across}");
    let through = with("axis: Z, anchor: 0, driven: 1, displacement: -1");
    assert!(through.contains("motion.stretch") && through.contains("reaches its anchor"), "{through}");
    let ramp = with("axis: Z, anchor: 0, driven: 1, displacement: -1, ramp: []");
    assert!(ramp.contains("motion.stretch.ramp"), "{ramp}");
}

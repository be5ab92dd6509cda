//! Tractions and point forces reach the supports whole, ramped, and act where they should.

use mpm_scene::{Scene, compile};
use mpm_solver::observe::{Entry, LoadStep, Observer, ObserverError};

/// Reaction of the only support at every load step.
#[derive(Default)]
struct Reactions(Vec<Vec<f64>>);

impl Observer for Reactions {
    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        if let [.., Entry::Real(reaction), Entry::Real(_), Entry::Real(moment)] = step.row {
            self.0.push([&reaction[..], &moment[..]].concat());
        }
        Ok(())
    }
}

/// Reactions (x, y, moment about the origin) of a stiff clamped bar 2 by 1 under some load.
fn reactions(basis: &str, load: &str) -> Vec<Vec<f64>> {
    let scene = format!(
        r#"PlaneStrain(
            mesh: Box(axes: [Uniform(from: 0, to: 3, cells: 6), Uniform(from: 0, to: 1, cells: 2)]),
            basis: {basis},
            materials: {{ "steel": Hencky(young: 1e9, poisson: 0.3) }},
            bodies: [(name: "bar", material: "steel", shape: Box(from: (0, 0), to: (2, 1)), points_per_cell: 4)],
            supports: [(name: "wall", region: Plane(axis: X, at: 0), fix: [X, Y], moment_about: (0, 0))],
            loads: [{load}],
            schedule: (steps: 4),
        )"#
    );
    let mut seen = Reactions::default();
    compile(&Scene::from_ron(&scene).unwrap()).unwrap().run(&mut seen).unwrap();
    seen.0
}

#[track_caller]
fn check(found: &[f64], expected: [f64; 3]) {
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-5, "{found} is not {expected}");
    }
}

#[test]
fn a_traction_is_shared_over_its_part_of_the_boundary() {
    for basis in ["Smpm", "Gimp", "Cpdi1", "Cpdi2q", "Cpdi2t"] {
        let whole = reactions(basis, r#"Traction(body: "bar", axis: X, at: 2, resultant: (8, 0))"#);
        // The resultant acts half way up the end, so it has the moment -8 · ½ and the wall its opposite.
        check(&whole[4], [-8.0, 0.0, 4.0]);
        check(&whole[1], [-2.0, 0.0, 1.0]);
        let upper = reactions(
            basis,
            r#"Traction(body: "bar", axis: X, at: 2, within: (from: (2, 0.5), to: (2, 1)), resultant: (8, 0))"#,
        );
        check(&upper[4], [-8.0, 0.0, 6.0]);
    }
}

#[test]
fn loads_follow_their_ramps() {
    let load = r#"PointForce(body: "bar", near: (2, 0.5), points: 2, force: (0, -6), ramp: [(0, 0), (0.5, 1), (1, 0.25)])"#;
    let seen = reactions("Gimp", load);
    for (step, factor) in [(1, 0.5), (2, 1.0), (3, 0.625), (4, 0.25)] {
        assert!((seen[step][1] - 6.0 * factor).abs() < 1e-6, "{}", seen[step][1]);
    }
}

#[test]
fn a_force_as_far_as_numbers_go_is_refused() {
    for (points, x) in [("", "-1e308"), ("points: 2, ", "-1e308"), ("points: 2, ", "1.7e308")] {
        let scene = format!(
            r#"PlaneStrain(
                mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 2, cells: 2)]),
                basis: Smpm,
                materials: {{ "a": Hencky(young: 1, poisson: 0) }},
                bodies: [(name: "b", material: "a", shape: Box(from: (0, 0), to: (1, 1)), points_per_cell: 2)],
                supports: [(name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y])],
                loads: [PointForce(body: "b", near: ({x}, 1), {points}force: (1, 0))],
                schedule: (steps: 1),
            )"#
        );
        let refused = compile(&Scene::from_ron(&scene).unwrap()).err().expect("it hits nothing").to_string();
        assert!(refused.contains("loads[0].near: the nearest material point"), "{refused}");
    }
}

//! A converged step is a solution: rigid motions that nothing holds are named, and every body is balanced by itself.

use mpm_scene::{Compiled, Scene, compile};
use mpm_solver::observe::{Column, Entry, LoadStep, Observer, ObserverError, RunStart};
use mpm_solver::{Error, StepFailure};

/// The last row of the history by the names of its columns.
#[derive(Default)]
struct Seen {
    columns: Vec<Column>,
    row: Vec<Entry>,
}

impl Observer for Seen {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        self.columns = run.columns.clone();
        Ok(())
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        self.row = step.row.to_vec();
        Ok(())
    }
}

impl Seen {
    fn last(&self, name: &str) -> Vec<f64> {
        let at = self.columns.iter().position(|column| column.name == name);
        match &self.row[at.unwrap_or_else(|| panic!("no column {name}"))] {
            Entry::Real(values) => values.clone(),
            Entry::Count(values) => values.iter().map(|n| *n as f64).collect(),
        }
    }
}

fn compiled(text: &str) -> Compiled {
    let scene = Scene::from_ron(text).unwrap_or_else(|it| panic!("{it}: {text}"));
    compile(&scene).unwrap_or_else(|it| panic!("{it}: {text}"))
}

fn run(text: &str) -> (Seen, Option<Error>) {
    let mut seen = Seen::default();
    let outcome = compiled(text).run(&mut seen);
    (seen, outcome.err())
}

/// What is not held, with the direct and with the iterative solver.
fn unheld(text: &str) -> String {
    let motions = ["Direct", "Iterative"].map(|solver| {
        match run(&text.replacen("schedule:", &format!("solver: {solver}, schedule:"), 1)).1 {
            Some(Error::Step { step: 1, level: 0, reason: StepFailure::Unheld { motion }, .. }) => motion,
            other => panic!("{other:?}: {text}"),
        }
    });
    assert_eq!(motions[0], motions[1]);
    motions[0].clone()
}

const AXIS: &str = "Uniform(from: 0, to: 8, cells: 8)";

/// A scene of boxes in the plane or in space.
struct Boxes<'a> {
    solid: bool,
    basis: &'a str,
    /// Name, and opposite corners.
    bodies: &'a [(&'a str, &'a str, &'a str)],
    supports: &'a str,
    /// What else the scene has.
    rest: &'a str,
}

impl Boxes<'_> {
    fn text(&self) -> String {
        let Self { solid, basis, bodies, supports, rest } = self;
        let (kind, axes) =
            if *solid { ("Solid", [AXIS; 3].join(", ")) } else { ("PlaneStrain", [AXIS; 2].join(", ")) };
        let body = |(name, from, to): &(&str, &str, &str)| {
            format!(
                "(name: \"{name}\", material: \"m\", shape: Box(from: ({from}), to: ({to})), points_per_cell: 2)"
            )
        };
        let bodies: Vec<String> = bodies.iter().map(body).collect();
        format!(
            "{kind}(mesh: Box(axes: [{axes}]), basis: {basis},
            materials: {{ \"m\": Hencky(young: 1000, poisson: 0.3) }},
            bodies: [{}], supports: [{supports}], schedule: (steps: 2), {rest})",
            bodies.join(", ")
        )
    }
}

const PLANE: [&str; 5] = ["Smpm", "Gimp", "Cpdi1", "Cpdi2q", "Cpdi2t"];

fn plane<'a>(bodies: &'a [(&'a str, &'a str, &'a str)], supports: &'a str) -> Boxes<'a> {
    Boxes { solid: false, basis: "Gimp", bodies, supports, rest: "" }
}

const BLOCK: [(&str, &str, &str); 1] = [("b", "2, 2", "4, 4")];
const CUBE: [(&str, &str, &str); 1] = [("b", "2, 2, 2", "4, 4, 4")];
const ROLLERS: &str = "(name: \"p\", region: Plane(axis: Y, at: 2), fix: [Y])";

#[test]
fn what_nothing_holds_in_the_plane_is_named() {
    let pin = "(name: \"p\", region: Point(2, 2), fix: [X, Y])";
    for basis in PLANE {
        let named = |supports| unheld(&Boxes { basis, ..plane(&BLOCK, supports) }.text());
        assert_eq!(named(ROLLERS), "body `b` along x");
        assert_eq!(named(""), "body `b` along x, along y and in rotation");
        assert_eq!(named(pin), "body `b` in rotation about the point (2, 2)");
    }
    // Two supports whose directions meet in a point.
    let crossed = "(name: \"p\", region: Point(2, 2), fix: [Y]), (name: \"q\", region: Point(2, 4), fix: [X])";
    assert_eq!(unheld(&plane(&BLOCK, crossed).text()), "body `b` in rotation about the point (2, 4)");
}

#[test]
fn what_nothing_holds_in_space_is_named() {
    let named = |supports| unheld(&Boxes { solid: true, ..plane(&CUBE, supports) }.text());
    assert_eq!(named(ROLLERS), "body `b` along x, along z and in rotation about an axis along y");
    let hinge = "(name: \"p\", region: Box(from: (2, 2, 2), to: (4, 2, 2)), fix: [X, Y, Z])";
    assert_eq!(named(hinge), "body `b` in rotation about an axis along x through the point (3, 2, 2)");
    let pin = "(name: \"p\", region: Point(2, 2, 2), fix: [X, Y, Z])";
    assert_eq!(
        named(pin),
        "body `b` in rotation about an axis along x through the point (3, 2, 2), in rotation about an axis along y \
         through the point (2, 3, 2) and in rotation about an axis along z through the point (2, 2, 3)"
    );
}

#[test]
fn bodies_and_parts_that_are_not_connected_are_told_apart() {
    let base = "(name: \"p\", region: Box(from: (2, 2), to: (4, 2)), fix: [X, Y])";
    let apart = [("b", "2, 2", "4, 4"), ("c", "6, 2", "7, 4")];
    assert_eq!(unheld(&plane(&apart, base).text()), "body `c` along x, along y and in rotation");
    // They share nodes.
    let joined = [("b", "2, 2", "4, 4"), ("c", "4, 2", "6, 4")];
    assert_eq!(unheld(&plane(&joined, ROLLERS).text()), "body `b` and body `c` along x");
    // A hinge: they share one node.
    let hinged = [("b", "2, 2", "4, 4"), ("c", "4, 4", "6, 6")];
    let hinged = Boxes { basis: "Smpm", ..plane(&hinged, base) };
    assert_eq!(unheld(&hinged.text()), "body `c` in rotation about the point (4, 4)");
    // Ghost faces join cells that share a face, so that they do not hold it.
    let ghost = Boxes { rest: "stabilisation: Ghost()", ..hinged };
    assert_eq!(unheld(&ghost.text()), "body `c` in rotation about the point (4, 4)");
}

#[test]
fn a_motion_without_load_is_kept_at_zero_where_the_scene_asks_for_it() {
    let zero = "unheld_motion: Zero, probes: [(name: \"all\", body: \"b\", points: All)], loads: ";
    let press = format!("{zero}[Traction(body: \"b\", axis: Y, at: 4, resultant: (0, -40))]");
    let push = format!("{zero}[Traction(body: \"b\", axis: Y, at: 4, resultant: (1, -40))]");
    let cube = press.replace("(0, -40)", "(0, -160, 0)");
    let mut scenes: Vec<Boxes<'_>> =
        PLANE.iter().map(|&basis| Boxes { basis, rest: &press, ..plane(&BLOCK, ROLLERS) }).collect();
    scenes.push(Boxes { solid: true, rest: &cube, ..plane(&CUBE, ROLLERS) });
    for (scene, solver) in scenes.iter().flat_map(|it| [(it, "Direct"), (it, "Iterative")]) {
        let text = scene.text().replacen("schedule:", &format!("solver: {solver}, schedule:"), 1);
        let (seen, error) = run(&text);
        assert!(error.is_none(), "{error:?}: {text}");
        // Zero but for the round-off of nodes that points barely reach, and what an iteration leaves of them.
        let moved = seen.last("probe/all/displacement");
        assert!(moved[1] < -0.01 && moved[0].abs() < 1e-11, "{moved:?}: {text}");
        assert!(moved.get(2).is_none_or(|z| z.abs() < 1e-11), "{moved:?}: {text}");
    }
    let loaded = run(&Boxes { rest: &push, ..plane(&BLOCK, ROLLERS) }.text()).1;
    let is_named = matches!(
        &loaded,
        Some(Error::Step { reason: StepFailure::UnheldLoaded { motion }, .. }) if motion == "body `b` along x"
    );
    assert!(is_named, "{loaded:?}");
}

/// A soft cube (E = 100) between a base of this modulus, that moves up by `lift`, and a top that moves down by 0.01.
fn on_base(young: f64, lift: f64) -> String {
    format!(
        "PlaneStrain(
        mesh: Box(axes: [Uniform(from: 0, to: 1, cells: 1), Uniform(from: 0, to: 4, cells: 4)]), basis: Smpm,
        materials: {{ \"soft\": Hencky(young: 100, poisson: 0), \"rigid\": Hencky(young: {young:e}, poisson: 0) }},
        bodies: [
            (name: \"low\", material: \"rigid\", shape: Box(from: (0, 1), to: (1, 2)), points_per_cell: 2),
            (name: \"up\", material: \"soft\", shape: Box(from: (0, 2), to: (1, 3)), points_per_cell: 2),
        ],
        supports: [
            (name: \"base\", region: Plane(axis: Y, at: 1), fix: [X], displace: [(axis: Y, by: {lift:?})]),
            (name: \"l\", region: Plane(axis: X, at: 0), fix: [X]),
            (name: \"r\", region: Plane(axis: X, at: 1), fix: [X]),
            (name: \"top\", region: Plane(axis: Y, at: 3), displace: [(axis: Y, by: -0.01)]),
        ],
        schedule: (steps: 1),
    )"
    )
}

#[test]
fn a_stiff_base_does_not_loosen_the_balance_of_a_soft_body() {
    // The stress of a bar without lateral strain and ν = 0: E ln λ / λ.
    for (lift, round_off) in [(0.0, 1e-12), (0.02, 2e-2)] {
        let stretch: f64 = 1.0 - 0.01 - lift;
        let exact = 100.0 * stretch.ln() / stretch;
        for young in [1e8, 1e12, 1e14, 1e16] {
            let (seen, error) = run(&on_base(young, lift));
            assert!(error.is_none(), "{error:?}");
            let (top, base) = (seen.last("reaction/top")[1], seen.last("reaction/base")[1]);
            // The base is not rigid.
            assert!(
                (top / exact - 1.0).abs() < 1e-9 + 2.0 * 100.0 / young,
                "E = {young:e}, lift {lift}: {top} at the top, {exact}"
            );
            // Of a base that moves, the stress is known to the round-off of its strain alone.
            let most = if lift == 0.0 { round_off } else { round_off * young / 1e14 };
            assert!((top + base).abs() <= most.max(1e-9), "E = {young:e}, lift {lift}: {top} and {base}");
        }
    }
}

#[test]
fn moduli_of_any_size_give_the_same_motion() {
    let scene = |young: f64, solver: &str| {
        format!(
            "PlaneStrain(
            mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 4, cells: 4)]), basis: Smpm,
            materials: {{ \"m\": Hencky(young: {young:e}, poisson: 0.3) }},
            bodies: [(name: \"b\", material: \"m\", shape: Box(from: (0, 0), to: (2, 2)), points_per_cell: 2)],
            supports: [
                (name: \"base\", region: Plane(axis: Y, at: 0), fix: [X, Y]),
                (name: \"top\", region: Plane(axis: Y, at: 2), displace: [(axis: Y, by: -0.1)]),
            ],
            probes: [(name: \"all\", body: \"b\", points: All)], solver: {solver}, schedule: (steps: 2))"
        )
    };
    let outcome = |young, solver| {
        let (seen, error) = run(&scene(young, solver));
        assert!(error.is_none(), "E = {young:e}: {error:?}");
        (seen.last("reaction/top")[1] / young, seen.last("newton_iterations")[0], seen.last("residual")[0])
    };
    for solver in ["Direct", "Iterative"] {
        let (force, iterations, _) = outcome(1.0, solver);
        for young in [1e-300, 1e-250, 1e-155, 1e155, 1e250, 1e300] {
            let (other, needed, residual) = outcome(young, solver);
            assert!((other / force - 1.0).abs() < 1e-9, "E = {young:e}: {other} for {force}");
            assert_eq!(needed, iterations, "E = {young:e}");
            assert!(residual < 1e-9);
        }
    }
}

#[test]
fn a_load_on_a_stiff_body_does_not_loosen_the_balance_of_another() {
    let text = |load: f64| {
        format!(
            "PlaneStrain(
            mesh: Box(axes: [Uniform(from: 0, to: 8, cells: 8), Uniform(from: 0, to: 4, cells: 4)]), basis: Gimp,
            materials: {{ \"soft\": Hencky(young: 100, poisson: 0.3), \"stiff\": Hencky(young: 1e14, poisson: 0.3) }},
            bodies: [
                (name: \"a\", material: \"stiff\", shape: Box(from: (0, 0), to: (2, 2)), points_per_cell: 2),
                (name: \"b\", material: \"soft\", shape: Box(from: (6, 0), to: (8, 2)), points_per_cell: 2),
            ],
            supports: [(name: \"base\", region: Plane(axis: Y, at: 0), fix: [X, Y])],
            loads: [
                Traction(body: \"a\", axis: Y, at: 2, resultant: (0, {load:e})),
                Traction(body: \"b\", axis: Y, at: 2, resultant: (0, -20)),
            ],
            probes: [(name: \"soft\", body: \"b\", points: All)],
            schedule: (steps: 2))"
        )
    };
    let moved = |load| {
        let (seen, error) = run(&text(load));
        assert!(error.is_none(), "{error:?}");
        seen.last("probe/soft/displacement")[1]
    };
    let alone = moved(-1e-6);
    assert!(alone < -0.05);
    for load in [-1e3, -1e12] {
        assert!((moved(load) / alone - 1.0).abs() < 1e-8, "{} beside a load of {load:e}, {alone}", moved(load));
    }
}

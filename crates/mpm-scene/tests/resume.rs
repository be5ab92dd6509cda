//! A run that goes on from a state ends as the run that was never interrupted, bit for bit.

#[path = "resume/seen.rs"]
mod seen;

use mpm_scene::{AddedStages, Scene};
use mpm_solver::{Error, State, StateError};
use seen::{Seen, compiled, goes_on_bit_for_bit, shipped};

/// A plastic block under its weight, a traction and a point force, pushed across the cells of its grid.
const PLANE: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 8, cells: 8), Uniform(from: 0, to: 5, cells: 5)]),
    basis: BASIS,
    materials: {
        "clay": VonMises(young: 1e3, poisson: 0.3, yield_radius: 4, density: 2),
        "rubber": Hencky(young: 1e3, poisson: 0.2, density: 1),
    },
    bodies: [
        (name: "block", material: "clay", shape: Box(from: (0, 0), to: (3, 3)), points_per_cell: 2),
        (name: "cap", material: "rubber", shape: Box(from: (0, 3), to: (3, 4)), points_per_cell: 2),
    ],
    supports: [
        (name: "base", region: Plane(axis: Y, at: 0), fix: [Y], displace: [(axis: X, by: 2.2)]),
    ],
    loads: [
        BodyForce(acceleration: (0, -1)),
        Traction(body: "cap", axis: Y, at: 4, resultant: (0, -3)),
        PointForce(body: "cap", near: (3, 4), points: 3, force: (0.3, 0)),
    ],
    schedule: (steps: 9),
    output: (fields: [CauchyStress, Displacement]),
)"#;

const SOLID: &str = r#"Solid(
    mesh: Box(axes: [Uniform(from: 0, to: 3, cells: 3), Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 3, cells: 3)]),
    basis: BASIS,
    materials: { "clay": VonMises(young: 1e3, poisson: 0.3, yield_radius: 4, density: 2) },
    bodies: [(name: "block", material: "clay", shape: Box(from: (0, 0, 0), to: (2, 1, 2)), points_per_cell: 2)],
    supports: [(name: "base", region: Plane(axis: Z, at: 0), fix: [X, Y, Z])],
    loads: [BodyForce(acceleration: (0.4, 0, -1))],
    schedule: (steps: 4),
    output: (fields: [CauchyStress, Displacement]),
)"#;

const RINGS: &str = r#"Axisymmetric(
    mesh: Box(axes: [Uniform(from: 0, to: 4, cells: 4), Uniform(from: 0, to: 4, cells: 4)]),
    basis: BASIS, stabilisation: Ghost(), schedule: (steps: 5), output: (fields: [CauchyStress, Displacement]),
    materials: { "clay": VonMises(young: 1e3, poisson: 0.45, yield_radius: 4, density: 2) },
    bodies: [(name: "block", material: "clay", shape: Box(from: (0, 0), to: (3, 3)), points_per_cell: 2, mean_dilatation: Points)],
    supports: [(name: "base", region: Plane(axis: Z, at: 0), fix: [Z])],
    loads: [BodyForce(acceleration: (0, -1)), Traction(body: "block", axis: Z, at: 3, value: (0, -0.5))],
    tools: [(name: "punch", parts: [Disc(centre: (0, 4), radius: 1.1)], interface: (friction: 0.2), motion: Move(by: (0, -0.4)))],
)"#;

/// A block that turns under a disc that turns and sinks.
const TWIST: &str = r#"Axisymmetric(twist: true,
    mesh: Box(axes: [Uniform(from: 0, to: 4, cells: 4), Uniform(from: 0, to: 4, cells: 4)]),
    basis: BASIS, stabilisation: Ghost(), schedule: (steps: 5), output: (fields: [CauchyStress, Displacement, Angle]),
    materials: { "clay": VonMises(young: 1e3, poisson: 0.45, yield_radius: 4, density: 2) },
    bodies: [(name: "block", material: "clay", shape: Box(from: (0, 0), to: (3, 3)), points_per_cell: 2, mean_dilatation: Points)],
    supports: [(name: "base", region: Plane(axis: Z, at: 0), fix: [Z, Theta])],
    loads: [BodyForce(acceleration: (0, -1)), Traction(body: "block", axis: R, at: 3, moment: 3)],
    tools: [(name: "punch", parts: [Disc(centre: (0, 4), radius: 1.1)], interface: (friction: 0.2, adhesion: 0.5),
        motion: Move(by: (0, -0.4), turn: (angle: 5)))],
)"#;

#[test]
fn under_every_basis() {
    for basis in [
        "Smpm",
        "Gimp",
        "Cpdi1",
        "Cpdi2q",
        "Cpdi2t",
        "Cpdi2q, domains: (fallback_beyond: 0.0001)",
        "Cpdi1, domains: (control: Cap(cells: 0.6))",
    ] {
        goes_on_bit_for_bit(basis, &PLANE.replace("BASIS", basis));
    }
    for basis in ["Smpm", "Gimp", "Cpdi1", "Cpdi2q", "Cpdi2t"] {
        goes_on_bit_for_bit(basis, &RINGS.replace("BASIS", basis));
        goes_on_bit_for_bit(&format!("twist, {basis}"), &TWIST.replace("BASIS", basis));
    }
    for basis in ["Smpm", "Gimp", "Cpdi1", "Cpdi2Hexahedron", "Cpdi2Tetrahedron"] {
        goes_on_bit_for_bit(basis, &SOLID.replace("BASIS", basis));
    }
    let splines =
        PLANE.replace("cells: 5)])", "cells: 5)], functions: Splines(degree: 2)), stabilisation: Ghost()");
    for basis in ["Smpm", "Cpdi1", "Cpdi2q"] {
        goes_on_bit_for_bit(&format!("{basis} on splines"), &splines.replace("BASIS", basis));
    }
    for gradient in ["modulus: 200, length: 0.8", "driver: Strain, modulus: 200, length: 0.8"] {
        let law = format!("yield_radius: 4, gradient: ({gradient}), density");
        goes_on_bit_for_bit(
            gradient,
            &PLANE.replace("BASIS", "Cpdi1").replace("yield_radius: 4, density", &law),
        );
        goes_on_bit_for_bit(
            &format!("{gradient} by iteration"),
            &PLANE.replace("BASIS", "Cpdi1, solver: Iterative").replace("yield_radius: 4, density", &law),
        );
    }
    let gently = SOLID.replace("(0.4, 0, -1)", "(0.1, 0, -0.3)");
    goes_on_bit_for_bit("multigrid", &SOLID.replace("BASIS", "Cpdi1, solver: Iterative"));
    let basis = "Cpdi2Hexahedron, domains: (fallback_beyond: 0.001)";
    goes_on_bit_for_bit(basis, &gently.replace("BASIS", basis));
}

#[test]
fn while_steps_are_halved_and_grow_again() {
    let text = r#"PlaneStrain(
        mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 1, cells: 1)]),
        basis: Smpm,
        materials: {"rubber": Hencky(young: 1e3, poisson: 0.3)},
        bodies: [(name: "slab", material: "rubber", shape: Box(from: (0, 0), to: (2, 1)), points_per_cell: 2)],
        supports: [
            (name: "sides", region: Everywhere, fix: [X]),
            (name: "base", region: Plane(axis: Y, at: 0), fix: [Y]),
            (name: "top", region: Plane(axis: Y, at: 1), displace: [(axis: Y, by: -2.7, ramp: [(0, 0), (0.75, 0.1111111111111111), (1, 1)])]),
        ],
        schedule: (steps: 4, cuts: 10),
    )"#;
    let seen = goes_on_bit_for_bit("cuts", text);
    assert!(seen.rows.len() > 5, "{} rows", seen.rows.len());
}

#[test]
fn where_domains_are_split_and_loads_with_them() {
    let text = PLANE.replace("BASIS", "Cpdi1, domains: (control: Split(cells: 0.55, growth: 9))");
    let seen = goes_on_bit_for_bit("split", &text);
    assert!(seen.rows[9].len() > seen.rows[1].len(), "points are split");
}

/// A block on which a disc rolls and slides, and a weight that sinks and tilts.
const TOOLS: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 3, cells: 6), Uniform(from: 0, to: 3, cells: 6)]),
    basis: Cpdi1 DOMAINS, stabilisation: Ghost(),
    materials: { "clay": VonMises(young: 1e3, poisson: 0.3, yield_radius: 20, density: 1) },
    bodies: [(name: "block", material: "clay", shape: Box(from: (0, 0), to: (3, 1.6)), points_per_cell: 2)],
    supports: [
        (name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y]),
        (name: "left", region: Plane(axis: X, at: 0), fix: [X]), (name: "right", region: Plane(axis: X, at: 3), fix: [X]),
    ],
    tools: [
        (name: "wheel", parts: [Disc(centre: (1, 2.2), radius: 0.6)],
            motion: Move(by: (0, -0.08), ramp: [(0, 0), (0.5, 1)], then: [(by: (0.015, 0), ramp: [(0.5, 0), (1, 1)])],
                turn: (centre: (1, 2.2), angle: -20)),
            interface: (friction: 0.3, adhesion: 1), moment_about: (1, 2.2)),
        (name: "weight", parts: [Polygon(vertices: [(2.2, 1.6), (3, 1.6), (3, 2.2), (2.2, 2.2)])], moment_about: (2.5, 1.6),
            motion: Loaded(free: [Y, Turn], force: (0, -20)), interface: (friction: 0.2, augment: 1)),
    ],
    schedule: (steps: 8),
    output: (energies: true),
)"#;

#[test]
fn while_tools_press_slide_and_sink() {
    goes_on_bit_for_bit("tools", &TOOLS.replace("DOMAINS", ""));
    let split = TOOLS.replace("DOMAINS", ", domains: (control: Split(cells: 0.51, growth: 9))");
    let seen = goes_on_bit_for_bit("tools, split", &split);
    assert!(seen.rows.last().map(Vec::len) > seen.rows.get(1).map(Vec::len), "points are split");
}

/// A turned block between a wall that moves and on which it slides, and a frame with a load, under a pressure and a traction.
const WALLS: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: -3, to: 5, cells: 13), Uniform(from: -3, to: 5, cells: 13)] FUNCTIONS),
    basis: BASIS, stabilisation: Ghost(),
    materials: { "clay": VonMises(young: 1e3, poisson: 0.3, yield_radius: 20) },
    bodies: [(name: "block", material: "clay", shape: Box(from: (1, 0), to: (3, 2), turned: 30), points_per_cell: 2, tiling: Shape)],
    walls: [
        (name: "left", body: "block", side: "left", surface: Plane(through: (1, 0), normal: (0.8660254037844387, 0.5)), EXACT,
            motion: Move(by: (0.017, 0.01))),
        (name: "right", body: "block", side: "right", hold: All, moment_about: (2, 1), motion: Loaded(free: [X, Turn], force: (9, 0), moment: 2)),
    ],
    loads: [Pressure(body: "block", side: "top", value: 8), Traction(body: "block", side: "top", value: (1, -1))],
    schedule: (steps: 6), output: (energies: true),
)"#;

#[test]
fn while_walls_hold() {
    for (basis, functions, exact) in [
        ("Cpdi2q", ", functions: Splines(degree: 2)", "exact: true"),
        ("Cpdi1", "", "exact: false"),
        ("Gimp", "", "stiffness: 50"),
        ("Smpm", "", "exact: false"),
    ] {
        let text = WALLS.replace("BASIS", basis).replace("FUNCTIONS", functions).replace("EXACT", exact);
        goes_on_bit_for_bit(&format!("walls, {basis}"), &text);
    }
}

/// Sand that yields: tangents that are not symmetric, in every load step.
#[test]
fn while_gmres_solves() {
    let sand = "MohrCoulomb(young: 1e3, poisson: 0.3, cohesion: 1, friction: 30, dilation: 5, density: 2)";
    let text = SOLID
        .replace("VonMises(young: 1e3, poisson: 0.3, yield_radius: 4, density: 2)", sand)
        .replace("schedule: (steps: 4)", "solver: Iterative,\n    schedule: (steps: 5)");
    for basis in ["Smpm", "Gimp", "Cpdi1"] {
        let seen = goes_on_bit_for_bit(basis, &text.replace("BASIS", basis));
        assert_eq!(seen.methods, [5; 5], "{basis}: all by GMRES");
    }
}

#[test]
fn on_a_moving_mesh_with_a_vortex() {
    goes_on_bit_for_bit("stretch", &shipped("simple_stretch", &[]));
    goes_on_bit_for_bit("twist", &shipped("doughnut", &[("inner: 90", "inner: 8"), ("steps: 90", "steps: 8")]));
    goes_on_bit_for_bit("vortex", &shipped("vortex", &[("cells: 24", "cells: 12"), ("steps: 20", "steps: 5")]));
}

#[test]
fn where_sand_has_come_apart() {
    goes_on_bit_for_bit("apex", &shipped("laws/apex", &[]));
    let layered = [("friction: 30", "friction: Layers([(top: 1, value: 30), (top: 0.5, value: 35)])")];
    goes_on_bit_for_bit("apex with fields", &shipped("laws/apex", &layered));
}

#[test]
fn along_the_path() {
    goes_on_bit_for_bit("arch", &shipped("path_arch", &[("force: (0, -250)", "force: (0, -60)")]));
    let turn = [("inner: 90", "inner: 31"), ("first: 0.011111", "first: 0.03226")];
    goes_on_bit_for_bit("dissipation", &shipped("path_doughnut", &turn));
}

/// A block under its weight that is pushed by a mesh that moves in two stages, then pulled, while a prop ends and a load
/// comes and goes.
const STAGED: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 4, cells: 4), Uniform(from: 0, to: 4, cells: 4)]),
    motion: Stretch([(axis: Y, anchor: 0, driven: 3, displacement: -0.4,
        ramp: {"press": [(1, 0.5)], "press more": [(1, 1)], "pull": [(0.5, 0.9), (1, 0.4)]})]),
    basis: Cpdi1,
    materials: { "clay": VonMises(young: 1e3, poisson: 0.3, yield_radius: 40, density: 2) },
    bodies: [(name: "block", material: "clay", shape: Box(from: (0, 0), to: (2, 3)), points_per_cell: 2)],
    supports: [
        (name: "base", region: Plane(axis: Y, at: 0), fix: [Y]),
        (name: "prop", region: Plane(axis: X, at: 2), fix: [X], active: (until: "press more")),
        (name: "top", region: Plane(axis: Y, at: 3), follow_mesh: [Y], active: (from: "press")),
        (name: "wall", region: Plane(axis: X, at: 0), fix: [X], active: (until: "press more")),
        (name: "side", region: Plane(axis: X, at: 0), displace: [(axis: X, by: 0.05)], active: (from: "press more")),
        (name: "again", region: Plane(axis: X, at: 2), fix: [X],
            active: (from: "press more", until: "pull", release: AtOnce)),
    ],
    loads: [
        BodyForce(acceleration: (0, -1)),
        PointForce(body: "block", near: (2, 2), points: 2, force: (0.3, 0), active: (from: "press", until: "pull")),
    ],
    probes: [(name: "middle", body: "block", points: Near(1, 1.5))],
    schedule: (stages: [
        (name: "weight", steps: 2),
        (name: "press", steps: 2, reset_displacements: true),
        (name: "press more", steps: 3, predictor: Rest),
        (name: "pull", steps: 3, reset_displacements: true),
    ]),
    output: (fields: [CauchyStress, Displacement], energies: true),
)"#;

#[test]
fn in_the_middle_of_stages_and_between_them() {
    let seen = goes_on_bit_for_bit("stages", STAGED);
    let ends: Vec<usize> = seen.at_stage_ends.iter().map(|it| it.0).collect();
    assert_eq!(ends, [2, 4, 7, 11]);
}

/// The scene with its first stages only, without what comes with the others.
fn first_stages() -> String {
    let mut text = STAGED.to_string();
    for (from, to) in [
        (r#", "press more": [(1, 1)], "pull": [(0.5, 0.9), (1, 0.4)]"#, ""),
        (r#", active: (until: "press more")"#, ""),
        (r#"from: "press", until: "pull""#, r#"from: "press""#),
        (
            r#"        (name: "press more", steps: 3, predictor: Rest),
        (name: "pull", steps: 3, reset_displacements: true),
"#,
            "",
        ),
        (
            r#"        (name: "side", region: Plane(axis: X, at: 0), displace: [(axis: X, by: 0.05)], active: (from: "press more")),
        (name: "again", region: Plane(axis: X, at: 2), fix: [X],
            active: (from: "press more", until: "pull", release: AtOnce)),
"#,
            "",
        ),
    ] {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    text
}

#[test]
fn stages_that_are_added_go_on_as_if_they_had_always_been_there() {
    let [before, after] = [first_stages(), STAGED.to_string()].map(|text| Scene::from_ron(&text).unwrap());
    let added = AddedStages::between(&before, &after).unwrap();
    assert_eq!(added.names, ["press more", "pull"]);
    let (mut whole, mut first) = (Seen::default(), Seen::default());
    compiled(STAGED).run(&mut whole).unwrap();
    compiled(&first_stages()).run(&mut first).unwrap();
    let (step, state) = first.at_stage_ends.pop().unwrap();
    assert_eq!(step, 4);
    let state = added.extend(state, &compiled(&first_stages()), &compiled(STAGED)).unwrap();
    let mut rest = Seen::default();
    compiled(STAGED).resume(&state, &mut rest).unwrap();
    assert_eq!(rest.rows.len(), whole.rows.len() - 5);
    for (k, row) in rest.rows.iter().enumerate() {
        assert!(row == &whole.rows[5 + k], "load step {} differs", 5 + k);
    }
    // A state in the middle of the first stages will do, too.
    let state = added.extend(first.states[2].clone(), &compiled(&first_stages()), &compiled(STAGED)).unwrap();
    let mut rest = Seen::default();
    compiled(STAGED).resume(&state, &mut rest).unwrap();
    assert!(rest.rows[..] == whole.rows[4..]);
}

#[test]
fn what_is_changed_besides_stages_is_refused_with_its_place() {
    let before = Scene::from_ron(&first_stages()).unwrap();
    let cases = [
        (r#"(name: "weight", steps: 2)"#, r#"(name: "weight", steps: 3)"#, "schedule.stages[0]"),
        ("young: 1e3", "young: 2e3", "materials"),
        ("acceleration: (0, -1)", "acceleration: (0, -2)", "loads[0]"),
        (r#"at: 0), fix: [Y]"#, r#"at: 0), fix: [X, Y]"#, "supports[0]"),
        (
            r#"fix: [X], active: (until: "press more")),
        (name: "top""#,
            r#"fix: [X], active: (until: "press")),
        (name: "top""#,
            "supports[1]",
        ),
        (r#""press": [(1, 0.5)]"#, r#""press": [(1, 0.6)]"#, "motion"),
        (r#"basis: Cpdi1"#, r#"basis: Cpdi1, unheld_motion: Zero"#, "unheld_motion"),
        (r#"points: Near(1, 1.5)"#, r#"points: All"#, "probes"),
    ];
    for (from, to, path) in cases {
        assert!(STAGED.contains(from), "{from}");
        let after = Scene::from_ron(&STAGED.replace(from, to)).unwrap();
        let error = AddedStages::between(&before, &after).unwrap_err();
        assert_eq!(error.path, path, "{error}");
        assert!(error.reason.contains("differs from that of the checkpoint"), "{error}");
    }
    let plain = Scene::from_ron(&PLANE.replace("BASIS", "Gimp")).unwrap();
    let error = AddedStages::between(&plain, &before).unwrap_err();
    assert!(error.reason.contains("has no `stages`"), "{error}");
    // A title may change, and when checkpoints are kept.
    let titled = STAGED.replace("PlaneStrain(", "PlaneStrain(title: \"another\",");
    let titled = titled.replace("energies: true", "energies: true, checkpoint: (every: 1)");
    assert!(AddedStages::between(&before, &Scene::from_ron(&titled).unwrap()).is_ok());
}

/// The state after the fourth step, changed, and what is said of it.
fn refused(change: impl FnOnce(&mut State)) -> StateError {
    let text = PLANE.replace("BASIS", "Gimp");
    let mut seen = Seen::default();
    compiled(&text).run(&mut seen).unwrap();
    let mut state = seen.states[3].clone();
    change(&mut state);
    match compiled(&text).resume(&state, &mut Seen::default()) {
        Err(Error::State(error)) => error,
        other => panic!("{other:?}"),
    }
}

#[test]
fn states_of_other_scenes_are_refused_by_name() {
    type Change = fn(&mut State);
    let cases: &[(Change, &str, &str)] = &[
        (|state| state.bodies.truncate(1), "bodies", "there are 1, expected 2"),
        (|state| state.bodies[1].points = 7, "bodies/1", "has 7 points, expected 12 to 12"),
        (|state| state.bodies[0].columns[0].values[3] = f64::NAN, "bodies/0/position", "is NaN at point 1"),
        (|state| state.bodies[0].columns[0].width = 3, "bodies/0/position", "expected 2 numbers per point"),
        (|state| state.bodies[0].columns[3].values.truncate(35), "bodies/0/mass", "holds 35 numbers"),
        (|state| state.bodies[0].columns[2].values[2] = -1.0, "bodies/0/reference_volume", "is -1 at point 2"),
        (|state| state.shares[1].clear(), "loads/1/point", "expected points that ascend below 12"),
        (|state| state.shares[0][0].part = 2.0, "loads/0/share", "is 2, expected 0 to 1"),
        (|state| state.linear_solver.as_mut().unwrap().numbers[0] = 1, "linear_solver", "is no order"),
        (|state| state.bodies[0].columns[0].values[1] = 77.0, "bodies", "outside"),
    ];
    for (change, item, reason) in cases {
        let error = refused(change);
        assert!(error.item.starts_with(item) && error.reason.contains(reason), "{item}: {error}");
    }
    let error = refused(|state| {
        let text = ron::to_string(&state.progress).unwrap().replace("last:Some(0.1", "last:Some(-0.1");
        state.progress = ron::from_str(&text).unwrap();
    });
    assert!(error.reason.contains("a last step over -0.1"), "{error}");
    let error = refused(|state| state.predictor.increment[0] = f64::NAN);
    assert!(error.reason.contains("a last step that is not finite"), "{error}");
    let path = shipped("path_arch", &[("steps: 100", "steps: 3")]);
    let mut seen = Seen::default();
    assert!(matches!(compiled(&path).run(&mut seen), Err(Error::StepLimit { steps: 3, .. })));
    let arch = seen.at_end.expect("kept at the limit");
    let error = compiled(&PLANE.replace("BASIS", "Gimp")).resume(&arch, &mut Seen::default());
    assert!(matches!(error, Err(Error::State(_))), "{error:?}");
}

//! Scenes of bodies of revolution that turn about their axis: closed forms, names, tools, and what such scenes cannot have.

use mpm_scene::{Compiled, Scene, compile};
use mpm_solver::observe::{Column, Entry, Field, LoadStep, Observer, ObserverError, RunStart, Space};
use std::f64::consts::PI;

/// Rows of a run, and the points at its end.
#[derive(Default)]
struct Watched {
    columns: Vec<Column>,
    rows: Vec<Vec<Vec<f64>>>,
    iterations: usize,
    positions: Vec<f64>,
    displacement: Vec<f64>,
    angle: Vec<f64>,
    stress: Vec<f64>,
}

impl Observer for Watched {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        assert_eq!(run.space, Space::Axisymmetric);
        self.columns.clone_from(&run.columns);
        Ok(())
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        let numbers = |entry: &Entry| match entry {
            Entry::Count(values) => values.iter().map(|it| *it as f64).collect(),
            Entry::Real(values) => values.clone(),
        };
        self.rows.push(step.row.iter().map(numbers).collect());
        self.iterations = self.iterations.max(step.residuals.len());
        self.positions = step.fields.positions();
        self.displacement = step.fields.field(Field::DISPLACEMENT);
        self.angle = step.fields.field(Field::ANGLE);
        self.stress = step.fields.field(Field::CAUCHY_STRESS);
        Ok(())
    }
}

impl Watched {
    /// A column in the last row.
    fn last(&self, name: &str) -> &[f64] {
        let place = self.columns.iter().position(|it| it.name == name);
        &self.rows.last().unwrap()[place.unwrap_or_else(|| panic!("no column {name}"))]
    }

    fn unit(&self, name: &str) -> &'static str {
        self.columns.iter().find(|it| it.name == name).unwrap().unit(Space::Axisymmetric)
    }
}

fn watch(text: &str) -> Watched {
    let mut watched = Watched::default();
    let mut compiled =
        compile(&Scene::from_ron(text).unwrap()).unwrap_or_else(|error| panic!("{error}: {text}"));
    assert!(matches!(&compiled, Compiled::Solid(model) if model.turns()));
    compiled.run(&mut watched).unwrap_or_else(|error| panic!("{error}: {text}"));
    watched
}

const BASES: [&str; 5] = ["Smpm", "Gimp", "Cpdi1", "Cpdi2q", "Cpdi2t"];

/// A cylinder whose top is turned.
const CYLINDER: &str = r#"Axisymmetric(
    twist: true,
    mesh: Box(axes: [Uniform(from: 0, to: 1, cells: 8), Uniform(from: 0, to: 1, cells: 8)]),
    basis: BASIS,
    materials: { "m": Hencky(young: 1000, poisson: 0.3) },
    bodies: [(name: "cylinder", material: "m", shape: Box(from: (0, 0), to: (1, 1)), points_per_cell: 2)],
    supports: [
        (name: "all", region: Everywhere, fix: [R]),
        (name: "base", region: Plane(axis: Z, at: 0), fix: [Z, Theta]),
        (name: "top", region: Plane(axis: Z, at: 1), fix: [Z], displace: [(axis: Theta, by: 22.918311805232928)]),
    ],
    probes: [(name: "rim", body: "cylinder", points: Near(1, 1))],
    schedule: (steps: STEPS),
    output: (energies: true),
)"#;

#[test]
fn the_torque_of_a_cylinder_is_that_of_the_table() {
    for basis in BASES {
        for steps in ["1", "3"] {
            let watched = watch(&CYLINDER.replace("BASIS", basis).replace("STEPS", steps));
            let (torque, axial) = (watched.last("reaction_moment/top")[0], watched.last("reaction/top")[1]);
            // Points of triangles are others.
            let within = if basis == "Cpdi2t" { 2e-3 } else { 1e-10 };
            assert!((torque / 237.013197712514 - 1.0).abs() < within, "{basis}: {torque}");
            assert!((axial / -47.4026395425027 - 1.0).abs() < within, "{basis}: {axial}");
            assert!((watched.last("angle/top")[0] - 0.4_f64.to_degrees()).abs() < 1e-12);
            assert!((watched.last("reaction_moment/base")[0] + torque).abs() < 1e-9 * torque);
            assert!(watched.last("reaction_moment/total")[0].abs() < 1e-9 * torque);
            assert!(watched.iterations <= 3, "{} iterations", watched.iterations);
            assert_eq!((watched.last("reaction/top").len(), watched.last("displacement/top").len()), (2, 2));
            // Points turn and stay where they are; their angle is linear in z.
            for ((x, u), angle) in
                watched.positions.chunks(3).zip(watched.displacement.chunks(3)).zip(&watched.angle)
            {
                assert!(x[2] == 0.0 && u.iter().all(|u| u.abs() < 1e-12));
                assert!((angle - 0.4 * x[1]).abs() < 1e-12);
            }
            let angle = watched.last("probe/rim/angle")[0];
            assert!(
                (angle - 0.4_f64.to_degrees() * watched.last("probe/rim/position")[1]).abs() < 1e-10
                    && watched.last("probe/rim/position").len() == 2
            );
            // Shear between z and the hoop.
            assert!(watched.stress.chunks(9).all(|stress| stress[5] > 0.0 && stress[5] == stress[7]));
            let energy = watched.last("energy/unbalanced")[0] / watched.last("energy/elastic")[0];
            assert!(steps != "1" || energy.abs() < 0.02, "{energy}");
        }
    }
    let watched = watch(&CYLINDER.replace("BASIS", "Smpm").replace("STEPS", "1"));
    let units =
        ["reaction_moment/top", "angle/top", "probe/rim/angle", "reaction/top"].map(|it| watched.unit(it));
    assert_eq!(units, ["F L", "°", "°", "F"]);
}

/// A torque on the end of a free cylinder, and on its side.
#[test]
fn a_cylinder_under_a_torque_turns_as_its_closed_form_says() {
    for basis in &BASES[1..] {
        let scene = |load: &str| {
            format!(
                r#"Axisymmetric(
                    twist: true,
                    mesh: Box(axes: [Uniform(from: 0, to: 1.25, cells: 10), Uniform(from: 0, to: 2.25, cells: 18)]),
                    basis: {basis},
                    materials: {{ "m": Hencky(young: 1000, poisson: 0.25) }},
                    bodies: [(name: "c", material: "m", shape: Box(from: (0, 0), to: (1, 2)), points_per_cell: 2)],
                    supports: [(name: "base", region: Plane(axis: Z, at: 0), fix: [Z, Theta])],
                    loads: [{load}],
                    probes: [(name: "end", body: "c", points: Within(from: (0, 1.875), to: (1, 2)))],
                    schedule: (steps: 1),
                )"#
            )
        };
        // T = G J φ/z with G = 400 and J = π/2.
        let stiffness = 400.0 * PI / 2.0;
        let ended = watch(&scene(r#"Traction(body: "c", axis: Z, at: 2, moment: 0.1)"#));
        let angle = 0.1 / stiffness * 1.9375;
        let error = ended.last("probe/end/angle")[0].to_radians() / angle - 1.0;
        assert!(error.abs() < 4e-3, "{basis}: {error}");
        assert!((ended.last("reaction_moment/base")[0] + 0.1).abs() < 1e-12);
        assert!(ended.last("reaction/base")[1].abs() < 1e-3 * 0.1);
        // Along the side the torque grows from the end: half of the angle at the end.
        let side = watch(&scene(r#"Traction(body: "c", axis: R, at: 1, moment: 0.1)"#));
        assert!((side.last("reaction_moment/base")[0] + 0.1).abs() < 1e-12);
        let error = side.last("probe/end/angle")[0].to_radians() / (0.1 / stiffness) - 1.0;
        assert!(error.abs() < 0.03, "{basis}: {error}");
    }
}

/// A plate that turns on a cylinder, and sticks.
const PLATE: &str = r#"Axisymmetric(
    twist: true,
    mesh: Box(axes: [Uniform(from: 0, to: 1.5, cells: 12), Uniform(from: 0, to: 1.25, cells: 10)]),
    basis: Cpdi1, stabilisation: Ghost(),
    materials: { "m": MATERIAL },
    bodies: [(name: "c", material: "m", shape: Box(from: (0, 0), to: (1, 1)), points_per_cell: 2)],
    supports: [(name: "base", region: Plane(axis: Z, at: 0), fix: [Z, Theta])],
    tools: [(name: "plate", parts: [Plane(through: (0, 1), normal: (0, -1))], interface: INTERFACE, motion: MOTION)],
    schedule: (steps: STEPS),
    output: (energies: true),
)"#;

fn plate(material: &str, interface: &str, motion: &str, steps: u32) -> Watched {
    let text = PLATE.replace("MATERIAL", material).replace("INTERFACE", interface).replace("MOTION", motion);
    watch(&text.replace("STEPS", &steps.to_string()))
}

#[test]
fn a_plate_that_turns_slips_at_its_limit_torque() {
    let elastic = "Hencky(young: 1000, poisson: 0.3)";
    // By adhesion, 2π a R³/3.
    let turned = plate(elastic, "(adhesion: 2)", "Move(turn: (angle: 4))", 8);
    let limit = 2.0 * PI * 2.0 / 3.0;
    let torque = turned.last("tool/plate/moment")[0];
    assert!((torque / -limit - 1.0).abs() < 2e-2, "{torque} {limit}");
    assert!((turned.last("reaction_moment/base")[0] + limit).abs() < 2e-2 * limit);
    assert!((turned.last("reaction_moment/base")[0] - torque).abs() < 1e-6 * limit);
    assert!((turned.last("tool/plate/angle")[0] - 4.0).abs() < 1e-12);
    assert_eq!(turned.last("tool/plate/force").len(), 2);
    // By friction under pressure, about μ P R 2/3; smooth plates turn nothing.
    let pressed = "Move(by: (0, -0.01), ramp: [(0, 0), (0.25, 1), (1, 1)], turn: (angle: 8, ramp: [(0, 0), (0.25, 0), (1, 1)]))";
    let rubbed = plate(elastic, "(friction: 0.1)", pressed, 16);
    let (torque, force) = (rubbed.last("tool/plate/moment")[0], rubbed.last("tool/plate/force")[1]);
    assert!((torque / (-0.1 * force * 2.0 / 3.0) - 1.0).abs() < 3e-2, "{torque} {force}");
    let smooth = plate(elastic, "()", pressed, 8);
    assert!(smooth.last("tool/plate/moment")[0].abs() < 1e-9);
    assert!(smooth.angle.iter().all(|angle| angle.abs() < 1e-9));
    // What the plate works is stored or dissipated.
    let elastic_energy = rubbed.last("energy/elastic")[0] + rubbed.last("energy/dissipated")[0];
    let work = rubbed.last("energy/external_work")[0];
    assert!((elastic_energy / work - 1.0).abs() < 0.05, "{elastic_energy} {work}");
}

#[test]
fn a_plate_under_a_torque_turns_until_it_is_balanced() {
    let elastic = "Hencky(young: 1000, poisson: 0.25)";
    let motion = "Loaded(free: [Z, Turn], force: (0, -30), moment: 0.5)";
    let loaded = plate(elastic, "(friction: 0.8, stiffness: 400)", motion, 2);
    assert!((loaded.last("tool/plate/moment")[0] + 0.5).abs() < 1e-6, "{:?}", loaded.last("tool/plate/moment"));
    assert!((loaded.last("tool/plate/force")[1] - 30.0).abs() < 1e-6);
    assert!((loaded.last("reaction_moment/base")[0] + 0.5).abs() < 1e-6);
    // T = G J φ/z.
    let angle = loaded.last("tool/plate/angle")[0].to_radians() / (0.5 / (400.0 * PI / 2.0));
    assert!((angle - 1.0).abs() < 0.1, "{angle}");
}

const SCENE: &str = r#"Axisymmetric(
    twist: true,
    mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 4), Uniform(from: 0, to: 2, cells: 4)]),
    motion: Fixed,
    basis: Cpdi2q,
    materials: { "m": Hencky(young: 1000, poisson: 0.3, density: 1) },
    bodies: [(name: "b", material: "m", shape: Box(from: (0, 0), to: (1, 1)), points_per_cell: 2)],
    supports: [(name: "base", region: Plane(axis: Z, at: 0), fix: [Z, Theta])],
    loads: [Traction(body: "b", axis: Z, at: 1, moment: 1)],
    tools: [(name: "t", parts: [Plane(through: (0, 1.5), normal: (0, -1))], motion: Move(turn: (angle: 3)))],
    schedule: (steps: 1),
)"#;

/// What replaces what, where the refusal points, and what it says.
const REFUSED: &[(&str, &str, &str, &str)] = &[
    ("twist: true", "twist: false", "supports[0].fix[1]", "which bodies turn by with `twist: true` only"),
    (
        "fix: [Z, Theta]",
        "fix: [Z], follow_mesh: [Theta]",
        "supports[0].follow_mesh[0]",
        "no direction in the half plane",
    ),
    (
        "Plane(axis: Z, at: 0)",
        "Plane(axis: Theta, at: 0)",
        "supports[0].region.axis",
        "no direction in the half plane",
    ),
    (
        "fix: [Z, Theta]",
        "fix: [Z, Theta], displace: [(axis: Theta, by: 3)]",
        "supports[0]",
        "component Theta is prescribed twice",
    ),
    (
        "(angle: 3)",
        "(angle: 3, centre: (1, 0))",
        "tools[0].motion.turn",
        "is a turn about Z through r = 1, expected one about Z through 0",
    ),
    (
        "points_per_cell: 2",
        "points_per_cell: 2, mean_dilatation: Cell",
        "bodies[0].mean_dilatation",
        "expected `Points`",
    ),
    (
        "Move(turn: (angle: 3))",
        "Screw(angle: 10, advance: -0.1)",
        "tools[0].motion",
        "expected `Move`, which can turn with `twist: true`",
    ),
];

#[test]
fn what_is_no_turn_about_the_axis_is_refused_with_its_place() {
    assert!(compile(&Scene::from_ron(SCENE).unwrap()).is_ok());
    let refused = |text: &str| compile(&Scene::from_ron(text).unwrap()).err().map(|it| (it.path, it.reason));
    for (what, by, path, reason) in REFUSED {
        assert!(SCENE.contains(what), "{what}");
        let found = refused(&SCENE.replace(what, by)).unwrap_or_else(|| panic!("{by} is accepted"));
        assert!(found.0 == *path && found.1.contains(reason), "{by}: {found:?}");
    }
    let plain = SCENE.replace("fix: [Z, Theta]", "fix: [Z]").replace("twist: true", "twist: false");
    let found = refused(&plain).unwrap();
    assert!(found.0 == "loads[0].moment" && found.1.contains("need `twist: true`"), "{found:?}");
    let found = refused(&plain.replace("moment: 1", "value: (0, 1)")).unwrap();
    assert!(found.0 == "tools[0].motion.turn" && found.1.contains("with `twist: true` only"), "{found:?}");
    let plane = r#"PlaneStrain(
        mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 4), Uniform(from: 0, to: 2, cells: 4)]),
        basis: Smpm, materials: { "m": Hencky(young: 1000, poisson: 0.3) }, TWIST
        bodies: [(name: "b", material: "m", shape: Box(from: (0, 0), to: (1, 1)), points_per_cell: 2)],
        supports: [(name: "base", region: Plane(axis: Y, at: 0), fix: [Y, Theta])],
        schedule: (steps: 1),
    )"#;
    let found = refused(&plane.replace("TWIST", "")).unwrap();
    assert!(
        found.0 == "supports[0]" && found.1.contains("Theta is a direction of `Axisymmetric`"),
        "{found:?}"
    );
    let found = refused(&plane.replace("TWIST", "twist: true,")).unwrap();
    assert!(found.0 == "twist" && found.1.contains("`Axisymmetric` scenes only"), "{found:?}");
}

#[test]
fn motions_that_nothing_holds_are_named() {
    let warned = |fix: &str| {
        let text = SCENE.replace("fix: [Z, Theta]", fix);
        let mut compiled = compile(&Scene::from_ron(&text).unwrap()).unwrap();
        compiled.estimate().unwrap().warnings.join("; ")
    };
    assert!(!warned("fix: [Z, Theta]").contains("nothing holds"), "{}", warned("fix: [Z, Theta]"));
    assert!(warned("fix: [Z]").contains("nothing holds body `b` about the axis"), "{}", warned("fix: [Z]"));
    assert!(warned("fix: [Theta]").contains("nothing holds body `b` along z"), "{}", warned("fix: [Theta]"));
}

/// The hoop of a ring that is held nowhere along r holds it.
#[test]
fn a_ring_is_held_along_r_by_its_hoop() {
    for twist in ["", "twist: true, "] {
        let text = format!(
            r#"Axisymmetric({twist}
                mesh: Box(axes: [Uniform(from: 0, to: 3, cells: 12), Uniform(from: 0, to: 1.25, cells: 5)]),
                basis: Cpdi1,
                materials: {{ "m": Hencky(young: 1000, poisson: 0.3) }},
                bodies: [(name: "ring", material: "m", shape: Box(from: (1, 0), to: (2, 1)), points_per_cell: 2)],
                supports: [(name: "base", region: Plane(axis: Z, at: 0), fix: [Z{}])],
                loads: [Traction(body: "ring", axis: R, at: 1, value: (10, 0))],
                schedule: (steps: 1),
            )"#,
            if twist.is_empty() { "" } else { ", Theta" }
        );
        let mut compiled = compile(&Scene::from_ron(&text).unwrap()).unwrap();
        let warnings = compiled.estimate().unwrap().warnings.join("; ");
        assert!(!warnings.contains("nothing holds"), "{warnings}");
        compiled.run(&mut ()).unwrap();
    }
}

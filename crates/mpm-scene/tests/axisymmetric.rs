//! Scenes of bodies of revolution: closed forms, tables, and what such scenes cannot have.

use mpm_scene::{Compiled, Scene, compile};
use mpm_solver::observe::{Entry, Field, LoadStep, Observer, ObserverError, RunStart};
use std::f64::consts::{PI, TAU};

/// Rows of a run, and the stresses at its end.
#[derive(Default)]
struct Watched {
    names: Vec<String>,
    rows: Vec<Vec<Vec<f64>>>,
    stress: Vec<f64>,
}

impl Observer for Watched {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        self.names = run.columns.iter().map(|it| it.name.clone()).collect();
        Ok(())
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        let numbers = |entry: &Entry| match entry {
            Entry::Count(values) => values.iter().map(|it| *it as f64).collect(),
            Entry::Real(values) => values.clone(),
        };
        self.rows.push(step.row.iter().map(numbers).collect());
        self.stress = step.fields.field(Field::CAUCHY_STRESS);
        Ok(())
    }
}

impl Watched {
    /// A component of a column in the last row.
    fn last(&self, name: &str, component: usize) -> f64 {
        let place = self.names.iter().position(|it| it == name).unwrap_or_else(|| panic!("no column {name}"));
        self.rows.last().unwrap()[place][component]
    }

    /// Least and largest of a component of Cauchy's stress.
    fn range(&self, component: usize) -> [f64; 2] {
        let values = self.stress.chunks_exact(9).map(|it| it[component]);
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
    }
}

fn watch(text: &str) -> Watched {
    let mut watched = Watched::default();
    let mut compiled =
        compile(&Scene::from_ron(text).unwrap()).unwrap_or_else(|error| panic!("{error}: {text}"));
    compiled.run(&mut watched).unwrap_or_else(|error| panic!("{error}: {text}"));
    watched
}

const BASES: [&str; 5] = ["Smpm", "Gimp", "Cpdi1", "Cpdi2q", "Cpdi2t"];

/// A cylinder whose side cuts cells, pressed together without friction.
const CYLINDER: &str = r#"Axisymmetric(
    mesh: Box(axes: [Uniform(from: 0, to: 1.5, cells: 6), Uniform(from: 0, to: 1, cells: 4)]),
    motion: Stretch([(axis: Z, anchor: 0, driven: 1, displacement: -0.2)]),
    basis: BASIS, stabilisation: Ghost(),
    materials: { "m": VonMises(young: 1000, poisson: 0.3, yield_radius: RADIUS) },
    bodies: [(name: "cylinder", material: "m", shape: Box(from: (0, 0), to: (0.9, 1)), points_per_cell: 2 MEAN)],
    supports: [
        (name: "base", region: Plane(axis: Z, at: 0), fix: [Z]),
        (name: "top", region: Plane(axis: Z, at: 1), follow_mesh: [Z]),
    ],
    schedule: (steps: 4),
)"#;

#[test]
fn a_compressed_cylinder_has_the_force_of_its_closed_form() {
    for basis in BASES {
        for (radius, tau) in [("1e9", 1e3 * 0.8_f64.ln()), ("40", -40.0 * 1.5_f64.sqrt())] {
            for mean in ["", ", mean_dilatation: Points"] {
                let text = CYLINDER.replace("BASIS", basis).replace("RADIUS", radius).replace(" MEAN", mean);
                let watched = watch(&text);
                let exact = PI * 0.81 * tau / 0.8;
                let error = watched.last("reaction/top", 1) / exact - 1.0;
                assert!(error.abs() < 1e-11, "{basis} {radius}{mean}: {error:e}");
            }
        }
    }
}

/// Pressure on the top and the side of a cylinder that no grid line ends: a uniform stress.
#[test]
fn pressure_on_all_sides_is_a_uniform_stress() {
    for basis in &BASES[1..] {
        let watched = watch(&format!(
            r#"Axisymmetric(
                mesh: Box(axes: [Uniform(from: 0, to: 1.3, cells: 5), Uniform(from: 0, to: 1.2, cells: 5)]),
                basis: {basis}, stabilisation: Ghost(),
                materials: {{ "m": Hencky(young: 1000, poisson: 0.3) }},
                bodies: [(name: "c", material: "m", shape: Box(from: (0, 0), to: (0.9, 1)), points_per_cell: 2)],
                supports: [(name: "base", region: Plane(axis: Z, at: 0), fix: [Z])],
                loads: [
                    Traction(body: "c", axis: Z, at: 1, resultant: (0, {})),
                    Traction(body: "c", axis: R, at: 0.9, value: (-1e-3, 0)),
                ],
                schedule: (steps: 1),
            )"#,
            -1e-3 * PI * 0.81
        ));
        assert!((watched.last("reaction/base", 1) / (1e-3 * PI * 0.81) - 1.0).abs() < 1e-12);
        for component in [0, 4, 8] {
            let [low, high] = watched.range(component);
            // The loads are dead: of the present areas the pressures differ by the strain, 1e-6.
            assert!(high - low < 1e-11 * 1e-3 && (low / -1e-3 - 1.0).abs() < 2e-6, "{basis}: {low} {high}");
        }
    }
}

/// A disc whose inner edge is driven outward while its lines follow: reactions of another code.
#[test]
fn a_driven_disc_agrees_with_the_table() {
    let scene = r#"Axisymmetric(
        mesh: Box(axes: [Uniform(from: 1, to: 2, cells: 8), Uniform(from: 0, to: 0.125, cells: 1)]),
        motion: Stretch([(axis: R, anchor: 2, driven: 1, displacement: 0.3)]),
        basis: BASIS,
        materials: { "m": Hencky(young: 1000, poisson: 0.3) },
        bodies: [(name: "disc", material: "m", shape: Box(from: (1, 0), to: (2, 0.125)), points_per_cell: 2)],
        supports: [
            (name: "z", region: Everywhere, fix: [Z]),
            (name: "inner", region: Plane(axis: R, at: 1), displace: [(axis: R, by: 0.3)]),
            (name: "outer", region: Plane(axis: R, at: 2), fix: [R]),
        ],
        schedule: (steps: 6),
    )"#;
    for (basis, reaction) in [
        ("Smpm", 5403.91684505125),
        ("Gimp", 5490.09732183604),
        ("Cpdi1", 5490.51034379533),
        ("Cpdi2q", 5490.51034379534),
    ] {
        let watched = watch(&scene.replace("BASIS", basis));
        let error = watched.last("reaction/inner", 0) / 0.125 / reaction - 1.0;
        assert!(error.abs() < 1e-10, "{basis}: {error:e}");
    }
}

/// A column under its own weight is that in the plane, whatever its radius.
#[test]
fn a_heavy_column_is_that_in_the_plane() {
    for (from, to) in [(0, 10), (7, 17)] {
        for basis in ["Cpdi1", "Cpdi2q"] {
            let watched = watch(&format!(
                r#"Axisymmetric(
                    mesh: Box(axes: [Uniform(from: {from}, to: {to}, cells: 2), Uniform(from: 0, to: 50, cells: 8)]),
                    basis: {basis},
                    materials: {{ "m": Hencky(young: 10000, poisson: 0, density: 80) }},
                    bodies: [(name: "c", material: "m", shape: Box(from: ({from}, 0), to: ({to}, 50)), points_per_cell: 2)],
                    supports: [
                        (name: "sides", region: Everywhere, fix: [R]), (name: "base", region: Plane(axis: Z, at: 0), fix: [Z]),
                    ],
                    loads: [BodyForce(acceleration: (0, -10))],
                    schedule: (steps: 40),
                )"#
            ));
            let [lowest, _] = watched.range(4);
            assert!((lowest / -36661.4286233 - 1.0).abs() < 1e-11, "{basis} from {from}: {lowest}");
        }
    }
}

/// A flat platen that a body meets presses it evenly.
#[test]
fn a_platen_presses_evenly() {
    for basis in ["Cpdi1", "Cpdi2q"] {
        let watched = watch(&format!(
            r#"Axisymmetric(
                mesh: Box(axes: [Uniform(from: 0, to: 1.5, cells: 6), Uniform(from: 0, to: 1.25, cells: 5)]),
                basis: {basis}, stabilisation: Ghost(),
                materials: {{ "m": Hencky(young: 1000, poisson: 0.3) }},
                bodies: [(name: "c", material: "m", shape: Box(from: (0, 0), to: (0.9, 1)), points_per_cell: 2)],
                supports: [(name: "base", region: Plane(axis: Z, at: 0), fix: [Z])],
                tools: [(name: "platen", parts: [Plane(through: (0, 1), normal: (0, -1))], motion: Move(by: (0, -0.1)))],
                schedule: (steps: 5),
            )"#
        ));
        let [low, high] = watched.range(4);
        assert!(high - low < 1e-11 * low.abs(), "{basis}: {low} {high}");
        let [_, radial] = watched.range(0);
        assert!(radial.abs() < 1e-10 * low.abs(), "{basis}: {radial}");
        let balance = watched.last("tool/platen/force", 1) / watched.last("reaction/base", 1) - 1.0;
        assert!(balance.abs() < 1e-10, "{balance:e}");
    }
}

/// Tools as their whole section: a cone with its shaft, and a polygon with an edge on the axis, are the same.
#[test]
fn tools_are_figures_of_revolution() {
    let scene = r#"Axisymmetric(
        mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 8), Uniform(from: -2, to: 1, cells: 12)]),
        basis: Cpdi1, stabilisation: Ghost(),
        materials: { "m": VonMises(young: 1000, poisson: 0.45, yield_radius: 14) },
        bodies: [(name: "c", material: "m", shape: Box(from: (0, -2), to: (2, 0)), points_per_cell: 2, mean_dilatation: Points)],
        supports: [(name: "base", region: Plane(axis: Z, at: -2), fix: [Z]), (name: "side", region: Plane(axis: R, at: 2), fix: [R])],
        tools: [(name: "cone", rounding: 0.03, parts: [PARTS], interface: (adhesion: 2), motion: Move(by: (0, -0.2)))],
        schedule: (steps: 8, cuts: 4),
    )"#;
    let parts = [
        "Cone(tip: (0, 0.05), radius: 0.6, length: 0.6)",
        "Polygon(vertices: [(0, 0.05), (0.6, 0.65), (0, 0.65)])",
        "Polygon(vertices: [(0, 0.65), (0, 0.05), (0.6, 0.65)])",
    ];
    let forces = parts.map(|part| watch(&scene.replace("PARTS", part)).last("tool/cone/force", 1));
    assert!(forces[0] > 1.0, "{forces:?}");
    for force in forces {
        assert!((force / forces[0] - 1.0).abs() < 1e-9, "{forces:?}");
    }
}

/// A ball is a disc that the axis cuts, and volumes are those of whole rings.
#[test]
fn volumes_are_those_of_figures_of_revolution() {
    let scene = |shape: &str| {
        format!(
            r#"Axisymmetric(
                mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 20), Uniform(from: -2, to: 2, cells: 40)]),
                basis: Cpdi1, materials: {{ "m": Hencky(young: 1, poisson: 0) }},
                bodies: [(name: "b", material: "m", shape: {shape}, points_per_cell: 2)],
                supports: [(name: "all", region: Everywhere, fix: [R, Z])],
                schedule: (steps: 1),
            )"#
        )
    };
    for (shape, volume, within) in [
        ("Box(from: (0.5, 0), to: (1, 2))", PI * 0.75 * 2.0, 1e-13),
        ("Sphere(centre: (0, 0.1), radius: 1.2)", 4.0 / 3.0 * PI * 1.2_f64.powi(3), 1e-4),
    ] {
        let mut compiled = compile(&Scene::from_ron(&scene(shape)).unwrap()).unwrap();
        let found = compiled.estimate().unwrap().volumes[0].points;
        assert!((found / volume - 1.0).abs() < within, "{shape}: {found} {volume}");
        let Compiled::Plane(_) = compiled else { panic!("two coordinates") };
    }
}

const SCENE: &str = r#"Axisymmetric(
    mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 4), Uniform(from: 0, to: 2, cells: 4)]),
    motion: Fixed,
    basis: Cpdi2q, domains: (fallback_beyond: 2),
    materials: { "m": Hencky(young: 1000, poisson: 0.3, density: 1) },
    bodies: [(name: "b", material: "m", shape: Box(from: (0, 0), to: (1, 1)), points_per_cell: 2)],
    supports: [(name: "base", region: Plane(axis: Z, at: 0), fix: [Z])],
    loads: [BodyForce(acceleration: (0, -1))],
    tools: [(name: "t", parts: [Plane(through: (0, 1.5), normal: (0, -1))], motion: Move(by: (0, -0.1)))],
    schedule: (steps: 1),
)"#;

/// What replaces what, where the refusal points, and what it says.
const REFUSED: &[(&str, &str, &str, &str)] = &[
    (
        "from: 0, to: 2, cells: 4), U",
        "from: -1, to: 2, cells: 6), U",
        "mesh",
        "reaches to r = -1, expected r of at least 0",
    ),
    (
        "from: (0, 0), to",
        "from: (-1, 0), to",
        "bodies[0].shape.from",
        "begins at r = -1, expected r of at least 0",
    ),
    (
        "Box(from: (0, 0), to: (1, 1))",
        "Cylinder(radius: 0.5)",
        "bodies[0].shape",
        "a cylinder or a tube is a `Box`, and a ball a `Sphere`",
    ),
    (
        "Box(from: (0, 0), to: (1, 1))",
        "Sphere(centre: (1, 1), radius: 0.5)",
        "bodies[0].shape.centre",
        "lies at r = 1, expected 0",
    ),
    (
        "Plane(axis: Z, at: 0)",
        "Plane(axis: Y, at: 0)",
        "supports[0].region.axis",
        "Y is no direction of an `Axisymmetric` scene, expected R or Z",
    ),
    ("fix: [Z]", "fix: [Z, X]", "supports[0].fix[1]", "X is no direction of an `Axisymmetric` scene"),
    (
        "fix: [Z]",
        "displace: [(axis: R, by: 0.1)]",
        "supports[0]",
        "support `base` drives a node on the axis r = 0 along r",
    ),
    ("fix: [Z]", "turn: (centre: (0, 0), angle: 1)", "supports[0].turn", "no figure of revolution does"),
    (
        "fix: [Z]",
        "fix: [Z], moment_about: (0, 0)",
        "supports[0].moment_about",
        "no moment about a point of (r, z)",
    ),
    ("acceleration: (0, -1)", "acceleration: (1, -1)", "loads[0].acceleration", "is 1 along r, expected 0"),
    ("motion: Fixed", "motion: Rotate(angle: 1)", "motion", "turns the plane (r, z)"),
    (
        "motion: Fixed",
        "motion: Stretch([(axis: X, anchor: 0, driven: 2, displacement: 0.1)])",
        "motion[0].axis",
        "expected R or Z",
    ),
    (
        "BodyForce(acceleration: (0, -1))",
        "Vortex(body: \"b\", angle: 1)",
        "loads[0]",
        "a vortex turns the plane (r, z)",
    ),
    (
        "BodyForce(acceleration: (0, -1))",
        "PointForce(body: \"b\", near: (0, 1), force: (1, 0))",
        "loads[0].force",
        "acts at r = 0",
    ),
    (
        "BodyForce(acceleration: (0, -1))",
        "Traction(body: \"b\", axis: R, at: 1, resultant: (1, 0))",
        "loads[0].resultant",
        "no part along r, expected `value`",
    ),
    (
        "BodyForce(acceleration: (0, -1))",
        "Traction(body: \"b\", axis: R, at: 1)",
        "loads[0]",
        "expected either `resultant`, the whole force, or `value`, the traction",
    ),
    (
        "fallback_beyond: 2",
        "corner_weights: Frozen",
        "domains.corner_weights",
        "expected `Current` in `Axisymmetric` scenes",
    ),
    (
        "Move(by: (0, -0.1))",
        "Move(by: (0.1, 0))",
        "tools[0].motion.by",
        "moves the tool by 0.1 along r, expected 0",
    ),
    (
        "Move(by: (0, -0.1))",
        "Move(turn: (angle: 1))",
        "tools[0].motion.turn",
        "turns the tool, which takes bodies along with `twist: true` only",
    ),
    (
        "Move(by: (0, -0.1))",
        "Loaded(free: [X], force: (0, -1))",
        "tools[0].motion.free[0]",
        "X is no motion of a figure of revolution, expected Z",
    ),
    ("Move(by: (0, -0.1))", "Loaded(free: [Z], force: (1, -1))", "tools[0].motion", "acts along the axis"),
    ("normal: (0, -1)", "normal: (0.1, -1)", "tools[0].parts[0].normal", "leans against the axis"),
    (
        "Plane(through: (0, 1.5), normal: (0, -1))",
        "Disc(centre: (0.5, 1.6), radius: 0.4)",
        "tools[0].parts[0].centre",
        "lies at r = 0.5, expected 0: on the axis",
    ),
    (
        "Plane(through: (0, 1.5), normal: (0, -1))",
        "Polygon(vertices: [(-1, 1.5), (1, 1.5), (1, 3)])",
        "tools[0].parts[0].vertices[0]",
        "lies at r = -1, expected r of at least 0",
    ),
    (
        "Plane(through: (0, 1.5), normal: (0, -1))",
        "Cylinder(axis: X, radius: 1, extent: (1.5, 3))",
        "tools[0].parts[0].axis",
        "is along X, expected Z",
    ),
];

#[test]
fn what_is_no_figure_of_revolution_is_refused() {
    compile(&Scene::from_ron(SCENE).unwrap()).unwrap();
    for (from, to, path, reason) in REFUSED {
        assert!(SCENE.contains(from), "{from}");
        let scene =
            Scene::from_ron(&SCENE.replacen(from, to, 1)).unwrap_or_else(|error| panic!("{error}: {to}"));
        let Err(error) = compile(&scene) else { panic!("accepted: {to}") };
        assert!(error.to_string().contains(reason), "{to}: {error}");
        assert_eq!(error.path, *path, "{to}: {error}");
    }
    let plane = SCENE
        .replace("Axisymmetric", "PlaneStrain")
        .replace("axis: Z", "axis: R")
        .replace("fix: [Z]", "fix: [Y]");
    let Err(error) = compile(&Scene::from_ron(&plane).unwrap()) else { panic!("R in the plane") };
    assert!(error.to_string().contains("R is a direction of `Axisymmetric` scenes only"), "{error}");
}

/// A mesh that moves away from its axis, and a point that is driven across it.
#[test]
fn the_axis_stays() {
    let away =
        SCENE.replace("motion: Fixed", "motion: Stretch([(axis: R, anchor: 2, driven: 0, displacement: 0.5)])");
    let Err(error) = compile(&Scene::from_ron(&away).unwrap()) else { panic!("accepted") };
    assert!(error.to_string().contains("moves away from the axis"), "{error}");
    let across = r#"Axisymmetric(
        mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 4), Uniform(from: 0, to: 1, cells: 2)]),
        basis: Smpm, materials: { "m": Hencky(young: 1000, poisson: 0) },
        bodies: [(name: "b", material: "m", shape: Box(from: (0.5, 0), to: (1, 1)), points_per_cell: 1)],
        supports: [(name: "all", region: Box(from: (0.5, 0), to: (1, 1)), fix: [Z], displace: [(axis: R, by: -2)])],
        schedule: (steps: 1, cuts: 0),
    )"#;
    let error = compile(&Scene::from_ron(across).unwrap()).unwrap().run(&mut Watched::default()).unwrap_err();
    assert!(error.to_string().contains("would reach the axis (hoop stretch"), "{error}");
}

/// Clay around a cylinder under a pressure of ten times its strength, driven open by 0.4 of its radius: points pass through
/// the cells, because a mesh that is stretched along r moves otherwise than a material that keeps its volume.
#[test]
fn a_run_tells_of_cells_that_points_have_crowded() {
    let scene = |mean: &str| {
        let text = format!(
            r#"Axisymmetric(
                mesh: Box(axes: [Graded(from: 1, to: 10, cells: 16, ratio: 4), Uniform(from: 0, to: 0.25, cells: 1)]),
                motion: Stretch([(axis: R, anchor: 10, driven: 1, displacement: 0.4)]), basis: Cpdi1,
                materials: {{ "clay": Tresca(young: 3000, poisson: 0.49, undrained_strength: 10) }},
                bodies: [(name: "ground", material: "clay", shape: Box(from: (1, 0), to: (10, 0.25)), points_per_cell: 2,
                    mean_dilatation: {mean}, initial: Stress(xx: -100, yy: -100, zz: -100))],
                supports: [
                    (name: "plates", region: Everywhere, fix: [Z]),
                    (name: "inner", region: Plane(axis: R, at: 1), follow_mesh: [R]),
                    (name: "far", region: Plane(axis: R, at: 10), fix: [R]),
                ],
                schedule: (steps: 40), output: (fields: []),
            )"#
        );
        let mut watched = Watched::default();
        let mut compiled = compile(&Scene::from_ron(&text).unwrap()).unwrap();
        let summary = compiled.run(&mut watched).unwrap();
        // The pressure of the same equations in one dimension is 636.763.
        let error = watched.last("reaction/inner", 0) / (TAU * 1.4 * 0.25) / 636.763 - 1.0;
        (error, summary.crowding_over_shear)
    };
    let (error, told) = scene("Cell");
    assert!(error < -0.05 && told.is_some_and(|ratio| ratio > 30.0), "{error} {told:?}");
    let (error, told) = scene("Points");
    assert!(error.abs() < 1e-3 && told.is_none(), "{error} {told:?}");
}

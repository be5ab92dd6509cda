//! Fields: those of points and of laws that a scene asks for by name, and parameters that differ from point to point.

use mpm_linear::Symmetry;
use mpm_scene::{Compiled, Scene, compile};
use mpm_solver::Model;
use mpm_solver::observe::{Field, LoadStep, Observer, ObserverError, Space};

/// An elastic body beside one that yields, pressed from above.
const SCENE: &str = "PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 1, cells: 1)]),
    basis: Smpm,
    materials: { \"e\": Hencky(young: 1000, poisson: 0.3), \"p\": VonMises(young: 1000, poisson: 0.3, yield_radius: 5) },
    bodies: [
        (name: \"left\", material: \"e\", shape: Box(from: (0, 0), to: (1, 1)), points_per_cell: 1),
        (name: \"right\", material: \"p\", shape: Box(from: (1, 0), to: (2, 1)), points_per_cell: 1),
    ],
    supports: [
        (name: \"base\", region: Plane(axis: Y, at: 0), fix: [X, Y]),
        (name: \"top\", region: Plane(axis: Y, at: 1), fix: [X], displace: [(axis: Y, by: -0.02)]),
    ],
    schedule: (steps: 2),
    output: (fields: [CauchyStress, PlasticStrain]),
)";

struct Last(Vec<Field>, Vec<f64>);

impl Observer for Last {
    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        self.1 = step.fields.field(self.0[1]);
        Ok(())
    }
}

#[test]
fn what_a_law_remembers_is_recorded_under_its_own_name() {
    let scene = Scene::from_ron(SCENE).unwrap();
    let mut compiled = compile(&scene).unwrap();
    let fields = compiled.fields(scene.output()).unwrap();
    assert_eq!(fields[0], Field::CAUCHY_STRESS);
    assert_eq!(
        (fields[1].name(), fields[1].components(), fields[1].unit(Space::Cartesian)),
        ("plastic_strain", 1, "-")
    );
    let mut last = Last(fields, Vec::new());
    compiled.run(&mut last).unwrap();
    let [elastic, plastic] = last.1[..] else { panic!("two points: {:?}", last.1) };
    assert_eq!(elastic, 0.0, "the elastic law remembers nothing");
    // Confined by 2 ln 0.99 (the mesh rests): |e| = √(2/3) |ε_yy|, less the elastic part 5/2G.
    let shear = 1000.0 / 2.6;
    let expected = (2.0_f64 / 3.0).sqrt() * 2.0 * 0.99_f64.ln().abs() - 5.0 / (2.0 * shear);
    assert!((plastic - expected).abs() < 1e-12, "{plastic} for {expected}");
}

#[test]
fn a_name_that_nothing_has_is_refused_with_those_that_there_are() {
    let scene = Scene::from_ron(&SCENE.replace("PlasticStrain", "Temperature")).unwrap();
    let error = compile(&scene).err().expect("refused").to_string();
    assert!(error.contains("no point has a field `Temperature`, expected one of Displacement,"), "{error}");
    assert!(error.ends_with("Outline, Angle, PlasticStrain"), "{error}");
}

const AT_REST: &str = "Geostatic(surface: 10, unit_weight: 20, k0: 0.6)";

/// Ground of 10 m under its weight.
fn ground(law: &str, initial: &str) -> Result<Model<2>, String> {
    let text = format!(
        r#"PlaneStrain(
            mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 10, cells: 5)]),
            basis: Gimp,
            materials: {{ "soil": {law} }},
            bodies: [(name: "ground", material: "soil", shape: Box(from: (0, 0), to: (2, 10)), points_per_cell: 2,
                mean_dilatation: Points, initial: {initial})],
            supports: [
                (name: "base", region: Plane(axis: Y, at: 0), fix: [Y]),
                (name: "left", region: Plane(axis: X, at: 0), fix: [X]),
                (name: "right", region: Plane(axis: X, at: 2), fix: [X]),
            ],
            loads: [BodyForce(acceleration: (0, -10), ramp: [(0, 1)])],
            schedule: (steps: 1),
        )"#
    );
    match compile(&Scene::from_ron(&text).expect("a scene")) {
        Ok(Compiled::Plane(model)) => Ok(model),
        Ok(Compiled::Solid(_)) => panic!("a plane scene"),
        Err(error) => Err(error.to_string()),
    }
}

/// Ground whose initial stress is that of its weight stays where it is.
#[track_caller]
fn does_not_move(law: &str, initial: &str) {
    struct Most(f64);
    impl Observer for Most {
        fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
            let displacement = step.fields.field(Field::DISPLACEMENT);
            self.0 = displacement.iter().fold(self.0, |most, u| most.max(u.abs()));
            Ok(())
        }
    }
    let mut moved = Most(0.0);
    let mut model = ground(law, initial).unwrap_or_else(|error| panic!("{error}: {law}"));
    mpm_solver::run(&mut model, &mut moved).unwrap_or_else(|error| panic!("{error}: {law}"));
    assert!(moved.0 < 1e-11, "{law}: {:e}", moved.0);
}

#[test]
fn angles_water_and_density_are_those_of_the_point() {
    let sand = "MohrCoulomb(young: 1e4, poisson: 0.2, cohesion: 1, friction: Linear(at: 10, value: 30, gradient: 0.5), \
                dilation: Layers([(top: 10, value: 5), (top: 4, value: 10)]), \
                fluid_bulk: Linear(at: 10, value: 1e5, gradient: 1e4), \
                density: Layers([(top: 10, value: 2), (top: 4, value: 3)]))";
    let layered =
        "Geostatic(surface: 10, unit_weight: Layers([(top: 10, value: 20), (top: 4, value: 30)]), k0: 0.6)";
    let model = ground(sand, layered).unwrap();
    let body = &model.bodies[0].body;
    let fields = body.history_fields();
    let names: Vec<_> = fields.iter().map(|field| field.name).collect();
    let own = ["young", "cohesion", "tensile_strength", "friction", "dilation", "fluid_bulk"];
    assert_eq!(names[..2], ["plastic_strain", "excess_pore_pressure"]);
    assert_eq!(names[2..], own);
    for p in 0..body.n_points() {
        let depth = 10.0 - body.point(p).position.y;
        let expected = [30.0 + 0.5 * depth, if depth < 6.0 { 5.0 } else { 10.0 }, 1e5 + 1e4 * depth];
        let mut history = Vec::new();
        body.history(p, &mut history);
        for (found, expected) in history[5..].iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12 * expected, "{found} {expected}");
        }
    }
    does_not_move(sand, layered);
    does_not_move(
        "CamClay(critical_ratio: Linear(at: 10, value: 1, gradient: 0.01), compression: 0.12, \
         swelling: Layers([(top: 10, value: 0.025), (top: 4, value: 0.03)]), shear_ratio: 30, \
         reference_pressure: 50, preconsolidation: 1e3, density: 2)",
        AT_REST,
    );
    does_not_move(
        "DruckerPrager(young: 1e4, poisson: 0.2, cone: Matched(at: PlaneStrain, cohesion: 2, \
         friction: Linear(at: 10, value: 35, gradient: 0.2), dilation: 5), density: 2)",
        AT_REST,
    );
    does_not_move(
        "DruckerPrager(young: 1e4, poisson: 0.2, cone: Slopes(slope: Linear(at: 10, value: 1.1, gradient: 0.01), \
         flow_slope: 0.2, strength: 1), density: 2)",
        AT_REST,
    );
}

#[test]
fn symmetry_is_that_of_all_points() {
    let symmetry = |friction: &str, dilation: &str| {
        let sand = format!(
            "MohrCoulomb(young: 1e4, poisson: 0.2, cohesion: 1, friction: {friction}, dilation: {dilation}, density: 2)"
        );
        ground(&sand, AT_REST).unwrap().bodies[0].body.symmetry()
    };
    let rising = "Linear(at: 10, value: 30, gradient: 0.5)";
    assert_eq!(symmetry(rising, rising), Symmetry::Symmetric);
    assert_eq!(symmetry(rising, "30"), Symmetry::Unsymmetric);
    let layers = "Layers([(top: 10, value: 30), (top: 1, value: 20)])";
    assert_eq!(symmetry("30", layers), Symmetry::Unsymmetric);
}

#[test]
fn fields_that_a_law_refuses_name_the_point() {
    let error = |law: &str| ground(law, AT_REST).err().expect("it is refused");
    let sand = |angles: &str| format!("MohrCoulomb(young: 1e4, poisson: 0.2, cohesion: 1, {angles})");
    for (angles, path, said) in [
        (
            "friction: Linear(at: 10, value: 30, gradient: 10), dilation: 0, density: 2",
            "friction",
            "friction is 125",
        ),
        (
            "friction: 30, dilation: Linear(at: 10, value: 29, gradient: 1), density: 2",
            "dilation",
            "dilation is 38.5",
        ),
        (
            "friction: 30, dilation: 0, density: Linear(at: 10, value: 2, gradient: -1)",
            "density",
            "density is -7.5",
        ),
        (
            "friction: 30, dilation: 0, density: 2, fluid_bulk: Linear(at: 10, value: 2, gradient: -1)",
            "fluid_bulk",
            "fluid_bulk is -7.5",
        ),
    ] {
        let found = error(&sand(angles));
        let expected = format!("materials.soil.{path}: at the point (0.25, 0.5): {said}");
        assert!(found.starts_with(&expected), "{found}");
    }
    let found = error(&sand("friction: 30, dilation: 0, density: Layers([])"));
    assert!(found.starts_with("materials.soil.density: expected at least one layer"), "{found}");
}

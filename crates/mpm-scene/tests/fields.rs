//! Fields that a scene asks for by name: those of the points, and what laws remember.

use mpm_scene::{Scene, compile};
use mpm_solver::observe::{Field, LoadStep, Observer, ObserverError};

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
    assert_eq!((fields[1].name(), fields[1].components(), fields[1].unit()), ("plastic_strain", 1, "-"));
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
    assert!(error.ends_with("Outline, PlasticStrain"), "{error}");
}

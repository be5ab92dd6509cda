//! A law of one's own in the place of a scene's.

use mpm_assembly::LawOfBody;
use mpm_material::{Elasticity, Hencky, VonMises};
use mpm_scene::{Compiled, Scene, compile};
use mpm_solver::Model;
use mpm_solver::observe::{Field, LoadStep, Observer, ObserverError};

const SCENE: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 4), Uniform(from: 0, to: 1, cells: 2)]),
    basis: Cpdi1,
    materials: { "a": LAW },
    bodies: [(name: "b", material: "a", shape: Box(from: (0, 0), to: (1.5, 1)), points_per_cell: 2)],
    supports: [(name: "left", region: Plane(axis: X, at: 0), fix: [X]), (name: "base", region: Plane(axis: Y, at: 0), fix: [Y])],
    loads: [BodyForce(acceleration: (16, -5))],
    schedule: (steps: 3),
)"#;

#[derive(Default)]
struct Last(Vec<f64>, Vec<f64>);

impl Observer for Last {
    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        (self.0, self.1) = (step.fields.field(Field::DISPLACEMENT), step.fields.field(Field::CAUCHY_STRESS));
        Ok(())
    }
}

fn model(law: &str) -> Model<2> {
    match compile(&Scene::from_ron(&SCENE.replace("LAW", law)).unwrap()).unwrap() {
        Compiled::Plane(model) => model,
        Compiled::Solid(_) => unreachable!(),
    }
}

fn end(mut model: Model<2>) -> (Vec<f64>, Vec<f64>) {
    let mut last = Last::default();
    mpm_solver::run(&mut model, &mut last).unwrap();
    (last.0, last.1)
}

#[test]
fn a_law_that_is_set_answers_as_one_of_the_scene() {
    let elasticity = Elasticity::from_young_poisson(1000.0, 0.3).unwrap();
    let elastic = "Hencky(young: 1000, poisson: 0.3, density: 1)";
    let plastic = "VonMises(young: 1000, poisson: 0.3, yield_radius: 15, density: 1)";
    let mut from_elastic = model(elastic);
    from_elastic.bodies[0].body.set_law(LawOfBody::new(VonMises::new(elasticity, 15.0).unwrap()), &[]).unwrap();
    assert!(from_elastic.bodies[0].body.can_yield());
    assert_eq!(end(from_elastic), end(model(plastic)));
    let mut from_plastic = model(plastic);
    from_plastic.bodies[0].body.set_law(LawOfBody::new(Hencky(elasticity)), &[]).unwrap();
    assert_eq!(end(from_plastic), end(model(elastic)));
    assert!(end(model(elastic)) != end(model(plastic)), "it yields");
}

//! Half and quarter models: a part of a body that planes of symmetry cut answers as the whole does.

use mpm_scene::compile;
use mpm_scene::language::Scene;
use mpm_solver::observe::{Column, Entry, LoadStep, Observer, ObserverError, RunStart};

/// A disc between two rigid plates, the quarter of it or all of it.
fn disc(quarter: bool, plane: &str) -> Scene {
    let from = if quarter { 0 } else { -2 };
    let cells = if quarter { 8 } else { 16 };
    let (symmetry, other) = if quarter {
        ("symmetry: [X, Y],", r#"(name: "middle", region: Plane(axis: Y, at: 0), fix: [Y]),"#)
    } else {
        ("", r#"(name: "bottom", region: Plane(axis: Y, at: -1.5), displace: [(axis: Y, by: 0.1)]),"#)
    };
    let text = format!(
        r#"PlaneStrain(
            mesh: Box(axes: [Uniform(from: {from}, to: 2, cells: {cells}), Uniform(from: {from}, to: 2, cells: {cells})]),
            basis: Smpm,
            materials: {{ "m": Hencky(young: 1e3, poisson: 0.3) }},
            bodies: [(name: "disc", material: "m", shape: Cylinder(radius: 1.65), {symmetry} points_per_cell: 2)],
            supports: [
                {plane}
                {other}
                (name: "top", region: Plane(axis: Y, at: 1.5), displace: [(axis: Y, by: -0.1)]),
            ],
            schedule: (steps: 4),
            output: (fields: []),
        )"#
    );
    Scene::from_ron(&text).unwrap_or_else(|error| panic!("{error}"))
}

const HELD: &str = r#"(name: "axis", region: Plane(axis: X, at: 0), fix: [X]),"#;

#[derive(Default)]
struct Top {
    column: Option<usize>,
    forces: Vec<f64>,
}

impl Observer for Top {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        let is_top = |it: &Column| it.name == "reaction/top";
        self.column = run.columns.iter().position(is_top);
        Ok(())
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        let Entry::Real(force) = &step.row[self.column.expect("the support has a column")] else {
            panic!("reactions are reals")
        };
        self.forces.push(force[1]);
        Ok(())
    }
}

fn forces(scene: &Scene) -> Vec<f64> {
    let mut top = Top::default();
    compile(scene).unwrap().run(&mut top).unwrap();
    top.forces
}

/// To rounding: at this radius no sliver has two neighbours that are equally full, of which rounding would choose one.
#[test]
fn a_quarter_answers_as_the_whole() {
    let (whole, quarter) = (forces(&disc(false, HELD)), forces(&disc(true, HELD)));
    assert_eq!(whole.len(), quarter.len());
    assert!(whole[4] < -10.0, "{whole:?}");
    for (whole, quarter) in whole.iter().zip(&quarter).skip(1) {
        assert!((whole / quarter - 2.0).abs() < 1e-11, "{whole} {quarter}");
    }
}

#[test]
fn planes_of_symmetry_are_held() {
    let said = compile(&disc(true, "")).map(drop).unwrap_err().to_string();
    assert!(
        said.contains("bodies[0].symmetry") && said.contains("no support fixes X of the node at [0.0"),
        "{said}"
    );
}

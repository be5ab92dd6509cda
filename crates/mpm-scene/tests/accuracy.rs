//! How well a run was solved: told in its summary and its history; and what is told where it was not.

use mpm_scene::compile;
use mpm_scene::language::{MeanDilatationInput, Scene};
use mpm_solver::Summary;
use mpm_solver::observe::{Column, Entry, LoadStep, Observer, ObserverError, RunStart};

/// A block under its weight whose uppermost and rightmost points reach by `cut` of a cell into the next.
fn scene(cut: f64, more: &str) -> Scene {
    let size = 1.2 * (1.0 + cut);
    let text = format!(
        r#"PlaneStrain(
            mesh: Box(axes: [Uniform(from: -1, to: 4, cells: 5), Uniform(from: 0, to: 4, cells: 4)]),
            basis: Smpm,
            materials: {{ "a": Hencky(young: 1e3, poisson: 0.3, density: 1) }},
            bodies: [(name: "b", material: "a", shape: Box(from: (0, 0), to: ({size}, {size})), points_per_cell: 2)],
            supports: [(name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y])],
            loads: [BodyForce(acceleration: (0, -10))],
            schedule: (steps: 4),
            {more}
        )"#
    );
    Scene::from_ron(&text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// Columns of the history and their values, row by row.
#[derive(Default)]
struct Rows {
    columns: Vec<Column>,
    rows: Vec<Vec<Entry>>,
}

impl Observer for Rows {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        self.columns.clone_from(&run.columns);
        Ok(())
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        self.rows.push(step.row.to_vec());
        Ok(())
    }
}

impl Rows {
    fn largest(&self, name: &str) -> f64 {
        let column = self.columns.iter().position(|it| it.name == name).unwrap_or_else(|| panic!("no {name}"));
        let value = |row: &Vec<Entry>| match &row[column] {
            Entry::Real(values) => values[0],
            Entry::Count(counts) => counts[0] as f64,
        };
        self.rows.iter().map(value).fold(0.0, f64::max)
    }
}

fn run(scene: &Scene) -> (Summary, Rows) {
    let mut rows = Rows::default();
    let summary = compile(scene).unwrap().run(&mut rows).unwrap();
    (summary, rows)
}

#[test]
fn the_summary_tells_the_worst_of_all_load_steps() {
    let (summary, rows) = run(&scene(0.1, "output: (condition: true)"));
    let condition = summary.condition.expect("it was asked for");
    assert_eq!(rows.largest("condition"), condition);
    assert_eq!(Some(rows.largest("backward_error")), summary.backward_error);
    assert_eq!(Some(rows.largest("pivot_spread")), summary.pivot_spread);
    assert_eq!(rows.largest("residual"), summary.residual);
    assert!(summary.backward_error.is_some_and(|error| error > 0.0 && error < 1e-12), "{summary:?}");
    assert!(summary.residual > 0.0 && summary.residual < 1e-9, "{summary:?}");
    // Both are bounds from below of the same number, of other iterations of a load step at most.
    assert!(summary.pivot_spread.is_some_and(|spread| spread > 1.0 && spread < 2.0 * condition), "{summary:?}");

    // Unless it is asked for there is no such column, and all else is the same.
    let (without, rows) = run(&scene(0.1, ""));
    assert!(rows.columns.iter().all(|it| it.name != "condition"));
    let timeless = |it: &Summary| Summary { timings: Vec::new(), condition: None, ..it.clone() };
    assert_eq!(timeless(&without), timeless(&summary));
    assert_eq!(without.condition, None);
}

#[test]
fn a_small_cut_shows_in_the_condition_number_and_ghost_stabilisation_mends_it() {
    let condition = |cut, more: &str| run(&scene(cut, more)).0.condition.unwrap();
    let asked = "output: (condition: true)";
    let ghost = "stabilisation: Ghost(), output: (condition: true)";
    let (large, small) = (condition(0.2, asked), condition(1e-2, asked));
    assert!(small > 100.0 * large, "{large} {small}");
    let (large, small) = (condition(0.2, ghost), condition(1e-2, ghost));
    assert!(small < 10.0 * large && small < 1e4, "{large} {small}");
}

#[test]
fn a_tangent_without_a_pivot_names_the_node_and_the_remedy() {
    // One point in a cell leaves its corners free to move against each other.
    let scene = Scene::from_ron(
        "PlaneStrain(
        mesh: Box(axes: [Uniform(from: 0, to: 6, cells: 6), Uniform(from: 0, to: 6, cells: 6)]), basis: Smpm,
        materials: { \"m\": Hencky(young: 1e3, poisson: 0.3) },
        bodies: [(name: \"b\", material: \"m\", shape: Box(from: (1, 0), to: (3, 4)), points_per_cell: 1)],
        supports: [
            (name: \"base\", region: Point(1, 0), fix: [X, Y]),
            (name: \"side\", region: Point(3, 0), fix: [Y]),
        ],
        loads: [PointForce(body: \"b\", near: (1, 4), force: (0, -1))],
        schedule: (steps: 2, cuts: 1))",
    );
    let scene = scene.unwrap();
    let error = compile(&scene).unwrap().run(&mut ()).unwrap_err().to_string();
    for part in ["the tangent is singular at node", "along x", "barely reaches", "`stabilisation: Ghost()`"] {
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn a_cut_of_a_ten_millionth_is_told_by_the_pivots() {
    let spread = |more| run(&scene(1e-7, more)).0.pivot_spread.expect("it is factorised");
    assert!(spread("") > 1e12);
    assert!(spread("stabilisation: Ghost()") < 1e4);
}

#[test]
fn ghost_stabilisation_and_mean_dilatation_go_together() {
    let run = |more: &str, mean: bool| {
        let mut scene = scene(1e-3, more);
        if let Scene::PlaneStrain(scene) = &mut scene {
            scene.bodies[0].mean_dilatation = mean.then_some(MeanDilatationInput::Points);
        }
        run(&scene)
    };
    let (both, rows) = run("stabilisation: Ghost()", true);
    assert_eq!((both.steps, both.cuts, both.shortened), (4, 0, 0));
    assert!(rows.largest("newton_iterations") < 5.0 && rows.largest("ghost_faces") > 0.0, "{both:?}");
    assert!(both.pivot_spread.is_some_and(|spread| spread < 1e4), "{both:?}");
    // Each does something to the other.
    for (more, mean) in [("stabilisation: Ghost()", false), ("", true)] {
        assert_ne!(run(more, mean).0.smallest_determinant, both.smallest_determinant);
    }
}

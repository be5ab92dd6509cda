//! Scenes on splines: tractions on a body that ends inside cells, and the iterations of the iterative solver.

use mpm_scene::Scene;
use mpm_scene::compile;
use mpm_solver::observe::{Entry, Field, LoadStep, Observer, ObserverError, RunStart};

/// What is seen of the last load step.
#[derive(Default)]
struct Seen {
    columns: Vec<String>,
    stress: Vec<f64>,
    /// Along the first direction, of the support `inner`.
    reaction: f64,
    /// Of the tool `disc`.
    tool: Vec<f64>,
    newton: u64,
    linear: u64,
}

impl Observer for Seen {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        self.columns = run.columns.iter().map(|it| it.name.clone()).collect();
        Ok(())
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        self.stress = step.fields.field(Field::CAUCHY_STRESS);
        let count = |name: &str| {
            let column = self.columns.iter().position(|it| it == name)?;
            match &step.row[column] {
                Entry::Count(values) => values.first().copied(),
                Entry::Real(_) => None,
            }
        };
        let inner = self.columns.iter().position(|it| it == "reaction/inner");
        if let Some(Entry::Real(force)) = inner.map(|column| &step.row[column]) {
            self.reaction = force[0];
        }
        let tool = self.columns.iter().position(|it| it == "tool/disc/force");
        if let Some(Entry::Real(force)) = tool.map(|column| &step.row[column]) {
            self.tool = force.clone();
        }
        self.newton = count("newton_iterations").unwrap_or(0);
        self.linear = count("linear_iterations").unwrap_or(0);
        Ok(())
    }
}

fn run(text: &str) -> Seen {
    let mut seen = Seen::default();
    compile(&Scene::from_ron(text).unwrap()).unwrap().run(&mut seen).unwrap();
    seen
}

/// Tractions are lumped to the ends of the sides of domains, as the balance at corners needs it: a uniform stress is exact,
/// also where the loaded side lies inside cells.
#[test]
fn a_uniform_traction_inside_cells_makes_a_uniform_stress() {
    for basis in ["Cpdi1", "Cpdi2q"] {
        for degree in [2, 3] {
            let seen = run(&format!(
                r#"PlaneStrain(
                    mesh: Box(
                        axes: [Uniform(from: 0, to: 4, cells: 4), Graded(from: 0, to: 4, cells: 4, ratio: 1.4)],
                        functions: Splines(degree: {degree}),
                    ),
                    basis: {basis}, stabilisation: Ghost(), materials: {{ "a": Hencky(young: 1e3, poisson: 0.3) }},
                    bodies: [(name: "b", material: "a", shape: Box(from: (0, 0), to: (3, 2.5)), points_per_cell: 2)],
                    supports: [
                        (name: "base", region: Plane(axis: Y, at: 0), fix: [Y]),
                        (name: "left", region: Plane(axis: X, at: 0), fix: [X]),
                    ],
                    loads: [Traction(body: "b", axis: Y, at: 2.5, resultant: (0, -300))],
                    schedule: (steps: 3), tolerance: (residual: 1e-12), output: (fields: [CauchyStress]),
                )"#
            ));
            let first = &seen.stress[..9];
            // The force over the width now, which ν has made larger than 3.
            assert!(first[4] < -90.0 && first[4] > -100.0, "{first:?}");
            let apart = seen.stress.iter().zip(first.iter().cycle()).map(|(a, b)| (a - b).abs());
            let (apart, across) = (apart.fold(0.0, f64::max), first[0].abs().max(first[1].abs()));
            assert!(apart < 1e-9 && across < 1e-9, "{basis}, {degree}: {apart:e}, {across:e}");
        }
    }
}

/// The same of rings about an axis.
#[test]
fn a_uniform_traction_on_a_solid_of_revolution_makes_a_uniform_stress() {
    for basis in ["Cpdi1", "Cpdi2q"] {
        let seen = run(&format!(
            r#"Axisymmetric(
                mesh: Box(
                    axes: [Uniform(from: 0, to: 4, cells: 4), Graded(from: 0, to: 4, cells: 4, ratio: 1.4)],
                    functions: Splines(degree: 2),
                ),
                basis: {basis}, stabilisation: Ghost(), materials: {{ "a": Hencky(young: 1e3, poisson: 0.3) }},
                bodies: [(name: "b", material: "a", shape: Box(from: (0, 0), to: (3, 2.5)), points_per_cell: 2)],
                supports: [(name: "base", region: Plane(axis: Z, at: 0), fix: [Z])],
                loads: [Traction(body: "b", axis: Z, at: 2.5, value: (0, -100))],
                schedule: (steps: 3), tolerance: (residual: 1e-12), output: (fields: [CauchyStress]),
            )"#
        ));
        let first = &seen.stress[..9];
        assert!(first[4] < -90.0 && first[4] > -100.0, "{first:?}");
        let apart = seen.stress.iter().zip(first.iter().cycle()).map(|(a, b)| (a - b).abs());
        let across = [0, 1, 8].map(|k| first[k].abs()).into_iter().fold(apart.fold(0.0, f64::max), f64::max);
        assert!(across < 1e-9, "{basis}: {across:e}");
    }
}

/// The pressure in a thick cylinder of revolution, as in the validation's *thick walls of revolution*, is of second order.
#[test]
fn the_pressure_in_a_thick_cylinder_is_of_second_order() {
    let error = |cells: u32| {
        let height = 2.0 / f64::from(cells);
        let seen = run(&format!(
            r#"Axisymmetric(
                mesh: Box(
                    axes: [Uniform(from: 1, to: 3, cells: {cells}), Uniform(from: 0, to: {height}, cells: 1)],
                    functions: Splines(degree: 2),
                ),
                motion: Stretch([(axis: R, anchor: 3, driven: 1, displacement: 0.3)]),
                basis: Cpdi1, materials: {{ "m": Hencky(young: 1000, poisson: 0.3) }},
                bodies: [(name: "wall", material: "m", shape: Box(from: (1, 0), to: (3, {height})), points_per_cell: 2)],
                supports: [
                    (name: "below", region: Plane(axis: Z, at: 0), fix: [Z]),
                    (name: "above", region: Plane(axis: Z, at: {height}), fix: [Z]),
                    (name: "inner", region: Plane(axis: R, at: 1), follow_mesh: [R]),
                    (name: "outer", region: Plane(axis: R, at: 3), fix: [R]),
                ],
                schedule: (steps: 6), output: (fields: [CauchyStress]),
            )"#
        ));
        seen.reaction / (std::f64::consts::TAU * 1.3 * height) / 321.750_314_652_756 - 1.0
    };
    let (coarse, fine) = (error(4), error(8));
    let order = (coarse / fine).log2();
    assert!(coarse.abs() < 3e-4 && (1.9..2.3).contains(&order), "{coarse:e} {fine:e}");
}

/// Tools touch the corners at which the functions are sampled: the force on the tool is that of the base, and converges
/// to 193.
#[test]
fn a_tool_touches_corners_on_splines() {
    for (degree, within) in [(2, 0.01), (3, 0.01)] {
        let seen = run(&format!(
            r#"PlaneStrain(
                mesh: Box(
                    axes: [Uniform(from: 0, to: 4, cells: 16), Uniform(from: 0, to: 5, cells: 20)],
                    functions: Splines(degree: {degree}),
                ),
                basis: Cpdi1, stabilisation: Ghost(), materials: {{ "g": Hencky(young: 1e3, poisson: 0.3) }},
                bodies: [(name: "b", material: "g", shape: Box(from: (0, 0), to: (4, 4)), points_per_cell: 2)],
                supports: [
                    (name: "inner", region: Plane(axis: Y, at: 0), fix: [X, Y]),
                    (name: "left", region: Plane(axis: X, at: 0), fix: [X]),
                    (name: "right", region: Plane(axis: X, at: 4), fix: [X]),
                ],
                tools: [(name: "disc", parts: [Disc(centre: (2, 5.01), radius: 1)], motion: Move(by: (0, -0.3)))],
                schedule: (steps: 10), output: (fields: [CauchyStress]),
            )"#
        ));
        let [across, along] = seen.tool[..] else { panic!("a force in the plane") };
        assert!(
            across.abs() < 1e-9 && (along / 193.0 - 1.0).abs() < within,
            "degree {degree}: {across} {along}"
        );
    }
}

/// Conjugate gradients with multigrid between lines of control points take as many iterations on every mesh.
#[test]
fn iterations_do_not_depend_on_the_mesh() {
    for (degree, most) in [(2, 20.0), (3, 40.0)] {
        for cells in [16, 32] {
            let seen = run(&format!(
                r#"PlaneStrain(
                    mesh: Box(
                        axes: [Uniform(from: 0, to: 4, cells: {cells}), Uniform(from: 0, to: 4, cells: {cells})],
                        functions: Splines(degree: {degree}),
                    ),
                    basis: Cpdi1, solver: Iterative, materials: {{ "a": Hencky(young: 1e3, poisson: 0.3, density: 1) }},
                    bodies: [(name: "b", material: "a", shape: Box(from: (0, 0), to: (4, 4)), points_per_cell: 2)],
                    supports: [(name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y])],
                    loads: [BodyForce(acceleration: (0.3, -1))],
                    schedule: (steps: 1), output: (fields: [CauchyStress]),
                )"#
            ));
            let each = seen.linear as f64 / seen.newton as f64;
            assert!(each > 2.0 && each <= most, "degree {degree}, {cells}²: {each} iterations a solution");
        }
    }
}

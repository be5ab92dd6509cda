//! Scenes whose laws a nodal field regularises: what it leaves as it is, what it stores, and what is refused.

use mpm_material::FieldInfo;
use mpm_scene::{Scene, compile};
use mpm_solver::Error;
use mpm_solver::observe::{Column, Entry, Field, LoadStep, Observer, ObserverError, RunStart};

const PLASTIC: &str = "gradient: (modulus: 400, length: 0.7)";
const STRAIN: &str = "gradient: (driver: Strain, modulus: 400, length: 0.7)";

const PLANE: &str = "PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 3, cells: 3), Uniform(from: 0, to: 3, cells: 4)]),
    basis: BASIS,
    materials: { \"m\": LAW },
    bodies: [(name: \"b\", material: \"m\", shape: Box(from: (0, 0), to: (2, 1.5)), points_per_cell: 2)],
    supports: [
        (name: \"left\", region: Plane(axis: X, at: 0), fix: [X]),
        (name: \"base\", region: Plane(axis: Y, at: 0), fix: [Y]),
        (name: \"right\", region: Plane(axis: X, at: 2), follow_mesh: [X]),
    ],
    motion: Stretch([(axis: X, anchor: 0, driven: 2, displacement: 0.2)]),
    schedule: (steps: 5), tolerance: (residual: 1e-12),
    output: (fields: [CauchyStress, Plastic]),
)";

const SOLID: &str = "Solid(
    mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 2, cells: 2)]),
    basis: BASIS,
    materials: { \"m\": LAW },
    bodies: [(name: \"b\", material: \"m\", shape: Box(from: (0, 0, 0), to: (2, 2, 2)), points_per_cell: 2)],
    supports: [
        (name: \"all\", region: Everywhere, fix: [Y, Z]),
        (name: \"left\", region: Plane(axis: X, at: 0), fix: [X]),
        (name: \"right\", region: Plane(axis: X, at: 2), follow_mesh: [X]),
    ],
    motion: Stretch([(axis: X, anchor: 0, driven: 2, displacement: 0.2)]),
    schedule: (steps: 4), tolerance: (residual: 1e-12),
    output: (fields: [CauchyStress, Plastic]),
)";

/// What is seen of a run.
#[derive(Default)]
struct Seen {
    columns: Vec<Column>,
    rows: Vec<Vec<Entry>>,
    stress: Vec<f64>,
    plastic: Vec<f64>,
    driver: Vec<f64>,
    field: Vec<f64>,
    /// The driver and the field one load step before.
    before: [Vec<f64>; 2],
}

impl Observer for Seen {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        self.columns = run.columns.clone();
        Ok(())
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        let remembered = |name| step.fields.field(Field::from(FieldInfo { name, components: 1, unit: "-" }));
        self.rows.push(step.row.to_vec());
        self.stress = step.fields.field(Field::CAUCHY_STRESS);
        self.plastic = step.fields.field(Field::PLASTIC);
        let driver = std::mem::replace(&mut self.driver, remembered("plastic_strain"));
        self.before = [driver, std::mem::take(&mut self.field)];
        self.field = remembered("nonlocal_plastic_strain");
        if self.field.iter().all(|k| *k == 0.0) {
            self.field = remembered("nonlocal_shear_measure");
        }
        Ok(())
    }
}

impl Seen {
    fn last(&self, name: &str) -> f64 {
        self.of(name, &self.rows[self.rows.len() - 1])
    }

    fn of(&self, name: &str, row: &[Entry]) -> f64 {
        let at = self.columns.iter().position(|column| column.name == name);
        match &row[at.unwrap_or_else(|| panic!("no column {name}"))] {
            Entry::Real(values) => values[0],
            Entry::Count(values) => values[0] as f64,
        }
    }
}

fn run(text: &str) -> Seen {
    let mut seen = Seen::default();
    let scene = Scene::from_ron(text).unwrap_or_else(|it| panic!("{it}: {text}"));
    compile(&scene).unwrap_or_else(|it| panic!("{it}: {text}")).run(&mut seen).unwrap();
    seen
}

/// A law that hardens, so that it stays homogeneous, with a gradient.
fn law(gradient: &str) -> String {
    let softening = "undrained_strength: 5, softening: Linear(modulus: 20, residual: 5)";
    format!("VonMises(young: 1000, poisson: 0.3, {softening}, {gradient})")
}

/// Where the strain is the same everywhere, the field is its driver, and stress is that of the law alone.
#[test]
fn a_homogeneous_stretch_does_not_feel_the_field() {
    let plane = ["Smpm", "Gimp", "Cpdi1", "Cpdi2q", "Cpdi2t"].map(|basis| PLANE.replace("BASIS", basis));
    let solid = ["Smpm", "Gimp", "Cpdi1", "Cpdi2Hexahedron", "Cpdi2Tetrahedron"];
    let solid = solid.map(|basis| SOLID.replace("BASIS", basis));
    for scene in plane.iter().chain(&solid) {
        let local = run(&scene.replace("LAW", &law("")));
        assert!(local.plastic.iter().all(|it| *it == 1.0));
        for gradient in [PLASTIC, STRAIN] {
            let found = run(&scene.replace("LAW", &law(gradient)));
            let size = local.stress.iter().fold(0.0_f64, |most, it| most.max(it.abs()));
            for (found, local) in found.stress.iter().zip(&local.stress) {
                assert!((found - local).abs() < 1e-11 * size, "{gradient}: {found} {local}");
            }
            assert!(found.field.iter().all(|k| *k > 1e-3), "{gradient}: {:?}", found.field);
            if gradient == PLASTIC {
                let pairs = found.field.iter().zip(&found.driver);
                assert!(pairs.clone().all(|(k, d)| (k - d).abs() < 1e-12), "{:?}", pairs.collect::<Vec<_>>());
            }
        }
    }
}

/// A block that is sheared and pressed from above, so that its strain varies.
const VARYING: &str = "PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 4, cells: 8), Uniform(from: 0, to: 3, cells: 6)]),
    basis: Cpdi1,
    materials: { \"m\": LAW },
    bodies: [(name: \"b\", material: \"m\", shape: Box(from: (0, 0), to: (2, 2)), points_per_cell: 2)],
    supports: [(name: \"base\", region: Plane(axis: Y, at: 0), fix: [Y], displace: [(axis: X, by: 0)])],
    loads: [Traction(body: \"b\", axis: Y, at: 2, value: (FORCE))],
    schedule: (steps: STEPS), tolerance: (residual: 1e-12),
    output: (fields: [CauchyStress], energies: true),
)";

/// Work is stored, or dissipated: with the field as without it, up to what the change of the mesh lets go of in both.
#[test]
fn the_field_stores_what_it_takes() {
    let unbalanced = |gradient: &str| {
        let law = format!("Hencky(young: 1000, poisson: 0.3{gradient})");
        let text = VARYING.replace("LAW", &law).replace("FORCE", "40, 0").replace("STEPS", "16");
        let seen = run(&text);
        (seen.last("energy/unbalanced") / seen.last("energy/elastic"), seen.last("energy/elastic"))
    };
    let (without, with) =
        (unbalanced(""), unbalanced(", gradient: (driver: Strain, modulus: 3000, length: 0.7)"));
    assert!(without.0 < 1e-3 && (with.0 - without.0).abs() < 1.5e-4, "{without:?} {with:?}");
    // The field takes part: the block is stiffer.
    assert!(with.1 < 0.99 * without.1, "{without:?} {with:?}");
}

#[test]
fn a_block_yields_and_its_run_goes_on_through_the_softening() {
    let softening = "undrained_strength: 5, softening: Remoulding(remoulded: 0.5, shear_95: 0.3)";
    let law = format!("VonMises(young: 1000, poisson: 0.3, {softening}, {PLASTIC})");
    let text = VARYING.replace("LAW", &law).replace("FORCE", "3, -2").replace("STEPS", "6");
    let seen = run(&text);
    assert!(seen.field.iter().any(|k| *k > 1e-5), "{:?}", seen.field);
}

/// Multigrid takes the displacements and the field of a node as one block.
#[test]
fn iteration_gives_what_factorisation_gives() {
    let softening = "undrained_strength: 5, softening: Remoulding(remoulded: 0.5, shear_95: 0.3)";
    let varying = VARYING.replace("FORCE", "2.6, -2").replace("STEPS", "4");
    let solid = SOLID.replace("BASIS", "Cpdi1").replace("fix: [Y, Z]", "fix: [Y]").replace(
        "(name: \"left\"",
        "(name: \"back\", region: Plane(axis: Z, at: 0), fix: [Z]), (name: \"left\"",
    );
    for (scene, gradient) in [(&varying, PLASTIC), (&varying, STRAIN), (&solid, PLASTIC), (&solid, STRAIN)] {
        let law = format!("VonMises(young: 1000, poisson: 0.3, {softening}, {gradient})");
        let scene = scene.replace("LAW", &law);
        let direct = run(&scene);
        let iterative = run(&scene.replace("schedule:", "solver: Iterative, schedule:"));
        assert!(iterative.last("linear_iterations") > 0.0);
        let size = direct.stress.iter().fold(0.0_f64, |most, it| most.max(it.abs()));
        for (found, expected) in iterative.stress.iter().zip(&direct.stress) {
            assert!((found - expected).abs() < 1e-7 * size, "{gradient}: {found} {expected}");
        }
    }
}

/// A load beyond what a block bears is followed down by what the block dissipates.
#[test]
fn path_control_follows_a_regularised_block_that_softens() {
    let softening = "undrained_strength: 5, softening: Remoulding(remoulded: 0.3, shear_95: 0.1)";
    let law =
        format!("VonMises(young: 1000, poisson: 0.3, {softening}, gradient: (modulus: 1000, length: 0.5))");
    let along = "STEPS, control: Path(first: 0.2, measure: Dissipation(most: 0.1))";
    let text = VARYING.replace("STEPS", along).replace("LAW", &law);
    let text = text.replace("FORCE", "0, -20").replace("STEPS", "20");
    let mut seen = Seen::default();
    let ended = compile(&Scene::from_ron(&text).unwrap()).unwrap().run(&mut seen);
    assert!(matches!(ended, Err(Error::StepLimit { steps: 20, .. })), "{ended:?}");
    let loads: Vec<f64> = seen.rows.iter().map(|row| seen.of("load_fraction", row)).collect();
    let highest = loads.iter().copied().fold(0.0, f64::max);
    assert!(highest < 1.0 && loads[loads.len() - 1] < 0.9 * highest, "{loads:?}");
    assert!(seen.field.iter().any(|k| *k > 0.01), "{:?}", seen.field);
}

/// Largest relative error of the torque of a ring against a solution in one dimension at some load fractions.
fn torque_error(scene: &str, expected: &[(f64, f64)]) -> f64 {
    let seen = run(scene);
    let error = |&(at, torque): &(f64, f64)| {
        let row = seen.rows.iter().find(|row| (seen.of("load_fraction", row) - at).abs() < 1e-9);
        (seen.of("reaction_moment/inner", row.unwrap_or_else(|| panic!("no step ends at {at}"))) / torque - 1.0)
            .abs()
    };
    expected.iter().map(error).fold(0.0, f64::max)
}

/// The doughnut of the slides: a solution in one dimension (640 quadratic elements, converged to 2e-6) with the same steps.
/// Without the field torques differ by 30 % between meshes.
#[test]
fn the_doughnut_with_large_elastic_strains_has_the_torque_of_one_dimension() {
    let expected = [
        (20.0, 6.834872e7),
        (30.0, 9.433072e7),
        (34.0, 9.80691e7),
        (45.0, 9.27339e7),
        (60.0, 8.42698e7),
        (90.0, 7.43822e7),
    ];
    let expected = expected.map(|(angle, torque)| (angle / 90.0, torque));
    let error = torque_error(include_str!("../../../scenes/doughnut_regularised.ron"), &expected);
    assert!(error < 0.01, "{error}");
}

/// A ring whose material softens: as above, converged to 9e-6. Without the field the innermost row of points unloads the ring
/// faster than it is turned.
#[test]
fn a_ring_that_softens_has_the_torque_of_one_dimension() {
    let expected = [
        (0.25, 0.7029557e6),
        (0.5, 1.162890e6),
        (0.75, 1.018592e6),
        (1.0, 0.936451e6),
        (2.0, 0.793453e6),
        (3.0, 0.739449e6),
    ];
    let expected = expected.map(|(angle, torque)| (angle / 3.0, torque));
    let error = torque_error(include_str!("../../../scenes/soil/ring_softening.ron"), &expected);
    assert!(error < 0.015, "{error}");
}

/// The doughnut up to 20°, where it is elastic: the error is of second order, and does not depend on the direction.
#[test]
fn an_elastic_doughnut_has_errors_of_second_order_either_way() {
    let scene = include_str!("../../../scenes/doughnut_regularised.ron").replace("Cpdi2q", "Cpdi1");
    let torque = |angle: f64, rows: u32| {
        let turn = format!("angle: {angle}");
        let (cells, sectors) = (format!("cells: {rows}"), format!("sectors: {}", 16 * rows / 5));
        let scene = scene.replace("angle: 90", &turn).replace("steps: 90", "steps: 20");
        let scene = scene.replace("cells: 10", &cells).replace("sectors: 32", &sectors);
        run(&scene).last("reaction_moment/inner")
    };
    let (coarse, back, fine) = (torque(20.0, 10), torque(-20.0, 10), torque(20.0, 20));
    assert!((coarse / back + 1.0).abs() < 1e-9, "{coarse} {back}");
    // Errors of a prototype with points: -5.1e-3 and -1.3e-3.
    let errors = [coarse, fine].map(|it| it / 6.834872e7 - 1.0);
    assert!((errors[0] + 5.1e-3).abs() < 1e-4 && (errors[1] + 1.27e-3).abs() < 1e-4, "{errors:?}");
}

/// The mesh is reset and nothing is turned further: the field is found anew as it was, and nothing flows.
#[test]
fn a_step_without_load_changes_nothing() {
    let ramp = "angle: 1, ramp: [(0, 0), (0.9523809523809523, 1), (1, 1)]";
    let scene = include_str!("../../../scenes/soil/ring_softening.ron").replace("angle: 3", ramp);
    let seen = run(&scene.replace("steps: 60", "steps: 21"));
    let most = |values: &[f64]| values.iter().fold(0.0_f64, |most, it| most.max(it.abs()));
    let [driver, field] = &seen.before;
    for (now, before) in [(&seen.driver, driver), (&seen.field, field)] {
        let changes: Vec<f64> = now.iter().zip(before).map(|(now, before)| now - before).collect();
        assert!(most(before) > 0.05 && most(&changes) < 1e-6 * most(before), "{}", most(&changes));
    }
}

/// Points that are too large for a band, and a length that is larger than the body.
#[test]
fn a_check_remarks_on_lengths_that_do_not_suit() {
    let softening = "undrained_strength: 5, softening: Remoulding(remoulded: 0.3, shear_95: 0.1)";
    let remarks = |length: f64| {
        let gradient = format!("gradient: (modulus: 1000, length: {length})");
        let law = format!("VonMises(young: 1000, poisson: 0.3, {softening}, {gradient})");
        let scene = PLANE.replace("BASIS", "Cpdi1").replace("LAW", &law);
        let mut compiled = compile(&Scene::from_ron(&scene).unwrap()).unwrap();
        compiled.estimate().unwrap().remarks
    };
    let told = |remarks: &[String], part: &str| remarks.iter().any(|remark| remark.contains(part));
    let (short, right, long) = (remarks(0.1), remarks(0.5), remarks(2.1));
    assert!(told(&short, "expected 6 points across a band") && !told(&short, "nodal field"), "{short:?}");
    assert!(!told(&right, "across a band") && !told(&right, "nodal field"), "{right:?}");
    let expected = "the length of the nodal field of body `b` is 2.1, and the body is about 1.93301 long";
    assert!(told(&long, expected), "{long:?}");
}

#[test]
fn what_cannot_have_a_field_is_told() {
    let plane = PLANE.replace("BASIS", "Cpdi1");
    let refused = |text: &str| {
        let scene = Scene::from_ron(text).unwrap_or_else(|it| panic!("{it}: {text}"));
        compile(&scene).err().map_or_else(|| panic!("it is not refused: {text}"), |it| it.to_string())
    };
    let hencky = plane.replace("LAW", &format!("Hencky(young: 1000, poisson: 0.3, {PLASTIC})"));
    assert_eq!(
        refused(&hencky),
        "materials.m.gradient.driver: `PlasticStrain` is the driver of `VonMises` and `Tresca` only: expected `Strain`"
    );
    let varies = format!(
        "Tresca(young: 1000, poisson: 0.3, undrained_strength: Layers([(top: 2, value: 5)]), {PLASTIC})"
    );
    assert_eq!(
        refused(&plane.replace("LAW", &varies)),
        "materials.m.gradient.driver: `PlasticStrain` needs parameters that are the same everywhere, and \
         `undrained_strength` is a field"
    );
    let averaged = plane
        .replace("LAW", &law(PLASTIC))
        .replace("points_per_cell: 2", "points_per_cell: 2, mean_dilatation: Points");
    assert_eq!(
        refused(&averaged),
        "materials.m.gradient: a body with `mean_dilatation` has no nodal field: leave out one of them"
    );
    let soft = "Tresca(young: 1000, poisson: 0.3, undrained_strength: 5, \
                softening: Linear(modulus: -250, residual: 1), gradient: (modulus: 400, length: 0.7))";
    assert_eq!(
        refused(&plane.replace("LAW", soft)),
        "materials.m.gradient.modulus: modulus is 400, expected above the fastest softening -dρ/dκ, or it holds no shear \
         band together"
    );
    let ring = "Axisymmetric(
        mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 2, cells: 2)]), basis: Cpdi1,
        materials: { \"m\": LAW }, schedule: (steps: 1),
        bodies: [(name: \"b\", material: \"m\", shape: Box(from: (0, 0), to: (2, 1)), points_per_cell: 2)],
        supports: [(name: \"base\", region: Plane(axis: Z, at: 0), fix: [Z])],
    )";
    assert_eq!(
        refused(&ring.replace("LAW", &law(STRAIN))),
        "materials.m.gradient: no body of revolution has a nodal field: expected a scene in the plane or in space"
    );
}

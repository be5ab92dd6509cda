//! Scenes whose laws a nodal field regularises: what it leaves as it is, what it stores, and what is refused.

use mpm_material::FieldInfo;
use mpm_scene::{Scene, compile};
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
    basis: Cpdi1,
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
        self.driver = remembered("plastic_strain");
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
    let scenes = ["Smpm", "Cpdi1", "Cpdi2q"].map(|basis| PLANE.replace("BASIS", basis));
    for scene in scenes.iter().map(String::as_str).chain([SOLID]) {
        let local = run(&scene.replace("LAW", &law("")));
        assert!(local.plastic.iter().all(|it| *it == 1.0));
        for gradient in [PLASTIC, STRAIN] {
            let found = run(&scene.replace("LAW", &law(gradient)));
            let size = local.stress.iter().fold(0.0_f64, |most, it| most.max(it.abs()));
            for (found, local) in found.stress.iter().zip(&local.stress) {
                assert!((found - local).abs() < 1e-11 * size, "{gradient}: {found} {local}");
            }
            assert!(found.field.iter().all(|k| *k > 0.01), "{gradient}: {:?}", found.field);
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

/// Work is stored, or dissipated; what the trapezoidal rule leaves falls with the square of the step.
#[test]
fn the_field_stores_what_it_takes() {
    let elastic = "Hencky(young: 1000, poisson: 0.3, gradient: (driver: Strain, modulus: 3000, length: 0.7))";
    let left = |steps: u32| {
        let text = VARYING.replace("LAW", elastic).replace("FORCE", "40, 0");
        let seen = run(&text.replace("STEPS", &steps.to_string()));
        seen.last("energy/unbalanced") / seen.last("energy/elastic")
    };
    let (coarse, fine) = (left(4), left(8));
    assert!(fine.abs() < 2e-3 && (coarse / fine - 4.0).abs() < 1.2, "{coarse:e} {fine:e}");
}

#[test]
fn a_block_yields_and_its_run_goes_on_through_the_softening() {
    let softening = "undrained_strength: 5, softening: Remoulding(remoulded: 0.5, shear_95: 0.3)";
    let law = format!("VonMises(young: 1000, poisson: 0.3, {softening}, {PLASTIC})");
    let text = VARYING.replace("LAW", &law).replace("FORCE", "3, -2").replace("STEPS", "6");
    let seen = run(&text);
    assert!(seen.field.iter().any(|k| *k > 1e-5), "{:?}", seen.field);
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
    let iterative = plane.replace("LAW", &law(PLASTIC)).replace("schedule:", "solver: Iterative, schedule:");
    assert_eq!(
        refused(&iterative),
        "materials.m.gradient: multigrid does not take a nodal field: expected `solver: Auto` or `Direct`"
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

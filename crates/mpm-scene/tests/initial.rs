//! Bodies that begin under stress, and points with parameters of their own.

use mpm_scene::{Compiled, NamedColumns, PointTable, Scene, SceneFiles, compile, compile_with};
use mpm_solver::State;
use mpm_solver::observe::{Field, LoadStep, Moment, Observer, ObserverError};

const HEIGHT: f64 = 10.0;

const LAWS: [(&str, &str); 9] = [
    ("Hencky", "Hencky(young: 1e4, poisson: 0.3, density: 2)"),
    ("neo-Hooke", "NeoHooke(young: 1e4, poisson: 0.3, density: 2)"),
    ("von Mises", "VonMises(young: 1e4, poisson: 0.49, undrained_strength: 60, density: 2)"),
    (
        "Tresca",
        "Tresca(young: Linear(at: 10, value: 5e3, gradient: 800), poisson: 0.49, \
         undrained_strength: Linear(at: 10, value: 5, gradient: 5), density: 2)",
    ),
    (
        "Mohr-Coulomb",
        "MohrCoulomb(young: 1e4, poisson: 0.2, cohesion: 0, friction: 30, dilation: 5, tensile_strength: 0, density: 2)",
    ),
    (
        "Drucker-Prager",
        "DruckerPrager(young: 1e4, poisson: 0.2, cone: Matched(at: PlaneStrain, cohesion: 0, friction: 35, dilation: 5), \
         density: 2)",
    ),
    (
        "Cam-Clay",
        "CamClay(critical_ratio: 1.05, compression: 0.12, swelling: 0.025, shear_ratio: 30, reference_pressure: 50, \
         preconsolidation: 1e3, density: 2)",
    ),
    (
        "Cam-Clay with water",
        "CamClay(critical_ratio: 1.05, compression: 0.12, swelling: 0.025, shear: 2000, reference_pressure: 50, \
         preconsolidation: 1e3, fluid_bulk: 1e5, density: 2)",
    ),
    (
        "Mohr-Coulomb with water",
        "MohrCoulomb(young: 1e4, poisson: 0.2, cohesion: Layers([(top: 10, value: 1), (top: 4, value: 3)]), friction: 30, \
         dilation: 0, fluid_bulk: 5e5, density: 2)",
    ),
];

fn plane(basis: &str, law: &str, initial: &str) -> String {
    format!(
        r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 10, cells: 5)]),
    basis: {basis},
    materials: {{ "soil": {law} }},
    bodies: [(name: "ground", material: "soil", shape: Box(from: (0, 0), to: (2, 10)), points_per_cell: 2,
        mean_dilatation: Points, initial: {initial})],
    supports: [
        (name: "base", region: Plane(axis: Y, at: 0), fix: [Y]),
        (name: "left", region: Plane(axis: X, at: 0), fix: [X]),
        (name: "right", region: Plane(axis: X, at: 2), fix: [X]),
    ],
    loads: [BodyForce(acceleration: (0, -10), ramp: [(0, 1)])],
    schedule: (steps: 2),
    output: (fields: [Displacement, CauchyStress, DeformationGradient], energies: true),
)"#
    )
}

fn solid(basis: &str, law: &str, initial: &str) -> String {
    format!(
        r#"Solid(
    mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 10, cells: 5)]),
    basis: {basis},
    materials: {{ "soil": {law} }},
    bodies: [(name: "ground", material: "soil", shape: Box(from: (0, 0, 0), to: (2, 2, 10)), points_per_cell: 2,
        initial: {initial})],
    supports: [
        (name: "base", region: Plane(axis: Z, at: 0), fix: [Z]),
        (name: "left", region: Plane(axis: X, at: 0), fix: [X]),
        (name: "right", region: Plane(axis: X, at: 2), fix: [X]),
        (name: "front", region: Plane(axis: Y, at: 0), fix: [Y]),
        (name: "back", region: Plane(axis: Y, at: 2), fix: [Y]),
    ],
    loads: [BodyForce(acceleration: (0, 0, -10), ramp: [(0, 1)])],
    schedule: (steps: 1),
    output: (fields: [Displacement, CauchyStress, DeformationGradient]),
)"#
    )
}

const AT_REST: &str = "Geostatic(surface: 10, unit_weight: 20, k0: 0.6)";

/// Largest displacement of any step, stresses before and after, states.
#[derive(Default)]
struct Seen {
    moved: f64,
    first: Vec<f64>,
    last: Vec<f64>,
    positions: Vec<f64>,
    remembered: Vec<(&'static str, Vec<f64>)>,
    fields: Vec<Field>,
    states: Vec<State>,
}

impl Observer for Seen {
    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        let displacement = step.fields.field(Field::DISPLACEMENT);
        self.moved = displacement.iter().fold(self.moved, |most, u| most.max(u.abs()));
        self.last = step.fields.field(Field::CAUCHY_STRESS);
        if step.index == 0 {
            self.first.clone_from(&self.last);
            self.positions = step.fields.positions();
            self.remembered = self.fields.iter().map(|&it| (it.name(), step.fields.field(it))).collect();
        }
        Ok(())
    }

    fn save(&mut self, at: Moment, state: &dyn Fn() -> State) -> Result<(), ObserverError> {
        if matches!(at, Moment::Step(_)) {
            self.states.push(state());
        }
        Ok(())
    }
}

fn run(text: &str) -> Seen {
    let scene = Scene::from_ron(text).unwrap_or_else(|error| panic!("{error}: {text}"));
    let mut seen = Seen::default();
    let mut compiled = compile(&scene).unwrap_or_else(|error| panic!("{error}: {text}"));
    compiled.run(&mut seen).unwrap_or_else(|error| panic!("{error}: {text}"));
    seen
}

#[test]
fn ground_at_rest_does_not_move() {
    for (name, law) in LAWS {
        for basis in ["Smpm", "Gimp", "Cpdi1", "Cpdi2q", "Cpdi2t"] {
            let seen = run(&plane(basis, law, AT_REST));
            assert!(seen.moved < 1e-12 * HEIGHT, "{name}, {basis}: {:e}", seen.moved);
            let largest = 20.0 * HEIGHT;
            let change =
                seen.first.iter().zip(&seen.last).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
            assert!(change < 1e-10 * largest, "{name}, {basis}: {change:e}");
        }
    }
    for (name, law) in [LAWS[0], LAWS[4], LAWS[6]] {
        for basis in ["Smpm", "Gimp", "Cpdi2Hexahedron"] {
            let seen = run(&solid(basis, law, AT_REST));
            assert!(seen.moved < 1e-12 * HEIGHT, "{name}, {basis}: {:e}", seen.moved);
        }
    }
}

/// A traction acts on the surface itself, so that it balances a stress that is constant over the depth.
#[test]
fn ground_under_a_surcharge_does_not_move() {
    let loaded = "Geostatic(surface: 10, unit_weight: 20, k0: 0.6, surcharge: 5)";
    for (name, law) in [LAWS[0], LAWS[4], LAWS[6]] {
        for basis in ["Smpm", "Cpdi1"] {
            let text = plane(basis, law, loaded).replace(
                "loads: [",
                "loads: [Traction(body: \"ground\", axis: Y, at: 10, resultant: (0, -10), ramp: [(0, 1)]), ",
            );
            let seen = run(&text);
            assert!(seen.moved < 1e-12 * HEIGHT, "{name}, {basis}: {:e}", seen.moved);
        }
    }
}

#[test]
fn the_stress_is_that_of_the_depth() {
    let layered = "Geostatic(surface: 10, unit_weight: Layers([(top: 10, value: 8), (top: 4, value: 11)]), \
                   k0: Linear(at: 10, value: 0.5, gradient: 0.01), surcharge: 3)";
    let seen = run(&plane("Smpm", LAWS[0].1, layered)
        .replace("BodyForce(acceleration: (0, -10)", "BodyForce(acceleration: (0, -0.0)"));
    let points = seen.first.len() / 9;
    for p in 0..points {
        let height = seen.positions[3 * p + 1];
        let vertical = -3.0 - 8.0 * (10.0 - height).min(6.0) - 11.0 * (4.0 - height).max(0.0);
        let k0 = 0.5 + 0.01 * (10.0 - height);
        let stress = &seen.first[9 * p..9 * p + 9];
        for (found, expected) in [(stress[4], vertical), (stress[0], k0 * vertical), (stress[8], k0 * vertical)]
        {
            assert!((found - expected).abs() < 1e-11 * 80.0, "{height}: {found} {expected}");
        }
    }
}

/// The first points' values of the fields that a law remembers.
fn remembered(text: &str, files: &dyn SceneFiles) -> (Vec<f64>, Vec<(&'static str, Vec<f64>)>) {
    let scene = Scene::from_ron(text).unwrap_or_else(|error| panic!("{error}: {text}"));
    let mut compiled = compile_with(&scene, files).unwrap_or_else(|error| panic!("{error}: {text}"));
    let (Scene::PlaneStrain(_), Compiled::Plane(model)) = (&scene, &compiled) else { panic!("a plane scene") };
    let fields = model.bodies[0].body.history_fields().into_iter().map(Field::from).collect();
    let mut seen = Seen { fields, ..Seen::default() };
    compiled.run(&mut seen).unwrap_or_else(|error| panic!("{error}: {text}"));
    (seen.positions, seen.remembered)
}

#[test]
fn points_carry_their_parameters_and_record_them() {
    let (positions, fields) = remembered(&plane("Gimp", LAWS[3].1, AT_REST), &Files);
    let names: Vec<_> = fields.iter().map(|field| field.0).collect();
    assert_eq!(names, ["plastic_shear", "young", "undrained_strength"]);
    for (p, strength) in fields[2].1.iter().enumerate() {
        let depth = 10.0 - positions[3 * p + 1];
        assert!((strength - (5.0 + 5.0 * depth)).abs() < 1e-12 * strength);
        assert!((fields[1].1[p] - (5e3 + 800.0 * depth)).abs() < 1e-11 * 1e4);
    }
    // The whole past of an over-consolidated clay.
    let clay = "Geostatic(surface: 10, unit_weight: 20, k0: 0.9, over_consolidation: 2)";
    let (positions, fields) = remembered(&plane("Smpm", LAWS[6].1, clay), &Files);
    let lambda = 3.0 * (1.0 - 0.025 / 0.12);
    let eta: f64 = 0.5 * ((lambda * lambda + 4.0 * 1.05 * 1.05_f64).sqrt() - lambda);
    for (p, found) in fields[0].1.iter().enumerate() {
        let vertical = 2.0 * 20.0 * (10.0 - positions[3 * p + 1]);
        let k0 = (3.0 - eta) / (3.0 + 2.0 * eta);
        let mean = vertical * (1.0 + 2.0 * k0) / 3.0;
        let expected = mean * (1.0 + eta * eta / (1.05 * 1.05));
        assert!((found - expected).abs() < 1e-10 * expected, "{found} {expected}");
    }
}

/// Tables of numbers by name.
struct Files;

impl SceneFiles for Files {
    fn surface(&self, file: &str) -> Result<mpm_geometry::Surface, String> {
        Err(format!("{file} is none"))
    }

    fn points(&self, file: &str, _dimensions: usize) -> Result<PointTable, String> {
        Err(format!("{file} is none"))
    }

    fn columns(&self, file: &str) -> Result<NamedColumns, String> {
        let columns: &[(&str, &[f64])] = match file {
            "depths.csv" => &[("y", &[0.0, 10.0]), ("su", &[60.0, 10.0])],
            "stress.csv" => &[
                ("x", &[1.0, 1.0]),
                ("y", &[2.0, 8.0]),
                ("sxx", &[-3.0, -1.0]),
                ("syy", &[-3.0, -1.0]),
                ("szz", &[-3.0, -1.0]),
                ("sxy", &[0.5, 0.0]),
                ("preconsolidation", &[40.0, 30.0]),
            ],
            _ => return Err(format!("{file} is none")),
        };
        let columns = columns.iter().map(|(name, values)| ((*name).into(), values.to_vec())).collect();
        Ok(NamedColumns { file: file.into(), columns })
    }
}

#[test]
fn tables_give_strengths_and_stresses() {
    let law = r#"Tresca(young: 1e4, poisson: 0.3, undrained_strength: Table(file: "depths.csv", column: "SU"), density: 2)"#;
    let (positions, fields) = remembered(&plane("Smpm", law, AT_REST), &Files);
    for (p, strength) in fields[2].1.iter().enumerate() {
        let expected = 60.0 - 5.0 * positions[3 * p + 1];
        assert!((strength - expected).abs() < 1e-12 * expected);
    }
    let law = LAWS[6].1;
    let text = plane("Smpm", law, r#"Table(file: "stress.csv")"#).replace("density: 2", "density: 1e-9");
    let scene = Scene::from_ron(&text).unwrap();
    let Compiled::Plane(model) = compile_with(&scene, &Files).unwrap() else { panic!("a plane scene") };
    let body = &model.bodies[0].body;
    for p in 0..body.n_points() {
        let view = body.point(p);
        let is_low = view.position.y < 5.0;
        let (pressure, shear, before) = if is_low { (-3.0, 0.5, 40.0) } else { (-1.0, 0.0, 30.0) };
        let tau = body.kirchhoff(p);
        assert!((tau.xx - pressure).abs() < 1e-12 && (tau.xy - shear).abs() < 1e-12);
        let mut history = Vec::new();
        body.history(p, &mut history);
        assert_eq!(history, [before]);
    }
}

#[test]
fn random_strengths_are_the_same_again() {
    let law = "VonMises(young: 1e4, poisson: 0.3, undrained_strength: Random(mean: 80, variation: 0.2, \
               correlation_length: 4, vertical_correlation_length: 1, seed: 3), density: 2)";
    let once = remembered(&plane("Smpm", law, AT_REST), &Files);
    assert_eq!(once, remembered(&plane("Smpm", law, AT_REST), &Files));
    let radii = &once.1[2].1;
    assert!(radii.iter().any(|radius| (radius / radii[0] - 1.0).abs() > 0.05));
    let other = remembered(&plane("Smpm", &law.replace("seed: 3", "seed: 4"), AT_REST), &Files);
    assert_ne!(once.1, other.1);
}

#[test]
fn what_cannot_begin_is_refused_with_point_and_depth() {
    let error = |law: &str, initial: &str| {
        let scene = Scene::from_ron(&plane("Smpm", law, initial)).unwrap();
        compile_with(&scene, &Files).err().expect("it cannot begin").to_string()
    };
    let sand = LAWS[4].1;
    let said = error(sand, "Geostatic(surface: 10, unit_weight: 20, k0: 0.3)");
    assert!(
        said.starts_with(
            "bodies[0].initial: the point (0.25, 0.5), 9.5 below the surface, cannot begin under the stress"
        ) && said.ends_with("the law yields under it"),
        "{said}"
    );
    assert!(
        error(sand, "Geostatic(surface: 10, unit_weight: 20, k0: 3.1)").ends_with("the law yields under it")
    );
    let said = error(sand, "Geostatic(surface: 9, unit_weight: 20, k0: 0.5)");
    assert_eq!(said, "bodies[0].initial: at the point (0.25, 9.5): it lies above the surface at 9");
    let said = error(sand, "Geostatic(surface: 10, unit_weight: 20, k0: 0.5, over_consolidation: 2)");
    assert!(
        said.starts_with("bodies[0].initial.over_consolidation: the law of the body remembers no"),
        "{said}"
    );
    let said = error(LAWS[6].1, "Stress(xx: 1, yy: 0, zz: 0)");
    assert!(said.ends_with("the law bears mean pressure above 0 only"), "{said}");
    let said = error(LAWS[0].1, r#"Table(file: "depths.csv")"#);
    assert!(said.contains("depths.csv has no column `x`; it has y, su"), "{said}");
    // |1 − K₀| γ z ≤ 2 s_u.
    let weak = "Tresca(young: 1e4, poisson: 0.3, undrained_strength: 37, density: 2)";
    assert!(error(weak, AT_REST).contains("cannot begin under the stress"), "{}", error(weak, AT_REST));
    let said = error(
        "Tresca(young: 1e4, poisson: 0.3, undrained_strength: Linear(at: 10, value: 1, gradient: -2), density: 2)",
        AT_REST,
    );
    let expected =
        "materials.soil.undrained_strength: at the point (0.25, 0.5): undrained_strength is -18, expected";
    assert!(said.starts_with(expected), "{said}");
}

/// What `mpm check` remarks on.
#[test]
fn a_stress_that_does_not_balance_is_told_with_its_size() {
    let remarks = |law: &str, initial: &str| {
        compile(&Scene::from_ron(&plane("Smpm", law, initial)).unwrap()).unwrap().estimate().unwrap().remarks
    };
    for (name, law) in LAWS {
        assert_eq!(remarks(law, AT_REST), Vec::<String>::new(), "{name}");
    }
    let heavy = remarks(LAWS[0].1, "Geostatic(surface: 10, unit_weight: 60, k0: 0.6)");
    assert_eq!(heavy.len(), 1, "{heavy:?}");
    let said = "the initial stress does not balance the loads at load fraction 0: 0.";
    assert!(
        heavy[0].starts_with(said) && heavy[0].contains(" of its forces are left, most at x = "),
        "{heavy:?}"
    );
    // Nothing begins under stress, so that nothing has to balance.
    let text = plane("Smpm", LAWS[0].1, AT_REST).replace(&format!(", initial: {AT_REST}"), "");
    let estimate =
        compile(&Scene::from_ron(&text.replace(", ramp: [(0, 1)]", "")).unwrap()).unwrap().estimate();
    assert!(!estimate.unwrap().remarks.iter().any(|remark| remark.contains("initial stress")));
}

#[test]
fn cells_with_one_point_are_told_of_where_it_begins_under_stress() {
    let is_told = |text: &str| {
        let remarks = compile(&Scene::from_ron(text).unwrap()).unwrap().estimate().unwrap().remarks;
        remarks.iter().any(|remark| remark.contains("with one material point in most of its cells"))
    };
    let two = plane("Cpdi1", LAWS[0].1, AT_REST);
    let one = two.replace("points_per_cell: 2", "points_per_cell: 1");
    assert!(is_told(&one) && !is_told(&two));
    assert!(!is_told(&one.replace(&format!(", initial: {AT_REST}"), "")), "no stress, no growth");
}

#[test]
fn a_resumed_run_is_the_same() {
    let text = plane("Gimp", LAWS[3].1, AT_REST)
        .replace("ramp: [(0, 1)]", "ramp: [(0, 1), (1, 1.2)]")
        .replace("energies: true", "energies: true, checkpoint: (every: 1)");
    let text = text.replace("schedule: (steps: 2)", "schedule: (steps: 4)");
    let compiled = || compile(&Scene::from_ron(&text).unwrap()).unwrap();
    let mut whole = Seen::default();
    compiled().run(&mut whole).unwrap();
    assert!(whole.moved > 1e-3);
    let mut rest = Seen::default();
    compiled().resume(&whole.states[1], &mut rest).unwrap();
    assert_eq!(
        rest.last.iter().map(|x| x.to_bits()).collect::<Vec<_>>(),
        whole.last.iter().map(|x| x.to_bits()).collect::<Vec<_>>()
    );
}

#[test]
fn energies_balance_from_the_stress_at_the_start() {
    // What was stored before is not taken for work.
    struct Unbalanced(Vec<f64>, usize);
    impl Observer for Unbalanced {
        fn start(&mut self, run: &mpm_solver::observe::RunStart) -> Result<(), ObserverError> {
            self.1 =
                run.columns.iter().position(|it| it.name.contains("unbalanced")).ok_or("no such column")?;
            Ok(())
        }

        fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
            if let mpm_solver::observe::Entry::Real(values) = &step.row[self.1] {
                self.0.extend(values);
            }
            Ok(())
        }
    }
    for (name, law) in LAWS {
        let text = plane("Smpm", law, AT_REST);
        let mut seen = Unbalanced(Vec::new(), 0);
        compile(&Scene::from_ron(&text).unwrap()).unwrap().run(&mut seen).unwrap();
        assert!(seen.0.iter().all(|energy| energy.abs() < 1e-9), "{name}: {:?}", seen.0);
    }
}

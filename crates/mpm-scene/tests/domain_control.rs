//! Domains that outgrow their cells, in whole runs.

use mpm_scene::Scene;
use mpm_scene::compile;
use mpm_solver::observe::{Entry, Field, LoadStep, Observer, ObserverError, RunStart};
use mpm_solver::{Error, Summary};

/// One column of the history, the points, and one field at the end.
struct Seen {
    column: &'static str,
    at: usize,
    names: Vec<String>,
    values: Vec<f64>,
    positions: Vec<f64>,
    field: Field,
    at_end: Vec<f64>,
}

impl Seen {
    fn of(column: &'static str, field: Field) -> Self {
        let (names, values, positions, at_end) = Default::default();
        Self { column, at: 0, names, values, positions, field, at_end }
    }
}

impl Observer for Seen {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        self.names = run.columns.iter().map(|column| column.name.clone()).collect();
        self.at = self.names.iter().position(|name| name == self.column).ok_or("no such column")?;
        Ok(())
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        self.values.push(match &step.row[self.at] {
            Entry::Real(values) => values[0],
            Entry::Count(values) => values[0] as f64,
        });
        self.positions = step.fields.positions();
        self.at_end = step.fields.field(self.field);
        Ok(())
    }
}

fn text(name: &str, changes: &[(&str, &str)]) -> String {
    let path = format!("{}/../../scenes/{name}.ron", env!("CARGO_MANIFEST_DIR"));
    let mut text = std::fs::read_to_string(path).unwrap();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    text
}

fn run(text: &str, seen: &mut Seen) -> Result<Summary, Error> {
    compile(&Scene::from_ron(text).unwrap()).unwrap().run(seen)
}

const TWIST: (&str, &str) = ("inner: 180", "inner: 20");
const STEPS: (&str, &str) = ("steps: 180", "steps: 20");

#[test]
fn domains_that_stay_short_change_no_bit() {
    let ring = [("basis: Smpm", "basis: Cpdi1")];
    let cases = [
        ("doughnut_elastic", "reaction_moment/inner", &ring[..], "Cpdi1"),
        ("column", "residual", &[], "Gimp"),
    ];
    for (name, column, changes, basis) in cases {
        let plain = text(name, changes);
        let mut expected = Seen::of(column, Field::CAUCHY_STRESS);
        run(&plain, &mut expected).unwrap();
        for control in ["Cap()", "Reshape()", "Split()"] {
            let on = format!("basis: {basis}, domains: (control: {control})");
            let mut found = Seen::of(column, Field::CAUCHY_STRESS);
            let summary = run(&plain.replace(&format!("basis: {basis}"), &on), &mut found).unwrap();
            assert_eq!((summary.domains_capped, summary.domains_split), (0, 0), "{name}, {control}");
            assert_eq!(found.values, expected.values, "{name}, {control}");
            assert_eq!(found.positions, expected.positions, "{name}, {control}");
            assert_eq!(found.at_end, expected.at_end, "{name}, {control}");
            assert_eq!(found.names.len(), expected.names.len() + 1, "one column more");
        }
    }
}

#[test]
fn what_is_done_is_counted_and_keeps_the_volume() {
    for (control, column) in
        [("Cap()", "domains_capped"), ("Reshape()", "domains_capped"), ("Split()", "domains_split")]
    {
        let scene = text("doughnut_limit", &[TWIST, STEPS, ("Reshape(cells: 0.7)", control)]);
        let mut seen = Seen::of(column, Field::VOLUME);
        let summary = run(&scene, &mut seen).unwrap();
        let counted: f64 = seen.values.iter().sum();
        assert!(counted > 0.0);
        assert_eq!(counted as u64, summary.domains_capped + summary.domains_split);
        assert_eq!(summary.points > 640, column == "domains_split");
        assert_eq!(seen.positions.len(), 3 * summary.points);
        let polygon = 16.0 * (std::f64::consts::PI / 16.0).sin() * 75.0;
        let volume: f64 = seen.at_end.iter().sum();
        assert!((volume / polygon - 1.0).abs() < 0.01, "{volume} of {polygon}");
    }
}

#[test]
fn threads_change_nothing() {
    let scene = text("doughnut_limit", &[TWIST, STEPS, ("Reshape", "Split")]);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut seen = Seen::of("reaction_moment/inner", Field::CAUCHY_STRESS);
        pool.install(|| run(&scene, &mut seen)).unwrap();
        (seen.values, seen.positions, seen.at_end)
    };
    let alone = on(1);
    assert!(alone.1.len() > 3 * 640, "no point was split");
    assert!(on(3) == alone);
}

#[test]
fn too_many_points_end_the_run_with_their_reason() {
    let scene = text("doughnut_limit", &[TWIST, STEPS, ("Reshape(cells: 0.7)", "Split(growth: 1.1)")]);
    let mut seen = Seen::of("domains_split", Field::VOLUME);
    let error = run(&scene, &mut seen).unwrap_err();
    let Error::TooManyPoints { step, ref body, points, most } = error else { panic!("{error}") };
    assert_eq!((body.as_str(), most), ("ring", 704));
    assert!((640..=704).contains(&points));
    // The step that converged is in the record, with the points as they were.
    assert_eq!((seen.values.len(), seen.positions.len()), (step + 1, 3 * points));
}

/// A block sheared with its mesh, the points split after the first of four steps.
#[test]
fn a_uniform_deformation_of_split_points_is_found_exactly() {
    let follow = |axis: &str, at: u32| {
        format!("(name: \"{axis}{at}\", region: Plane(axis: {axis}, at: {at}), follow_mesh: [X, Y])")
    };
    let corner = |x: u32, y: u32, ux: f64, uy: f64| format!("(corner: ({x}, {y}), displacement: ({ux}, {uy}))");
    for basis in ["Cpdi1", "Cpdi2q", "Cpdi2t"] {
        for law in
            ["Hencky(young: 1000, poisson: 0.3)", "VonMises(young: 1000, poisson: 0.3, yield_radius: 50)"]
        {
            let scene = format!(
                "PlaneStrain(
                    mesh: Box(axes: [Uniform(from: 0, to: 4, cells: 4), Uniform(from: 0, to: 4, cells: 4)]),
                    motion: Corners([{}, {}, {}]),
                    basis: {basis}, domains: (control: Split(cells: 0.4)),
                    materials: {{ \"m\": {law} }},
                    bodies: [(name: \"b\", material: \"m\", shape: Box(from: (0, 0), to: (4, 4)), points_per_cell: 2)],
                    supports: [{}, {}, {}, {}],
                    schedule: (steps: 4),
                    output: (fields: [DeformationGradient]),
                )",
                corner(4, 0, 0.8, -0.4),
                corner(0, 4, 1.2, 0.4),
                corner(4, 4, 2.0, 0.0),
                follow("X", 0),
                follow("X", 4),
                follow("Y", 0),
                follow("Y", 4)
            );
            let mut seen = Seen::of("domains_split", Field::DEFORMATION_GRADIENT);
            let summary = run(&scene, &mut seen).unwrap();
            assert!(seen.values[1] == 64.0 && summary.points > 128, "{basis}: {:?}", seen.values);
            let expected = [1.2, 0.3, 0.0, -0.1, 1.1, 0.0, 0.0, 0.0, 1.0];
            for f in seen.at_end.chunks_exact(9) {
                let off = f.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(off < 1e-9, "{basis}, {law}: F is off by {off:e}");
            }
        }
    }
}

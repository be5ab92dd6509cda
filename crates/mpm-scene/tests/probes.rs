//! Probes and energies in the history, against what they stand for.

use mpm_scene::Scene;
use mpm_scene::{Compiled, compile};
use mpm_solver::State;
use mpm_solver::observe::{Column, Entry, Field, LoadStep, Moment, Observer, ObserverError, RunStart};

/// Columns and rows, and the points at the end.
#[derive(Default)]
struct Seen {
    columns: Vec<Column>,
    rows: Vec<Vec<Entry>>,
    positions: Vec<f64>,
    stress: Vec<f64>,
    volume: Vec<f64>,
    /// The state after this load step.
    wanted: Option<usize>,
    state: Option<State>,
}

impl Observer for Seen {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        self.columns = run.columns.clone();
        Ok(())
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        self.rows.push(step.row.to_vec());
        self.positions = step.fields.positions();
        self.stress = step.fields.field(Field::CAUCHY_STRESS);
        self.volume = step.fields.field(Field::VOLUME);
        Ok(())
    }

    fn save(&mut self, at: Moment, state: &dyn Fn() -> State) -> Result<(), ObserverError> {
        if self.wanted.map(Moment::Step) == Some(at) {
            self.state = Some(state());
        }
        Ok(())
    }
}

impl Seen {
    fn of(text: &str) -> Self {
        let mut seen = Self::default();
        compiled(text).run(&mut seen).unwrap();
        seen
    }

    fn row(&self, row: usize, name: &str) -> Vec<f64> {
        let at = self.columns.iter().position(|column| column.name == name);
        match &self.rows[row][at.unwrap_or_else(|| panic!("no column {name}"))] {
            Entry::Real(values) => values.clone(),
            Entry::Count(values) => values.iter().map(|n| *n as f64).collect(),
        }
    }

    fn last(&self, name: &str) -> Vec<f64> {
        self.row(self.rows.len() - 1, name)
    }
}

fn compiled(text: &str) -> Compiled {
    compile(&Scene::from_ron(text).unwrap()).unwrap()
}

/// A square of `LAW`, pulled to twice its length on rollers.
fn pulled(law: &str, steps: usize) -> String {
    format!(
        r#"PlaneStrain(
        mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 2, cells: 2)]),
        motion: Stretch([(axis: X, anchor: 0, driven: 2, displacement: 2)]),
        basis: Smpm,
        materials: {{ "metal": {law} }},
        bodies: [(name: "square", material: "metal", shape: Box(from: (0, 0), to: (2, 2)), points_per_cell: 2)],
        supports: [
            (name: "left", region: Plane(axis: X, at: 0), fix: [X]),
            (name: "sides", region: Everywhere, fix: [Y]),
            (name: "pulled", region: Plane(axis: X, at: 2), follow_mesh: [X]),
        ],
        probes: [
            (name: "corner", body: "square", points: Near(2, 2)),
            (name: "right", body: "square", points: Within(from: (1, 0), to: (2, 2))),
            (name: "all", body: "square", points: All),
        ],
        schedule: (steps: {steps}),
        output: (energies: true, fields: [CauchyStress]),
    )"#
    )
}

const ELASTIC: &str = "Hencky(young: 1e3, poisson: 0.3)";
const PLASTIC: &str = "VonMises(young: 1e3, poisson: 0.3, yield_radius: 300)";

#[test]
fn probes_are_means_of_their_points() {
    let seen = Seen::of(&pulled(PLASTIC, 10));
    let n = seen.volume.len();
    assert_eq!(seen.row(0, "probe/corner/position"), [1.75, 1.75]);
    assert_eq!(seen.row(0, "probe/right/position"), [1.5, 1.0]);
    assert_eq!(seen.row(0, "probe/all/displacement"), [0.0, 0.0]);
    // A homogeneous stretch by two.
    let near = |found: &[f64], expected: &[f64]| {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?} {expected:?}");
    };
    near(&seen.last("probe/corner/position"), &[3.5, 1.75]);
    near(&seen.last("probe/right/displacement"), &[1.5, 0.0]);
    let volume: f64 = seen.volume.iter().sum();
    for c in 0..9 {
        let sum: f64 = (0..n).map(|point| seen.stress[9 * point + c] * seen.volume[point]).sum();
        let mean = seen.last("probe/all/cauchy_stress")[c];
        assert!((mean - sum / volume).abs() < 1e-10 * 1e3, "{c}: {mean} {}", sum / volume);
    }
    assert!(seen.last("probe/all/cauchy_stress")[0] > 100.0);
}

/// ψ = ½ (λ + 2G) (ln λ)² on a volume of four.
#[test]
fn elastic_energy_is_the_potential() {
    let seen = Seen::of(&pulled(ELASTIC, 10));
    let (e, nu) = (1e3, 0.3);
    let modulus = e * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu));
    for row in 0..=10 {
        let stretch = 1.0 + row as f64 / 10.0;
        let expected = 4.0 * 0.5 * modulus * f64::ln(stretch).powi(2);
        let found = seen.row(row, "energy/elastic")[0];
        assert!((found - expected).abs() <= 1e-10 * 4.0 * modulus, "{row}: {found} {expected}");
        assert_eq!(seen.row(row, "energy/dissipated"), [0.0]);
    }
}

/// What is left of the work falls with the square of the load step, elastic and plastic.
#[test]
fn energies_balance() {
    for law in [ELASTIC, PLASTIC] {
        let unbalanced = [10, 20, 40].map(|steps| {
            let seen = Seen::of(&pulled(law, steps));
            let work = seen.last("energy/external_work")[0];
            let parts = seen.last("energy/elastic")[0] + seen.last("energy/dissipated")[0];
            let rest = seen.last("energy/unbalanced")[0];
            assert!((work - parts - rest).abs() < 1e-9 * work && work > 0.0);
            assert_eq!(law == PLASTIC, seen.last("energy/dissipated")[0] > 0.1 * work);
            rest.abs() / work
        });
        assert!(unbalanced[2] < 2e-3, "{law}: {unbalanced:?}");
        let rates = [unbalanced[0] / unbalanced[1], unbalanced[1] / unbalanced[2]].map(f64::log2);
        assert!(rates.iter().all(|rate| *rate > 1.6), "{law}: {unbalanced:?} {rates:?}");
    }
}

/// A force on the points instead of a support: a beam bent far.
#[test]
fn the_work_of_loads_is_counted() {
    let beam = |steps: usize| {
        format!(
            r#"PlaneStrain(
            mesh: Box(axes: [Uniform(from: 0, to: 6, cells: 12), Uniform(from: -4, to: 2, cells: 12)]),
            basis: Gimp,
            materials: {{ "rubber": Hencky(young: 1e4, poisson: 0.3, density: 1) }},
            bodies: [(name: "beam", material: "rubber", shape: Box(from: (0, 0), to: (4, 1)), points_per_cell: 3)],
            supports: [(name: "clamp", region: Plane(axis: X, at: 0), fix: [X, Y])],
            loads: [
                Traction(body: "beam", axis: X, at: 4, resultant: (0, -10)),
                BodyForce(acceleration: (0, -1)),
            ],
            schedule: (steps: {steps}),
            output: (energies: true),
        )"#
        )
    };
    let unbalanced = [5, 10, 20].map(|steps| {
        let seen = Seen::of(&beam(steps));
        seen.last("energy/unbalanced")[0].abs() / seen.last("energy/external_work")[0]
    });
    assert!(unbalanced[2] < 1e-2 && unbalanced[2] < unbalanced[0], "{unbalanced:?}");
}

#[test]
fn sums_go_on_where_a_run_is_resumed() {
    let text = pulled(PLASTIC, 6);
    let mut whole = Seen { wanted: Some(4), ..Seen::default() };
    compiled(&text).run(&mut whole).unwrap();
    let mut rest = Seen::default();
    compiled(&text).resume(&whole.state.take().unwrap(), &mut rest).unwrap();
    for name in ["energy/dissipated", "energy/external_work", "energy/unbalanced", "probe/corner/displacement"]
    {
        let bits = |values: Vec<f64>| values.into_iter().map(f64::to_bits).collect::<Vec<_>>();
        assert_eq!(bits(rest.last(name)), bits(whole.last(name)), "{name}");
    }
}

#[test]
fn what_is_not_asked_for_is_not_there() {
    let text = pulled(ELASTIC, 1).replace("energies: true, ", "");
    let start = text.find("        probes:").unwrap();
    let end = text.find("        schedule:").unwrap();
    let seen = Seen::of(&format!("{}{}", &text[..start], &text[end..]));
    assert!(
        seen.columns.iter().all(|column| !column.name.contains("energy") && !column.name.contains("probe"))
    );
}

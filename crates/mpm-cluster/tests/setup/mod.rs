//! Scenes run by one rank and by several.

#![allow(dead_code)]

use mpm_cluster::{Bordered, Cluster, Gathered, Threads, Whole, on_threads};
use mpm_material::FieldInfo;
use mpm_scene::{Compiled, Scene, compile};
use mpm_solver::observe::{Entry, Field, LoadStep, Moment, Observer, ObserverError, Resumed, RunStart};
use mpm_solver::{Error, Model, State, Summary, resume_on, run_on};
use std::fs;
use std::path::Path;
use std::rc::Rc;

/// What a run leaves.
#[derive(Clone, Debug, Default)]
pub struct Seen {
    /// The name of the column of every number in a row.
    pub columns: Vec<String>,
    /// Every row of the history, but for its seconds.
    pub rows: Vec<Vec<f64>>,
    /// Of the last load step.
    pub positions: Vec<f64>,
    /// Relative out-of-balance forces of every load step.
    pub residuals: Vec<Vec<f64>>,
    pub stress: Vec<f64>,
    pub strain: Vec<f64>,
    pub volume: Vec<f64>,
    /// What tools tell of the points.
    pub contact: Vec<f64>,
    pub outlines: Vec<Vec<[f64; 3]>>,
    /// States that were kept, after these load steps.
    pub keep_after: Vec<usize>,
    /// The row that cannot be written.
    pub fails_at: Option<usize>,
    pub states: Vec<State>,
}

/// What tools tell of the points.
const CONTACT: [FieldInfo; 3] = [
    FieldInfo { name: "contact_force", components: 3, unit: "F" },
    FieldInfo { name: "contact_gap", components: 1, unit: "L" },
    FieldInfo { name: "contact_slip", components: 1, unit: "L" },
];

impl Seen {
    fn keeping(keep_after: &[usize]) -> Self {
        Self { keep_after: keep_after.to_vec(), ..Self::default() }
    }
}

impl Observer for Seen {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        let names = run.columns.iter().flat_map(|it| std::iter::repeat_n(it.name.clone(), it.width));
        self.columns = names.collect();
        Ok(())
    }

    fn resume(&mut self, run: &RunStart, _: &Resumed) -> Result<(), ObserverError> {
        self.start(run)
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        if self.fails_at == Some(self.rows.len()) {
            return Err("no space is left on the disk".into());
        }
        let numbers = |entry: &Entry| match entry {
            Entry::Count(values) => values.iter().map(|&n| n as f64).collect(),
            Entry::Real(values) => values.clone(),
        };
        self.rows.push(step.row.iter().flat_map(numbers).collect());
        self.residuals.push(step.residuals.to_vec());
        self.positions = step.fields.positions();
        self.stress = step.fields.field(Field::CAUCHY_STRESS);
        self.strain = step.fields.field(Field::ELASTIC_STRAIN);
        self.volume = step.fields.field(Field::VOLUME);
        let of_tools = self.columns.iter().any(|it| it.starts_with("tool/"));
        let told = CONTACT.iter().filter(|_| of_tools);
        self.contact = told.flat_map(|&info| step.fields.field(Field::from(info))).collect();
        self.outlines = step.fields.outlines();
        assert_eq!(step.fields.n_points(), self.volume.len());
        Ok(())
    }

    fn save(&mut self, at: Moment, state: &dyn Fn() -> State) -> Result<(), ObserverError> {
        if matches!(at, Moment::Step(step) if self.keep_after.contains(&step)) {
            self.states.push(state());
        }
        Ok(())
    }
}

/// A scene of the repository with parts of its text replaced.
pub fn repository_scene(path: &str, changes: &[(&str, &str)]) -> String {
    let whole = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path);
    let mut text = fs::read_to_string(whole).unwrap();
    for (from, to) in changes {
        assert!(text.contains(from), "{path} has no `{from}`");
        text = text.replace(from, to);
    }
    text
}

pub fn compiled(text: &str) -> Compiled {
    compile(&Scene::from_ron(text).unwrap_or_else(|it| panic!("{it:?}"))).unwrap_or_else(|it| panic!("{it:?}"))
}

/// One rank alone.
pub fn alone(text: &str, keep_after: &[usize]) -> (Seen, Result<Summary, Error>) {
    let mut seen = Seen::keeping(keep_after);
    let summary = compiled(text).run(&mut seen);
    (seen, summary)
}

/// What each of so many ranks sees, where rank 0 sees all, and how the run ended there.
pub fn shared(text: &str, ranks: usize, keep_after: &[usize]) -> Vec<(Seen, Result<Summary, String>)> {
    on_threads(ranks, |wire| match compiled(text) {
        Compiled::Plane(model) => on_rank(model, wire, None, Seen::keeping(keep_after)),
        Compiled::Solid(model) => on_rank(model, wire, None, Seen::keeping(keep_after)),
    })
}

/// The same where this row cannot be written.
pub fn shared_until(text: &str, ranks: usize, fails_at: usize) -> Vec<(Seen, Result<Summary, String>)> {
    on_threads(ranks, |wire| {
        let seen = Seen { fails_at: Some(fails_at), ..Seen::default() };
        match compiled(text) {
            Compiled::Plane(model) => on_rank(model, wire, None, seen),
            Compiled::Solid(model) => on_rank(model, wire, None, seen),
        }
    })
}

/// The same where rank 0 solves for the unknowns of nodes only.
pub fn shared_with_border(text: &str, ranks: usize) -> Vec<(Seen, Result<Summary, String>)> {
    on_threads(ranks, |wire| {
        let Compiled::Plane(mut model) = compiled(text) else { panic!("in the plane") };
        let mut seen = Seen::default();
        let cluster = Cluster::new(wire, &model).with_solver(|model, exchange| {
            let of_nodes = Box::new(Gathered::new(model, exchange.clone()));
            Box::new(Bordered::new(of_nodes, exchange))
        });
        let cluster = Rc::new(cluster);
        let mut whole = cluster.whole(&mut seen);
        let outcome = run_on(&mut model, cluster.clone(), &mut whole);
        (seen, outcome.map_err(|it| it.to_string()))
    })
}

/// The same from a state on.
pub fn resumed(text: &str, ranks: usize, state: &State) -> Vec<(Seen, Result<Summary, String>)> {
    on_threads(ranks, |wire| match compiled(text) {
        Compiled::Plane(model) => on_rank(model, wire, Some(state), Seen::default()),
        Compiled::Solid(model) => on_rank(model, wire, Some(state), Seen::default()),
    })
}

fn on_rank<const D: usize>(
    mut model: Model<D>,
    wire: Threads,
    state: Option<&State>,
    mut seen: Seen,
) -> (Seen, Result<Summary, String>) {
    let cluster = Rc::new(Cluster::new(wire, &model));
    let mut whole: Whole<'_, D, Threads> = cluster.whole(&mut seen);
    let outcome = match state {
        None => run_on(&mut model, cluster.clone(), &mut whole),
        Some(state) => resume_on(&mut model, cluster.clone(), state, &mut whole),
    };
    (seen, outcome.map_err(|it| it.to_string()))
}

/// Asserts that so many ranks find what one finds, in as many iterations, cuts and points.
pub fn check(text: &str, ranks: &[usize]) {
    let (one, summary) = alone(text, &[]);
    let summary = summary.unwrap_or_else(|it| panic!("{it}\n{text}"));
    for &size in ranks {
        let all = shared(text, size, &[]);
        let several = all[0].1.as_ref().unwrap_or_else(|it| panic!("{size} ranks: {it}\n{text}"));
        assert_same(text, (&one, &all[0].0), &format!("{size} ranks"));
        assert_eq!(several.iterations, summary.iterations, "{size} ranks\n{text}");
        let counts = |it: &Summary| (it.steps, it.cuts, it.points);
        assert_eq!(counts(several), counts(&summary), "{size} ranks\n{text}");
    }
}

/// Asserts that a run whose state three ranks keep after a load step goes on with one, two, three and four as one rank goes on alone;
/// what one rank has kept, and what three have.
pub fn check_resumed(text: &str, after: usize) -> [State; 2] {
    let (one, _) = alone(text, &[after]);
    let three = shared(text, 3, &[after]);
    let state = &three[0].0.states[0];
    let rest = Seen { rows: one.rows[after + 1..].to_vec(), ..one.clone() };
    for size in [1, 2, 3, 4] {
        let later = resumed(text, size, state);
        later[0].1.as_ref().unwrap_or_else(|it| panic!("{size} ranks: {it}\n{text}"));
        assert_same(text, (&rest, &later[0].0), &format!("{size} ranks"));
    }
    let (mut goes_on, mut model) = (Seen::default(), compiled(text));
    model.resume(state, &mut goes_on).unwrap_or_else(|it| panic!("{it}\n{text}"));
    assert_same(text, (&rest, &goes_on), "alone");
    [one.states[0].clone(), state.clone()]
}

/// Largest difference of two lists over the largest entry of both.
pub fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let largest = a.iter().chain(b).fold(f64::MIN_POSITIVE, |most, x| most.max(x.abs()));
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest
}

/// Columns of the history that count what depends on rounding, time, or on who has what.
const NOT_COMPARED: [&str; 8] = [
    "factorization",
    "wall_seconds",
    "residual",
    "backward_error",
    "pivot_spread",
    "refinements",
    "symbolic_reused",
    "linear_iterations",
];

/// Asserts that several ranks have found what one finds: points, history, and Newton iterations.
pub fn assert_same(text: &str, (one, several): (&Seen, &Seen), what: &str) {
    let fields = [
        ("position", &one.positions, &several.positions),
        ("stress", &one.stress, &several.stress),
        ("strain", &one.strain, &several.strain),
        ("volume", &one.volume, &several.volume),
    ];
    for (name, a, b) in fields {
        assert!(apart(a, b) < 1e-9, "{what}: {name} is {:e} apart\n{text}", apart(a, b));
    }
    // Forces of single corners are stiffnesses times differences of positions. Corners of a part of a domain stand halfway
    // between two of before: rounding decides whose slip they go on with.
    let n = one.volume.len() * usize::from(!one.contact.is_empty());
    let of_slip = if text.contains("Split(") { f64::INFINITY } else { 1e-6 };
    for (name, range, within) in
        [("force", 0..3 * n, 1e-6), ("gap", 3 * n..4 * n, 1e-9), ("slip", 4 * n..5 * n, of_slip)]
    {
        let apart = apart(&one.contact[range.clone()], &several.contact[range]);
        assert!(apart < within, "{what}: contact {name} is {apart:e} apart\n{text}");
    }
    let flat = |outlines: &[Vec<[f64; 3]>]| outlines.iter().flatten().flatten().copied().collect::<Vec<f64>>();
    assert!(apart(&flat(&one.outlines), &flat(&several.outlines)) < 1e-9, "{what}: outlines\n{text}");
    assert_eq!(one.rows.len(), several.rows.len(), "{what}: load steps\n{text}");
    let width = one.rows[0].len();
    let names = &one.columns;
    assert_eq!(names.len(), width);
    for (k, name) in names.iter().enumerate().filter(|(_, name)| !NOT_COMPARED.contains(&name.as_str())) {
        let column = |seen: &Seen| seen.rows.iter().map(|row| row[k]).collect::<Vec<f64>>();
        let (a, b) = (column(one), column(several));
        // What balances to rounding is compared with the largest of its kind, and with the stress times an area.
        let kind = |name: &str| name.split('/').next().unwrap_or_default().to_owned();
        let of_kind = |seen: &Seen| {
            let like = (0..width).filter(|&j| kind(&names[j]) == kind(name));
            like.flat_map(|j| seen.rows.iter().map(move |row| row[j].abs())).fold(1e-9, f64::max)
        };
        let size = |values: &[f64]| values.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let least = match kind(name).as_str() {
            "reaction" | "reaction_moment" => 0.1 * size(&one.stress) * size(&one.positions),
            "displacement" | "angle" => size(&one.positions),
            _ => 0.0,
        };
        let most = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(most <= 1e-8 * of_kind(one).max(least), "{what}: {name}: {a:?} and {b:?}\n{text}");
    }
}

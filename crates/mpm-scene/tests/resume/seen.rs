//! Runs that are stopped and go on, compared with those that are not.

use mpm_material::FieldInfo;
use mpm_scene::Scene;
use mpm_scene::{Compiled, compile};
use mpm_solver::observe::{
    Cancellation, Entry, Field, LoadStep, Moment, Observer, ObserverError, Resumed, RunStart,
};
use mpm_solver::{Error, State, Summary};

/// Bits of every row (without its wall seconds), of its residuals and of the points there.
pub type Rows = Vec<Vec<u64>>;

/// What an observer sees of a run.
#[derive(Default)]
pub struct Seen {
    wall: usize,
    /// The column of how the linear systems were solved, and its values.
    method: usize,
    pub methods: Vec<u64>,
    /// Row of the first entry of `rows`.
    pub first: usize,
    pub rows: Rows,
    pub states: Vec<State>,
    pub at_end: Option<State>,
    pub at_stage_ends: Vec<(usize, State)>,
    /// Load step after which the run is asked to stop.
    pub cancel_after: Option<usize>,
    cancellation: Cancellation,
}

impl Observer for Seen {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        let column = |name: &str| run.columns.iter().position(|it| it.name == name).ok_or("no such column");
        (self.wall, self.method) = (column("wall_seconds")?, column("factorization")?);
        Ok(())
    }

    fn resume(&mut self, run: &RunStart, so_far: &Resumed) -> Result<(), ObserverError> {
        self.first = so_far.rows;
        self.start(run)
    }

    fn cancellation(&self) -> Cancellation {
        self.cancellation.clone()
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        assert_eq!(step.index, self.first + self.rows.len());
        let mut bits: Vec<u64> = Vec::new();
        for (_, entry) in step.row.iter().enumerate().filter(|(k, _)| *k != self.wall) {
            match entry {
                Entry::Count(values) => bits.extend(values),
                Entry::Real(values) => bits.extend(values.iter().map(|x| x.to_bits())),
            }
        }
        if let (Entry::Count(method), true) = (&step.row[self.method], step.index > 0) {
            self.methods.extend(method);
        }
        let stress = step.fields.field(Field::CAUCHY_STRESS);
        let mut fields = vec![step.fields.positions(), stress, step.fields.field(Field::DISPLACEMENT)];
        for (name, components) in [("contact_force", 3), ("contact_gap", 1), ("contact_slip", 1)] {
            let unit = if components == 3 { "F" } else { "L" };
            fields.push(step.fields.field(Field::from(FieldInfo { name, components, unit })));
        }
        bits.extend(step.residuals.iter().chain(fields.iter().flatten()).map(|x| x.to_bits()));
        self.rows.push(bits);
        if self.cancel_after == Some(step.index) {
            self.cancellation.cancel();
        }
        Ok(())
    }

    fn save(&mut self, at: Moment, state: &dyn Fn() -> State) -> Result<(), ObserverError> {
        match at {
            Moment::Step(step) => {
                assert_eq!(step, self.first + self.rows.len() - 1);
                self.states.push(state());
            }
            Moment::StageEnd(step) => self.at_stage_ends.push((step, state())),
            Moment::End => self.at_end = Some(state()),
        }
        Ok(())
    }
}

pub fn compiled(text: &str) -> Compiled {
    let mut compiled = compile(&Scene::from_ron(text).unwrap()).unwrap();
    // Some of the bodies leave the nodes that drive them.
    if let Compiled::Plane(model) = &mut compiled {
        model.needs_grip = false;
    }
    compiled
}

/// Counters that do not depend on the clock.
fn counters(summary: &Summary) -> impl PartialEq + std::fmt::Debug {
    let Summary { steps, iterations, cuts, shortened, indefinite_steps, points, .. } = *summary;
    let counts: Vec<u64> = summary.timings.iter().map(|it| it.count).collect();
    let split = (summary.domains_capped, summary.domains_split);
    (steps, iterations, cuts, shortened, indefinite_steps, points, split, summary.smallest_determinant, counts)
}

/// Resumes after a few of the load steps, and after being stopped in the next one.
#[track_caller]
pub fn goes_on_bit_for_bit(case: &str, text: &str) -> Seen {
    let mut whole = Seen::default();
    let expected = compiled(text).run(&mut whole).unwrap_or_else(|error| panic!("{case}: {error}"));
    let last = whole.rows.len() - 1;
    assert!(last >= 4 && whole.states.len() == last, "{case}: {last} load steps");
    for after in [1, last / 3, last / 2, last - 1] {
        let mut stopped = Seen { cancel_after: Some(after), ..Seen::default() };
        let error = compiled(text).run(&mut stopped).expect_err("it was asked to stop");
        assert!(matches!(error, Error::Cancelled { steps, .. } if steps == after), "{case}: {error}");
        let at_end = stopped.at_end.take().expect("it was offered");
        for (how, state) in [("kept", &whole.states[after - 1]), ("stopped", &at_end)] {
            // As a file keeps it.
            let text_of_it = ron::to_string(&state.progress).unwrap();
            let state = State { progress: ron::from_str(&text_of_it).unwrap(), ..state.clone() };
            let mut rest = Seen::default();
            let summary = compiled(text).resume(&state, &mut rest).unwrap();
            assert_eq!(rest.first, after + 1, "{case}");
            for (k, row) in rest.rows.iter().enumerate() {
                let k = k + after + 1;
                assert!(row == &whole.rows[k], "{case}: {how} after {after}: load step {k} differs");
            }
            assert_eq!(rest.rows.len(), last - after, "{case}: {how} after {after}");
            if how == "kept" {
                assert_eq!(counters(&summary), counters(&expected), "{case}: after {after}");
            }
        }
    }
    whole
}

pub fn shipped(name: &str, changes: &[(&str, &str)]) -> String {
    let path = format!("{}/../../scenes/{name}.ron", env!("CARGO_MANIFEST_DIR"));
    let mut text = std::fs::read_to_string(path).unwrap();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    text
}

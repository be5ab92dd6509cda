//! What is seen of a run.

use mpm_scene::{Scene, compile};
use mpm_solver::observe::{Entry, Field, LoadStep, Observer, ObserverError, RunStart};

/// What is seen of a run: positions at the start, and the last step.
#[derive(Default)]
pub struct Seen {
    columns: Vec<String>,
    row: Vec<Entry>,
    pub rest: Vec<f64>,
    pub position: Vec<f64>,
    pub stress: Vec<f64>,
    pub residuals: Vec<Vec<f64>>,
}

impl Observer for Seen {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        self.columns = run.columns.iter().map(|it| it.name.clone()).collect();
        Ok(())
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        self.row = step.row.to_vec();
        self.position = step.fields.positions();
        if step.index == 0 {
            self.rest.clone_from(&self.position);
        }
        self.stress = step.fields.field(Field::CAUCHY_STRESS);
        self.residuals.push(step.residuals.to_vec());
        Ok(())
    }
}

impl Seen {
    pub fn real(&self, column: &str) -> Vec<f64> {
        let at = self.columns.iter().position(|name| name == column).expect("a column of the history");
        match &self.row[at] {
            Entry::Real(values) => values.clone(),
            Entry::Count(_) => panic!("{column} is a count"),
        }
    }

    /// Stresses along a direction.
    pub fn along(&self, [x, y]: [f64; 2]) -> Vec<f64> {
        self.stress.chunks_exact(9).map(|s| x * x * s[0] + 2.0 * x * y * s[1] + y * y * s[4]).collect()
    }
}

pub fn run(text: &str) -> Seen {
    let mut seen = Seen::default();
    compile(&Scene::from_ron(text).unwrap()).unwrap().run(&mut seen).unwrap();
    seen
}

pub fn functions(degree: u32) -> String {
    if degree == 1 { "Linear".into() } else { format!("Splines(degree: {degree})") }
}

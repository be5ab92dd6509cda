//! Watches a run: passes it on to the results file, shows how far it is, keeps what the report needs.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use mpm_io::ResultsWriter;
use mpm_solver::observe::{Entry, LoadStep, Observer, ObserverError, Outcome, RunStart, Timing};

/// Parts of the load fraction that the progress bar tells apart.
const PARTS: f64 = 10_000.0;

/// One converged load step.
#[derive(Clone, Debug)]
pub struct Row {
    /// Number of the step, from 1.
    pub step: usize,
    /// Load fraction at its end.
    pub fraction: f64,
    /// Relative out-of-balance force of every iterate.
    pub residuals: Vec<f64>,
    /// Free components of displacement.
    pub equations: u64,
    /// 0 LLᵀ, 1 LBLᵀ, 2 LU.
    pub method: u64,
    /// Times the step was halved before it converged.
    pub cuts: u64,
    /// Newton corrections halved.
    pub shortened: u64,
}

/// An observer that hands on to the results file.
pub struct Watch {
    writer: ResultsWriter,
    bar: ProgressBar,
    columns: Vec<String>,
    rows: Vec<Row>,
}

impl Watch {
    /// Watches a run for `writer`; shows nothing if `quiet` or where nobody looks.
    pub fn new(writer: ResultsWriter, quiet: bool) -> Self {
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(PARTS as u64), target);
        let style = ProgressStyle::with_template("{wide_bar} {percent:>3} %  {msg}  {eta} left");
        bar.set_style(style.expect("the template is well formed"));
        Self { writer, bar, columns: Vec::new(), rows: Vec::new() }
    }

    /// The converged load steps.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    fn count(&self, row: &[Entry], column: &str) -> u64 {
        let at = self.columns.iter().position(|name| name == column);
        match at.map(|at| &row[at]) {
            Some(Entry::Count(values)) => values[0],
            _ => 0,
        }
    }
}

impl Observer for Watch {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        self.columns = run.columns.iter().map(|column| column.name.clone()).collect();
        self.bar.set_message(format!("step 1 of {}", run.steps));
        self.writer.start(run)
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        self.writer.load_step(step)?;
        if step.index == 0 {
            return Ok(());
        }
        let residuals = step.residuals.to_vec();
        let last = residuals.last().map_or(String::new(), |residual| format!(", residual {residual:.1e}"));
        self.bar.set_position((step.fraction * PARTS) as u64);
        self.bar.set_message(format!("step {}: {} iterations{last}", step.index, residuals.len()));
        self.rows.push(Row {
            step: step.index,
            fraction: step.fraction,
            equations: self.count(step.row, "equations"),
            method: self.count(step.row, "factorization"),
            cuts: self.count(step.row, "cuts"),
            shortened: self.count(step.row, "shortened_corrections"),
            residuals,
        });
        Ok(())
    }

    fn finish(&mut self, outcome: &Outcome, timings: &[Timing]) -> Result<(), ObserverError> {
        self.bar.finish_and_clear();
        self.writer.finish(outcome, timings)
    }
}

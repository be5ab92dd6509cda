//! Watches a run: passes it on to the results file, shows how far it is, keeps what the report needs.

use std::io::Write;

use crate::keeper;
use crate::report::{self, Row};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use mpm_io::{Keeper, ResultsWriter};
use mpm_solver::observe::{
    Cancellation, Entry, Fields, LoadStep, Moment, Observer, ObserverError, Outcome, Resumed, RunStart, Timing,
};
use mpm_solver::{HistoryNotes, State};

/// Parts of the load fraction that the progress bar tells apart.
const PARTS: f64 = 10_000.0;

/// What is shown of a run while it goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Show {
    Nothing,
    /// A bar on standard error, where that is a terminal.
    Bar,
    /// A line on standard output for each load step, for files and other programs.
    Lines,
}

/// An observer that hands on to the results file.
pub struct Watch {
    show: Show,
    writer: ResultsWriter,
    keeper: Keeper,
    started: bool,
    /// Load steps before those of this run.
    before: usize,
    bar: ProgressBar,
    /// Positions of the bar for a stage.
    parts: f64,
    columns: Vec<String>,
    rows: Vec<Row>,
    /// What of the history is worth a word.
    notes: HistoryNotes,
}

impl Watch {
    /// Watches a run for `writer` and `keeper`.
    pub fn new(writer: ResultsWriter, keeper: Keeper, show: Show) -> Self {
        let target =
            if show == Show::Bar { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(PARTS as u64), target);
        let style = ProgressStyle::with_template("{wide_bar} {percent:>3} %  {msg}  {eta} left");
        bar.set_style(style.expect("the template is well formed"));
        let (columns, rows) = (Vec::new(), Vec::new());
        let notes = HistoryNotes::default();
        Self { show, writer, keeper, started: false, before: 0, bar, parts: PARTS, columns, rows, notes }
    }

    /// Whether the results file was created or continued.
    pub fn has_started(&self) -> bool {
        self.started
    }

    /// Load steps taken, those of the run that this one goes on from too.
    pub fn steps(&self) -> usize {
        self.before + self.rows.len()
    }

    /// See [`keeper::advice`].
    pub fn advice(&self) -> String {
        keeper::advice(&self.keeper)
    }

    /// The converged load steps of this run.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// Prints a line at once; a reader that has gone away ends the talk, not the run.
    fn tell(&self, line: &str) {
        if self.show == Show::Lines {
            let mut out = std::io::stdout().lock();
            let _ = writeln!(out, "{line}").and_then(|()| out.flush());
        }
    }

    /// Prints a warning; if standard error is closed, there is nowhere to print it.
    fn warn(&self, note: &str) {
        let _ = self.bar.suspend(|| writeln!(std::io::stderr(), "warning: {note}"));
    }

    /// Keeps the names of the columns, and which of them are worth a word.
    fn take_columns(&mut self, run: &RunStart) {
        self.columns = run.columns.iter().map(|column| column.name.clone()).collect();
        self.notes = HistoryNotes::of(&run.columns);
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
        self.take_columns(run);
        self.parts = PARTS / run.stages.max(1) as f64;
        self.bar.set_message(format!("step 1 of {}", run.steps));
        self.writer.start(run)?;
        self.started = true;
        self.tell(&report::step_names());
        Ok(())
    }

    fn resume(&mut self, run: &RunStart, so_far: &Resumed) -> Result<(), ObserverError> {
        self.take_columns(run);
        self.parts = PARTS / run.stages.max(1) as f64;
        self.bar.set_position((so_far.fraction * self.parts) as u64);
        self.bar.reset_eta();
        self.writer.resume(run, so_far)?;
        self.before = so_far.rows.saturating_sub(1);
        self.started = true;
        self.tell(&report::step_names());
        Ok(())
    }

    fn cancellation(&self) -> Cancellation {
        self.keeper.cancellation()
    }

    fn save(&mut self, at: Moment, state: &dyn Fn() -> State) -> Result<(), ObserverError> {
        if !self.keeper.wants(at) {
            return Ok(());
        }
        // The results file must hold every row before the checkpoint, also after a power cut.
        self.writer.flush()?;
        let kept = self.writer.sync().map_err(ObserverError::from);
        let kept = kept.and_then(|()| self.keeper.write(&state()).map_err(ObserverError::from));
        if let Err(error) = kept {
            // A failed checkpoint does not stop the run.
            let note = format!("{error}; the run goes on without{}", keeper::advice(&self.keeper));
            let note = if at == Moment::End { error.to_string() } else { note };
            self.warn(&note);
        }
        Ok(())
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        self.writer.load_step(step)?;
        if step.index == 0 {
            return Ok(());
        }
        let residuals = step.residuals.to_vec();
        let last = residuals.last().map_or(String::new(), |residual| format!(", residual {residual:.1e}"));
        self.bar.set_position((step.fraction * self.parts) as u64);
        self.bar.set_message(format!("step {}: {} iterations{last}", step.index, residuals.len()));
        let row = Row {
            step: step.index,
            fraction: step.fraction,
            equations: self.count(step.row, "equations"),
            method: self.count(step.row, "factorization"),
            cuts: self.count(step.row, "cuts"),
            shortened: self.count(step.row, "shortened_corrections"),
            residuals,
        };
        self.notes.see(step.row);
        self.tell(&report::step(&row));
        self.rows.push(row);
        Ok(())
    }

    fn last(&mut self, fraction: f64, fields: &dyn Fields) -> Result<(), ObserverError> {
        self.writer.last(fraction, fields)
    }

    fn finish(&mut self, outcome: &Outcome, timings: &[Timing]) -> Result<(), ObserverError> {
        self.bar.finish_and_clear();
        self.notes.notes().for_each(|note| self.warn(&note));
        self.writer.finish(outcome, timings)
    }
}

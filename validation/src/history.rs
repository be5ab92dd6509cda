//! An observer that keeps what it sees in memory.

use mpm_solver::observe::{Column, Entry, Field, LoadStep, Observer, ObserverError, Outcome, RunStart, Timing};

/// Everything that a run showed, row 0 being the initial state.
#[derive(Clone, Debug, Default)]
pub struct History {
    fields: Vec<Field>,
    columns: Vec<Column>,
    rows: Vec<Row>,
    only_ends: bool,
    keeps_outlines: bool,
    outlines: Vec<Vec<[f64; 3]>>,
    stations: Vec<f64>,
    frames: Vec<Frame>,
    /// How the run ended, once it has.
    pub outcome: Option<Outcome>,
}

/// The points and their domains at one load step.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Load fraction at its end.
    pub fraction: f64,
    /// Positions of the material points, three numbers each `[L]`.
    pub positions: Vec<f64>,
    /// Corners of each point's domain, none where there is no domain `[L]`.
    pub outlines: Vec<Vec<[f64; 3]>>,
}

/// One load step.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Load fraction at its end.
    pub fraction: f64,
    /// One entry per column.
    pub entries: Vec<Entry>,
    /// Relative out-of-balance force of every iterate.
    pub residuals: Vec<f64>,
    /// Positions of the material points, three numbers each `[L]`.
    pub positions: Vec<f64>,
    /// The fields asked for, in that order.
    pub fields: Vec<Vec<f64>>,
}

impl History {
    /// Will keep these fields besides the positions.
    pub fn of(fields: &[Field]) -> Self {
        Self { fields: fields.to_vec(), ..Self::default() }
    }

    /// Will keep the initial state and the end of the load only; nothing is asked for in between.
    pub fn only_ends(self) -> Self {
        Self { only_ends: true, ..self }
    }

    /// Will keep the outlines of the points' domains at the last load step, too.
    pub fn with_outlines(self) -> Self {
        Self { keeps_outlines: true, ..self }
    }

    /// Will keep frames at these load fractions (where a load step ends there), too.
    pub fn with_frames(self, fractions: impl IntoIterator<Item = f64>) -> Self {
        Self { stations: fractions.into_iter().collect(), ..self }
    }

    /// Frames that were to be kept, as far as the run got.
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// The last load step as a frame, if outlines were to be kept.
    ///
    /// # Panics
    /// If the run never started.
    pub fn last_frame(&self) -> Frame {
        let Row { fraction, positions, .. } = self.last();
        Frame { fraction: *fraction, positions: positions.clone(), outlines: self.outlines.clone() }
    }

    /// Corners of each point's domain at the last load step, if they were to be kept `[L]`.
    pub fn outlines(&self) -> &[Vec<[f64; 3]>] {
        &self.outlines
    }

    /// The last row.
    ///
    /// # Panics
    /// If the run never started.
    pub fn last(&self) -> &Row {
        self.rows.last().expect("the initial state is always shown")
    }

    /// All rows.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// Columns of the rows.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// One component of a column, one value per row; counts come as reals.
    ///
    /// # Panics
    /// If there is no such column.
    pub fn series(&self, column: &str, component: usize) -> Vec<f64> {
        let at = self.index(column);
        let value = |row: &Row| match &row.entries[at] {
            Entry::Real(values) => values[component],
            Entry::Count(values) => values[component] as f64,
        };
        self.rows.iter().map(value).collect()
    }

    /// A field at a row, `field.components()` numbers per point.
    ///
    /// # Panics
    /// If the field was not asked for.
    pub fn field(&self, field: Field, row: usize) -> &[f64] {
        let at = self.fields.iter().position(|&it| it == field).expect("a field that the scene asks for");
        &self.rows[row].fields[at]
    }

    /// The rows without what differs from run to run: the wall time.
    pub fn reproducible(&self) -> Vec<Row> {
        let clock = self.index("wall_seconds");
        let mut rows = self.rows.clone();
        for row in &mut rows {
            row.entries.remove(clock);
        }
        rows
    }

    fn index(&self, column: &str) -> usize {
        let at = self.columns.iter().position(|it| it.name == column);
        at.unwrap_or_else(|| panic!("the history has no column `{column}`"))
    }
}

impl Row {
    /// All numbers of the row as bits, so that two rows are equal only if nothing differs at all.
    pub fn bits(&self) -> Vec<u64> {
        let entries = self.entries.iter().flat_map(|entry| match entry {
            Entry::Real(values) => values.iter().map(|x| x.to_bits()).collect::<Vec<_>>(),
            Entry::Count(values) => values.clone(),
        });
        let reals = self.residuals.iter().chain(&self.positions).chain(self.fields.iter().flatten());
        entries.chain(std::iter::once(self.fraction.to_bits())).chain(reals.map(|x| x.to_bits())).collect()
    }
}

impl Observer for History {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        self.columns = run.columns.clone();
        Ok(())
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        if self.only_ends && step.index > 0 && step.fraction < 1.0 {
            return Ok(());
        }
        self.rows.push(Row {
            fraction: step.fraction,
            entries: step.row.to_vec(),
            residuals: step.residuals.to_vec(),
            positions: step.fields.positions(),
            fields: self.fields.iter().map(|&field| step.fields.field(field)).collect(),
        });
        if self.keeps_outlines {
            self.outlines = step.fields.outlines();
        }
        if self.stations.iter().any(|station| (station - step.fraction).abs() < 1e-9) {
            self.frames.push(Frame {
                fraction: step.fraction,
                positions: step.fields.positions(),
                outlines: step.fields.outlines(),
            });
        }
        Ok(())
    }

    fn finish(&mut self, outcome: &Outcome, _: &[Timing]) -> Result<(), ObserverError> {
        self.outcome = Some(outcome.clone());
        Ok(())
    }
}

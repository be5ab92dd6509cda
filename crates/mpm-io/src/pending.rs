//! Load steps that are not in the file yet.
//!
//! They are written together, because a call of HDF5 takes as long for many rows as for one.

use std::mem;
use std::time::{Duration, Instant};

use mpm_solver::observe::{Column, ColumnKind, Entry};

use crate::snapshot::Snapshot;

/// Rows that are kept back at most.
const MOST_ROWS: usize = 1024;

/// Numbers that are kept back at most \[bytes\].
const MOST_BYTES: usize = 4 << 20;

/// Time between two writes against the time that the last one took: writing takes a twentieth of a run at most.
const REST: u32 = 20;

/// Rows of the history, one column after the other, and the points that are recorded.
pub(crate) struct Batch {
    /// Numbers of each column, row by row.
    pub(crate) columns: Vec<Values>,
    pub(crate) residuals: Vec<f64>,
    /// Number of residuals up to the end of each row, counted from the first row that is kept here.
    pub(crate) ends: Vec<u64>,
    pub(crate) snapshots: Vec<Snapshot>,
    bytes: usize,
}

/// Numbers of a column.
pub(crate) enum Values {
    Count(Vec<u64>),
    Real(Vec<f64>),
}

impl Batch {
    fn new(columns: &[Column]) -> Self {
        let values = columns.iter().map(|column| match column.kind {
            ColumnKind::Count => Values::Count(Vec::new()),
            ColumnKind::Real => Values::Real(Vec::new()),
        });
        Self {
            columns: values.collect(),
            residuals: Vec::new(),
            ends: Vec::new(),
            snapshots: Vec::new(),
            bytes: 0,
        }
    }

    /// Number of rows.
    pub(crate) fn rows(&self) -> usize {
        self.ends.len()
    }

    /// What it takes up.
    pub(crate) fn bytes(&self) -> usize {
        self.bytes
    }
}

/// What is kept back, and since when.
pub(crate) struct Pending {
    columns: Vec<Column>,
    batch: Batch,
    /// When the rows before these were written, and how long that took.
    written: Instant,
    took: Duration,
    /// When the last row came.
    last: Instant,
}

impl Pending {
    /// Nothing yet.
    pub(crate) fn new(columns: &[Column]) -> Self {
        let now = Instant::now();
        Self {
            columns: columns.to_vec(),
            batch: Batch::new(columns),
            written: now,
            took: Duration::ZERO,
            last: now,
        }
    }

    /// Columns of the history.
    pub(crate) fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Number of rows.
    pub(crate) fn rows(&self) -> usize {
        self.batch.rows()
    }

    /// Keeps the row of a load step.
    pub(crate) fn push(&mut self, row: &[Entry], residuals: &[f64]) {
        let Self { columns, batch, .. } = self;
        assert_eq!(row.len(), columns.len(), "a row has one entry per column");
        for ((kept, column), entry) in batch.columns.iter_mut().zip(columns).zip(row) {
            match (kept, entry) {
                (Values::Count(kept), Entry::Count(values)) if values.len() == column.width => {
                    kept.extend(values)
                }
                (Values::Real(kept), Entry::Real(values)) if values.len() == column.width => {
                    kept.extend(values)
                }
                _ => panic!("the entry of column {} is of its kind and width", column.name),
            }
            batch.bytes += 8 * column.width;
        }
        batch.residuals.extend(residuals);
        batch.ends.push(batch.residuals.len() as u64);
        batch.bytes += 8 * residuals.len() + 8;
    }

    /// Keeps the points of the last load step.
    pub(crate) fn record(&mut self, snapshot: Snapshot) {
        self.batch.bytes += snapshot.bytes();
        self.batch.snapshots.push(snapshot);
    }

    /// Whether there is so much that it is written whatever the time.
    pub(crate) fn is_much(&self) -> bool {
        self.batch.rows() >= MOST_ROWS || self.batch.bytes >= MOST_BYTES
    }

    /// Whether a row that has just come is written at once: the next may come later than `longest` after the last write.
    pub(crate) fn is_due(&mut self, longest: Duration) -> bool {
        let now = Instant::now();
        let step = now - mem::replace(&mut self.last, now);
        self.is_much() || now - self.written + step >= longest.min(REST * self.took)
    }

    /// Gives away what is kept.
    pub(crate) fn take(&mut self) -> Batch {
        self.written = Instant::now();
        mem::replace(&mut self.batch, Batch::new(&self.columns))
    }

    /// What was taken last is in the file, written within `took`.
    pub(crate) fn is_written(&mut self, took: Duration) {
        (self.written, self.took) = (Instant::now(), took);
    }
}

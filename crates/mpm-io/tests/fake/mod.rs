//! A made-up run whose every number is a formula, so that any of them can be checked.
#![allow(dead_code)] // each test binary uses its part

use mpm_io::{Options, ResultsWriter};
use mpm_solver::observe::{
    Column, ColumnKind, Counted, Entry, Field, Fields, LoadStep, Observer, ObserverError, RunStart, Space,
    Timing,
};

/// Material points at one load step.
pub struct Cloud {
    pub step: usize,
    pub points: usize,
}

/// Component `c` of point `p` after load step `step`; `tag` tells quantities apart.
pub fn value(tag: usize, step: usize, p: usize, c: usize) -> f64 {
    tag as f64 + 0.1 * c as f64 + (1 + step) as f64 / (p + 3) as f64
}

impl Cloud {
    fn rows(&self, tag: usize, width: usize) -> Vec<f64> {
        (0..self.points * width).map(|i| value(tag, self.step, i / width, i % width)).collect()
    }
}

impl Fields for Cloud {
    fn n_points(&self) -> usize {
        self.points
    }
    fn positions(&self) -> Vec<f64> {
        self.rows(0, 3)
    }
    fn field(&self, field: Field) -> Vec<f64> {
        self.rows(1 + field.name().len(), field.components())
    }
}

/// One count, one real, one vector in a group of its own.
pub fn columns() -> Vec<Column> {
    let column = |name: &str, kind, width| Column { name: name.into(), kind, width };
    vec![
        column("newton_iterations", ColumnKind::Count, 1),
        column("load_fraction", ColumnKind::Real, 1),
        column("reaction/pulled", ColumnKind::Real, 3),
    ]
}

pub fn row(step: usize) -> Vec<Entry> {
    vec![
        Entry::Count(vec![3 * step as u64]),
        Entry::Real(vec![0.125 * step as f64]),
        Entry::Real((0..3).map(|c| value(40, step, 0, c)).collect()),
    ]
}

/// Two more residuals with every step, none for the initial state.
pub fn residuals(step: usize) -> Vec<f64> {
    (0..2 * step.min(5)).map(|k| value(50, step, k, 0)).collect()
}

pub fn timings(step: usize) -> Vec<Timing> {
    vec![
        Timing { phase: "assemble", seconds: 0.5 * step as f64, count: 2 * step as u64 },
        Timing { phase: "solve", seconds: 0.25 * step as f64, count: step as u64 },
    ]
}

pub fn fields() -> Vec<Field> {
    vec![Field::DISPLACEMENT, Field::CAUCHY_STRESS, Field::VOLUME]
}

pub fn options() -> Options {
    Options {
        scene: "(name: \"Zugstab – 1 m²\")".into(),
        program: "mpm test".into(),
        fields: fields(),
        ..Options::default()
    }
}

pub fn start(writer: &mut ResultsWriter, points: usize) -> Result<(), ObserverError> {
    start_in(Space::Cartesian, writer, points)
}

pub fn start_in(space: Space, writer: &mut ResultsWriter, points: usize) -> Result<(), ObserverError> {
    let counted = Counted::Rows;
    writer.start(&RunStart { space, columns: columns(), points, steps: 10, stages: 1, counted })
}

pub fn load_step(writer: &mut ResultsWriter, step: usize, points: usize) -> Result<(), ObserverError> {
    writer.load_step(&LoadStep {
        index: step,
        fraction: 0.125 * step as f64,
        row: &row(step),
        residuals: &residuals(step),
        timings: &timings(step),
        fields: &Cloud { step, points },
    })
}

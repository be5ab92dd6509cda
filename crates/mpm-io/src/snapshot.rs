//! The points at the end of a load step, as they are recorded.

use mpm_solver::observe::{Field, Fields};

/// Positions and fields at the end of one load step.
pub(crate) struct Snapshot {
    pub(crate) fraction: f64,
    pub(crate) positions: Vec<f64>,
    pub(crate) fields: Vec<Vec<f64>>,
}

impl Snapshot {
    /// What there is to record now.
    pub(crate) fn of(fraction: f64, points: &dyn Fields, fields: &[Field]) -> Self {
        let values = fields.iter().map(|&field| points.field(field)).collect();
        Self { fraction, positions: points.positions(), fields: values }
    }

    /// What it takes up.
    pub(crate) fn bytes(&self) -> usize {
        let fields: usize = self.fields.iter().map(Vec::len).sum();
        size_of::<f64>() * (self.positions.len() + fields)
    }
}

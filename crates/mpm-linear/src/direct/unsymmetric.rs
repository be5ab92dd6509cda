//! LU of an unsymmetric matrix: by fronts, and over whole columns where those have no usable pivots.

use super::column_lu::ColumnLu;
use super::front_lu::FrontLu;
use super::multifrontal::Stopped;
use crate::matrix::{Matrix, Pattern};
use crate::report::{Cause, Factored, OutOfMemory, Singular};

/// Structure and factors of one pattern.
pub(super) struct Unsymmetric {
    fronts: FrontLu,
    order: Vec<usize>,
    /// Made when first needed for a pattern.
    columns: Option<ColumnLu>,
    by_columns: bool,
}

impl Unsymmetric {
    /// Finds the structure for an order of elimination (new to old) and makes room for the factors, in memory that is
    /// no longer needed.
    pub(super) fn allocate(
        pattern: Pattern<'_>,
        order: &[usize],
        memory: Vec<f64>,
    ) -> Result<Self, OutOfMemory> {
        let fronts = FrontLu::allocate(pattern, order, memory)?;
        Ok(Self { fronts, order: order.to_vec(), columns: None, by_columns: false })
    }

    /// The memory, for the next analysis.
    pub(super) fn into_memory(self) -> Vec<f64> {
        self.fronts.into_memory()
    }

    /// Numbers of both factors that every matrix of the pattern needs.
    pub(super) fn factor_entries(&self) -> usize {
        self.fronts.factor_entries()
    }

    /// Factorises, or names the equation that has no pivot.
    pub(super) fn factorise(&mut self, matrix: Matrix<'_>) -> Result<Factored, Singular> {
        self.by_columns = false;
        match self.fronts.factorise(matrix) {
            Ok(factored) => Ok(factored),
            Err(Stopped::Pivot(_)) => self.factorise_by_columns(matrix),
            Err(Stopped::Memory) => Err(self.no_memory()),
        }
    }

    /// The same with pivots that are free.
    pub(super) fn factorise_by_columns(&mut self, matrix: Matrix<'_>) -> Result<Factored, Singular> {
        let columns = match self.columns.take() {
            Some(columns) => columns,
            None => ColumnLu::allocate(&self.order).map_err(|_| self.no_memory())?,
        };
        self.by_columns = true;
        self.columns.insert(columns).factorise(matrix)
    }

    fn no_memory(&self) -> Singular {
        let entries = self.fronts.factor_entries() as f64;
        Singular { equation: 0, pivot: None, cause: Cause::NoMemory { entries } }
    }

    /// Whether pivots of the factors at hand are free.
    pub(super) fn has_free_pivots(&self) -> bool {
        self.by_columns
    }

    /// Replaces b by x.
    pub(super) fn solve(&mut self, x: &mut [f64]) {
        match &mut self.columns {
            Some(columns) if self.by_columns => columns.solve(x),
            _ => self.fronts.solve(x),
        }
    }
}

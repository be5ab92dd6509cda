//! Multifrontal LU of an unsymmetric matrix: rows are exchanged within the block that a front eliminates.
//!
//! The fronts are those of LLᵀ of the same structure, so no more is filled than there. A tangent's pivots stand mostly
//! near its diagonal. Where a front has no usable pivot of its own, the whole matrix is left to [`super::column_lu`].

use super::elimination::Kind;
use super::multifrontal::{Multifrontal, Stopped};
use super::pivots::Pivots;
use crate::matrix::{Matrix, Pattern};
use crate::report::{Factored, Method, OutOfMemory, Pivot, Sign};

/// A pivot below this part of the largest entry of its column is what rounding has left of zero.
pub(super) const NO_DIGITS: f64 = 1e-13;

/// Structure and factors of one pattern.
pub(super) struct FrontLu {
    factors: Multifrontal,
}

impl FrontLu {
    /// Finds the structure for an order of elimination (new to old) and makes room for the factors, in memory that is
    /// no longer needed.
    pub(super) fn allocate(
        pattern: Pattern<'_>,
        order: &[usize],
        memory: Vec<f64>,
    ) -> Result<Self, OutOfMemory> {
        Ok(Self { factors: Multifrontal::allocate(pattern, order, memory)? })
    }

    /// The memory, for the next analysis.
    pub(super) fn into_memory(self) -> Vec<f64> {
        self.factors.into_memory()
    }

    /// Numbers of both factors.
    pub(super) fn factor_entries(&self) -> usize {
        self.factors.factor_entries()
    }

    /// Factorises, or returns the pivot that is none.
    pub(super) fn factorise(&mut self, matrix: Matrix<'_>) -> Result<Factored, Stopped> {
        let Ok(mut is_negative) = self.factors.factorise(Kind::Lu, matrix.values) else {
            return Err(Stopped::Memory);
        };
        let mut pivots = Pivots::default();
        let mut none = None;
        self.factors.for_each_diagonal(|step, _, value| {
            let equation = self.factors.order()[step];
            let relative = value.abs() / matrix.diagonal(equation).abs();
            let pivot = Pivot { equation, value, relative };
            let is_none = !value.is_finite() || value.abs() <= NO_DIGITS * matrix.largest_of_column(equation);
            if is_none && none.is_none() {
                none = Some(pivot);
            }
            is_negative ^= value < 0.0;
            pivots.add(pivot);
        });
        if let Some(pivot) = none {
            return Err(Stopped::Pivot(pivot));
        }
        let sign = if is_negative { Sign::Negative } else { Sign::Positive };
        // Eigenvalues have other signs than the pivots of LU.
        Ok(Factored { determinant_sign: Some(sign), inertia: None, ..pivots.report(Method::Lu) })
    }

    /// Replaces b by x.
    pub(super) fn solve(&mut self, x: &mut [f64]) {
        self.factors.solve(Kind::Lu, x);
    }
}

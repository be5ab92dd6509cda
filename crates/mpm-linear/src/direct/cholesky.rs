//! LLᵀ and LBLᵀ by fronts: what their pivots tell.

use super::elimination::Kind;
use super::multifrontal::{Failed, Multifrontal, Stopped};
use super::pivots::Pivots;
use crate::matrix::{Matrix, Pattern};
use crate::report::{Factored, Method, OutOfMemory, Pivot};
use faer::Side;
use std::hint::black_box;

/// Analysis and factor of one symmetric pattern.
pub(super) struct Cholesky {
    factor: Multifrontal,
}

/// Seconds that an operation of a dense factorisation takes here, one thread, by a `clock` that tells
/// processor time `[s]`.
pub fn dense_operation(clock: impl Fn() -> f64) -> f64 {
    const SIZE: usize = 384;
    let matrix = faer::Mat::from_fn(SIZE, SIZE, |i, j| if i == j { SIZE as f64 } else { 0.5 });
    let once = || {
        let start = clock();
        black_box(black_box(&matrix).llt(Side::Lower).is_ok());
        clock() - start
    };
    let shortest = (0..4).map(|_| once()).fold(f64::INFINITY, f64::min);
    shortest / (SIZE.pow(3) as f64 / 3.0)
}

impl Cholesky {
    /// Finds the structure and makes room for the factor, in memory that is no longer needed.
    pub(super) fn allocate(
        pattern: Pattern<'_>,
        order: &[usize],
        memory: Vec<f64>,
    ) -> Result<Self, OutOfMemory> {
        Ok(Self { factor: Multifrontal::allocate(pattern, order, memory)? })
    }

    /// The memory, for the next analysis.
    pub(super) fn into_memory(self) -> Vec<f64> {
        self.factor.into_memory()
    }

    pub(super) fn factor_entries(&self) -> usize {
        self.factor.factor_entries()
    }

    /// Factorises by LLᵀ, or returns the first pivot that is not positive.
    pub(super) fn llt(&mut self, matrix: Matrix<'_>) -> Result<Factored, Stopped> {
        match self.factor.factorise(Kind::Llt, matrix.values) {
            Ok(_) => {}
            Err(Failed::Memory) => return Err(Stopped::Memory),
            Err(Failed::NotPositive(index)) => {
                // The failing diagonal entry is left as elimination found it.
                let mut value = f64::NAN;
                self.factor.for_each_diagonal(|step, _, d| {
                    if step == index {
                        value = d;
                    }
                });
                return Err(Stopped::Pivot(self.pivot(matrix, index, value)));
            }
        }
        let mut pivots = Pivots::default();
        self.factor.for_each_diagonal(|step, _, d| pivots.add(self.pivot(matrix, step, d * d)));
        Ok(pivots.report(Method::Llt))
    }

    /// Factorises by LBLᵀ, or returns the first pivot that is zero or not finite.
    pub(super) fn lblt(&mut self, matrix: Matrix<'_>) -> Result<Factored, Stopped> {
        if self.factor.factorise(Kind::Lblt, matrix.values).is_err() {
            return Err(Stopped::Memory);
        }
        let off_diagonal = self.factor.off_diagonal();
        let mut pivots = Pivots::default();
        let mut upper: Option<(usize, f64)> = None;
        self.factor.for_each_diagonal(|step, here, d| match upper.take() {
            None if off_diagonal[step] != 0.0 => upper = Some((here, d)),
            None => pivots.add(self.pivot(matrix, here, d)),
            Some((before, a)) => {
                for eigenvalue in eigenvalues(a, off_diagonal[step - 1], d) {
                    let one = self.pivot(matrix, before, eigenvalue);
                    let other = self.pivot(matrix, here, eigenvalue);
                    pivots.add(if one.relative < other.relative { one } else { other });
                }
            }
        });
        match pivots.unusable {
            Some(pivot) => Err(Stopped::Pivot(pivot)),
            None => Ok(pivots.report(Method::Lblt)),
        }
    }

    /// Replaces b by x with the factor of LLᵀ.
    pub(super) fn solve_llt(&mut self, x: &mut [f64]) {
        self.factor.solve(Kind::Llt, x);
    }

    /// Replaces b by x with the factor of LBLᵀ.
    pub(super) fn solve_lblt(&mut self, x: &mut [f64]) {
        self.factor.solve(Kind::Lblt, x);
    }

    /// The pivot of an elimination step, in the caller's numbering.
    fn pivot(&self, matrix: Matrix<'_>, step: usize, value: f64) -> Pivot {
        let equation = self.factor.order()[step];
        let diagonal = matrix.diagonal(equation);
        let relative = if value == 0.0 { 0.0 } else { value.abs() / diagonal.abs() };
        Pivot { equation, value, relative }
    }
}

/// Eigenvalues of [[a, b], [b, c]]; the smaller one by the determinant, without cancellation.
fn eigenvalues(a: f64, b: f64, c: f64) -> [f64; 2] {
    let mean = 0.5 * (a + c);
    let radius = (0.5 * (a - c)).hypot(b);
    let large = if mean < 0.0 { mean - radius } else { mean + radius };
    let small = if large == 0.0 { 0.0 } else { (a / large) * c - (b / large) * b };
    [small, large]
}

//! Levels in single precision: values of their matrices and vectors, sweeps, and transfer between levels.
//!
//! The cycle is a preconditioner, so that the rounding of its numbers changes how fast an iteration converges and not
//! where to. The matrix of every level is multiplied by one power of two that brings the largest diagonal entry near 1.

use super::arithmetic::{Block, LARGE_LEVEL, for_each_node, for_each_part, for_each_row};
use super::blocks::BlockMatrix;
use super::coarsening::Weights;
use super::strips::Strips;
use std::ops::Range;

/// Components of a node, and zeros that fill a register.
pub(crate) type Short<const L: usize> = [f32; L];

/// The matrix of one level by blocks of D columns with L rows each, L ≥ D, and the vectors of a cycle.
#[derive(Clone, Debug)]
pub(crate) struct Single<const D: usize, const L: usize> {
    block: Vec<[Short<L>; D]>,
    inverse: Vec<[Short<L>; D]>,
    pub b: Vec<Short<L>>,
    pub x: Vec<Short<L>>,
    pub r: Vec<Short<L>>,
    /// For what alternates between the coefficients of splines; empty where there are none.
    pub rough: [Vec<Short<L>>; 2],
}

/// `sum − block · x`.
#[inline(always)]
fn without<const D: usize, const L: usize>(mut sum: Short<L>, block: &[Short<L>; D], x: &Short<L>) -> Short<L> {
    let product = times(block, x);
    for (sum, product) in sum.iter_mut().zip(&product) {
        *sum -= product;
    }
    sum
}

/// `block · x`.
#[inline(always)]
fn times<const D: usize, const L: usize>(block: &[Short<L>; D], x: &Short<L>) -> Short<L> {
    let mut product = [0.0; L];
    for (column, x) in block.iter().zip(x) {
        for (product, coefficient) in product.iter_mut().zip(column) {
            *product += coefficient * x;
        }
    }
    product
}

/// A block multiplied by a factor and rounded.
fn rounded<const D: usize, const L: usize>(block: &Block<D>, factor: f64) -> [Short<L>; D] {
    std::array::from_fn(|j| std::array::from_fn(|i| if i < D { (block[(i, j)] * factor) as f32 } else { 0.0 }))
}

/// The weighted sum of a vector of another level.
#[inline(always)]
fn weighted<const L: usize>(weights: &[(u32, f64)], of: &[Short<L>]) -> Short<L> {
    let mut sum = [0.0; L];
    for &(node, weight) in weights {
        for (sum, value) in sum.iter_mut().zip(&of[node as usize]) {
            *sum += value * weight as f32;
        }
    }
    sum
}

impl<const D: usize, const L: usize> Single<D, L> {
    /// Zeros for a matrix of this structure.
    pub(crate) fn zeros(matrix: &BlockMatrix<D>) -> Self {
        let n = matrix.n_rows();
        let nothing = vec![[0.0; L]; n];
        Self {
            block: vec![[[0.0; L]; D]; matrix.column.len()],
            inverse: vec![[[0.0; L]; D]; n],
            b: nothing.clone(),
            x: nothing.clone(),
            r: nothing,
            rough: Default::default(),
        }
    }

    /// Bytes of a level with so many blocks and rows.
    pub(crate) fn bytes(blocks: usize, rows: usize) -> usize {
        (blocks + rows) * size_of::<[Short<L>; D]>() + 3 * rows * size_of::<Short<L>>()
    }

    /// Takes the values of a matrix times a power of two.
    ///
    /// # Errors
    /// The first row whose inverse is beyond single precision.
    pub(crate) fn take(&mut self, matrix: &BlockMatrix<D>, scale: f64) -> Result<(), usize> {
        for_each_node(&mut self.block, |entry, block| *block = rounded(&matrix.block[entry], scale));
        for_each_row(&mut self.inverse, |row, inverse| *inverse = rounded(&matrix.inverse[row], scale.recip()));
        match self.inverse.iter().position(|block| block.iter().flatten().any(|it| !it.is_finite())) {
            Some(row) => Err(row),
            None => Ok(()),
        }
    }

    /// One forward Gauss–Seidel sweep from x = 0.
    pub(crate) fn sweep_from_zero(&mut self, matrix: &BlockMatrix<D>, strips: &Strips) {
        let Self { block, inverse, b, x, .. } = self;
        let BlockMatrix { start, column, diagonal, .. } = matrix;
        let in_parallel = x.len() > LARGE_LEVEL;
        let (even, odd) = x.split_at_mut(strips.n_even());
        for_each_part(in_parallel, &strips.even, &mut *even, &|strip, x| {
            let first = strips.even[strip];
            for i in 0..x.len() {
                let row = first + i;
                let mut sum = b[row];
                for entry in start[row]..diagonal[row] {
                    sum = without(sum, &block[entry], &x[column[entry] as usize - first]);
                }
                x[i] = times(&inverse[row], &sum);
            }
        });
        let even = &*even;
        for_each_part(in_parallel, &strips.odd, &mut *odd, &|strip, x| {
            let first = strips.odd[strip];
            for i in 0..x.len() {
                let row = first + i;
                let mut sum = b[row];
                for entry in start[row]..diagonal[row] {
                    let column = column[entry] as usize;
                    let value = if column < even.len() { &even[column] } else { &x[column - first] };
                    sum = without(sum, &block[entry], value);
                }
                x[i] = times(&inverse[row], &sum);
            }
        });
    }

    /// `r = b − A x` after [`Self::sweep_from_zero`]: what later rows have added.
    pub(crate) fn residual_after_sweep(&mut self, matrix: &BlockMatrix<D>) {
        let Self { block, x, r, .. } = self;
        for_each_row(r, |row, r| {
            let mut sum = [0.0; L];
            for entry in matrix.diagonal[row] + 1..matrix.start[row + 1] {
                sum = without(sum, &block[entry], &x[matrix.column[entry] as usize]);
            }
            *r = sum;
        });
    }

    /// One backward Gauss–Seidel sweep, the transpose of a forward one.
    pub(crate) fn sweep_back(&mut self, matrix: &BlockMatrix<D>, strips: &Strips) {
        let Self { block, inverse, b, x, .. } = self;
        let in_parallel = x.len() > LARGE_LEVEL;
        let (even, odd) = x.split_at_mut(strips.n_even());
        let n_even = even.len();
        let other = &*even;
        for_each_part(in_parallel, &strips.odd, &mut *odd, &|strip, x| {
            let first = strips.odd[strip];
            for i in (0..x.len()).rev() {
                let row = first + i;
                let sum = beside_diagonal(matrix, row).fold(b[row], |sum, entry| {
                    let column = matrix.column[entry] as usize;
                    let value = if column < n_even { &other[column] } else { &x[column - first] };
                    without(sum, &block[entry], value)
                });
                x[i] = times(&inverse[row], &sum);
            }
        });
        let other = &*odd;
        for_each_part(in_parallel, &strips.even, &mut *even, &|strip, x| {
            let first = strips.even[strip];
            for i in (0..x.len()).rev() {
                let row = first + i;
                let sum = beside_diagonal(matrix, row).fold(b[row], |sum, entry| {
                    let column = matrix.column[entry] as usize;
                    let value = if column < n_even { &x[column - first] } else { &other[column - n_even] };
                    without(sum, &block[entry], value)
                });
                x[i] = times(&inverse[row], &sum);
            }
        });
    }

    /// Takes the right-hand side from the residual of the next finer level.
    pub(crate) fn restrict(&mut self, fine: &Self, children: &Weights) {
        for_each_node(&mut self.b, |node, b| *b = weighted(children.of(node), &fine.r));
    }

    /// Adds the correction of the next coarser level.
    pub(crate) fn correct(&mut self, coarse: &Self, parents: &Weights) {
        for_each_node(&mut self.x, |node, x| {
            let correction = weighted(parents.of(node), &coarse.x);
            for (x, correction) in x.iter_mut().zip(&correction) {
                *x += correction;
            }
        });
    }
}

/// Entries of a row but for the diagonal one.
fn beside_diagonal<const D: usize>(
    matrix: &BlockMatrix<D>,
    row: usize,
) -> std::iter::Chain<Range<usize>, Range<usize>> {
    (matrix.start[row]..matrix.diagonal[row]).chain(matrix.diagonal[row] + 1..matrix.start[row + 1])
}

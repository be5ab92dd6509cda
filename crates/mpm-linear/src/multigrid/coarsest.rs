//! The matrix of the coarsest level, factorised densely.

use super::blocks::BlockMatrix;
use super::single::Short;
use crate::matrix::Symmetry;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, LU};

/// Its factors.
#[derive(Clone, Debug)]
pub(crate) enum CoarsestFactor {
    Symmetric(Cholesky<f64, Dyn>),
    Unsymmetric(LU<f64, Dyn, Dyn>),
}

impl CoarsestFactor {
    /// None where a symmetric matrix is not positive definite, and where another one is singular.
    pub(crate) fn of<const D: usize>(matrix: &BlockMatrix<D>, symmetry: Symmetry) -> Option<Self> {
        let dense = dense(matrix);
        match symmetry {
            Symmetry::Symmetric => dense.cholesky().map(Self::Symmetric),
            Symmetry::Unsymmetric => Some(dense.lu()).filter(LU::is_invertible).map(Self::Unsymmetric),
        }
    }

    /// `x = (s A)⁻¹ b` of the first D components of each node; the others are zeros.
    pub(crate) fn solve<const D: usize, const L: usize>(&self, s: f64, b: &[Short<L>], x: &mut [Short<L>]) {
        let numbers = b.iter().flat_map(|b| b[..D].iter().map(|&b| f64::from(b)));
        let mut dense = DVector::from_iterator(b.len() * D, numbers);
        match self {
            Self::Symmetric(factor) => factor.solve_mut(&mut dense),
            Self::Unsymmetric(factor) => assert!(factor.solve_mut(&mut dense), "singular ones are refused"),
        }
        for (x, found) in x.iter_mut().zip(dense.as_slice().chunks_exact(D)) {
            x.iter_mut().zip(found).for_each(|(x, found)| *x = (found / s) as f32);
        }
    }
}

/// A matrix with ones on the diagonal where a component carries nothing.
fn dense<const D: usize>(matrix: &BlockMatrix<D>) -> DMatrix<f64> {
    let n = matrix.n_rows();
    let mut dense = DMatrix::zeros(n * D, n * D);
    for row in 0..n {
        for entry in matrix.start[row]..matrix.start[row + 1] {
            let column = matrix.column[entry] as usize;
            dense.view_mut((row * D, column * D), (D, D)).copy_from(&matrix.block[entry]);
        }
        for i in row * D..(row + 1) * D {
            if matrix.inverse[row].row(i - row * D).iter().all(|&it| it == 0.0) {
                dense.row_mut(i).fill(0.0);
                dense.column_mut(i).fill(0.0);
                dense[(i, i)] = 1.0;
            }
        }
    }
    dense
}

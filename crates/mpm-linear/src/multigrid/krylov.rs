//! The iteration that suits a matrix: conjugate gradients, or GMRES where it is not symmetric or not positive definite.

use super::arithmetic::Vector;
use super::blocks::BlockMatrix;
use super::outcome::Stop;
use super::{conjugate_gradients, gmres};
use crate::matrix::Symmetry;

/// An iteration with its vectors, which are kept from one system to the next.
#[derive(Clone, Debug)]
pub(crate) enum Krylov<const D: usize> {
    ConjugateGradients(conjugate_gradients::Iterates<D>),
    Gmres(gmres::Iterates<D>),
}

impl<const D: usize> Krylov<D> {
    pub(crate) fn zeros(symmetry: Symmetry, n: usize) -> Self {
        match symmetry {
            Symmetry::Symmetric => Self::ConjugateGradients(conjugate_gradients::Iterates::zeros(n)),
            Symmetry::Unsymmetric => Self::Gmres(gmres::Iterates::zeros(n)),
        }
    }

    /// Vectors held at most.
    pub(crate) fn vectors(symmetry: Symmetry) -> usize {
        match symmetry {
            Symmetry::Symmetric => 6,
            Symmetry::Unsymmetric => gmres::VECTORS,
        }
    }

    /// Right-hand side and solution.
    pub(crate) fn system(&mut self) -> (&mut Vec<Vector<D>>, &mut Vec<Vector<D>>) {
        match self {
            Self::ConjugateGradients(it) => (&mut it.b, &mut it.x),
            Self::Gmres(it) => (&mut it.b, &mut it.x),
        }
    }

    /// Iterates from x = 0 until `|b − A x| ≤ tolerance · |b|`; for `unit` see [`gmres::solve`].
    pub(crate) fn solve(
        &mut self,
        matrix: &BlockMatrix<D>,
        precondition: impl FnMut(&[Vector<D>], f64, &mut [Vector<D>]),
        unit: f64,
        (tolerance, most): (f64, u32),
    ) -> Stop {
        match self {
            Self::ConjugateGradients(it) => {
                conjugate_gradients::solve(matrix, it, precondition, tolerance, most)
            }
            Self::Gmres(it) => gmres::solve(matrix, it, precondition, unit, (tolerance, most)),
        }
    }
}

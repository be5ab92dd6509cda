//! An affine map with its inverse.

use crate::cell::{determinant, inverse};
use crate::{Block, Vector};

/// `x = A X + b` with `det A > 0`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Affine<const D: usize> {
    matrix: Block<D>,
    inverse: Block<D>,
    shift: Vector<D>,
}

impl<const D: usize> Affine<D> {
    /// `None` where the map folds space or squeezes it flat.
    pub(crate) fn new(matrix: Block<D>, shift: Vector<D>) -> Option<Self> {
        let inverse = inverse(&matrix);
        let upright = determinant(&matrix) > 0.0 && inverse.iter().all(|number| number.is_finite());
        upright.then_some(Self { matrix, inverse, shift })
    }

    pub(crate) fn place(&self, rest: &Vector<D>) -> Vector<D> {
        self.matrix * rest + self.shift
    }

    pub(crate) fn recall(&self, x: &Vector<D>) -> Vector<D> {
        self.inverse * (x - self.shift)
    }

    /// (∂rest/∂x)ᵀ.
    pub(crate) fn push_gradients(&self) -> Block<D> {
        self.inverse.transpose()
    }
}

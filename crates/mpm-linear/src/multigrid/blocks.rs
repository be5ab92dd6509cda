//! The matrix of one level by block rows.

use super::arithmetic::{Block, LARGE_LEVEL, Vector, for_each_row, without};
use crate::matrix::Symmetry;
use rayon::prelude::*;

/// A pivot of a diagonal block below this part of the block's largest entry belongs to nothing.
const NOTHING: f64 = 1e-13;

/// A matrix by rows of `D × D` blocks, both triangles; columns ascend in each row.
#[derive(Clone, Debug)]
pub(crate) struct BlockMatrix<const D: usize> {
    /// Where each row starts in `column` and `block`, and their length.
    pub start: Vec<usize>,
    pub column: Vec<u32>,
    pub block: Vec<Block<D>>,
    /// Place of each row's diagonal block.
    pub diagonal: Vec<usize>,
    /// Inverse of each diagonal block, zero in components that carry nothing.
    pub inverse: Vec<Block<D>>,
}

impl<const D: usize> BlockMatrix<D> {
    /// A matrix of zeros with this structure.
    pub(crate) fn zeros(start: Vec<usize>, column: Vec<u32>) -> Self {
        let n = start.len() - 1;
        let diagonal = |row: usize| {
            let columns = &column[start[row]..start[row + 1]];
            start[row] + columns.binary_search(&(row as u32)).expect("every row has its diagonal")
        };
        // The first write to new memory is what takes time, so threads share it.
        let (diagonal, block) = if n > LARGE_LEVEL {
            let zeros =
                |n: usize| (0..n).into_par_iter().with_min_len(1 << 14).map(|_| Block::zeros()).collect();
            ((0..n).into_par_iter().map(diagonal).collect(), zeros(column.len()))
        } else {
            ((0..n).map(diagonal).collect(), vec![Block::zeros(); column.len()])
        };
        Self { start, column, block, diagonal, inverse: vec![Block::zeros(); n] }
    }

    pub(crate) fn n_rows(&self) -> usize {
        self.diagonal.len()
    }

    #[inline]
    fn row(&self, row: usize) -> impl Iterator<Item = (usize, &Block<D>)> {
        let entries = self.start[row]..self.start[row + 1];
        self.column[entries.clone()].iter().map(|&column| column as usize).zip(&self.block[entries])
    }

    /// Inverts the diagonal blocks.
    ///
    /// # Errors
    /// The first row whose block is not finite or, of a symmetric matrix, not positive definite.
    pub(crate) fn invert_diagonal(&mut self, symmetry: Symmetry) -> Result<(), usize> {
        let Self { block, diagonal, inverse, .. } = self;
        let invert = |(row, (inverse, &place)): (usize, (&mut Block<D>, &usize))| match pseudo_inverse(
            block[place],
            symmetry,
        ) {
            Some(found) => {
                *inverse = found;
                None
            }
            None => Some(row),
        };
        let failed = if diagonal.len() <= LARGE_LEVEL {
            inverse.iter_mut().zip(&*diagonal).enumerate().filter_map(invert).min()
        } else {
            inverse.par_iter_mut().zip(&*diagonal).enumerate().filter_map(invert).min()
        };
        failed.map_or(Ok(()), Err)
    }

    /// `y = A x`.
    pub(crate) fn multiply(&self, x: &[Vector<D>], y: &mut [Vector<D>]) {
        for_each_row(y, |row, y| {
            let mut sum = Vector::zeros();
            for (column, block) in self.row(row) {
                sum = without(sum, block, &x[column]);
            }
            *y = -sum;
        });
    }

    /// Size of the largest diagonal entry; not counted are components i of rows whose bit i of `held` is set.
    pub(crate) fn largest_diagonal(&self, held: &[u8]) -> f64 {
        self.diagonal.iter().zip(held).fold(0.0, |most, (&place, &held)| {
            let of_component =
                |i: usize| if held & 1 << i == 0 { self.block[place][(i, i)].abs() } else { 0.0 };
            (0..D).map(of_component).fold(most, f64::max)
        })
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.start[..])
            + size_of_val(&self.column[..])
            + size_of_val(&self.block[..])
            + size_of_val(&self.diagonal[..])
            + size_of_val(&self.inverse[..])
    }
}

/// Inverse of a block, by elimination; components whose pivot is nothing stay zero. None where a pivot is not finite,
/// or a pivot of a symmetric block negative.
fn pseudo_inverse<const D: usize>(mut block: Block<D>, symmetry: Symmetry) -> Option<Block<D>> {
    let may_be_negative = symmetry == Symmetry::Unsymmetric;
    let largest = block.diagonal().amax();
    let mut inverse = Block::identity();
    let mut carries = [false; D];
    for k in 0..D {
        let pivot = block[(k, k)];
        if !pivot.is_finite() || !may_be_negative && pivot < -NOTHING * largest {
            return None;
        }
        carries[k] = pivot.abs() > NOTHING * largest;
        if !carries[k] {
            continue;
        }
        for i in (0..D).filter(|&i| i != k) {
            let factor = block[(i, k)] / pivot;
            for j in 0..D {
                let (from, was) = (block[(k, j)], inverse[(k, j)]);
                block[(i, j)] -= factor * from;
                inverse[(i, j)] -= factor * was;
            }
        }
    }
    for i in 0..D {
        for j in 0..D {
            inverse[(i, j)] = if carries[i] && carries[j] { inverse[(i, j)] / block[(i, i)] } else { 0.0 };
        }
    }
    Some(inverse)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_is_inverted_in_what_it_carries() {
        let block = Block::<3>::new(4.0, 1.0, 0.0, 1.0, 3.0, 0.0, 0.0, 0.0, 0.0);
        let inverse = pseudo_inverse(block, Symmetry::Symmetric).unwrap();
        let product = block * inverse;
        let expected = Block::<3>::from_diagonal(&Vector::<3>::new(1.0, 1.0, 0.0));
        assert!((product - expected).norm() < 1e-15, "{product}");
        let indefinite = Block::<2>::new(1.0, 2.0, 2.0, 1.0);
        assert!(pseudo_inverse(indefinite, Symmetry::Symmetric).is_none());
        assert!(pseudo_inverse(Block::<2>::new(f64::NAN, 0.0, 0.0, 1.0), Symmetry::Symmetric).is_none());
        let unsymmetric = Block::<2>::new(-1.0, 3.0, 2.0, 1.0);
        let inverse = pseudo_inverse(unsymmetric, Symmetry::Unsymmetric).unwrap();
        assert!((unsymmetric * inverse - Block::<2>::identity()).norm() < 1e-15, "{inverse}");
    }
}

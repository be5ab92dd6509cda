//! LU with partial pivoting over whole columns of an unsymmetric matrix: faer's column by column, in our order. It takes
//! the matrices that [`super::front_lu`] cannot factorise, and takes longer.
//!
//! Columns are eliminated in the order of nested dissection. It keeps the fill low as long as pivots stay
//! on the diagonal, which they mostly do, because tangents of stable material have strong diagonals.

use super::front_lu::NO_DIGITS;
use super::pivots::Pivots;
use crate::matrix::Matrix;
use crate::report::{Cause, Factored, Method, OutOfMemory, Pivot, Sign, Singular};
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::perm::PermRef;
use faer::sparse::linalg::LuError;
use faer::sparse::linalg::lu::simplicial::{
    SimplicialLu, factorize_simplicial_numeric_lu, factorize_simplicial_numeric_lu_scratch,
    solve_in_place_scratch,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par};

/// Order and factors of one pattern.
pub(super) struct ColumnLu {
    /// Column of K at each step of elimination, and its inverse.
    order: Vec<usize>,
    position: Vec<usize>,
    /// Row of K at each step of elimination, and its inverse.
    row: Vec<usize>,
    row_position: Vec<usize>,
    factors: SimplicialLu<usize, f64>,
    scratch: MemBuffer,
}

impl ColumnLu {
    /// Makes room for the work with this order of elimination (new to old). The factors grow as they are computed.
    pub(super) fn allocate(order: &[usize]) -> Result<Self, OutOfMemory> {
        let n = order.len();
        let mut position = vec![0; n];
        for (k, &equation) in order.iter().enumerate() {
            position[equation] = k;
        }
        let work = StackReq::or(
            factorize_simplicial_numeric_lu_scratch::<usize, f64>(n, n),
            solve_in_place_scratch::<usize, f64>(n, 1, Par::Seq),
        );
        let scratch = MemBuffer::try_new(work).map_err(|_| OutOfMemory { equations: n, factor_entries: 0 })?;
        let (row, row_position) = (vec![0; n], vec![0; n]);
        Ok(Self { order: order.to_vec(), position, row, row_position, factors: SimplicialLu::new(), scratch })
    }

    /// Entries of both factors; 0 before the first factorisation.
    pub(super) fn factor_entries(&self) -> usize {
        self.factors.l_factor_unsorted().compute_nnz() + self.factors.u_factor_unsorted().compute_nnz()
    }

    /// Factorises, or names the equation that has no pivot.
    pub(super) fn factorise(&mut self, matrix: Matrix<'_>) -> Result<Factored, Singular> {
        let n = self.order.len();
        let order = PermRef::new_checked(&self.order, &self.position, n);
        let pattern = matrix.pattern;
        let structure = SymbolicSparseColMatRef::new_checked(n, n, pattern.column_start, None, pattern.row);
        let factorised = factorize_simplicial_numeric_lu(
            &mut self.row,
            &mut self.row_position,
            &mut self.factors,
            SparseColMatRef::new(structure, matrix.values),
            order,
            MemStack::new(&mut self.scratch),
        );
        let singular = |equation, pivot, cause| Singular { equation, pivot, cause };
        match factorised {
            Ok(()) => {}
            Err(LuError::SymbolicSingular { index }) => {
                return Err(singular(self.order[index], Some(0.0), Cause::NoPivot));
            }
            Err(LuError::Generic(_)) => {
                return Err(singular(0, None, Cause::NoMemory { entries: self.factor_entries() as f64 }));
            }
        }
        let mut pivots = Pivots::default();
        let mut is_negative = is_odd(&self.order) != is_odd(&self.row);
        let upper = self.factors.u_factor_unsorted();
        for (k, &equation) in self.order.iter().enumerate() {
            let value = upper.val_of_col(k).last().copied().unwrap_or(0.0);
            if !value.is_finite() || value.abs() <= NO_DIGITS * matrix.largest_of_column(equation) {
                return Err(singular(equation, Some(value), Cause::NoPivot));
            }
            is_negative ^= value < 0.0;
            let relative = value.abs() / matrix.diagonal(equation).abs();
            pivots.add(Pivot { equation, value, relative });
        }
        let sign = if is_negative { Sign::Negative } else { Sign::Positive };
        // Eigenvalues have other signs than the pivots of LU.
        Ok(Factored { determinant_sign: Some(sign), inertia: None, ..pivots.report(Method::Lu) })
    }

    /// Replaces b by x.
    pub(super) fn solve(&mut self, x: &mut [f64]) {
        let n = x.len();
        self.factors.solve_in_place_with_conj(
            PermRef::new_checked(&self.row, &self.row_position, n),
            PermRef::new_checked(&self.order, &self.position, n),
            Conj::No,
            MatMut::from_column_major_slice_mut(x, n, 1),
            Par::Seq,
            MemStack::new(&mut self.scratch),
        );
    }
}

/// Whether a permutation is odd: a cycle of k numbers is k − 1 exchanges.
fn is_odd(permutation: &[usize]) -> bool {
    let mut seen = vec![false; permutation.len()];
    let mut odd = false;
    for start in 0..permutation.len() {
        let mut at = permutation[start];
        while !seen[start] && at != start {
            seen[at] = true;
            odd = !odd;
            at = permutation[at];
        }
        seen[start] = true;
    }
    odd
}

#[cfg(test)]
mod tests {
    use super::is_odd;

    #[test]
    fn parity_counts_exchanges() {
        assert!(!is_odd(&[]) && !is_odd(&[0, 1, 2]));
        assert!(is_odd(&[1, 0, 2]) && is_odd(&[2, 1, 0]));
        assert!(!is_odd(&[1, 2, 0]) && !is_odd(&[1, 0, 3, 2]));
        assert!(is_odd(&[1, 2, 3, 0]));
    }
}

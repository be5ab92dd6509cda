//! Structure of factors, found by faer: supernodes for a given order, and orders by minimum degree.

use crate::matrix::Pattern;
use crate::report::OutOfMemory;
use faer::Side;
use faer::perm::PermRef;
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};

/// Structure of the factor of a pattern, eliminated in this order (new to old).
pub(super) fn analyse(pattern: Pattern<'_>, order: &[usize]) -> Result<SymbolicCholesky<usize>, OutOfMemory> {
    let n = order.len();
    let mut position = vec![0; n];
    for (k, &equation) in order.iter().enumerate() {
        position[equation] = k;
    }
    let order = SymmetricOrdering::Custom(PermRef::new_checked(order, &position, n));
    factorize_symbolic_cholesky(structure(pattern), Side::Lower, order, symbolic_params())
        .map_err(|_| OutOfMemory { equations: n, factor_entries: 0 })
}

/// Always supernodes: LBLᵀ pivots inside them. faer's rule for merging small ones was the best of
/// those tried.
fn symbolic_params() -> CholeskySymbolicParams<'static> {
    CholeskySymbolicParams {
        supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
        ..Default::default()
    }
}

fn structure(pattern: Pattern<'_>) -> SymbolicSparseColMatRef<'_, usize> {
    let n = pattern.column_start.len() - 1;
    SymbolicSparseColMatRef::new_checked(n, n, pattern.column_start, None, pattern.row)
}

/// An order with little fill from the pattern alone, by minimum degree (P. R. Amestoy, T. A. Davis and
/// I. S. Duff, SIAM J. Matrix Anal. Appl. 17, 1996).
///
/// # Errors
/// If memory does not suffice.
pub(super) fn minimum_degree(pattern: Pattern<'_>) -> Result<Vec<usize>, OutOfMemory> {
    let symbolic = by_minimum_degree(pattern)?;
    Ok(symbolic.perm().map_or_else(Vec::new, |order| order.arrays().0.to_vec()))
}

fn by_minimum_degree(pattern: Pattern<'_>) -> Result<SymbolicCholesky<usize>, OutOfMemory> {
    factorize_symbolic_cholesky(structure(pattern), Side::Lower, SymmetricOrdering::Amd, symbolic_params())
        .map_err(|_| OutOfMemory { equations: pattern.n_equations(), factor_entries: 0 })
}

/// Entries of the factor with faer's minimum-degree order and our supernodes, to compare with.
#[cfg(test)]
pub(super) fn entries_by_minimum_degree(pattern: Pattern<'_>) -> usize {
    by_minimum_degree(pattern).unwrap().len_val()
}

//! Direct solution: order of elimination, factorisation, check of the solution.
//!
//! A [`Factorization`] lives as long as a run. [`Factorization::analyse`] orders the equations and
//! finds the structure of the factor, or keeps both if the pattern is the last one;
//! [`Factorization::factorise`] computes the factor, [`Factorization::solve`] solves with it and
//! checks the solution against K itself.
//!
//! A stable state has a positive definite tangent and LLᵀ succeeds. Where it meets a pivot that is
//! not positive, the equation is reported (the structure loses stability there, or a node carries
//! almost no material) and LBLᵀ with Bunch–Kaufman pivots takes over. LU with partial pivoting is
//! the last resort, and slow in three dimensions.
//!
//! Here everything is sequential, so the bits of a solution never depend on the number of threads.
//!
//! ```
//! use mpm_linear::{Factorization, Method, SymmetricPattern};
//!
//! // Three nodes in a row with one equation each: K = tridiag(-1, 2, -1), lower triangle.
//! let pattern = SymmetricPattern { column_start: &[0, 2, 4, 5], row: &[0, 1, 1, 2, 2] };
//! let values = [2.0, -1.0, 2.0, -1.0, 2.0];
//! let lattice = [[0, 0, 0], [1, 0, 0], [2, 0, 0]];
//!
//! let mut factorization = Factorization::new();
//! factorization.analyse(pattern, &lattice, [None; 3], 1)?;
//! let report = factorization.factorise(&values, Method::Llt)?;
//! assert_eq!(report.method, Method::Llt);
//!
//! let mut x = [0.0, 0.0, 4.0];
//! let solved = factorization.solve(&values, &mut x)?;
//! assert!(solved.backward_error < 1e-15);
//! assert!((x[2] - 3.0).abs() < 1e-14);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod cholesky;
mod dissection;
mod factorization;
mod graph;
mod lu;
mod order;
mod residual;

pub use cholesky::dense_operation;
pub use factorization::{Factorization, predict_factor_entries};
pub use order::StoredOrder;
pub(crate) use order::fingerprint;

#[cfg(test)]
mod tests;

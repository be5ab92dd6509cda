//! Direct solution: order of elimination, factorisation, check of the solution.
//!
//! A [`Factorization`] lives as long as a run. It orders the equations and finds the structure of the factor,
//! or keeps both if the pattern is the last one; it computes the factor, solves with it, and checks the
//! solution against K itself.
//!
//! A stable state has a positive definite tangent and LLᵀ succeeds. Where it meets a pivot that is
//! not positive, the equation is reported (the structure loses stability there, or a node carries
//! almost no material) and LBLᵀ with Bunch–Kaufman pivots takes over. LU with partial pivoting is
//! the last resort, and slow in three dimensions. Unsymmetric matrices have a multifrontal LU from the start,
//! and LU with free pivots as the last resort; both tell the sign of their determinant.
//!
//! All three factorisations are multifrontal. Subtrees of fronts are factorised in parallel, and so are tiles of large
//! fronts; where they are cut depends on the matrix only, so the bits of a solution never depend on the number of threads.
//!
//! ```
//! use mpm_linear::{Factorization, Hints, LatticePlaces, LinearSolver, Matrix, Method, Pattern};
//!
//! // Three nodes in a row with one equation each: K = tridiag(-1, 2, -1), lower triangle.
//! let pattern = Pattern::symmetric(&[0, 2, 4, 5], &[0, 1, 1, 2, 2], 1);
//! let matrix = Matrix { pattern, values: &[2.0, -1.0, 2.0, -1.0, 2.0] };
//! let index = [[0, 0, 0], [1, 0, 0], [2, 0, 0]];
//! let lines = [vec![0.0, 1.0, 2.0], vec![0.0], vec![0.0]];
//! let places = LatticePlaces { index: &index, lines: &lines, periods: [None; 3], degree: [1; 3] };
//!
//! let mut factorization = Factorization::new();
//! factorization.analyse(pattern, &Hints::on_lattice(places))?;
//! let factored = factorization.factorise(matrix)?;
//! assert_eq!(factored.method, Method::Llt);
//!
//! let mut x = [0.0, 0.0, 4.0];
//! let solved = factorization.solve(matrix, &mut x, 0.0)?;
//! assert!(solved.backward_error.is_some_and(|error| error < 1e-15));
//! assert!((x[2] - 3.0).abs() < 1e-14);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod cholesky;
mod column_lu;
mod condition;
mod dissection;
mod elimination;
mod factorization;
mod front_lu;
mod fronts;
mod graph;
mod multifrontal;
mod order;
mod pivots;
mod residual;
mod substitution;
mod symbolic;
mod symmetric_lu;
mod tree;
mod unsymmetric;

pub use cholesky::dense_operation;
pub use factorization::{FactorSize, Factorization, predict_factor};
pub(crate) use order::fingerprint;

#[cfg(test)]
mod tests;

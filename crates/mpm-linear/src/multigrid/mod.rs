//! Conjugate gradients with a geometric multigrid preconditioner, for symmetric matrices of `D × D` blocks
//! whose nodes stand on a lattice that is filled in part: the tangents of implicit material point methods.
//!
//! [`Multigrid::analyse`] takes the pattern and coarsens the lattice: every second line of the directions
//! in which lines stand closest. [`Multigrid::prepare`] takes values and forms the coarse matrices
//! `A_c = Pᵀ A P` (Galerkin), P multilinear interpolation between lattice lines, which reproduces
//! translations and strains. [`Multigrid::solve`] iterates; one V-cycle with a forward block Gauss–Seidel
//! sweep before and a backward one after the coarse correction is the preconditioner
//! (W. L. Briggs, V. E. Henson and S. F. McCormick, *A Multigrid Tutorial*, 2000).
//!
//! Sweeps run over strips of lattice lines, all even strips and then all odd ones: strips of one kind do
//! not couple, so threads change nothing but the time.

mod arithmetic;
mod blocks;
mod coarsening;
mod conjugate_gradients;
mod galerkin;
mod hierarchy;
mod outcome;
mod strips;

pub use hierarchy::{Multigrid, Size};
pub use outcome::{Converged, Failure};

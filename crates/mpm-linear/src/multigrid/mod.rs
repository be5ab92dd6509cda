//! Conjugate gradients and GMRES with a geometric multigrid preconditioner, for matrices of `D × D` blocks whose nodes
//! stand on a lattice that is filled in part: the tangents of implicit material point methods.
//!
//! [`Multigrid::analyse`] takes the pattern and coarsens the lattice: every second line of the directions
//! in which lines stand closest. [`Multigrid::prepare`] takes values and forms the coarse matrices
//! `A_c = Pᵀ A P` (Galerkin), P multilinear interpolation between lattice lines, which reproduces
//! translations and strains. [`Multigrid::solve`] iterates; one V-cycle with a forward block Gauss–Seidel
//! sweep before and a backward one after the coarse correction is the preconditioner
//! (W. L. Briggs, V. E. Henson and S. F. McCormick, *A Multigrid Tutorial*, 2000).
//!
//! Symmetric matrices are solved by conjugate gradients, others by restarted GMRES. The hierarchy of the latter is that of
//! A itself and not of its symmetric part, which is indefinite where frictional material flows.
//!
//! The cycle works in single precision, inside an iteration in double precision: it moves half the bytes, and takes no
//! more iterations.
//!
//! Sweeps run over strips of lattice lines, all even strips and then all odd ones: strips of one kind do
//! not couple, so threads change nothing but the time.

mod arithmetic;
mod blocks;
mod coarsening;
mod coarsest;
mod conjugate_gradients;
mod cycle;
mod finest;
mod galerkin;
mod gmres;
mod hierarchy;
mod interleaved;
mod krylov;
mod lines;
mod outcome;
mod roughness;
mod single;
mod source;
mod strips;

pub(crate) use gmres::RESTART;
pub use hierarchy::{Multigrid, Size};
pub(crate) use interleaved::Interleaved;
pub use lines::{Coarsening, LatticeLines};
pub use outcome::{Converged, Failure};

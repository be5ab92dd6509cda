#![doc = include_str!("../README.md")]
//!
//! # In more detail
//!
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
mod strips;

pub use hierarchy::{Multigrid, Size};

/// Lower triangle of a symmetric matrix by columns, made of `D × D` blocks.
///
/// Rows ascend within a column, the diagonal is the first; the blocks of a node's column are whole, but
/// for the upper half of its diagonal block.
#[derive(Clone, Copy, Debug)]
pub struct Pattern<'a> {
    /// Where each column starts in `row`, and the number of entries at the end.
    pub column_start: &'a [usize],
    /// Row of each entry.
    pub row: &'a [usize],
}

/// Where the nodes of the matrix stand.
#[derive(Clone, Copy, Debug)]
pub struct Nodes<'a> {
    /// Multi-index of each node on the lattice; directions beyond the lattice's are 0.
    pub index: &'a [[u32; 3]],
    /// Coordinates of the lattice lines of each direction `[L]`; only their ratios matter.
    pub lines: &'a [Vec<f64>; 3],
    /// Number of lines of each direction that closes on itself.
    pub periodic: [Option<u32>; 3],
}

/// How a system was solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solved {
    /// Iterations.
    pub iterations: u32,
    /// `|b − A x| / |b|`, computed from x.
    pub residual: f64,
}

/// Why a system was not solved.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Failure {
    /// The matrix is not positive definite.
    #[error("the matrix is not positive definite (seen at node {node})")]
    Indefinite {
        /// A node at which it showed, in the caller's numbering; where it showed on a coarser lattice, or
        /// along a search direction, the node nearest to it or moved most.
        node: usize,
    },
    /// The iterations were used up, or no longer improve x.
    #[error("the residual is {residual:.1e} after {iterations} iterations")]
    NotConverged {
        /// Iterations taken.
        iterations: u32,
        /// `|b − A x| / |b|` reached.
        residual: f64,
    },
    /// The matrix or the right-hand side holds a number that is not finite.
    #[error("the matrix or the right-hand side is not finite at node {node}")]
    NotFinite {
        /// The node, in the caller's numbering.
        node: usize,
    },
}

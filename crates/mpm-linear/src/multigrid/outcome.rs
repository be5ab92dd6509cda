//! How an iteration ended.

/// A system that was solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Converged {
    /// Iterations.
    pub iterations: u32,
    /// `|b − A x| / |b|`, computed from x.
    pub residual: f64,
}

/// How the iteration ended.
pub(crate) enum Stop {
    Solved(Converged),
    NotConverged(Converged),
    /// A search direction along which a symmetric matrix is not positive; the row that it moves most.
    Indefinite {
        row: usize,
    },
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
    /// The coarsest matrix of a hierarchy that is not symmetric is singular, or a diagonal block is not finite.
    #[error("the matrix is singular on a coarser lattice (seen near node {node})")]
    Singular {
        /// The node nearest to where it showed, in the caller's numbering.
        node: usize,
    },
    /// Diagonal entries differ so much that some are beyond single precision, which the cycle works in.
    #[error("the diagonal at node {node} is too small beside the others")]
    OutOfRange {
        /// A node at which, or near which, they do, in the caller's numbering.
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

//! How conjugate gradients ended.

/// A system that was solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Converged {
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

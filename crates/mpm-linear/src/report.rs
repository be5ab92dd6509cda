//! What analysis, factorisation and solution tell the caller.

/// A way to factorise, from the quick and particular to the slow and general.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Method {
    /// Conjugate gradients with multigrid; end if K is not positive definite.
    ConjugateGradients,
    /// K = L Lᵀ; exists if and only if K is positive definite.
    Llt,
    /// K = L B Lᵀ with Bunch–Kaufman pivots (1×1 and 2×2) chosen inside supernodes.
    Lblt,
    /// P K Q = L U with partial pivoting.
    Lu,
}

/// Whether an analysis was made or kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Analysis {
    /// The pattern is new: equations were ordered and memory was sized.
    New,
    /// The pattern equals the last one; everything was kept.
    Reused,
}

/// A pivot of a factorisation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pivot {
    /// Its equation, in the caller's numbering.
    pub equation: usize,
    /// What elimination left of the diagonal (the smaller eigenvalue in size for a 2×2 pivot), in units of K.
    pub value: f64,
    /// |value| over the diagonal entry of K in size: 1e-12 says that twelve digits cancelled.
    /// Infinite where the diagonal of K is zero and the pivot is not.
    pub relative: f64,
}

/// What a factorisation met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// The factorisation that was kept.
    pub method: Method,
    /// The pivot at which LLᵀ stopped, if it was tried and did. A physical signal: stability is
    /// lost at the node of this equation.
    pub not_positive: Option<Pivot>,
    /// Negative eigenvalues of K (Sylvester's law of inertia); unknown for LU.
    pub negative_pivots: Option<usize>,
    /// The pivot that lost most digits of its diagonal; unknown for LU.
    pub weakest: Option<Pivot>,
    /// Smallest over largest pivot in size; unknown for LU.
    pub pivot_ratio: Option<f64>,
}

/// How well a system was solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveReport {
    /// Componentwise backward error of the solution: K and b need relative changes of this size,
    /// entry by entry, to make it exact. Of conjugate gradients `|b − K x| / |b|`.
    pub backward_error: f64,
    /// Steps of iterative refinement taken.
    pub refinements: usize,
    /// Iterations of conjugate gradients, also where they were given up.
    pub iterations: u32,
    /// The factorisation that solved it: LU if another one was found wanting.
    pub method: Method,
}

/// The pattern is too large for this machine's memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not enough memory to factorise {equations} equations: the factor has {factor_entries} entries")]
pub struct OutOfMemory {
    /// Equations of the system.
    pub equations: usize,
    /// Entries of the factor; 0 if the structure of the factor itself did not fit.
    pub factor_entries: usize,
}

/// A system that cannot be solved.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("no solution at equation {equation}: {cause}")]
pub struct Singular {
    /// The equation, in the caller's numbering, that shows it.
    pub equation: usize,
    /// Its pivot, where there is one, in units of K.
    pub pivot: Option<f64>,
    /// What went wrong.
    pub cause: Cause,
}

/// Why a system cannot be solved.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Cause {
    /// All entries of the row are zero: nothing holds this degree of freedom.
    #[error("its row is zero, nothing holds this degree of freedom")]
    EmptyRow,
    /// Elimination left no usable pivot.
    #[error("the matrix is singular")]
    NoPivot,
    /// K has an entry that is not a finite number.
    #[error("the matrix has an entry that is not finite")]
    MatrixNotFinite,
    /// b has an entry that is not a finite number.
    #[error("the right-hand side is not finite")]
    RightHandSideNotFinite,
    /// No factorisation gave an acceptable solution.
    #[error("the best solution has a backward error of {backward_error:.1e}")]
    Inaccurate {
        /// Backward error of that solution.
        backward_error: f64,
    },
    /// Conjugate gradients do not solve it (K is not positive definite, or far from its coarse images),
    /// and its factor is too large.
    #[error(
        "conjugate gradients do not solve the system, as where the tangent is not positive definite or the \
         material nearly incompressible, and its factor would have about {entries:.0e} entries"
    )]
    TooLargeToFactorise {
        /// Entries of the factor, about.
        entries: f64,
    },
}

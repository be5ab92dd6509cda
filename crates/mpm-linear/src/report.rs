//! What analysis, factorisation and solution tell the caller.

/// How a system was solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Conjugate gradients with multigrid; end if K is not positive definite.
    ConjugateGradients,
    /// Restarted GMRES with multigrid, for matrices that are not symmetric or not positive definite.
    Gmres,
    /// K = L Lᵀ; exists if and only if K is positive definite.
    Llt,
    /// K = L B Lᵀ with Bunch–Kaufman pivots (1×1 and 2×2) chosen inside supernodes.
    Lblt,
    /// P K Q = L U with partial pivoting.
    Lu,
    /// A method of another solver, by its name.
    Other(&'static str),
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

/// Numbers of positive and negative eigenvalues of a symmetric matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Inertia {
    /// Positive eigenvalues.
    pub positive: usize,
    /// Negative eigenvalues.
    pub negative: usize,
}

/// Sign of a determinant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// Above 0.
    Positive,
    /// Below 0.
    Negative,
}

/// What a factorisation found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Factored {
    /// The method that will solve.
    pub method: Method,
    /// Signs of the eigenvalues of K (Sylvester's law of inertia), where the method tells them.
    pub inertia: Option<Inertia>,
    /// Sign of det K, where the method tells it.
    pub determinant_sign: Option<Sign>,
    /// The pivot at which LLᵀ stopped, if it was tried and did. A physical signal: stability is
    /// lost at the node of this equation.
    pub not_positive: Option<Pivot>,
    /// The equation at which an iteration saw that K, though symmetric, is not positive definite: the one that the
    /// direction moves most along which K is not positive.
    pub indefinite_at: Option<usize>,
    /// The pivot that lost most digits of its diagonal, where the method tells it.
    pub weakest: Option<Pivot>,
    /// Smallest over largest pivot in size, where the method tells it.
    pub pivot_ratio: Option<f64>,
}

impl Factored {
    /// By a method that tells nothing about the matrix.
    pub fn by(method: Method) -> Self {
        Self {
            method,
            inertia: None,
            determinant_sign: None,
            not_positive: None,
            indefinite_at: None,
            weakest: None,
            pivot_ratio: None,
        }
    }

    /// Whether K was seen not to be positive definite: a pivot, an eigenvalue, or a direction is not positive, or
    /// det K is negative.
    pub fn shows_instability(&self) -> bool {
        self.not_positive.is_some()
            || self.indefinite_at.is_some()
            || self.inertia.is_some_and(|inertia| inertia.negative > 0)
            || self.determinant_sign == Some(Sign::Negative)
    }
}

/// How well a system was solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solved {
    /// The method that solved it.
    pub method: Method,
    /// Componentwise backward error of the solution, where it was computed: K and b need relative changes of
    /// this size, entry by entry, to make it exact.
    pub backward_error: Option<f64>,
    /// `|b − K x| / |b|`, where it was computed: what an iteration has left.
    pub residual: Option<f64>,
    /// Steps of iterative refinement taken.
    pub refinements: usize,
    /// Iterations of conjugate gradients or GMRES, also where they were given up.
    pub iterations: u32,
    /// What another method found that took over because the solutions by the first one were not accurate, the
    /// iteration did not converge, or conjugate gradients saw that K is not positive definite.
    pub taken_over: Option<Factored>,
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
    /// Memory does not suffice for factors with free pivots.
    #[error("memory does not suffice for its factors of over {entries:.0e} entries")]
    NoMemory {
        /// Entries that were stored.
        entries: f64,
    },
    /// The iteration does not solve it (K is not positive definite, or far from its coarse images), and its factor is
    /// too large.
    #[error(
        "the iteration does not solve the system, as where the tangent is not positive definite or the \
         material nearly incompressible, and its factor would have about {entries:.0e} entries"
    )]
    TooLargeToFactorise {
        /// Entries of the factor, about.
        entries: f64,
    },
    /// The solver does not take matrices of this kind, whatever their values: what it needs, in a sentence that follows
    /// on a colon. No step is tried again.
    #[error("{0}")]
    Unsuitable(&'static str),
}

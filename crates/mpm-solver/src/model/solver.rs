//! How the linear systems of a run are solved.

use mpm_linear::{Choice, LinearSolver};

/// Makes a linear solver, once for every run.
pub type SolverFactory = Box<dyn Fn() -> Box<dyn LinearSolver> + Send + Sync>;

/// How linear systems are solved.
///
/// ```
/// use mpm_linear::{Automatic, Choice};
/// use mpm_solver::SolverChoice;
///
/// // By factorisation.
/// let direct = SolverChoice::from(Choice::Direct);
/// // By a solver of one's own, here another one of this library.
/// let custom = SolverChoice::custom(|| Automatic::new(Choice::Iterative));
/// # let _ = (direct, custom);
/// ```
pub enum SolverChoice {
    /// By the solvers of `mpm-linear`.
    Automatic(Choice),
    /// By a solver of one's own.
    Custom(SolverFactory),
}

impl SolverChoice {
    /// By a solver of one's own that `make` returns at the start of every run.
    pub fn custom<S: LinearSolver + 'static>(make: impl Fn() -> S + Send + Sync + 'static) -> Self {
        Self::Custom(Box::new(move || Box::new(make())))
    }
}

impl Default for SolverChoice {
    fn default() -> Self {
        Self::Automatic(Choice::Auto)
    }
}

impl From<Choice> for SolverChoice {
    fn from(choice: Choice) -> Self {
        Self::Automatic(choice)
    }
}

//! The interface of every linear solver.

use crate::matrix::{Matrix, Pattern};
use crate::report::{Analysis, Factored, Method, OutOfMemory, Singular, Solved};
use std::ops::Range;

/// Solves the linear systems K x = b of a run, one after another.
///
/// A run calls the methods in this order:
/// 1. [`restore`](Self::restore), once, where the run goes on from a checkpoint;
/// 2. [`analyse`](Self::analyse), whenever a load step is tried;
/// 3. [`factorise`](Self::factorise), for every matrix;
/// 4. [`solve`](Self::solve), for every right-hand side of that matrix;
/// 5. [`end_step`](Self::end_step) once the load step has converged, then [`save`](Self::save) where a
///    checkpoint is due. A step that does not converge is tried again from 2 on.
///
/// Methods with a body have nothing to do in most solvers.
pub trait LinearSolver {
    /// Prepares for matrices of this pattern. It also [restarts](Self::restart) the solver.
    ///
    /// # Errors
    /// If memory does not suffice.
    fn analyse(&mut self, pattern: Pattern<'_>, hints: &Hints<'_>) -> Result<Analysis, OutOfMemory>;

    /// Takes the matrix of the next solutions. Its pattern is the one last analysed.
    ///
    /// # Errors
    /// If the matrix is singular, is not finite, or cannot be solved by this solver. The load step is then cut. With
    /// [`crate::Cause::Unsuitable`], for a kind of matrix that this solver does not take at all, the run ends.
    fn factorise(&mut self, matrix: Matrix<'_>) -> Result<Factored, Singular>;

    /// Replaces the right-hand side b by x with K x = b, where K is the `matrix` last factorised. (A solver
    /// needs no copy of it for checking solutions, because it is given once more.) An iterative solver may
    /// leave `|b − K x| ≤ tolerance · |b|`, in Euclidean norms.
    ///
    /// # Errors
    /// If no accurate solution was found or b is not finite; `rhs` is unchanged then.
    fn solve(&mut self, matrix: Matrix<'_>, rhs: &mut [f64], tolerance: f64) -> Result<Solved, Singular>;

    /// The method that is tried first on the next matrix. It is written into the history of the run where a
    /// load step needs no solution.
    fn first_method(&self) -> Method;

    /// Forgets what the matrices since the last analysis have shown, for example that they are
    /// indefinite: Newton's method begins anew from another state.
    fn restart(&mut self) {}

    /// The load step has converged: what was analysed for it is kept, and a checkpoint may save it.
    fn end_step(&mut self) {}

    /// What a run that is resumed needs in order to go on bit for bit: nothing, where any analysis of a
    /// pattern gives the same solutions.
    fn save(&self) -> Option<Saved> {
        None
    }

    /// Goes on from what [`Self::save`] returned in an earlier run.
    ///
    /// # Errors
    /// If another solver has saved it, or it is damaged.
    fn restore(&mut self, saved: Saved) -> Result<(), NotSavedHere> {
        let _ = saved;
        Err(NotSavedHere { reason: "is of another linear solver".to_owned() })
    }

    /// Estimate of the condition number |λ|_max / |λ|_min of the matrix last factorised, where the solver
    /// can tell.
    fn condition(&mut self, matrix: Matrix<'_>) -> Option<f64> {
        let _ = matrix;
        None
    }
}

/// What is known of a linear system besides its entries. A solver takes what helps it.
#[derive(Clone, Default)]
pub struct Hints<'a> {
    /// Where the nodes stand on a lattice.
    pub lattice: Option<LatticePlaces<'a>>,
    /// Position of a node `[L]`, 0 in directions that do not exist.
    pub position: Option<&'a dyn Fn(usize) -> [f64; 3]>,
    /// The node at which an equation stands that comes behind those of the nodes: of a further field on the nodes, which
    /// couples as their other equations do.
    pub further: Option<&'a dyn Fn(usize) -> Option<usize>>,
    /// Whether the displacement of an equation is prescribed: its row and column hold nothing but the diagonal.
    pub is_held: Option<&'a dyn Fn(usize) -> bool>,
    /// Whether the caller knows that the pattern is the one last analysed.
    pub is_kept: bool,
    /// Equations that this process owns, where several share a system; all of them, if left out.
    pub owned: Option<Range<usize>>,
}

impl<'a> Hints<'a> {
    /// The nodes stand on a lattice; nothing else is known.
    pub fn on_lattice(places: LatticePlaces<'a>) -> Self {
        Self { lattice: Some(places), ..Self::default() }
    }
}

/// Where the nodes of a system stand on a lattice of lines, which may be occupied in part.
#[derive(Clone, Copy, Debug)]
pub struct LatticePlaces<'a> {
    /// Multi-index of each node; 0 in directions that do not exist.
    pub index: &'a [[u32; 3]],
    /// Coordinates of the lines of each direction `[L]`; only their ratios matter.
    pub lines: &'a [Vec<f64>; 3],
    /// Number of lines of each direction that closes on itself.
    pub periods: [Option<u32>; 3],
    /// Degree of the splines along each direction whose coefficients belong to the nodes: 1 where these are values at the nodes.
    pub degree: [u32; 3],
}

/// What a linear solver keeps for a run that is resumed. Only the solver that saved it can read it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Saved {
    /// Tells what the numbers belong to.
    pub fingerprint: u64,
    /// Anything.
    pub numbers: Vec<u64>,
}

/// Saved numbers that are not of the solver that is to restore them.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{reason}")]
pub struct NotSavedHere {
    /// What the numbers are, and what was expected.
    pub reason: String,
}

//! The iteration of a run: a multigrid hierarchy with its coarse matrices, by conjugate gradients or GMRES.

use crate::matrix::{Matrix, Pattern, Symmetry};
use crate::multigrid::{Converged, Failure, Interleaved, Multigrid};
use crate::prediction::Prediction;
use crate::report::{Factored, Method};
use crate::solver::{Hints, LatticePlaces};

/// Coarse matrices are renewed when a solution took more than this times the iterations of the first with them.
const SLOWER: f64 = 1.3;

/// An iteration for one pattern, and what it is of.
pub(super) struct Iterative {
    pub(super) method: Method,
    pub(super) multigrid: Box<dyn Iteration>,
    /// A node at which a symmetric matrix was seen not to be positive definite since the last restart.
    pub(super) indefinite_at: Option<usize>,
    /// Whether GMRES goes on then.
    pub(super) goes_on: bool,
    /// Of pattern and places: all that the hierarchy depends on besides the lattice.
    pub(super) fingerprint: u64,
    pub(super) index: Vec<[u32; 3]>,
    pub(super) lines: [Vec<f64>; 3],
    pub(super) periods: [Option<u32>; 3],
    pub(super) prediction: Prediction,
    /// Equations of each node, without that of a further field.
    pub(super) block: usize,
    /// Nodes of the equations of a further field, in order.
    pub(super) further: Vec<usize>,
    pub(super) coarse: Coarse,
}

/// What the coarse matrices at hand are of. They are kept through a load step as long as they serve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Coarse {
    /// Of no matrix, or one that they no longer suit.
    Old,
    /// Of the matrix at hand, or of an earlier one; iterations for each factor of e that the first solution with them
    /// has taken off its residual.
    Kept { is_of_this: bool, first: Option<f64> },
}

impl Coarse {
    /// What becomes of them after a solution: a small number of iterations may have one more.
    fn after(self, solved: &Converged) -> Self {
        let Self::Kept { is_of_this, first } = self else { return self };
        let taken_off = -solved.residual.ln();
        if !(taken_off > 0.0 && taken_off.is_finite()) {
            return self;
        }
        let iterations = f64::from(solved.iterations);
        match first {
            Some(first) if iterations > (SLOWER * first * taken_off).max(first * taken_off + 1.0) => Self::Old,
            Some(_) => self,
            None => Self::Kept { is_of_this, first: Some(iterations / taken_off) },
        }
    }
}

impl Iterative {
    /// Begins with conjugate gradients again, if the pattern is symmetric, and with coarse matrices of the next matrix.
    pub(super) fn restart(&mut self) {
        self.coarse = Coarse::Old;
        if self.indefinite_at.take().is_some() {
            self.method = Method::ConjugateGradients;
            self.multigrid.take_as(Symmetry::Symmetric);
        }
    }

    /// Does something by conjugate gradients, and once more by GMRES where the matrix proves not to be positive definite.
    pub(super) fn or_by_gmres<T>(
        &mut self,
        mut work: impl FnMut(&mut Self, bool) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        match work(self, false) {
            Err(Failure::Indefinite { node }) if self.goes_on && self.indefinite_at.is_none() => {
                self.indefinite_at = Some(node);
                self.method = Method::Gmres;
                self.multigrid.take_as(Symmetry::Unsymmetric);
                self.coarse = Coarse::Old;
                work(self, true)
            }
            outcome => outcome,
        }
    }

    /// What was found while a matrix was prepared or solved.
    pub(super) fn found(&self) -> Factored {
        Factored {
            indefinite_at: self.indefinite_at.map(|node| node * self.block),
            ..Factored::by(self.method)
        }
    }

    /// Takes a matrix, with coarse matrices of its own or those that are kept.
    pub(super) fn take(&mut self, matrix: Matrix<'_>) -> Result<(), Failure> {
        if let Coarse::Kept { first, .. } = self.coarse {
            self.coarse = Coarse::Kept { is_of_this: false, first };
            return self.multigrid.update(matrix);
        }
        self.multigrid.prepare(matrix)?;
        self.coarse = Coarse::Kept { is_of_this: true, first: None };
        Ok(())
    }

    /// Solves; where kept coarse matrices do not serve, with new ones. Leaves x as it was where that fails.
    pub(super) fn solve(
        &mut self,
        matrix: Matrix<'_>,
        x: &mut [f64],
        (tolerance, most): (f64, u32),
    ) -> Result<Converged, Failure> {
        let b = x.to_vec();
        let mut outcome = self.multigrid.solve(x, tolerance, most);
        let is_kept = matches!(self.coarse, Coarse::Kept { is_of_this: false, .. });
        if is_kept && matches!(outcome, Err(Failure::NotConverged { .. } | Failure::Indefinite { .. })) {
            x.copy_from_slice(&b);
            self.coarse = Coarse::Old;
            outcome = self.take(matrix).and_then(|()| self.multigrid.solve(x, tolerance, most));
        }
        match &outcome {
            Ok(solved) => self.coarse = self.coarse.after(solved),
            Err(_) => x.copy_from_slice(&b),
        }
        outcome
    }
}

/// An iteration with multigrid for any number of equations a node.
pub(super) trait Iteration: Send {
    fn take_as(&mut self, symmetry: Symmetry);
    fn prepare(&mut self, matrix: Matrix<'_>) -> Result<(), Failure>;
    fn update(&mut self, matrix: Matrix<'_>) -> Result<(), Failure>;
    fn solve(&mut self, x: &mut [f64], tolerance: f64, iterations: u32) -> Result<Converged, Failure>;
}

impl<const D: usize> Iteration for Multigrid<D> {
    fn take_as(&mut self, symmetry: Symmetry) {
        Multigrid::take_as(self, symmetry);
    }

    fn prepare(&mut self, matrix: Matrix<'_>) -> Result<(), Failure> {
        Multigrid::prepare(self, matrix)
    }

    fn update(&mut self, matrix: Matrix<'_>) -> Result<(), Failure> {
        Multigrid::update(self, matrix)
    }

    fn solve(&mut self, x: &mut [f64], tolerance: f64, iterations: u32) -> Result<Converged, Failure> {
        Multigrid::solve(self, x, tolerance, iterations)
    }
}

impl<const N: usize> Iteration for Interleaved<N> {
    fn take_as(&mut self, symmetry: Symmetry) {
        Interleaved::take_as(self, symmetry);
    }

    fn prepare(&mut self, matrix: Matrix<'_>) -> Result<(), Failure> {
        Interleaved::prepare(self, matrix)
    }

    fn update(&mut self, matrix: Matrix<'_>) -> Result<(), Failure> {
        Interleaved::update(self, matrix)
    }

    fn solve(&mut self, x: &mut [f64], tolerance: f64, iterations: u32) -> Result<Converged, Failure> {
        Interleaved::solve(self, x, tolerance, iterations)
    }
}

/// Nodes of the equations behind those of the nodes, in order; none where one of them belongs to no node.
pub(super) fn further(pattern: Pattern<'_>, hints: &Hints<'_>) -> Option<Vec<usize>> {
    let mut behind = pattern.block * pattern.blocks..pattern.n_equations();
    behind.try_fold(Vec::new(), |mut nodes, equation| {
        nodes.push(hints.further?(equation)?);
        Some(nodes)
    })
}

/// The iteration for a pattern.
pub(super) fn method(pattern: Pattern<'_>) -> Method {
    if pattern.is_symmetric() { Method::ConjugateGradients } else { Method::Gmres }
}

pub(super) fn hierarchy(
    pattern: Pattern<'_>,
    further: &[usize],
    places: LatticePlaces<'_>,
) -> Option<Box<dyn Iteration>> {
    fn boxed<const D: usize>(pattern: Pattern<'_>, places: LatticePlaces<'_>) -> Option<Box<dyn Iteration>> {
        Multigrid::<D>::analyse(pattern, places).map(|it| Box::new(it) as Box<dyn Iteration>)
    }
    let node_of = |equation: usize| further.get(equation - pattern.block * pattern.blocks).copied();
    match (pattern.block, further.is_empty()) {
        (1, true) => boxed::<1>(pattern, places),
        (2, true) => boxed::<2>(pattern, places),
        (3, true) => boxed::<3>(pattern, places),
        (2, false) => Some(Box::new(Interleaved::<3>::analyse(pattern, node_of, places)?)),
        (3, false) => Some(Box::new(Interleaved::<4>::analyse(pattern, node_of, places)?)),
        _ => None,
    }
}

//! The linear solver of a run: direct, or iterative where that is asked for or predicted to be quicker.

use crate::direct::{Factorization, StoredOrder, fingerprint};
use crate::matrix::SymmetricPattern;
use crate::multigrid::{Failure, Multigrid};
use crate::prediction::{Prediction, predict};
use crate::report::{Analysis, Cause, Method, OutOfMemory, Report, Singular, SolveReport};
use crate::solver::Place;

/// Iterations after which a system is left to the direct solver.
const MOST_ITERATIONS: u32 = 400;

/// The least limit of iterations where the solver is chosen by its predicted cost.
const LEAST_BUDGET: u32 = 30;

/// Entries of a factor for which an iterative run still takes the direct solver's help: 8 GB.
const MOST_ENTRIES_AS_HELP: f64 = 1e9;

/// Which solver a scene asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Choice {
    /// The one that is predicted to be quicker.
    #[default]
    Auto,
    /// Sparse factorisation.
    Direct,
    /// Conjugate gradients with multigrid; what they cannot solve is factorised, if the factor is small enough.
    Iterative,
}

impl Choice {
    /// Whether a system of `D` equations a node is solved by iteration.
    pub fn is_iterative(self, prediction: &Prediction) -> bool {
        match self {
            Choice::Direct => false,
            Choice::Iterative => true,
            Choice::Auto => prediction.prefers_iterative(),
        }
    }

    /// Iterations after which a system is left to the direct solver: at once where that was asked not to be
    /// taken, else when as much has been spent as a factorisation is predicted to cost.
    fn most_iterations(self, prediction: &Prediction) -> u32 {
        match self {
            Choice::Auto => (prediction.break_even() as u32).clamp(LEAST_BUDGET, MOST_ITERATIONS),
            Choice::Direct | Choice::Iterative => MOST_ITERATIONS,
        }
    }
}

/// Solves one linear system after another, with `D` equations a node.
pub struct LinearSolver<const D: usize> {
    choice: Choice,
    direct: Factorization,
    iterative: Option<Iterative<D>>,
    /// Whether the matrix at hand has been left to the direct solver.
    helped: bool,
    /// Fingerprint of the hierarchy that an earlier run had at hand: its first analysis counts as kept.
    given: Option<u64>,
    /// Whether a hierarchy has been made since the last [`Self::settle`].
    unsettled: bool,
}

struct Iterative<const D: usize> {
    multigrid: Multigrid<D>,
    /// Of pattern and places: all that the hierarchy depends on besides the lattice.
    fingerprint: u64,
    index: Vec<[u32; 3]>,
    periodic: [Option<u32>; 3],
    prediction: Prediction,
}

impl<const D: usize> LinearSolver<D> {
    /// A solver that has not seen a pattern yet.
    pub fn new(choice: Choice) -> Self {
        Self {
            choice,
            direct: Factorization::new(),
            iterative: None,
            helped: false,
            given: None,
            unsettled: false,
        }
    }

    /// Prepares for matrices of this pattern.
    ///
    /// # Errors
    /// If the factor does not fit into memory.
    pub fn analyse(
        &mut self,
        pattern: SymmetricPattern<'_>,
        place: Place<'_>,
    ) -> Result<Analysis, OutOfMemory> {
        self.helped = false;
        let prediction = (self.choice != Choice::Direct).then(|| predict::<D>(pattern, place));
        let Some(prediction) = prediction.filter(|it| self.choice.is_iterative(it)) else {
            self.iterative = None;
            return self.direct.analyse(pattern, place.index, place.periodic, D);
        };
        let fingerprint = fingerprint(pattern, place.index);
        if self.iterative.as_ref().is_some_and(|kept| kept.fingerprint == fingerprint) {
            return Ok(Analysis::Reused);
        }
        let analysis = match self.given.take() {
            Some(given) if given == fingerprint => Analysis::Reused,
            _ => Analysis::New,
        };
        self.unsettled |= analysis == Analysis::New;
        // The memory of the former hierarchy is free before the next one is made; a factorisation that
        // helps with the next one orders its equations anew.
        self.iterative = None;
        self.direct = Factorization::new();
        let multigrid = Multigrid::analyse(pattern, place);
        let (index, periodic) = (place.index.to_vec(), place.periodic);
        self.iterative = Some(Iterative { multigrid, fingerprint, index, periodic, prediction });
        Ok(analysis)
    }

    /// The method that solves until it fails.
    pub fn first_method(&self) -> Method {
        if self.iterative.is_some() { Method::ConjugateGradients } else { Method::Llt }
    }

    /// Takes the matrix with these `values`; begins with `start`, as [`Factorization::factorise`].
    ///
    /// # Errors
    /// If the matrix is singular or not finite, or is not positive definite and too large for a factorisation.
    pub fn factorise(
        &mut self,
        pattern: SymmetricPattern<'_>,
        values: &[f64],
        start: Method,
    ) -> Result<Report, Singular> {
        self.helped = false;
        let Some(iterative) = self.iterative.as_mut().filter(|_| start == Method::ConjugateGradients) else {
            return match self.iterative {
                Some(_) => self.help(pattern, values, start),
                None => self.direct.factorise(values, start.max(Method::Llt)),
            };
        };
        match iterative.multigrid.prepare(pattern, values) {
            Ok(()) => Ok(Report {
                method: Method::ConjugateGradients,
                not_positive: None,
                negative_pivots: None,
                weakest: None,
                pivot_ratio: None,
            }),
            Err(Failure::NotFinite { node }) => {
                Err(Singular { equation: node * D, pivot: None, cause: Cause::MatrixNotFinite })
            }
            Err(_) => self.help(pattern, values, Method::Llt),
        }
    }

    /// Replaces b by the solution; conjugate gradients leave `tolerance · |b|` of it, at most.
    ///
    /// # Errors
    /// If no accurate solution was found or b is not finite; `rhs` is unchanged then.
    pub fn solve(
        &mut self,
        pattern: SymmetricPattern<'_>,
        values: &[f64],
        rhs: &mut [f64],
        tolerance: f64,
    ) -> Result<SolveReport, Singular> {
        let iterative = match &mut self.iterative {
            Some(iterative) if !self.helped => iterative,
            _ => return self.direct.solve(values, rhs),
        };
        let b = rhs.to_vec();
        let (method, refinements) = (Method::ConjugateGradients, 0);
        match iterative.multigrid.solve(rhs, tolerance, self.choice.most_iterations(&iterative.prediction)) {
            Ok(solved) => {
                let (backward_error, iterations) = (solved.residual, solved.iterations);
                Ok(SolveReport { backward_error, refinements, method, iterations })
            }
            Err(Failure::NotFinite { node }) => {
                rhs.copy_from_slice(&b);
                Err(Singular { equation: node * D, pivot: None, cause: Cause::RightHandSideNotFinite })
            }
            Err(failure) => {
                rhs.copy_from_slice(&b);
                let iterations = match failure {
                    Failure::NotConverged { iterations, .. } => iterations,
                    _ => 0,
                };
                self.help(pattern, values, Method::Llt)?;
                let report = self.direct.solve(values, rhs)?;
                Ok(SolveReport { iterations, ..report })
            }
        }
    }

    /// Factorises a matrix that the iteration cannot solve, or should not try.
    fn help(
        &mut self,
        pattern: SymmetricPattern<'_>,
        values: &[f64],
        start: Method,
    ) -> Result<Report, Singular> {
        let Iterative { index, periodic, prediction, .. } = self.iterative.as_ref().expect("it asked for help");
        let refused = |cause| Singular { equation: 0, pivot: None, cause };
        if prediction.factor_entries > MOST_ENTRIES_AS_HELP {
            return Err(refused(Cause::TooLargeToFactorise { entries: prediction.factor_entries }));
        }
        let analysed = self.direct.analyse(pattern, index, *periodic, D);
        analysed.map_err(|_| refused(Cause::TooLargeToFactorise { entries: prediction.factor_entries }))?;
        let report = self.direct.factorise(values, start.max(Method::Llt))?;
        self.helped = true;
        Ok(report)
    }

    /// See [`Factorization::condition`]; none of a system that was solved by iteration.
    pub fn condition(&mut self, values: &[f64]) -> Option<f64> {
        if self.iterative.is_some() && !self.helped {
            return None;
        }
        self.direct.condition(values)
    }

    /// See [`Factorization::recall`].
    pub fn recall(&mut self, order: Option<StoredOrder>) {
        match order {
            Some(StoredOrder { fingerprint, order }) if order.is_empty() => self.given = Some(fingerprint),
            order => self.direct.recall(order),
        }
    }

    /// See [`Factorization::settle`].
    pub fn settle(&mut self) {
        self.unsettled = false;
        self.direct.settle();
    }

    /// See [`Factorization::store`]; of a hierarchy only the fingerprint, without an order.
    pub fn store(&self) -> Option<StoredOrder> {
        let of_hierarchy = |fingerprint| StoredOrder { fingerprint, order: Vec::new() };
        match &self.iterative {
            _ if self.given.is_some() => self.given.map(of_hierarchy),
            Some(kept) => (!self.unsettled).then(|| of_hierarchy(kept.fingerprint)),
            None => self.direct.store(),
        }
    }
}

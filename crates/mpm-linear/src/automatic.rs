//! The linear solver of a run: direct, or iterative where that is asked for or predicted to be quicker.

mod iterative;

use crate::direct::{Factorization, fingerprint};
use crate::matrix::{Matrix, Pattern};
use crate::multigrid::{Converged, Failure};
use crate::prediction::{Prediction, predict};
use crate::report::{Analysis, Cause, Factored, Method, OutOfMemory, Singular, Solved};
use crate::solver::{Hints, LatticePlaces, LinearSolver, NotSavedHere, Saved};
use iterative::{Coarse, Iterative, further, hierarchy, method};

/// Iterations after which a system is left to the direct solver, whatever they cost.
const MOST_ITERATIONS: u32 = 400;

/// The least limit of iterations where the solver is chosen by its predicted cost.
const LEAST_BUDGET: u32 = 30;

/// Which solver is wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Choice {
    /// The one that is predicted to be quicker.
    #[default]
    Auto,
    /// Sparse factorisation.
    Direct,
    /// Conjugate gradients with multigrid, or GMRES where the matrix is not symmetric; what they cannot solve is
    /// factorised, if the factor is small enough.
    Iterative,
}

impl Choice {
    /// Whether a system that can be iterated on is solved by iteration.
    pub fn is_iterative(self, prediction: &Prediction) -> bool {
        match self {
            Choice::Direct => false,
            Choice::Iterative => true,
            Choice::Auto => prediction.prefers_iterative(),
        }
    }

    /// Iterations after which a system is left to the direct solver: at once where that was asked not to be
    /// taken, else when as much has been spent as a factorisation is predicted to cost.
    fn most_iterations(self, prediction: &Prediction, is_indefinite: bool) -> u32 {
        match self {
            Choice::Auto => (prediction.break_even(is_indefinite) as u32).clamp(LEAST_BUDGET, MOST_ITERATIONS),
            Choice::Direct | Choice::Iterative => MOST_ITERATIONS,
        }
    }

    /// Whether GMRES goes on with a symmetric matrix that is not positive definite; else it is factorised.
    pub fn iterates_where_indefinite(self, prediction: &Prediction) -> bool {
        match self {
            Choice::Direct => false,
            Choice::Iterative => true,
            Choice::Auto => prediction.prefers_gmres_where_indefinite(),
        }
    }
}

/// Solves by iteration or by factorisation, as the [`Choice`] says.
///
/// The iteration needs a matrix whose equations all belong to nodes on a lattice, also those of a further field on the nodes;
/// other matrices are factorised. It is by conjugate gradients where the matrix is symmetric, else by GMRES; GMRES goes on where
/// conjugate gradients see that a matrix is not positive definite, and takes the next matrices, too, until the restart.
pub struct Automatic {
    choice: Choice,
    direct: Factorization,
    iterative: Option<Iterative>,
    /// Whether the matrix at hand has been left to the direct solver.
    helped: bool,
    /// Whether a matrix has been left to it since the last restart; the next ones then are, too.
    has_given_up: bool,
    /// Fingerprint of the hierarchy that an earlier run had at hand: its first analysis counts as kept.
    given: Option<u64>,
    /// Whether a hierarchy has been made since the last [`LinearSolver::end_step`].
    is_new: bool,
}

impl Automatic {
    /// A solver that has not seen a pattern yet.
    pub fn new(choice: Choice) -> Self {
        Self {
            choice,
            direct: Factorization::new(),
            iterative: None,
            helped: false,
            has_given_up: false,
            given: None,
            is_new: false,
        }
    }

    /// Whether systems of a pattern can be solved by iteration.
    pub fn can_iterate(pattern: Pattern<'_>, hints: &Hints<'_>) -> bool {
        hints.lattice.is_some() && (1..=3).contains(&pattern.block) && further(pattern, hints).is_some()
    }

    /// The places of the nodes and the predicted cost, if the system is to be solved by iteration.
    fn iterates<'a>(&self, pattern: Pattern<'_>, hints: &Hints<'a>) -> Option<(LatticePlaces<'a>, Prediction)> {
        let can_be = self.choice != Choice::Direct && Self::can_iterate(pattern, hints);
        let places = hints.lattice.filter(|_| can_be)?;
        let prediction = predict(pattern, places);
        self.choice.is_iterative(&prediction).then_some((places, prediction))
    }

    /// Factorises a matrix that the iteration cannot solve, or should not try.
    fn help(&mut self, matrix: Matrix<'_>) -> Result<Factored, Singular> {
        let Iterative { index, lines, periods, prediction, further, .. } =
            self.iterative.as_ref().expect("it asked for help");
        let refused = Singular {
            equation: 0,
            pivot: None,
            cause: Cause::TooLargeToFactorise { entries: prediction.factor_entries },
        };
        self.has_given_up = true;
        if !prediction.is_factorised_as_help() {
            return Err(refused);
        }
        let behind = matrix.pattern.block * matrix.pattern.blocks;
        let node_of = |equation: usize| further.get(equation - behind).copied();
        // The direct solver asks for no degree.
        let places = LatticePlaces { index, lines, periods: *periods, degree: [1; 3] };
        let hints = Hints { further: Some(&node_of), ..Hints::on_lattice(places) };
        self.direct.prepare(matrix.pattern, &hints).map_err(|_| refused)?;
        let factored = self.direct.factorise(matrix)?;
        self.helped = true;
        Ok(factored)
    }
}

impl LinearSolver for Automatic {
    fn analyse(&mut self, pattern: Pattern<'_>, hints: &Hints<'_>) -> Result<Analysis, OutOfMemory> {
        self.helped = false;
        self.restart();
        let Some((places, prediction)) = self.iterates(pattern, hints) else {
            self.iterative = None;
            return self.direct.analyse(pattern, hints);
        };
        let fingerprint = fingerprint(pattern, places.index);
        if self.iterative.as_ref().is_some_and(|kept| kept.fingerprint == fingerprint) {
            return Ok(Analysis::Reused);
        }
        let analysis = match self.given.take() {
            Some(given) if given == fingerprint => Analysis::Reused,
            _ => Analysis::New,
        };
        self.is_new |= analysis == Analysis::New;
        // The memory of the former hierarchy is free before the next one is made; a factorisation that
        // helps with the next one orders its equations anew.
        self.iterative = None;
        self.direct = Factorization::new();
        let further = further(pattern, hints).unwrap_or_default();
        let Some(multigrid) = hierarchy(pattern, &further, places) else {
            return self.direct.analyse(pattern, hints);
        };
        let LatticePlaces { index, lines, periods, .. } = places;
        let (index, lines, block) = (index.to_vec(), lines.clone(), pattern.block);
        let method = method(pattern);
        self.iterative = Some(Iterative {
            method,
            multigrid,
            indefinite_at: None,
            goes_on: pattern.is_symmetric() && self.choice.iterates_where_indefinite(&prediction),
            fingerprint,
            index,
            lines,
            periods,
            prediction,
            block,
            further,
            coarse: Coarse::Old,
        });
        Ok(analysis)
    }

    /// # Errors
    /// If the matrix is singular or not finite, or cannot be iterated on and is too large for a factorisation.
    fn factorise(&mut self, matrix: Matrix<'_>) -> Result<Factored, Singular> {
        self.helped = false;
        let Some(iterative) = &mut self.iterative else {
            return self.direct.factorise(matrix);
        };
        if self.has_given_up {
            return self.help(matrix);
        }
        match iterative.or_by_gmres(|it, _| it.take(matrix)) {
            Ok(()) => Ok(iterative.found()),
            Err(Failure::NotFinite { node }) => {
                let equation = node * iterative.block;
                Err(Singular { equation, pivot: None, cause: Cause::MatrixNotFinite })
            }
            Err(_) => self.help(matrix),
        }
    }

    fn solve(&mut self, matrix: Matrix<'_>, rhs: &mut [f64], tolerance: f64) -> Result<Solved, Singular> {
        let iterative = match &mut self.iterative {
            Some(iterative) if !self.helped => iterative,
            _ => return self.direct.solve(matrix, rhs, tolerance),
        };
        let (choice, was_indefinite) = (self.choice, iterative.indefinite_at.is_some());
        let solved = iterative.or_by_gmres(|it, is_again| {
            if is_again {
                it.take(matrix)?;
            }
            let most = choice.most_iterations(&it.prediction, it.indefinite_at.is_some());
            it.solve(matrix, rhs, (tolerance, most))
        });
        let iterations = match solved {
            Ok(Converged { iterations, residual }) => {
                let is_seen_now = iterative.indefinite_at.is_some() && !was_indefinite;
                return Ok(Solved {
                    method: iterative.method,
                    backward_error: None,
                    residual: Some(residual),
                    refinements: 0,
                    iterations,
                    taken_over: is_seen_now.then(|| iterative.found()),
                });
            }
            Err(Failure::NotFinite { node }) => {
                let equation = node * iterative.block;
                return Err(Singular { equation, pivot: None, cause: Cause::RightHandSideNotFinite });
            }
            Err(Failure::NotConverged { iterations, .. }) => iterations,
            Err(Failure::Indefinite { .. } | Failure::Singular { .. } | Failure::OutOfRange { .. }) => 0,
        };
        let factored = self.help(matrix)?;
        let solved = self.direct.solve(matrix, rhs, tolerance)?;
        Ok(Solved { iterations, taken_over: solved.taken_over.or(Some(factored)), ..solved })
    }

    fn first_method(&self) -> Method {
        self.iterative.as_ref().map_or_else(|| self.direct.first_method(), |it| it.method)
    }

    fn restart(&mut self) {
        self.has_given_up = false;
        if let Some(iterative) = &mut self.iterative {
            iterative.restart();
        }
        self.direct.restart();
    }

    fn end_step(&mut self) {
        self.is_new = false;
        self.direct.end_step();
    }

    /// Of a hierarchy only the fingerprint, without an order.
    fn save(&self) -> Option<Saved> {
        let of_hierarchy = |fingerprint| Saved { fingerprint, numbers: Vec::new() };
        match &self.iterative {
            _ if self.given.is_some() => self.given.map(of_hierarchy),
            Some(kept) => (!self.is_new).then(|| of_hierarchy(kept.fingerprint)),
            None => self.direct.save(),
        }
    }

    fn restore(&mut self, saved: Saved) -> Result<(), NotSavedHere> {
        if saved.numbers.is_empty() {
            self.given = Some(saved.fingerprint);
            return Ok(());
        }
        self.direct.restore(saved)
    }

    /// None of a system that was solved by iteration.
    fn condition(&mut self, matrix: Matrix<'_>) -> Option<f64> {
        if self.iterative.is_some() && !self.helped {
            return None;
        }
        self.direct.condition(matrix)
    }
}

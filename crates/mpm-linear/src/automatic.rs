//! The linear solver of a run: direct, or iterative where that is asked for or predicted to be quicker.

use crate::direct::{Factorization, fingerprint};
use crate::matrix::{Matrix, Pattern};
use crate::multigrid::{Converged, Failure, Interleaved, Multigrid};
use crate::prediction::{Prediction, predict};
use crate::report::{Analysis, Cause, Factored, Method, OutOfMemory, Singular, Solved};
use crate::solver::{Hints, LatticePlaces, LinearSolver, NotSavedHere, Saved};

/// Iterations after which a system is left to the direct solver, whatever they cost.
const MOST_ITERATIONS: u32 = 400;

/// The least limit of iterations where the solver is chosen by its predicted cost.
const LEAST_BUDGET: u32 = 30;

/// Entries of a factor for which an iterative run still takes the direct solver's help: 8 GB.
const MOST_ENTRIES_AS_HELP: f64 = 1e9;

/// Coarse matrices are renewed when a solution took more than this times the iterations of the first with them.
const SLOWER: f64 = 1.3;

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
    fn most_iterations(self, prediction: &Prediction) -> u32 {
        match self {
            Choice::Auto => (prediction.break_even() as u32).clamp(LEAST_BUDGET, MOST_ITERATIONS),
            Choice::Direct | Choice::Iterative => MOST_ITERATIONS,
        }
    }
}

/// Solves by iteration or by factorisation, as the [`Choice`] says.
///
/// The iteration needs a matrix whose equations all belong to nodes on a lattice, also those of a further field on the nodes;
/// other matrices are factorised. It is by conjugate gradients where the matrix is symmetric, else by GMRES.
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

struct Iterative {
    method: Method,
    multigrid: Box<dyn Iteration>,
    /// Of pattern and places: all that the hierarchy depends on besides the lattice.
    fingerprint: u64,
    index: Vec<[u32; 3]>,
    lines: [Vec<f64>; 3],
    periods: [Option<u32>; 3],
    prediction: Prediction,
    /// Equations of each node, without that of a further field.
    block: usize,
    /// Nodes of the equations of a further field, in order.
    further: Vec<usize>,
    coarse: Coarse,
}

/// What the coarse matrices at hand are of. They are kept through a load step as long as they serve.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Coarse {
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
    /// Takes a matrix, with coarse matrices of its own or those that are kept.
    fn take(&mut self, matrix: Matrix<'_>) -> Result<(), Failure> {
        if let Coarse::Kept { first, .. } = self.coarse {
            self.coarse = Coarse::Kept { is_of_this: false, first };
            return self.multigrid.update(matrix);
        }
        self.multigrid.prepare(matrix)?;
        self.coarse = Coarse::Kept { is_of_this: true, first: None };
        Ok(())
    }

    /// Solves; where kept coarse matrices do not serve, with new ones. Leaves x as it was where that fails.
    fn solve(
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
trait Iteration: Send {
    fn prepare(&mut self, matrix: Matrix<'_>) -> Result<(), Failure>;
    fn update(&mut self, matrix: Matrix<'_>) -> Result<(), Failure>;
    fn solve(&mut self, x: &mut [f64], tolerance: f64, iterations: u32) -> Result<Converged, Failure>;
}

impl<const D: usize> Iteration for Multigrid<D> {
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
fn further(pattern: Pattern<'_>, hints: &Hints<'_>) -> Option<Vec<usize>> {
    let mut behind = pattern.block * pattern.blocks..pattern.n_equations();
    behind.try_fold(Vec::new(), |mut nodes, equation| {
        nodes.push(hints.further?(equation)?);
        Some(nodes)
    })
}

/// The iteration for a pattern.
fn method(pattern: Pattern<'_>) -> Method {
    if pattern.is_symmetric() { Method::ConjugateGradients } else { Method::Gmres }
}

fn hierarchy(pattern: Pattern<'_>, further: &[usize], places: LatticePlaces<'_>) -> Option<Box<dyn Iteration>> {
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
        if prediction.factor_entries > MOST_ENTRIES_AS_HELP {
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
        match iterative.take(matrix) {
            Ok(()) => Ok(Factored::by(iterative.method)),
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
        let most = self.choice.most_iterations(&iterative.prediction);
        let iterations = match iterative.solve(matrix, rhs, (tolerance, most)) {
            Ok(Converged { iterations, residual }) => {
                return Ok(Solved {
                    method: iterative.method,
                    backward_error: None,
                    residual: Some(residual),
                    refinements: 0,
                    iterations,
                    taken_over: None,
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
            iterative.coarse = Coarse::Old;
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

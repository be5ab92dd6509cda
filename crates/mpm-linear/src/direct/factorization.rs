//! Factorisation of one matrix after another: LLᵀ, then LBLᵀ, then LU; of unsymmetric matrices LU.

use super::cholesky::Cholesky;
use super::condition;
use super::dissection::elimination_order;
use super::fronts::Fronts;
use super::multifrontal::Stopped;
use super::order::StoredOrder;
use super::residual::{Residual, image_of_known};
use super::symbolic;
use super::symmetric_lu::SymmetricLu;
use super::unsymmetric::Unsymmetric;
use crate::matrix::{Matrix, Pattern, Symmetry};
use crate::report::{Analysis, Cause, Factored, Method, OutOfMemory, Singular, Solved};
use crate::solver::{Hints, LinearSolver, NotSavedHere, Saved};

/// A solution is refined while its backward error is above this.
const REFINE_ABOVE: f64 = 1e-12;
/// Refinement steps at most.
const REFINEMENTS: usize = 3;
/// A factorisation whose solutions stay above this backward error is given up.
const REJECT_ABOVE: f64 = 1e-8;

/// The direct solver.
///
/// Owns a copy of the pattern, the analysis, the factor and all scratch memory; they are reused while the
/// pattern is unchanged, and their memory as long as it suffices.
#[derive(Default)]
pub struct Factorization {
    column_start: Vec<usize>,
    row: Vec<usize>,
    /// Made when first needed for a pattern, if that is symmetric.
    symmetric_lu: Option<SymmetricLu>,
    structure: Option<Structure>,
    /// The factor at hand.
    method: Option<Method>,
    /// The method that is tried first: a more general one after it was needed.
    start: Option<Method>,
    residual: Residual,
    /// Order of elimination at hand.
    order: Vec<usize>,
    /// An order for the first pattern, if that is the one it was found for.
    given: Option<StoredOrder>,
    /// Whether a pattern has been analysed since the last [`LinearSolver::end_step`].
    is_new: bool,
}

/// Structure and memory of a factor.
enum Structure {
    Symmetric(Box<Cholesky>),
    Unsymmetric(Box<Unsymmetric>),
}

impl Structure {
    fn symmetry(&self) -> Symmetry {
        match self {
            Self::Symmetric(_) => Symmetry::Symmetric,
            Self::Unsymmetric(_) => Symmetry::Unsymmetric,
        }
    }
}

impl Factorization {
    /// A solver that has not seen a pattern yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// As [`LinearSolver::analyse`], without a restart.
    pub(crate) fn prepare(&mut self, pattern: Pattern<'_>, hints: &Hints<'_>) -> Result<Analysis, OutOfMemory> {
        if self.structure.as_ref().is_some_and(|kept| kept.symmetry() == pattern.symmetry)
            && self.column_start == pattern.column_start
            && self.row == pattern.row
        {
            return Ok(Analysis::Reused);
        }
        self.method = None;
        self.symmetric_lu = None;
        let memory = match self.structure.take() {
            Some(Structure::Symmetric(cholesky)) => cholesky.into_memory(),
            Some(Structure::Unsymmetric(lu)) => lu.into_memory(),
            None => Vec::new(),
        };
        let given = self.given.take().filter(|given| given.suits(pattern));
        let analysis = if given.is_some() { Analysis::Reused } else { Analysis::New };
        self.is_new |= analysis == Analysis::New;
        self.order = match given {
            Some(given) => given.order,
            None => order(pattern, hints)?,
        };
        self.structure = Some(match pattern.symmetry {
            Symmetry::Symmetric => {
                Structure::Symmetric(Box::new(Cholesky::allocate(pattern, &self.order, memory)?))
            }
            Symmetry::Unsymmetric => {
                Structure::Unsymmetric(Box::new(Unsymmetric::allocate(pattern, &self.order, memory)?))
            }
        });
        self.column_start.clear();
        self.column_start.extend_from_slice(pattern.column_start);
        self.row.clear();
        self.row.extend_from_slice(pattern.row);
        Ok(analysis)
    }

    /// Factorises beginning with `start`, and goes on to the next method where that one fails.
    ///
    /// # Errors
    /// If the matrix is singular or has an entry that is not finite.
    ///
    /// # Panics
    /// If no pattern was analysed or `matrix` does not fit it.
    pub(crate) fn factorise_from(&mut self, matrix: Matrix<'_>, start: Method) -> Result<Factored, Singular> {
        self.check(matrix);
        self.method = None;
        if let Some(equation) = matrix.first_not_finite() {
            return Err(Singular { equation, pivot: None, cause: Cause::MatrixNotFinite });
        }
        let factored = match self.structure.as_mut().expect("analyse comes before factorise") {
            Structure::Symmetric(_) => self.factorise_symmetric(matrix, start),
            Structure::Unsymmetric(lu) => {
                lu.factorise(matrix).map_err(|failed| match matrix.first_empty_row() {
                    Some(equation) => Singular { equation, pivot: Some(0.0), cause: Cause::EmptyRow },
                    None => failed,
                })
            }
        }?;
        self.method = Some(factored.method);
        self.start = self.method;
        Ok(factored)
    }

    fn factorise_symmetric(&mut self, matrix: Matrix<'_>, start: Method) -> Result<Factored, Singular> {
        let Some(Structure::Symmetric(cholesky)) = &mut self.structure else {
            unreachable!("of symmetric patterns")
        };
        let no_memory = Cause::NoMemory { entries: cholesky.factor_entries() as f64 };
        let no_memory = Singular { equation: 0, pivot: None, cause: no_memory };
        let mut not_positive = None;
        if start == Method::Llt {
            match cholesky.llt(matrix) {
                Ok(factored) => return Ok(factored),
                Err(Stopped::Pivot(pivot)) => not_positive = Some(pivot),
                Err(Stopped::Memory) => return Err(no_memory),
            }
        }
        if let Some(equation) = matrix.first_empty_row() {
            return Err(Singular { equation, pivot: Some(0.0), cause: Cause::EmptyRow });
        }
        let mut weakest = not_positive;
        if start != Method::Lu {
            match cholesky.lblt(matrix) {
                Ok(factored) => return Ok(Factored { not_positive, ..factored }),
                Err(Stopped::Pivot(pivot)) => weakest = Some(pivot),
                Err(Stopped::Memory) => return Err(no_memory),
            }
        }
        if let Err(equation) = self.factorise_lu(matrix) {
            return Err(Singular {
                equation: weakest.map_or(equation, |p| p.equation),
                pivot: weakest.map(|p| p.value),
                cause: Cause::NoPivot,
            });
        }
        Ok(Factored { not_positive, ..Factored::by(Method::Lu) })
    }

    /// Entries stored for the factor of the analysed pattern, 8 bytes each, with the zeros that supernodes keep: of a
    /// symmetric matrix the lower triangle of L, else L and U.
    pub fn factor_entries(&self) -> usize {
        match &self.structure {
            None => 0,
            Some(Structure::Symmetric(cholesky)) => cholesky.factor_entries(),
            Some(Structure::Unsymmetric(lu)) => lu.factor_entries(),
        }
    }

    /// LU factorisation of a symmetric matrix, checked by a solution that is known to exist; it becomes the
    /// factor at hand. On failure returns the equation with the largest error and leaves the factor as it was.
    fn factorise_lu(&mut self, matrix: Matrix<'_>) -> Result<(), usize> {
        let lu = match self.symmetric_lu.take() {
            Some(lu) => Some(lu),
            None => SymmetricLu::analyse(matrix.pattern),
        };
        self.symmetric_lu = lu.and_then(|lu| lu.factorise(matrix.values));
        if self.symmetric_lu.is_none() {
            return Err(0);
        }
        let probe = image_of_known(matrix);
        let solved = self.solve_by(Method::Lu, matrix, &probe);
        if solved.backward_error > REJECT_ABOVE {
            return Err(self.residual.worst);
        }
        self.method = Some(Method::Lu);
        Ok(())
    }

    /// Leaves the solution by one factorisation, refined, in `self.residual`.
    fn solve_by(&mut self, method: Method, matrix: Matrix<'_>, b: &[f64]) -> Checked {
        let structure = self.structure.as_mut().expect("analysed before");
        let mut substitute = |x: &mut [f64]| match (&mut *structure, method) {
            (Structure::Unsymmetric(lu), _) => lu.solve(x),
            (Structure::Symmetric(_), Method::Lu) => {
                self.symmetric_lu.as_mut().expect("factorised before").solve(x)
            }
            (Structure::Symmetric(cholesky), Method::Lblt) => cholesky.solve_lblt(x),
            (Structure::Symmetric(cholesky), _) => cholesky.solve_llt(x),
        };
        let check = &mut self.residual;
        check.solution.clear();
        check.solution.extend_from_slice(b);
        substitute(&mut check.solution);
        let mut backward_error = check.backward_error(matrix, b);
        let mut refinements = 0;
        while backward_error > REFINE_ABOVE && backward_error.is_finite() && refinements < REFINEMENTS {
            refinements += 1;
            substitute(&mut check.residual);
            check.correct();
            let refined = check.backward_error(matrix, b);
            if refined.is_nan() || refined >= backward_error {
                check.take_back();
                break;
            }
            backward_error = refined;
        }
        Checked { backward_error, refinements }
    }

    /// Factorises an unsymmetric matrix anew with free pivots, if those at hand are not.
    fn free_pivots(&mut self, matrix: Matrix<'_>) -> bool {
        match &mut self.structure {
            Some(Structure::Unsymmetric(lu)) if !lu.has_free_pivots() => {
                lu.factorise_by_columns(matrix).is_ok()
            }
            _ => false,
        }
    }

    fn check(&self, matrix: Matrix<'_>) {
        assert_eq!(matrix.values.len(), self.row.len(), "one value per entry of the analysed pattern");
    }
}

/// How good a solution is.
struct Checked {
    backward_error: f64,
    refinements: usize,
}

impl LinearSolver for Factorization {
    fn analyse(&mut self, pattern: Pattern<'_>, hints: &Hints<'_>) -> Result<Analysis, OutOfMemory> {
        self.restart();
        self.prepare(pattern, hints)
    }

    fn factorise(&mut self, matrix: Matrix<'_>) -> Result<Factored, Singular> {
        self.factorise_from(matrix, self.start.unwrap_or(Method::Llt))
    }

    /// The solution is checked against K, refined where the check is not satisfied, and computed
    /// anew by LU where refinement does not help. The tolerance is not used.
    fn solve(&mut self, matrix: Matrix<'_>, rhs: &mut [f64], _tolerance: f64) -> Result<Solved, Singular> {
        self.check(matrix);
        assert_eq!(rhs.len() + 1, self.column_start.len(), "one right-hand side entry per equation");
        let mut method = self.method.expect("a successful factorise comes before solve");
        if let Some(equation) = rhs.iter().position(|v| !v.is_finite()) {
            return Err(Singular { equation, pivot: None, cause: Cause::RightHandSideNotFinite });
        }
        let mut checked = self.solve_by(method, matrix, rhs);
        let mut equation = self.residual.worst;
        let mut taken_over = None;
        if checked.backward_error > REJECT_ABOVE && self.free_pivots(matrix) {
            checked = self.solve_by(method, matrix, rhs);
            equation = self.residual.worst;
        }
        if checked.backward_error > REJECT_ABOVE && method != Method::Lu && self.factorise_lu(matrix).is_ok() {
            method = Method::Lu;
            self.start = Some(method);
            taken_over = Some(Factored::by(method));
            checked = self.solve_by(method, matrix, rhs);
            equation = self.residual.worst;
        }
        let Checked { backward_error, refinements } = checked;
        if backward_error > REJECT_ABOVE {
            return Err(Singular { equation, pivot: None, cause: Cause::Inaccurate { backward_error } });
        }
        rhs.copy_from_slice(&self.residual.solution);
        let backward_error = Some(backward_error);
        Ok(Solved { method, backward_error, residual: None, refinements, iterations: 0, taken_over })
    }

    fn first_method(&self) -> Method {
        match self.structure {
            Some(Structure::Unsymmetric(_)) => Method::Lu,
            _ => Method::Llt,
        }
    }

    /// The next matrix is tried by LLᵀ again. After an indefinite matrix the next one is likely to be
    /// indefinite too, so that without a restart LLᵀ is not tried on it.
    fn restart(&mut self) {
        self.start = None;
    }

    fn end_step(&mut self) {
        self.is_new = false;
    }

    /// The order at hand when the present step was begun; none where that step has replaced it (or there
    /// was none), and would do so again.
    fn save(&self) -> Option<Saved> {
        if let Some(given) = &self.given {
            return Some(given.save());
        }
        let symmetry = self.structure.as_ref().filter(|_| !self.is_new)?.symmetry();
        // Nodes do not enter the fingerprint.
        let pattern =
            Pattern { column_start: &self.column_start, row: &self.row, symmetry, block: 1, blocks: 0 };
        Some(StoredOrder::of(pattern, &self.order).save())
    }

    /// The first pattern, if it is that of the saved order, counts as kept.
    fn restore(&mut self, saved: Saved) -> Result<(), NotSavedHere> {
        self.given = Some(StoredOrder::restore(saved)?);
        Ok(())
    }

    fn condition(&mut self, matrix: Matrix<'_>) -> Option<f64> {
        let method = self.method?;
        condition::estimate(matrix, |x| {
            self.solve_by(method, matrix, x);
            x.copy_from_slice(&self.residual.solution);
        })
    }
}

/// Size of a factor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FactorSize {
    /// Entries that are stored, as [`Factorization::factor_entries`].
    pub entries: usize,
    /// Bytes of these, of the structure, and of what fronts have handed on while it is computed, on any number of
    /// threads: at most.
    pub bytes: usize,
}

/// Size of the factor of a pattern, found from its structure alone, without memory for the factor.
///
/// # Errors
/// If not even the structure of the factor fits into memory.
pub fn predict_factor(pattern: Pattern<'_>, hints: &Hints<'_>) -> Result<FactorSize, OutOfMemory> {
    let fronts = Fronts::new(pattern, &order(pattern, hints)?)?;
    let bytes = size_of::<f64>() * (fronts.n_numbers + fronts.most_remainders()) + fronts.bytes();
    Ok(FactorSize { entries: fronts.n_numbers, bytes })
}

/// Elimination order of the equations, after checks of the pattern.
fn order(pattern: Pattern<'_>, hints: &Hints<'_>) -> Result<Vec<usize>, OutOfMemory> {
    pattern.check();
    match hints.lattice {
        Some(places) => {
            let further = |equation| hints.further.and_then(|node_of| node_of(equation));
            Ok(elimination_order(pattern, places.index, places.periods, further))
        }
        None => symbolic::minimum_degree(pattern),
    }
}

//! Factorisation of one pattern after another: LLᵀ, then LBLᵀ, then LU.

use super::cholesky::{self, Cholesky};
use super::dissection::elimination_order;
use super::graph::BlockGraph;
use super::lu::Lu;
use super::order::StoredOrder;
use super::residual::{Residual, holds_nothing, image_of_known, product};
use crate::matrix::SymmetricPattern;
use crate::report::{Analysis, Cause, Method, OutOfMemory, Report, Singular, SolveReport};

/// A solution is refined while its backward error is above this.
const REFINE_ABOVE: f64 = 1e-12;
/// Refinement steps at most.
const REFINEMENTS: usize = 3;
/// A factorisation whose solutions stay above this backward error is given up.
const REJECT_ABOVE: f64 = 1e-8;

/// Steps of power and of inverse iteration in an estimate of the condition number.
const CONDITION_STEPS: usize = 10;

/// A direct solver for one pattern after another.
///
/// Owns the pattern, the analysis, the factor and all scratch memory; they are reused while the
/// pattern is unchanged, and their memory as long as it suffices.
#[derive(Default)]
pub struct Factorization {
    column_start: Vec<usize>,
    row: Vec<usize>,
    cholesky: Option<Cholesky>,
    /// Made when first needed for a pattern.
    lu: Option<Lu>,
    /// The factor at hand.
    method: Option<Method>,
    residual: Residual,
    /// Order of elimination at hand.
    order: Vec<usize>,
    /// An order for the first pattern, if that is the one it was found for.
    given: Option<StoredOrder>,
    /// Whether a pattern has been analysed since the last [`Self::settle`].
    unsettled: bool,
}

impl Factorization {
    /// A solver that has not seen a pattern yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Prepares for matrices of this pattern.
    ///
    /// Node i has multi-index `lattice[i]` on the background grid and the equations
    /// components·i … components·i + components − 1; `periodic` holds the number of lattice lines
    /// of each direction that closes on itself. Both only serve to find an order with little fill.
    ///
    /// # Errors
    /// If the factor does not fit into memory.
    ///
    /// # Panics
    /// If the pattern is not as [`SymmetricPattern`] says, or not made of `components` equations
    /// for each node.
    pub fn analyse(
        &mut self,
        pattern: SymmetricPattern<'_>,
        lattice: &[[u32; 3]],
        periodic: [Option<u32>; 3],
        components: usize,
    ) -> Result<Analysis, OutOfMemory> {
        if self.cholesky.is_some() && self.column_start == pattern.column_start && self.row == pattern.row {
            return Ok(Analysis::Reused);
        }
        self.method = None;
        self.lu = None;
        let memory = self.cholesky.take().map(Cholesky::into_memory).unwrap_or_default();
        let given = self.given.take().filter(|given| given.suits(pattern));
        let analysis = if given.is_some() { Analysis::Reused } else { Analysis::New };
        self.unsettled |= analysis == Analysis::New;
        self.order = match given {
            Some(given) => given.order,
            None => order(pattern, lattice, periodic, components),
        };
        let symbolic = cholesky::analyse(pattern, &self.order)?;
        self.cholesky = Some(Cholesky::allocate(symbolic, memory)?);
        self.column_start.clear();
        self.column_start.extend_from_slice(pattern.column_start);
        self.row.clear();
        self.row.extend_from_slice(pattern.row);
        Ok(analysis)
    }

    /// Goes on from a run that had this order at hand: the first pattern, if it is the order's, counts as
    /// kept.
    pub fn recall(&mut self, order: Option<StoredOrder>) {
        self.given = order;
    }

    /// What has been analysed so far belongs to steps taken, not to the one that is tried next.
    pub fn settle(&mut self) {
        self.unsettled = false;
    }

    /// The order at hand when the present step was begun; none where that step has replaced it (or there
    /// was none), and would do so again.
    pub fn store(&self) -> Option<StoredOrder> {
        if self.given.is_some() {
            return self.given.clone();
        }
        let pattern = SymmetricPattern { column_start: &self.column_start, row: &self.row };
        let is_kept = self.cholesky.is_some() && !self.unsettled;
        is_kept.then(|| StoredOrder::of(pattern, &self.order))
    }

    /// Factorises the matrix with these `values` (one per entry of the pattern).
    ///
    /// Begins with `start` and goes on to the next method where that one fails. After an indefinite
    /// matrix the next one is likely to be indefinite too: `start` = [`Method::Lblt`] then saves
    /// the failing LLᵀ, until [`Report::negative_pivots`] is 0 again.
    ///
    /// # Errors
    /// If the matrix is singular or has an entry that is not finite.
    ///
    /// # Panics
    /// If no pattern was analysed or `values` does not fit it.
    pub fn factorise(&mut self, values: &[f64], start: Method) -> Result<Report, Singular> {
        assert_eq!(values.len(), self.row.len(), "one value per entry of the analysed pattern");
        let pattern = SymmetricPattern { column_start: &self.column_start, row: &self.row };
        let cholesky = self.cholesky.as_mut().expect("analyse comes before factorise");
        self.method = None;
        if let Some(entry) = values.iter().position(|v| !v.is_finite()) {
            let equation = self.column_start.partition_point(|&s| s <= entry) - 1;
            return Err(Singular { equation, pivot: None, cause: Cause::MatrixNotFinite });
        }

        let mut not_positive = None;
        if start == Method::Llt {
            match cholesky.llt(pattern, values) {
                Ok(report) => {
                    self.method = Some(Method::Llt);
                    return Ok(report);
                }
                Err(pivot) => not_positive = Some(pivot),
            }
        }
        if let Some(equation) = holds_nothing(pattern, values) {
            return Err(Singular { equation, pivot: Some(0.0), cause: Cause::EmptyRow });
        }
        let mut weakest = not_positive;
        if start != Method::Lu {
            match cholesky.lblt(pattern, values) {
                Ok(report) => {
                    self.method = Some(Method::Lblt);
                    return Ok(Report { not_positive, ..report });
                }
                Err(pivot) => weakest = Some(pivot),
            }
        }
        if let Err(equation) = self.factorise_lu(values) {
            return Err(Singular {
                equation: weakest.map_or(equation, |p| p.equation),
                pivot: weakest.map(|p| p.value),
                cause: Cause::NoPivot,
            });
        }
        Ok(Report { method: Method::Lu, not_positive, negative_pivots: None, weakest: None, pivot_ratio: None })
    }

    /// Replaces the right-hand side b by the solution of K x = b, where K is the matrix last
    /// factorised and `values` are its entries.
    ///
    /// The solution is checked against K, refined where the check is not satisfied, and computed
    /// anew by LU where refinement does not help.
    ///
    /// # Errors
    /// If no accurate solution was found or b is not finite; `rhs` is unchanged then.
    ///
    /// # Panics
    /// If no matrix was factorised or `values` or `rhs` do not fit it.
    pub fn solve(&mut self, values: &[f64], rhs: &mut [f64]) -> Result<SolveReport, Singular> {
        assert_eq!(values.len(), self.row.len(), "one value per entry of the analysed pattern");
        assert_eq!(rhs.len() + 1, self.column_start.len(), "one right-hand side entry per equation");
        let method = self.method.expect("a successful factorise comes before solve");
        if let Some(equation) = rhs.iter().position(|v| !v.is_finite()) {
            return Err(Singular { equation, pivot: None, cause: Cause::RightHandSideNotFinite });
        }
        let mut report = self.solve_by(method, values, rhs);
        let mut equation = self.residual.worst;
        if report.backward_error > REJECT_ABOVE && method != Method::Lu && self.factorise_lu(values).is_ok() {
            report = self.solve_by(Method::Lu, values, rhs);
            equation = self.residual.worst;
        }
        if report.backward_error > REJECT_ABOVE {
            let cause = Cause::Inaccurate { backward_error: report.backward_error };
            return Err(Singular { equation, pivot: None, cause });
        }
        rhs.copy_from_slice(&self.residual.solution);
        Ok(report)
    }

    /// Estimate of the condition number |λ|_max / |λ|_min of the matrix at hand: ten steps of power iteration with
    /// `values`, and ten of inverse iteration with the factor. Both approach from below: a lower bound (where the
    /// factor is that of `values`), mostly within a factor of two. None without a factor.
    ///
    /// # Panics
    /// If `values` does not fit the pattern.
    pub fn condition(&mut self, values: &[f64]) -> Option<f64> {
        let (method, n) = (self.method?, self.equations());
        let pattern = SymmetricPattern { column_start: &self.column_start, row: &self.row };
        let mut large = image_of_known(pattern, values);
        let mut largest = normalise(&mut large)?;
        for _ in 0..CONDITION_STEPS {
            large = product(pattern, values, &large);
            largest = normalise(&mut large)?;
        }
        let mut small: Vec<f64> = (0..n).map(|i| if i.is_multiple_of(3) { -1.0 } else { 1.0 }).collect();
        normalise(&mut small)?;
        let mut inverse = 0.0;
        for _ in 0..CONDITION_STEPS {
            self.solve_by(method, values, &small);
            small.copy_from_slice(&self.residual.solution);
            inverse = normalise(&mut small)?;
        }
        Some(largest * inverse)
    }

    /// Equations of the analysed pattern.
    pub fn equations(&self) -> usize {
        self.column_start.len().saturating_sub(1)
    }

    /// Entries stored for the factor of the analysed pattern, 8 bytes each: the lower triangle of
    /// L with the zeros that supernodes keep. Known before any factorisation.
    pub fn factor_entries(&self) -> usize {
        self.cholesky.as_ref().map_or(0, Cholesky::factor_entries)
    }

    /// LU factorisation, checked by a solution that is known to exist; it becomes the factor at
    /// hand. On failure returns the equation with the largest error and leaves the factor as it was.
    fn factorise_lu(&mut self, values: &[f64]) -> Result<(), usize> {
        let pattern = SymmetricPattern { column_start: &self.column_start, row: &self.row };
        let lu = match self.lu.take() {
            Some(lu) => Some(lu),
            None => Lu::analyse(pattern),
        };
        self.lu = lu.and_then(|lu| lu.factorise(values));
        if self.lu.is_none() {
            return Err(0);
        }
        let probe = image_of_known(pattern, values);
        let report = self.solve_by(Method::Lu, values, &probe);
        if report.backward_error > REJECT_ABOVE {
            return Err(self.residual.worst);
        }
        self.method = Some(Method::Lu);
        Ok(())
    }

    /// Leaves the solution by one factorisation, refined, in `self.residual`.
    fn solve_by(&mut self, method: Method, values: &[f64], b: &[f64]) -> SolveReport {
        let pattern = SymmetricPattern { column_start: &self.column_start, row: &self.row };
        let cholesky = self.cholesky.as_mut().expect("analysed before");
        let mut substitute = |x: &mut [f64]| match method {
            Method::ConjugateGradients | Method::Llt => cholesky.solve_llt(x),
            Method::Lblt => cholesky.solve_lblt(x),
            Method::Lu => self.lu.as_mut().expect("factorised before").solve(x),
        };
        let check = &mut self.residual;
        check.solution.clear();
        check.solution.extend_from_slice(b);
        substitute(&mut check.solution);
        let mut backward_error = check.backward_error(pattern, values, b);
        let mut refinements = 0;
        while backward_error > REFINE_ABOVE && backward_error.is_finite() && refinements < REFINEMENTS {
            refinements += 1;
            substitute(&mut check.residual);
            check.correct();
            let refined = check.backward_error(pattern, values, b);
            if refined.is_nan() || refined >= backward_error {
                check.take_back();
                break;
            }
            backward_error = refined;
        }
        SolveReport { backward_error, refinements, method, iterations: 0 }
    }
}

/// Makes a vector one of length 1; returns its length, if that is a number above 0.
fn normalise(x: &mut [f64]) -> Option<f64> {
    let length = x.iter().map(|x| x * x).sum::<f64>().sqrt();
    x.iter_mut().for_each(|x| *x /= length);
    (length > 0.0 && length.is_finite()).then_some(length)
}

/// Entries that the factor of a pattern will have (as [`Factorization::factor_entries`]), found
/// from its structure alone, without memory for the factor. Arguments as for
/// [`Factorization::analyse`].
///
/// # Errors
/// If not even the structure of the factor fits into memory.
pub fn predict_factor_entries(
    pattern: SymmetricPattern<'_>,
    lattice: &[[u32; 3]],
    periodic: [Option<u32>; 3],
    components: usize,
) -> Result<usize, OutOfMemory> {
    let order = order(pattern, lattice, periodic, components);
    Ok(cholesky::analyse(pattern, &order)?.len_val())
}

/// Elimination order of the equations, after checks of the pattern.
fn order(
    pattern: SymmetricPattern<'_>,
    lattice: &[[u32; 3]],
    periodic: [Option<u32>; 3],
    components: usize,
) -> Vec<usize> {
    let SymmetricPattern { column_start, row } = pattern;
    assert_eq!(column_start.len(), lattice.len() * components + 1, "n + 1 column starts");
    assert_eq!(column_start.last(), Some(&row.len()), "column starts end with the number of entries");
    let diagonal_first = column_start.windows(2).enumerate().all(|(j, s)| s[0] < s[1] && row[s[0]] == j);
    assert!(diagonal_first, "every column begins with its diagonal");
    elimination_order(&BlockGraph::new(column_start, row, components), lattice, periodic, components)
}

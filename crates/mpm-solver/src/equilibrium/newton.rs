//! Equilibrium of one load step by Newton's method with the consistent tangent.

use super::line_search::{Correction, Taken};
use super::problem::{Equilibrium, Iterate, Problem, Wanted};
use super::system::{Solver, singular};
use crate::failure::StepFailure;
use crate::ranks::any;
use crate::timing::Phase;
use mpm_assembly::UnknownVector;
use mpm_grid::Vector;

/// Smallest part of a correction that is tried before the load step is cut.
const LEAST_PART: f64 = 1.0 / 256.0;

/// A pivot that keeps less than this part of its diagonal marks an all but singular tangent.
const SINGULAR: f64 = 1e-11;

/// Part of the out-of-balance force that an inexact linear solution leaves, at most.
const MOST_LEFT: f64 = 1e-3;

/// Part that one leaves at least.
const LEAST_LEFT: f64 = 1e-12;

/// Part of the tolerance that an iteration from a guess goes on to, so that it ends as near to equilibrium as one
/// from rest, whose last residual is far below the tolerance: where a body softens, what is left grows from step to step.
const FROM_GUESS: f64 = 1e-2;

/// The out-of-balance force has grown beyond hope when it exceeds its smallest value by this factor.
const DIVERGED: f64 = 1e8;

/// Corrections that had to be shortened because they inverted points after which an iteration whose out-of-balance force
/// is still as large as at its start is given up: it never comes back, and each of its corrections is tried many times.
const HOPELESS: u32 = 3;

/// Iterations of a load step whose residuals have their place beforehand.
const MOST_RESERVED: u32 = 1000;

/// Balances the forces of a load step: full Newton from a guess, where there is one (prescribed components
/// and all), and where that converges at once; else from `Δu = 0`. Prescribed displacements are held exactly
/// from the first iterate on.
///
/// # Errors
/// Why the iteration from `Δu = 0` failed.
pub(crate) fn solve<const D: usize>(
    problem: &Problem<'_, D>,
    guess: Option<UnknownVector<D>>,
    solver: &mut Solver<D>,
) -> Result<Equilibrium<D>, StepFailure> {
    let mut rest = solver.at_rest(problem);
    if let Some(increment) = guess {
        let before = solver.timings.count(Phase::Solve);
        let mut guessed = rest.clone();
        guessed.increment = increment;
        guessed.is_first = false;
        let start = Start { iterate: guessed, lift: None, patience: Patience::UntilSlow };
        match iterate(start, problem, solver) {
            Err(failure) if failure != StepFailure::Cancelled => {}
            outcome => return outcome.map(Iterate::into_equilibrium),
        }
        rest.effort.dropped = solver.timings.count(Phase::Solve) - before;
        solver.restart();
    }
    solver.weakest_pivot = None;
    let lift = Some(problem.constraints.increment());
    let start = Start { iterate: rest, lift, patience: Patience::ToTheEnd };
    let found = iterate(start, problem, solver).map(Iterate::into_equilibrium);
    found.map_err(|failure| match solver.weakest_pivot {
        // If the tangent was nearly singular, report that, because it caused the later failure.
        Some(pivot) if pivot.relative.abs() < SINGULAR && failure != StepFailure::Cancelled => {
            let cause = format!("{:.0e} of its stiffness is left; then: {failure}", pivot.relative);
            singular(problem, pivot.equation, cause)
        }
        _ => failure,
    })
}

/// Balances the forces again, from an equilibrium on after which contributions have changed what they hold fixed.
///
/// # Errors
/// Why the iteration failed.
pub(crate) fn go_on<const D: usize>(
    problem: &Problem<'_, D>,
    found: Equilibrium<D>,
    solver: &mut Solver<D>,
) -> Result<Equilibrium<D>, StepFailure> {
    let mut start = solver.at_rest(problem);
    start.increment = found.increment;
    start.is_first = false;
    let start = Start { iterate: start, lift: None, patience: Patience::ToTheEnd };
    let mut next = iterate(start, problem, solver)?.into_equilibrium();
    next.effort.add_earlier(found.effort);
    Ok(next)
}

/// Where Newton's iteration begins.
pub(crate) struct Start<'a, const D: usize> {
    pub iterate: Iterate<D>,
    /// Prescribed increments that are still to be made, whole by the first correction `[L]`.
    pub lift: Option<&'a [Vector<D>]>,
    pub patience: Patience,
}

/// How long Newton's iteration goes on.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Patience {
    /// Until it does not converge well: there is another place where it can begin.
    UntilSlow,
    /// Until it diverges, or the allowed iterations are used up.
    ToTheEnd,
}

/// The tangent with which the next correction will be found.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Tangent {
    /// That of the present iterate; it was summed together with the forces.
    Summed,
    /// That of the present iterate; it was not summed, because the iterate was expected to be the last or to keep the
    /// factorisation at hand.
    Skipped,
    /// That of an earlier iterate, whose factorisation is kept.
    Kept,
}

/// Newton's iteration.
///
/// # Errors
/// The iteration does not converge, a point cannot be kept from being inverted, or a linear system cannot be solved.
pub(crate) fn iterate<const D: usize>(
    start: Start<'_, D>,
    problem: &Problem<'_, D>,
    solver: &mut Solver<D>,
) -> Result<Iterate<D>, StepFailure> {
    let Start { mut iterate, lift, patience } = start;
    let tolerance = problem.tolerance;
    // All that the iterations write to: they allocate nothing, unless they are very many.
    iterate.effort.residuals.reserve_exact(tolerance.iterations.min(MOST_RESERVED) as usize);
    let goal = match patience {
        Patience::UntilSlow => FROM_GUESS * tolerance.residual,
        Patience::ToTheEnd => tolerance.residual,
    };
    let mut newton = Newton {
        problem,
        solver,
        iterate,
        tangent: Tangent::Summed,
        goal,
        patience,
        inverting: 0,
        correction: UnknownVector::zeros(problem.unknowns()),
        before: UnknownVector::zeros(problem.unknowns()),
    };
    let outcome = newton.run(lift);
    if newton.tangent == Tangent::Skipped {
        newton.solver.timings.skipped.tangents += 1;
    }
    outcome.map(|()| newton.iterate)
}

/// Newton's iteration under way.
struct Newton<'a, 'p, const D: usize> {
    problem: &'a Problem<'p, D>,
    solver: &'a mut Solver<D>,
    iterate: Iterate<D>,
    tangent: Tangent,
    /// Relative out-of-balance force at which the iteration ends.
    goal: f64,
    patience: Patience,
    /// Corrections that were shortened because they inverted points.
    inverting: u32,
    /// `K⁻¹ f_oob`, zero on prescribed components `[L]`.
    correction: UnknownVector<D>,
    /// The increment before the correction `[L]`.
    before: UnknownVector<D>,
}

/// Whether the iteration ends.
#[derive(PartialEq, Eq)]
enum Verdict {
    Balanced,
    GoOn,
    GiveUp,
}

impl<const D: usize> Newton<'_, '_, D> {
    fn run(&mut self, lift: Option<&[Vector<D>]>) -> Result<(), StepFailure> {
        self.solver.check_cancellation(self.problem)?;
        let is_driven = any(&*self.problem.connected.shared.ranks, self.problem.constraints.is_driven());
        let driven = lift.filter(|_| is_driven);
        if self.begin(driven)? == Verdict::Balanced {
            return Ok(());
        }
        for iteration in 1..=self.problem.tolerance.iterations {
            let is_first = iteration == 1;
            // A short first correction would leave prescribed displacements to the points next to them.
            let least_part = if is_first && driven.is_some() { 1.0 } else { LEAST_PART };
            match self.correct(lift.filter(|_| is_first), least_part)? {
                Verdict::Balanced => return Ok(()),
                Verdict::GoOn => {}
                Verdict::GiveUp => break,
            }
        }
        Err(StepFailure::NotConverged { residuals: std::mem::take(&mut self.iterate.effort.residuals) })
    }

    /// Forces and tangent at the start. Prescribed increments that are still to be made (`lift`) enter once, through
    /// the tangent.
    fn begin(&mut self, lift: Option<&[Vector<D>]>) -> Result<Verdict, StepFailure> {
        let Self { problem, solver, iterate, .. } = self;
        let mut lifted = lift.map(|_| UnknownVector::zeros(problem.unknowns()));
        solver.evaluate(problem, iterate, Wanted::ForceAndTangent, lifted.as_mut())?;
        if lift.is_none() {
            iterate.effort.residual = problem.residual(iterate);
            if problem.is_balanced(iterate, self.goal) {
                return Ok(Verdict::Balanced);
            }
        }
        if let Some(lifted) = lifted {
            iterate.out_of_balance.subtract(&lifted);
        }
        problem.constraints.free_part(&mut iterate.out_of_balance.nodes);
        Ok(Verdict::GoOn)
    }

    /// One iteration: a correction, the forces after it, and whether they are balanced.
    fn correct(&mut self, lift: Option<&[Vector<D>]>, least_part: f64) -> Result<Verdict, StepFailure> {
        self.prepare_factor()?;
        let Self { problem, solver, iterate, .. } = self;
        let accuracy = accuracy(&iterate.effort.residuals, self.goal);
        solver.substitute(
            problem,
            &iterate.out_of_balance,
            accuracy,
            &mut self.correction,
            &mut iterate.effort,
        )?;
        // A tangent is not worth its cost where this iterate should be the last, or is expected to keep the factor.
        let is_first = iterate.effort.residuals.is_empty();
        let may_keep = problem.tolerance.keep_factor_below.is_some();
        let expects_to_keep = may_keep && (self.tangent == Tangent::Kept || is_first);
        let wanted = if expects_to_keep || expects_convergence(&iterate.effort.residuals, self.goal) {
            self.tangent = Tangent::Skipped;
            Wanted::Force
        } else {
            self.tangent = Tangent::Summed;
            Wanted::ForceAndTangent
        };
        self.before.copy_from(&iterate.increment);
        // An iteration that goes on only while it converges well ends with the first correction that is not whole, unless
        // rounding is what is left.
        let is_almost_balanced =
            iterate.effort.residuals.last().is_some_and(|last| *last < problem.tolerance.residual);
        let correction = Correction {
            start: &self.before,
            free: &self.correction,
            lift: lift.unwrap_or_default(),
            work: problem.connected.dot(&self.correction, &iterate.out_of_balance),
            least_part,
            whole: self.patience == Patience::UntilSlow && !is_almost_balanced,
        };
        if correction.add_to(problem, iterate, wanted, solver)? == Taken::Inverted {
            self.inverting += 1;
        }
        Ok(self.judge())
    }

    /// Has the factorisation ready with which the next correction is found.
    fn prepare_factor(&mut self) -> Result<(), StepFailure> {
        let Self { problem, solver, iterate, .. } = self;
        match self.tangent {
            Tangent::Kept => {
                solver.timings.skipped.factorisations += 1;
                return Ok(());
            }
            Tangent::Skipped => {
                self.tangent = Tangent::Summed;
                solver.evaluate(problem, iterate, Wanted::ForceAndTangent, None)?;
            }
            Tangent::Summed => {}
        }
        solver.factorise(problem, &mut iterate.effort)
    }

    /// Whether the iterate is balanced, or worth going on from.
    fn judge(&mut self) -> Verdict {
        let Self { problem, solver, iterate, goal, .. } = self;
        let residual = problem.residual(iterate);
        // The first correction of a step is taken to answer a residual of 1.
        let before = iterate.effort.residuals.last().copied().unwrap_or(1.0);
        let keeps_factor = problem.tolerance.keep_factor_below.is_some_and(|most| residual <= most * before);
        if self.tangent == Tangent::Skipped && keeps_factor {
            solver.timings.skipped.tangents += 1;
            self.tangent = Tangent::Kept;
        }
        iterate.effort.residuals.push(residual);
        iterate.effort.residual = residual;
        if problem.is_balanced(iterate, *goal) {
            return Verdict::Balanced;
        }
        if self.patience == Patience::UntilSlow && !converges_well(iterate) {
            // Rounding may not let it come nearer.
            return if residual < problem.tolerance.residual { Verdict::Balanced } else { Verdict::GiveUp };
        }
        // The first correction answers a residual of 1.
        if self.inverting >= HOPELESS && residual >= 1.0 {
            return Verdict::GiveUp;
        }
        let best = iterate.effort.residuals.iter().copied().fold(f64::INFINITY, f64::min);
        if !residual.is_finite() || residual > DIVERGED * best { Verdict::GiveUp } else { Verdict::GoOn }
    }
}

/// Part of the out-of-balance force that conjugate gradients may leave: no more than quadratic convergence
/// would (S. C. Eisenstat and H. F. Walker, SIAM J. Sci. Comput. 17, 1996, choice 2), and no less than the
/// tolerance asks for. A further digit costs less than a pass over the points.
fn accuracy(residuals: &[f64], tolerance: f64) -> f64 {
    let foreseen = match residuals {
        [.., before, last] => 0.1 * (last / before).powi(2),
        _ => MOST_LEFT,
    };
    let needed = residuals.last().map_or(0.0, |last| 0.02 * tolerance / last);
    foreseen.min(MOST_LEFT).max(needed).max(LEAST_LEFT)
}

/// Whether every correction was taken whole, and the last one halved the residual at least.
fn converges_well<const D: usize>(iterate: &Iterate<D>) -> bool {
    let halved = match iterate.effort.residuals[..] {
        [.., before, last] => last <= 0.5 * before,
        _ => true,
    };
    halved && iterate.effort.shortened == 0
}

/// Whether quadratic convergence would carry the next residual well below the tolerance.
fn expects_convergence(residuals: &[f64], tolerance: f64) -> bool {
    match residuals {
        [.., before, last] => last * (last / before).powi(2) < 0.01 * tolerance,
        _ => false,
    }
}

//! Equilibrium of one load step by Newton's method with the consistent tangent.

use crate::error::StepFailure;
use crate::load_step::Connected;
use crate::model::NamedBody;
use crate::observe::Cancellation;
use crate::timing::{Phase, Timings};
use mpm_assembly::{
    Connection, Constraints, GhostFaces, InvertedPoint, PassInput, Pattern, Sums, TangentSums, finish_tangent,
};
use mpm_basis::ActiveNodes;
use mpm_grid::{LoadFraction, Mesh, NodeId, Vector};
use mpm_linear::{Cause, LinearSolver, Method, Pivot, Singular, SymmetricPattern};

/// Smallest part of a correction that is tried before the load step is cut.
const LEAST_PART: f64 = 1.0 / 256.0;

/// A correction overshoots where the work at its end is minus this, or less, times that at its start.
const OVERSHOT: f64 = 0.9;

/// A pivot that keeps less than this part of its diagonal marks an all but singular tangent.
const SINGULAR: f64 = 1e-11;

/// Part of what is out of balance that the first stage lets go of.
const FIRST_PART: f64 = 0.25;

/// Relative out-of-balance force with which all stages but the last are content.
const STAGE_RESIDUAL: f64 = 1e-4;

/// Smallest part of what is out of balance at the start of a step that makes a stage.
const LEAST_STAGE: f64 = 1.0 / 16384.0;

/// Part of the out-of-balance force that an inexact linear solution leaves, at most.
const MOST_LEFT: f64 = 1e-3;

/// Part that one leaves at least.
const LEAST_LEFT: f64 = 1e-12;

/// Part that the linear solutions of path control leave.
const LEFT_ON_PATH: f64 = 1e-9;

/// Evaluations in the search for a shorter correction at most.
const SEARCHES: usize = 5;

/// Part of the tolerance that an iteration from a guess goes on to, so that it ends as near to equilibrium as one
/// from rest, whose last residual is far below the tolerance: where a body softens, what is left grows from step to step.
const FROM_GUESS: f64 = 1e-2;

/// The out-of-balance force has grown beyond hope when it exceeds its smallest value by this factor.
const DIVERGED: f64 = 1e8;

/// Iterations of a load step whose residuals have their place beforehand.
const MOST_RESERVED: u32 = 1000;

/// Everything that stays fixed while one load step is balanced.
#[derive(Clone, Copy)]
pub(crate) struct Problem<'a, const D: usize> {
    pub bodies: &'a [NamedBody<D>],
    pub connections: &'a [Connection<D>],
    pub mesh: &'a Mesh<D>,
    pub active: &'a ActiveNodes<D>,
    pub pattern: &'a Pattern<D>,
    pub ghost: Option<&'a Ghost<D>>,
    pub constraints: &'a Constraints<D>,
    /// `f_ext` of every active node `[F]`.
    pub external: &'a [Vector<D>],
    /// Out-of-balance force that rounding alone can cause `[F]`.
    pub round_off: f64,
    pub tolerance: crate::model::Tolerance,
}

/// Penalised faces, and where their stiffness goes in the pattern.
pub(crate) struct Ghost<const D: usize> {
    pub faces: GhostFaces<D>,
    pub slots: Vec<u32>,
}

/// Nodal displacement that balances the forces of a load step.
#[derive(Clone)]
pub(crate) struct Equilibrium<const D: usize> {
    /// `Δu_v` of every active node `[L]`.
    pub increment: Vec<Vector<D>>,
    /// `f_int - f_ext`: on prescribed components the reaction `[F]`.
    pub reaction: Vec<Vector<D>>,
    /// Relative out-of-balance force after each linear solution.
    pub residuals: Vec<f64>,
    /// The most general factorisation that was needed.
    pub method: Method,
    /// Iterations of conjugate gradients.
    pub linear_iterations: u64,
    /// Corrections of which only a part was taken.
    pub shortened: u32,
    /// Linear solutions that a guess took which was dropped; not among the `residuals`.
    pub dropped: u64,
    /// Stages in which the step was balanced; 0 where it was balanced at once.
    pub stages: u32,
    /// Node at which LLᵀ last met a pivot that was not positive.
    pub unstable_node: Option<NodeId>,
    /// Smallest `det ΔF` of any point.
    pub smallest_determinant: f64,
    /// How well the linear systems were solved.
    pub accuracy: Accuracy,
}

/// How well linear systems were solved, in the worst of them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Accuracy {
    /// Largest backward error of a solution.
    pub backward_error: f64,
    /// Steps of iterative refinement, in all.
    pub refinements: u32,
    /// Largest ratio of the pivots of a factorisation; the condition number is as large or larger. 0: no pivots.
    pub pivot_spread: f64,
    /// Estimate of the condition number of the last tangent, where it is asked for.
    pub condition: Option<f64>,
}

impl<const D: usize> Equilibrium<D> {
    /// Nothing has moved, and linear systems will be solved by `method` until it fails.
    pub(crate) fn start(n: usize, method: Method) -> Self {
        Self {
            increment: vec![Vector::zeros(); n],
            reaction: vec![Vector::zeros(); n],
            residuals: Vec::new(),
            method,
            linear_iterations: 0,
            shortened: 0,
            dropped: 0,
            stages: 0,
            unstable_node: None,
            smallest_determinant: f64::INFINITY,
            accuracy: Accuracy::default(),
        }
    }
}

/// What is kept from step to step, and the flag that stops the run.
pub(crate) struct Workspace<const D: usize> {
    pub values: Vec<f64>,
    rhs: Vec<f64>,
    /// The last connectivity, and the start of its step where the points are still as they were there.
    pub connected: Option<(Connected<D>, Option<LoadFraction>)>,
    cancellation: Cancellation,
}

impl<const D: usize> Workspace<D> {
    pub(crate) fn new(cancellation: Cancellation) -> Self {
        Self { values: Vec::new(), rhs: Vec::new(), connected: None, cancellation }
    }
}

/// Whether a pass over the points also sums the tangent.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Wanted {
    Force,
    ForceAndTangent,
}

/// Balances the forces of a load step: full Newton from a guess, where there is one (prescribed components
/// and all), and where that converges at once; else from `Δu = 0`. Prescribed displacements are held exactly
/// from the first iterate on.
pub(crate) fn solve<const D: usize>(
    problem: &Problem<'_, D>,
    guess: Option<Vec<Vector<D>>>,
    linear: &mut LinearSolver<D>,
    workspace: &mut Workspace<D>,
    timings: &mut Timings,
) -> Result<Equilibrium<D>, StepFailure> {
    let mut weakest = None;
    let mut rest = Equilibrium::start(problem.active.len(), linear.first_method());
    if let Some(increment) = guess {
        let before = timings.count(Phase::Solve);
        let state = Equilibrium { increment, ..rest.clone() };
        let start = Start { state, lift: &[], is_guess: true };
        match iterate(start, problem, linear, workspace, &mut weakest, timings) {
            Err(failure) if failure != StepFailure::Cancelled => weakest = None,
            outcome => return outcome,
        }
        rest.dropped = timings.count(Phase::Solve) - before;
    }
    let start = Start { state: rest, lift: problem.constraints.increment(), is_guess: false };
    let found = iterate(start, problem, linear, workspace, &mut weakest, timings);
    found.map_err(|failure| match weakest {
        // A failure after an all but singular tangent is that tangent's.
        Some(pivot) if pivot.relative.abs() < SINGULAR && failure != StepFailure::Cancelled => {
            let cause = format!("{:.0e} of its stiffness is left; then: {failure}", pivot.relative);
            singular(problem, pivot.equation, cause)
        }
        _ => failure,
    })
}

/// As [`solve`], in stages: of what is out of balance at the start of the step, more and more is let go
/// of, and each part balanced from where the one before ended. The first stage makes the prescribed
/// increments alone; the last is the step itself.
///
/// Where points meet other cells than in the step before, forces are out of balance that do not become
/// smaller with the step. Where these throw Newton's first correction too far, shorter steps are no help.
pub(crate) fn solve_in_stages<const D: usize>(
    problem: &Problem<'_, D>,
    linear: &mut LinearSolver<D>,
    workspace: &mut Workspace<D>,
    timings: &mut Timings,
) -> Result<Equilibrium<D>, StepFailure> {
    let mut weakest = None;
    let mut state = Equilibrium::start(problem.active.len(), linear.first_method());
    let imbalance = evaluate(problem, &mut state, Wanted::Force, &mut [], &mut [], timings)?;
    let mut residuals = Vec::new();
    let mut lift = problem.constraints.increment();
    // Parts grow until one is too large.
    let (mut freed, mut part, mut growth) = (0.0, 0.0, 2.0);
    loop {
        let aim = f64::min(freed + part, 1.0);
        let kept = problem.external.iter().zip(&imbalance).map(|(f, r)| f - r * (1.0 - aim));
        let external: Vec<Vector<D>> = kept.collect();
        let mut tolerance = problem.tolerance;
        if aim < 1.0 {
            tolerance.residual = tolerance.residual.max(STAGE_RESIDUAL);
        }
        let stage = Problem { external: &external, tolerance, ..*problem };
        let start = Equilibrium { residuals: Vec::new(), stages: state.stages + 1, ..state.clone() };
        let start = Start { state: start, lift, is_guess: false };
        match iterate(start, &stage, linear, workspace, &mut weakest, timings) {
            Ok(balanced) => {
                residuals.extend(&balanced.residuals);
                state = balanced;
                if aim == 1.0 {
                    return Ok(Equilibrium { residuals, ..state });
                }
                part = if lift.is_empty() { growth * part } else { FIRST_PART };
                freed = aim;
                lift = &[];
            }
            Err(StepFailure::Cancelled) => return Err(StepFailure::Cancelled),
            Err(failure) if 0.5 * part < LEAST_STAGE => return Err(failure),
            Err(_) => (part, growth) = (0.5 * part, 1.0),
        }
    }
}

/// Where Newton's iteration begins.
struct Start<'a, const D: usize> {
    state: Equilibrium<D>,
    /// Prescribed increments that are still to be made, whole by the first correction; none if empty [L].
    lift: &'a [Vector<D>],
    /// Whether the iteration ends as soon as it does not converge well: it can begin elsewhere.
    is_guess: bool,
}

/// Newton's iteration.
fn iterate<const D: usize>(
    Start { mut state, lift, is_guess }: Start<'_, D>,
    problem: &Problem<'_, D>,
    linear: &mut LinearSolver<D>,
    workspace: &mut Workspace<D>,
    weakest: &mut Option<Pivot>,
    timings: &mut Timings,
) -> Result<Equilibrium<D>, StepFailure> {
    if workspace.cancellation.is_cancelled() {
        return Err(StepFailure::Cancelled);
    }
    let n = problem.active.len();
    let driven = problem.constraints.is_driven() && !lift.is_empty();
    let tolerance = problem.tolerance.residual;
    let goal = if is_guess { FROM_GUESS * tolerance } else { tolerance };
    workspace.values.resize(problem.pattern.n_entries(), 0.0);
    // All that the iterations write to: they allocate nothing, unless they are very many.
    state.residuals.reserve_exact(problem.tolerance.iterations.min(MOST_RESERVED) as usize);
    let (mut free, mut start) = (vec![Vector::zeros(); n], vec![Vector::zeros(); n]);
    let mut out_of_balance = vec![Vector::zeros(); n];

    // Linear predictor: the prescribed increments enter once, through the tangent.
    let mut lifted = if driven { vec![Vector::zeros(); n] } else { Vec::new() };
    let sums = PassSums { values: &mut workspace.values, lift: &mut lifted };
    evaluate_into(problem, &mut state, Wanted::ForceAndTangent, sums, &mut out_of_balance, timings)?;
    let is_close = || problem.relative(&out_of_balance, &state.reaction) < goal;
    if !driven && (problem.is_rounding(&out_of_balance) || is_close()) {
        return Ok(state);
    }
    for (force, lifted) in out_of_balance.iter_mut().zip(&lifted) {
        *force -= lifted;
    }
    problem.constraints.free_part(&mut out_of_balance);
    let mut has_tangent = true;

    let mut is_kept = false;
    for iteration in 1..=problem.tolerance.iterations {
        if !has_tangent && !is_kept {
            timings.skipped.tangents -= 1;
            let sums = PassSums { values: &mut workspace.values, lift: &mut [] };
            evaluate_into(problem, &mut state, Wanted::ForceAndTangent, sums, &mut out_of_balance, timings)?;
        }
        if is_kept {
            timings.skipped.factorisations += 1;
        } else {
            factorise(problem, linear, workspace, &mut state, weakest, timings)?;
        }
        let accuracy = accuracy(&state.residuals, goal);
        substitute_into(problem, linear, workspace, &out_of_balance, accuracy, &mut free, &mut state, timings)?;
        // A tangent is not worth its cost where this iterate should be the last, or its factor is none.
        let expects_to_keep = problem.tolerance.keep_factor_below.is_some() && (is_kept || iteration == 1);
        let wanted = if expects_to_keep || expects_convergence(&state.residuals, goal) {
            timings.skipped.tangents += 1;
            Wanted::Force
        } else {
            Wanted::ForceAndTangent
        };
        has_tangent = wanted == Wanted::ForceAndTangent;
        let first = iteration == 1;
        let correction = Correction {
            free: &free,
            lift: if first { lift } else { &[] },
            work: work(&free, &out_of_balance),
            // A short first correction would leave prescribed displacements to the points next to them.
            least_part: if first && driven { 1.0 } else { LEAST_PART },
        };
        start.copy_from_slice(&state.increment);
        let fields = CorrectedFields { start: &start, out_of_balance: &mut out_of_balance };
        correct(problem, &mut state, &correction, wanted, &mut workspace.values, fields, timings)?;

        let residual = problem.relative(&out_of_balance, &state.reaction);
        is_kept = !has_tangent && problem.keeps_factor(&state, residual);
        state.residuals.push(residual);
        if residual < goal || problem.is_rounding(&out_of_balance) {
            return Ok(state);
        }
        if is_guess && !converges_well(&state) {
            // Rounding may not let it come nearer.
            if residual < tolerance {
                return Ok(state);
            }
            break;
        }
        let best = state.residuals.iter().copied().fold(f64::INFINITY, f64::min);
        if !residual.is_finite() || residual > DIVERGED * best {
            break;
        }
    }
    Err(StepFailure::NotConverged { residuals: state.residuals })
}

impl<const D: usize> Problem<'_, D> {
    /// `|f_oob| / (|f_ext| + |f_reaction|)`.
    pub(crate) fn relative(&self, out_of_balance: &[Vector<D>], reaction: &[Vector<D>]) -> f64 {
        let mut supported = 0.0;
        for (v, force) in reaction.iter().enumerate() {
            for i in (0..D).filter(|&i| self.constraints.is_prescribed(v, i)) {
                supported += force[i] * force[i];
            }
        }
        let scale = norm(self.external) + f64::sqrt(supported);
        let force = norm(out_of_balance);
        if force == 0.0 { 0.0 } else { force / scale }
    }

    /// Whether a correction that has left this residual was good enough for its factorisation to be kept.
    /// The first one of a step is taken to answer a residual of 1.
    fn keeps_factor(&self, state: &Equilibrium<D>, residual: f64) -> bool {
        let before = state.residuals.last().copied().unwrap_or(1.0);
        self.tolerance.keep_factor_below.is_some_and(|most| residual <= most * before)
    }

    /// Whether what is out of balance is no more than rounding.
    fn is_rounding(&self, out_of_balance: &[Vector<D>]) -> bool {
        norm(out_of_balance) <= self.round_off
    }

    /// Whether what is out of balance is small against the forces, or no more than rounding.
    pub(crate) fn is_balanced(&self, out_of_balance: &[Vector<D>], reaction: &[Vector<D>]) -> bool {
        self.is_rounding(out_of_balance) || self.relative(out_of_balance, reaction) < self.tolerance.residual
    }
}

fn norm<const D: usize>(field: &[Vector<D>]) -> f64 {
    field.iter().map(|x| x.norm_squared()).sum::<f64>().sqrt()
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
fn converges_well<const D: usize>(state: &Equilibrium<D>) -> bool {
    let halved = match state.residuals[..] {
        [.., before, last] => last <= 0.5 * before,
        _ => true,
    };
    halved && state.shortened == 0
}

/// Whether quadratic convergence would carry the next residual well below the tolerance.
fn expects_convergence(residuals: &[f64], tolerance: f64) -> bool {
    match residuals {
        [.., before, last] => last * (last / before).powi(2) < 0.01 * tolerance,
        _ => false,
    }
}

/// Adds the correction, or a part of it: a half, a quarter, … until no point is inverted, and where
/// the whole would overshoot (the work of the out-of-balance force along it changes sign and is not
/// smaller than at the start) about as much of it as makes that work vanish.
fn correct<const D: usize>(
    problem: &Problem<'_, D>,
    state: &mut Equilibrium<D>,
    correction: &Correction<'_, D>,
    wanted: Wanted,
    values: &mut [f64],
    fields: CorrectedFields<'_, D>,
    timings: &mut Timings,
) -> Result<(), StepFailure> {
    let CorrectedFields { start, out_of_balance } = fields;
    let mut part = 1.0;
    loop {
        correction.apply(part, start, &mut state.increment);
        let sums = PassSums { values: &mut *values, lift: &mut [] };
        match evaluate_into(problem, state, wanted, sums, out_of_balance, timings) {
            Err(StepFailure::Inverted { .. }) if part > correction.least_part => {
                part *= 0.5;
                state.shortened += 1;
            }
            result => break result?,
        }
    }

    let at_start = correction.work;
    let at_end = work(correction.free, out_of_balance);
    if part < 1.0 || at_start <= 0.0 || at_end > -OVERSHOT * at_start {
        return Ok(());
    }
    // Illinois variant of the false position method, on the sign change between none and all of it.
    let (mut low, mut low_work, mut high, mut high_work) = (0.0, at_start, 1.0, at_end);
    for _ in 0..SEARCHES {
        part = (low * high_work - high * low_work) / (high_work - low_work);
        correction.apply(part, start, &mut state.increment);
        let sums = PassSums { values: &mut *values, lift: &mut [] };
        evaluate_into(problem, state, Wanted::Force, sums, out_of_balance, timings)?;
        let here = work(correction.free, out_of_balance);
        if here.abs() <= 0.5 * at_start {
            break;
        }
        if here > 0.0 {
            (low, low_work, high_work) = (part, here, 0.5 * high_work);
        } else {
            (high, high_work, low_work) = (part, here, 0.5 * low_work);
        }
    }
    state.shortened += 1;
    if wanted == Wanted::ForceAndTangent {
        evaluate_into(problem, state, wanted, PassSums { values, lift: &mut [] }, out_of_balance, timings)?;
    }
    Ok(())
}

/// What a correction starts from, and what it leaves out of balance.
struct CorrectedFields<'a, const D: usize> {
    /// The increment before it [L].
    start: &'a [Vector<D>],
    /// [F].
    out_of_balance: &'a mut [Vector<D>],
}

/// A correction of the displacement and what is known of it.
struct Correction<'a, const D: usize> {
    /// The correction, zero on prescribed components [L].
    free: &'a [Vector<D>],
    /// Prescribed increments that it brings along, whole whatever part of it is taken; none but in
    /// the first iteration [L].
    lift: &'a [Vector<D>],
    /// Work along it of the out-of-balance force that it answers [F L].
    work: f64,
    /// Smallest part that is tried where it inverts a point.
    least_part: f64,
}

impl<const D: usize> Correction<'_, D> {
    fn apply(&self, part: f64, start: &[Vector<D>], increment: &mut [Vector<D>]) {
        for ((increment, start), free) in increment.iter_mut().zip(start).zip(self.free) {
            *increment = start + free * part;
        }
        for (increment, lift) in increment.iter_mut().zip(self.lift) {
            *increment += lift;
        }
    }
}

fn work<const D: usize>(displacement: &[Vector<D>], force: &[Vector<D>]) -> f64 {
    displacement.iter().zip(force).map(|(u, f)| u.dot(f)).sum()
}

/// Forces (and tangent) under the state's increment: sets the reaction, returns `f_ext - f_int` of
/// the components that are free.
pub(crate) fn evaluate<const D: usize>(
    problem: &Problem<'_, D>,
    state: &mut Equilibrium<D>,
    wanted: Wanted,
    values: &mut [f64],
    lift: &mut [Vector<D>],
    timings: &mut Timings,
) -> Result<Vec<Vector<D>>, StepFailure> {
    let mut out_of_balance = vec![Vector::zeros(); problem.active.len()];
    evaluate_into(problem, state, wanted, PassSums { values, lift }, &mut out_of_balance, timings)?;
    Ok(out_of_balance)
}

/// The tangent's values, and where not empty its product with the prescribed increments.
struct PassSums<'a, const D: usize> {
    values: &'a mut [f64],
    lift: &'a mut [Vector<D>],
}

/// As [`evaluate`], into `out_of_balance`.
fn evaluate_into<const D: usize>(
    problem: &Problem<'_, D>,
    state: &mut Equilibrium<D>,
    wanted: Wanted,
    targets: PassSums<'_, D>,
    out_of_balance: &mut [Vector<D>],
    timings: &mut Timings,
) -> Result<(), StepFailure> {
    let PassSums { values, lift } = targets;
    let phase = match wanted {
        Wanted::Force => Phase::Stress,
        Wanted::ForceAndTangent => Phase::Assemble,
    };
    for named in problem.bodies {
        timings.skipped.count_pass(&*named.body);
    }
    timings.time(phase, || {
        state.smallest_determinant = f64::INFINITY;
        state.reaction.fill(Vector::zeros());
        if wanted == Wanted::ForceAndTangent {
            values.fill(0.0);
        }
        let input = PassInput {
            pattern: problem.pattern,
            constraints: problem.constraints,
            increment: &state.increment,
        };
        for (named, connection) in problem.bodies.iter().zip(problem.connections) {
            let determinant = named
                .body
                .assemble(connection, input, sums(wanted, &mut state.reaction, values, lift))
                .map_err(|it| inverted(named, it))?;
            state.smallest_determinant = state.smallest_determinant.min(determinant);
        }
        if let Some(Ghost { faces, slots }) = problem.ghost {
            faces.assemble(slots, input, sums(wanted, &mut state.reaction, values, lift));
        }
        if wanted == Wanted::ForceAndTangent {
            finish_tangent(problem.pattern, problem.constraints, values);
        }
        // Internal force becomes f_int - f_ext; what is free of it must vanish.
        for (v, (reaction, external)) in state.reaction.iter_mut().zip(problem.external).enumerate() {
            *reaction -= external;
            out_of_balance[v] = -*reaction;
        }
        problem.constraints.free_part(out_of_balance);
        Ok(())
    })
}

/// What a pass adds to; no lift where `lift` is empty.
fn sums<'a, const D: usize>(
    wanted: Wanted,
    internal: &'a mut [Vector<D>],
    values: &'a mut [f64],
    lift: &'a mut [Vector<D>],
) -> Sums<'a, D> {
    let lift = if lift.is_empty() { None } else { Some(lift) };
    let tangent = TangentSums { values, lift };
    Sums { internal, tangent: (wanted == Wanted::ForceAndTangent).then_some(tangent) }
}

/// The failure of a trial that inverts a point.
pub(crate) fn inverted<const D: usize>(named: &NamedBody<D>, it: InvertedPoint) -> StepFailure {
    StepFailure::Inverted {
        body: named.name.clone(),
        basis: named.body.basis(),
        point: it.point,
        position: named.body.point(it.point).position.iter().copied().collect(),
        determinant: it.determinant,
    }
}

/// `K⁻¹ f`, zero on prescribed components.
pub(crate) fn correction<const D: usize>(
    problem: &Problem<'_, D>,
    linear: &mut LinearSolver<D>,
    workspace: &mut Workspace<D>,
    force: &[Vector<D>],
    state: &mut Equilibrium<D>,
    weakest: &mut Option<Pivot>,
    timings: &mut Timings,
) -> Result<Vec<Vector<D>>, StepFailure> {
    factorise(problem, linear, workspace, state, weakest, timings)?;
    substitute(problem, linear, workspace, force, state, timings)
}

/// Factorises the tangent in the workspace.
fn factorise<const D: usize>(
    problem: &Problem<'_, D>,
    linear: &mut LinearSolver<D>,
    workspace: &Workspace<D>,
    state: &mut Equilibrium<D>,
    weakest: &mut Option<Pivot>,
    timings: &mut Timings,
) -> Result<(), StepFailure> {
    if workspace.cancellation.is_cancelled() {
        return Err(StepFailure::Cancelled);
    }
    let report = timings
        .time(Phase::Factorise, || linear.factorise(columns(problem.pattern), &workspace.values, state.method))
        .map_err(|error| linear_failure(problem, error))?;
    state.method = state.method.max(report.method);
    *weakest = report.weakest;
    if let Some(ratio) = report.pivot_ratio {
        state.accuracy.pivot_spread = state.accuracy.pivot_spread.max(ratio.recip());
    }
    if let Some(pivot) = report.not_positive {
        state.unstable_node = Some(problem.active.nodes()[pivot.equation / D]);
    }
    Ok(())
}

/// As [`correction`], with the factorisation at hand.
pub(crate) fn substitute<const D: usize>(
    problem: &Problem<'_, D>,
    linear: &mut LinearSolver<D>,
    workspace: &mut Workspace<D>,
    force: &[Vector<D>],
    state: &mut Equilibrium<D>,
    timings: &mut Timings,
) -> Result<Vec<Vector<D>>, StepFailure> {
    let mut free = vec![Vector::zeros(); force.len()];
    substitute_into(problem, linear, workspace, force, LEFT_ON_PATH, &mut free, state, timings)?;
    Ok(free)
}

/// As [`substitute`], into `free`; conjugate gradients may leave `accuracy · |force|`.
#[expect(clippy::too_many_arguments, reason = "a linear system and where its solution goes")]
fn substitute_into<const D: usize>(
    problem: &Problem<'_, D>,
    linear: &mut LinearSolver<D>,
    workspace: &mut Workspace<D>,
    force: &[Vector<D>],
    accuracy: f64,
    free: &mut [Vector<D>],
    state: &mut Equilibrium<D>,
    timings: &mut Timings,
) -> Result<(), StepFailure> {
    let Workspace { values, rhs, .. } = workspace;
    rhs.clear();
    rhs.extend(force.iter().flat_map(|force| force.iter().copied()));
    let report = timings
        .time(Phase::Solve, || linear.solve(columns(problem.pattern), values, rhs, accuracy))
        .map_err(|error| linear_failure(problem, error))?;
    state.linear_iterations += u64::from(report.iterations);
    state.method = state.method.max(report.method);
    // What conjugate gradients leave is chosen, and no error.
    if report.method != Method::ConjugateGradients {
        state.accuracy.backward_error = state.accuracy.backward_error.max(report.backward_error);
    }
    state.accuracy.refinements += report.refinements as u32;
    for (free, x) in free.iter_mut().zip(rhs.chunks_exact(D)) {
        free.copy_from_slice(x);
    }
    Ok(())
}

/// The tangent's pattern as the linear solver takes it.
pub(crate) fn columns<const D: usize>(pattern: &Pattern<D>) -> SymmetricPattern<'_> {
    SymmetricPattern { column_start: pattern.column_start(), row: pattern.row() }
}

fn linear_failure<const D: usize>(problem: &Problem<'_, D>, error: Singular) -> StepFailure {
    match error.cause {
        Cause::EmptyRow | Cause::NoPivot | Cause::Inaccurate { .. } => {
            singular(problem, error.equation, error.cause.to_string())
        }
        Cause::MatrixNotFinite | Cause::RightHandSideNotFinite | Cause::TooLargeToFactorise { .. } => {
            StepFailure::Linear(error.to_string())
        }
    }
}

fn singular<const D: usize>(problem: &Problem<'_, D>, equation: usize, cause: String) -> StepFailure {
    let node = problem.active.nodes()[equation / D];
    StepFailure::Singular {
        node: node.index(),
        position: problem.mesh.position(node).iter().copied().collect(),
        component: equation % D,
        cause,
        stabilised: problem.ghost.is_some(),
    }
}

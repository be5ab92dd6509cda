//! Equilibrium of one load step at a load fraction that is itself unknown.
//!
//! With the load fraction t unknown, a load step needs one more equation: it has a given length. A
//! length is either the displacement of the material or the energy that it dissipates. One Newton
//! iteration on both (Crisfield 1981; Verhoosel, Remmers & Gutiérrez 2009, "A dissipation-based
//! arc-length method for robust simulation of brittle and ductile failure"):
//!
//! ```text
//! K δu₁ = f_ext - f_int                   the out-of-balance force
//! K δu₂ = ∂f_ext/∂t - K ∂ū/∂t             loads and prescribed displacements ū per load fraction
//! δt    = (length wanted - length - ∂length/∂u · δu₁) / (∂length/∂u · (δu₂ + ∂ū/∂t))
//! δu    = δu₁ + δt δu₂
//! ```
//!
//! One factorisation serves both right-hand sides; K stays symmetric and may be indefinite.

use crate::error::{PathFailure, StepFailure};
use crate::newton::{Equilibrium, Problem, Wanted, Workspace, correction, evaluate, inverted, substitute};
use crate::secant::Secant;
use crate::timing::{Phase, Timings};
use mpm_assembly::Constraints;
use mpm_grid::{LoadFraction, Vector};
use mpm_linear::LinearSolver;

/// Half the difference of load fractions over which loading is differentiated.
const HALF_DIFFERENCE: f64 = 1e-5;

/// A step counts as solved although its length is off by this part of what it should be.
const LENGTH_TOLERANCE: f64 = 0.1;

/// A correction that inverts a point, or makes the length vanish, is halved this often.
const HALVINGS: u32 = 6;

/// Evaluations in the search for a first guess that dissipates the right energy.
const SEARCHES: u32 = 30;

/// What the length of a step is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Length {
    /// Root mean square of the free displacements, nodes weighted by their share of stiffness `[L]`.
    /// Measured from where the body goes at once (to first order) because the mesh is another than that
    /// of the step before: around the start itself a short step need not hold any equilibrium.
    Displacement,
    /// Dissipated energy `[F L]`.
    Dissipation,
}

/// One step to be tried, and what came of it.
pub(crate) struct Attempt<'a, const D: usize> {
    /// Where displacement is measured from; nothing if it is the start of the step. See [`Length::Displacement`].
    pub origin: Vec<Vector<D>>,
    /// Load fraction at its start.
    pub start: f64,
    /// What its length is.
    pub measure: Length,
    /// How long it should be; if left out, as long as the step of `seed`, and then set.
    pub aim: Option<f64>,
    /// Change of the load fraction that the first guess begins with where there is no secant.
    pub seed: f64,
    /// Largest change of the load fraction, in one correction and in all.
    pub reach: f64,
    /// The last step, if there is one of the same kind.
    pub secant: Option<&'a Secant<D>>,
    /// Whether the first guess is the last step, or the tangent.
    pub guess_by_secant: bool,
    /// Load fraction at its end; outside 0 to 1 where the path leads there.
    pub end: f64,
    /// The length that it has in the end.
    pub length: f64,
}

/// Prescribed increments and external forces at a load fraction.
pub(crate) type LoadingAt<'a, const D: usize> =
    dyn Fn(LoadFraction) -> Result<(Constraints<D>, Vec<Vector<D>>), StepFailure> + 'a;

/// Balances the forces of a step of given length.
pub(crate) fn solve<const D: usize>(
    problem: &Problem<'_, D>,
    loading: &LoadingAt<'_, D>,
    attempt: &mut Attempt<'_, D>,
    linear: &mut LinearSolver<D>,
    workspace: &mut Workspace<D>,
    timings: &mut Timings,
) -> Result<Equilibrium<D>, StepFailure> {
    let weights = weights(problem);
    let origin = Vec::new();
    let mut state = Equilibrium::start(problem.active.len(), linear.first_method());
    let mut solver = Solver { problem, loading, weights, origin, linear, workspace, timings };
    let mut at = attempt.start;
    solver.guess(attempt, &mut state, &mut at)?;
    let mut trial = solver.evaluate(&mut state, at)?;
    let mut gauge = solver.gauge(attempt.measure, &state.increment)?;
    let aim = attempt.aim.expect("the first guess sets it");

    for _ in 0..problem.tolerance.iterations {
        let (first, second) = solver.directions(&trial, &mut state)?;
        let along = gauge.slope(&first);
        let per_fraction = gauge.slope(&second) + gauge.slope(trial.loading.rates.increment());
        if per_fraction == 0.0 {
            return Err(StepFailure::Path(PathFailure::NoLength));
        }
        let fraction = (aim - gauge.length - along) / per_fraction;
        // Far from the path the linear model of the length is worth nothing; half its way is.
        let mut part = f64::min(1.0, attempt.reach / fraction.abs());
        let (from, at_before) = (state.increment.clone(), at);
        let mut halvings = 0;
        (trial, gauge) = loop {
            at = at_before + part * fraction;
            for (v, increment) in state.increment.iter_mut().enumerate() {
                *increment = from[v] + (first[v] + second[v] * fraction) * part;
            }
            let result = solver.evaluate(&mut state, at);
            match result.and_then(|trial| Ok((trial, solver.gauge(attempt.measure, &state.increment)?))) {
                Err(StepFailure::Inverted { .. }) if halvings < HALVINGS => {}
                // Where nothing yields any more there is no way back.
                Ok((_, gauge)) if gauge.length == 0.0 && halvings < HALVINGS => {}
                result => break result?,
            }
            (part, halvings) = (0.5 * part, halvings + 1);
        };
        state.shortened += u32::from(part < 1.0);
        let now = problem.under(&trial.loading);
        state.residuals.push(now.relative(&trial.out_of_balance, &state.reaction));
        let is_as_long = (gauge.length - aim).abs() <= LENGTH_TOLERANCE * aim;
        if is_as_long && now.is_balanced(&trial.out_of_balance, &state.reaction) {
            (attempt.end, attempt.length) = (at, gauge.length);
            attempt.origin = solver.origin;
            return Ok(state);
        }
    }
    Err(StepFailure::NotConverged { residuals: state.residuals })
}

/// Length of the step that `increment` makes.
pub(crate) fn length<const D: usize>(
    problem: &Problem<'_, D>,
    measure: Length,
    increment: &[Vector<D>],
) -> Result<f64, StepFailure> {
    Ok(gauge(problem, &weights(problem), measure, increment, &[])?.length)
}

impl<'a, const D: usize> Problem<'a, D> {
    /// The same under other loading.
    fn under<'b>(&self, loading: &'b Loading<D>) -> Problem<'b, D>
    where
        'a: 'b,
    {
        Problem { constraints: &loading.rates, external: &loading.external, ..*self }
    }
}

/// Loading at a load fraction and its derivative.
struct Loading<const D: usize> {
    /// `ū` over the step `[L]`.
    prescribed: Vec<Vector<D>>,
    /// `∂ū/∂t` `[L]`, as the increments of constraints.
    rates: Constraints<D>,
    /// `f_ext` `[F]`.
    external: Vec<Vector<D>>,
    /// `∂f_ext/∂t` `[F]`.
    external_rate: Vec<Vector<D>>,
}

/// Forces and tangent at a trial; the tangent is in the workspace.
struct Trial<const D: usize> {
    loading: Loading<D>,
    /// `f_ext - f_int`, zero on prescribed components `[F]`.
    out_of_balance: Vec<Vector<D>>,
    /// `∂f_ext/∂t - K ∂ū/∂t`, zero on prescribed components `[F]`.
    rate: Vec<Vector<D>>,
}

/// A length and its derivative with respect to nodal displacements.
struct Gauge<const D: usize> {
    length: f64,
    gradient: Vec<Vector<D>>,
}

impl<const D: usize> Gauge<D> {
    fn slope(&self, direction: &[Vector<D>]) -> f64 {
        self.gradient.iter().zip(direction).map(|(g, u)| g.dot(u)).sum()
    }
}

struct Solver<'s, 'p, const D: usize> {
    problem: &'s Problem<'p, D>,
    loading: &'s LoadingAt<'s, D>,
    weights: Vec<f64>,
    /// See [`Attempt::origin`].
    origin: Vec<Vector<D>>,
    linear: &'s mut LinearSolver<D>,
    workspace: &'s mut Workspace<D>,
    timings: &'s mut Timings,
}

impl<const D: usize> Solver<'_, '_, D> {
    /// Forces and tangent at `at`, with the displacements that are prescribed there.
    fn evaluate(&mut self, state: &mut Equilibrium<D>, at: f64) -> Result<Trial<D>, StepFailure> {
        let loading = loading(self.loading, at)?;
        impose(&loading.rates, &loading.prescribed, &mut state.increment);
        let problem = self.problem.under(&loading);
        self.workspace.values.resize(problem.pattern.n_entries(), 0.0);
        let mut rate = vec![Vector::zeros(); problem.active.len()];
        let values = &mut self.workspace.values;
        let out_of_balance =
            evaluate(&problem, state, Wanted::ForceAndTangent, values, &mut rate, self.timings)?;
        for (rate, external) in rate.iter_mut().zip(&loading.external_rate) {
            *rate = external - *rate;
        }
        loading.rates.free_part(&mut rate);
        Ok(Trial { loading, out_of_balance, rate })
    }

    /// `K⁻¹` on the out-of-balance force and on the rate of the loading.
    fn directions(
        &mut self,
        trial: &Trial<D>,
        state: &mut Equilibrium<D>,
    ) -> Result<(Vec<Vector<D>>, Vec<Vector<D>>), StepFailure> {
        let problem = self.problem.under(&trial.loading);
        let (solver, workspace) = (&mut *self.linear, &mut *self.workspace);
        let force = &trial.out_of_balance;
        let first = correction(&problem, solver, workspace, force, state, &mut None, self.timings)?;
        let second = substitute(&problem, solver, workspace, &trial.rate, state, self.timings)?;
        Ok((first, second))
    }

    fn gauge(&mut self, measure: Length, increment: &[Vector<D>]) -> Result<Gauge<D>, StepFailure> {
        self.timings
            .time(Phase::Stress, || gauge(self.problem, &self.weights, measure, increment, &self.origin))
    }

    fn weighted(&self, a: &[Vector<D>], b: &[Vector<D>]) -> f64 {
        self.weights.iter().zip(a.iter().zip(b)).map(|(weight, (a, b))| weight * a.dot(b)).sum()
    }

    /// The first guess of displacement and load fraction.
    fn guess(
        &mut self,
        attempt: &mut Attempt<'_, D>,
        state: &mut Equilibrium<D>,
        at: &mut f64,
    ) -> Result<(), StepFailure> {
        let by_displacement = attempt.measure == Length::Displacement;
        let mut tangent = None;
        if by_displacement {
            let trial = self.evaluate(state, *at)?;
            let (mut first, second) = self.directions(&trial, state)?;
            // Across the path: along it the tangent is singular at a limit point.
            let shift = attempt.secant.map_or(0.0, |secant| {
                let onwards = secant.carried(self.problem);
                -self.weighted(&onwards, &first) / self.weighted(&onwards, &second)
            });
            for (first, second) in first.iter_mut().zip(&second) {
                *first += second * shift;
            }
            *at += shift;
            self.origin = first.clone();
            tangent = Some((trial, first, second));
        }
        if let (Some(secant), Some(aim), true) = (attempt.secant, attempt.aim, attempt.guess_by_secant) {
            let scale = aim / secant.length;
            state.increment = secant.carried(self.problem);
            for (v, increment) in state.increment.iter_mut().enumerate() {
                *increment *= scale;
                *increment += self.origin.get(v).copied().unwrap_or_else(Vector::zeros);
            }
            let end = *at + scale * secant.fraction;
            impose_at(self.loading, end, &mut state.increment)?;
            if matches!(self.gauge(attempt.measure, &state.increment), Ok(gauge) if gauge.length > 0.0) {
                *at = end;
                return Ok(());
            }
            state.increment.fill(Vector::zeros());
        }
        let (trial, first, second) = match tangent {
            Some(tangent) => tangent,
            None => {
                let trial = self.evaluate(state, *at)?;
                let (first, second) = self.directions(&trial, state)?;
                (trial, first, second)
            }
        };
        let step = match attempt.measure {
            Length::Displacement => {
                let unit = gauge(self.problem, &self.weights, Length::Displacement, &second, &[])?;
                let aim = *attempt.aim.get_or_insert(unit.length * attempt.seed);
                // Onwards is where the last step went.
                let onwards = attempt.secant.map_or(1.0, |secant| unit.slope(&secant.carried(self.problem)));
                (aim / unit.length).copysign(onwards)
            }
            Length::Dissipation => self.dissipating(attempt, |step| {
                let mut increment: Vec<Vector<D>> =
                    first.iter().zip(&second).map(|(first, second)| first + second * step).collect();
                let rates = trial.loading.rates.increment();
                let prescribed: Vec<Vector<D>> = rates.iter().map(|rate| rate * step).collect();
                impose(&trial.loading.rates, &prescribed, &mut increment);
                increment
            })?,
        };
        *at += step;
        for (v, increment) in state.increment.iter_mut().enumerate() {
            *increment = first[v] + second[v] * step;
        }
        Ok(())
    }

    /// The step of load fraction along the tangent that dissipates what it should. The tangent is that of
    /// points that are about to yield, taken as elastic or as plastic as rounding has it: elastic, only
    /// forwards does anything dissipate; plastic and past a limit point, backwards.
    fn dissipating(
        &mut self,
        attempt: &mut Attempt<'_, D>,
        along: impl Fn(f64) -> Vec<Vector<D>>,
    ) -> Result<f64, StepFailure> {
        let mut energy = |step: f64| match self.gauge(Length::Dissipation, &along(step)) {
            // A step that inverts a point is too long as well.
            Err(StepFailure::Inverted { .. }) => Ok(f64::INFINITY),
            gauge => gauge.map(|gauge| gauge.length),
        };
        let longest = attempt.reach.max(8.0 * attempt.seed);
        let (mut low, mut high, mut size) = (0.0, f64::INFINITY, attempt.seed);
        let mut least: Option<(f64, f64)> = None;
        for _ in 0..SEARCHES {
            let (forwards, backwards) = (energy(size)?, energy(-size)?);
            let (step, energy) = if forwards >= backwards { (size, forwards) } else { (-size, backwards) };
            if energy.is_finite() && energy > 0.0 {
                let aim = *attempt.aim.get_or_insert(0.5 * energy);
                if (0.5 * aim..=2.0 * aim).contains(&energy) {
                    return Ok(step);
                }
                if least.is_none_or(|(_, least)| energy < least) {
                    least = Some((step, energy));
                }
            }
            if energy > attempt.aim.unwrap_or(f64::MAX) {
                high = size;
            } else {
                low = size;
            }
            size = if high.is_finite() { 0.5 * (low + high) } else { 2.0 * size };
            if size > longest {
                break;
            }
        }
        // The change of mesh alone may dissipate more than the step should.
        let (step, energy) = least.ok_or(StepFailure::Path(PathFailure::NoLength))?;
        attempt.aim = Some(energy);
        Ok(step)
    }
}

/// Share of the stiffness that each node carries; they sum to 1.
fn weights<const D: usize>(problem: &Problem<'_, D>) -> Vec<f64> {
    let mut weights = vec![0.0; problem.active.len()];
    for (named, connection) in problem.bodies.iter().zip(problem.connections) {
        named.body.stiffness_force(connection.links(), &mut weights);
    }
    let sum: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|weight| *weight /= sum);
    weights
}

fn gauge<const D: usize>(
    problem: &Problem<'_, D>,
    weights: &[f64],
    measure: Length,
    increment: &[Vector<D>],
    origin: &[Vector<D>],
) -> Result<Gauge<D>, StepFailure> {
    let mut gradient = vec![Vector::zeros(); increment.len()];
    let mut length = 0.0;
    match measure {
        Length::Displacement => {
            gradient.copy_from_slice(increment);
            for (u, origin) in gradient.iter_mut().zip(origin) {
                *u -= origin;
            }
            problem.constraints.free_part(&mut gradient);
            for (u, weight) in gradient.iter_mut().zip(weights) {
                length += weight * u.norm_squared();
                *u *= *weight;
            }
            length = length.sqrt();
            if length > 0.0 {
                gradient.iter_mut().for_each(|g| *g /= length);
            }
        }
        Length::Dissipation => {
            for (named, connection) in problem.bodies.iter().zip(problem.connections) {
                let energy = named
                    .body
                    .dissipation(connection, increment, &mut gradient)
                    .map_err(|it| inverted(named, it))?;
                length += energy;
            }
        }
    }
    Ok(Gauge { length, gradient })
}

/// Loading at a load fraction; beyond 0 and 1 it goes on in a straight line.
fn loading<const D: usize>(loading: &LoadingAt<'_, D>, at: f64) -> Result<Loading<D>, StepFailure> {
    if !at.is_finite() {
        return Err(StepFailure::Path(PathFailure::Leaves { fraction: at }));
    }
    let fraction = |value: f64| LoadFraction::new(value.clamp(0.0, 1.0)).expect("clamped");
    let here = fraction(at);
    let (before, after) = (fraction(here.get() - HALF_DIFFERENCE), fraction(here.get() + HALF_DIFFERENCE));
    let (constraints, mut external) = loading(here)?;
    let (low, low_force) = loading(before)?;
    let (high, high_force) = loading(after)?;
    let (span, beyond) = (after.get() - before.get(), at - here.get());

    let mut prescribed = constraints.increment().to_vec();
    let mut rates = Constraints::none(constraints.n_nodes());
    for (v, prescribed) in prescribed.iter_mut().enumerate() {
        for i in (0..D).filter(|&i| constraints.is_prescribed(v, i)) {
            let rate = (high.increment()[v][i] - low.increment()[v][i]) / span;
            rates.prescribe(v, i, rate);
            prescribed[i] += rate * beyond;
        }
    }
    let external_rate: Vec<Vector<D>> =
        low_force.iter().zip(&high_force).map(|(low, high)| (high - low) / span).collect();
    for (force, rate) in external.iter_mut().zip(&external_rate) {
        *force += rate * beyond;
    }
    Ok(Loading { prescribed, rates, external, external_rate })
}

/// Sets the components that are prescribed at a load fraction.
fn impose_at<const D: usize>(
    at: &LoadingAt<'_, D>,
    end: f64,
    increment: &mut [Vector<D>],
) -> Result<(), StepFailure> {
    let loading = loading(at, end)?;
    impose(&loading.rates, &loading.prescribed, increment);
    Ok(())
}

/// Sets the prescribed components.
pub(crate) fn impose<const D: usize>(
    constraints: &Constraints<D>,
    prescribed: &[Vector<D>],
    increment: &mut [Vector<D>],
) {
    constraints.free_part(increment);
    for (increment, prescribed) in increment.iter_mut().zip(prescribed) {
        *increment += prescribed;
    }
}

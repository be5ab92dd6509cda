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

use super::newton;
use super::problem::{Equilibrium, Iterate, Problem, Wanted, inadmissible};
use super::system::{BorderRow, BorderedSolution, Solver};
use crate::failure::{PathFailure, StepFailure};
use crate::loading::{HALF_DIFFERENCE, LoadingAt, StepLoading, impose};
use crate::predictor::Predictor;
use crate::ranks::{Shared, agreed, total};
use crate::timing::Phase;
use mpm_assembly::UnknownVector;
use mpm_grid::{LoadFraction, Vector};
use std::sync::Arc;

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
pub(crate) struct PathStep<const D: usize> {
    /// Where displacement is measured from; nothing if it is the start of the step. See [`Length::Displacement`].
    pub origin: Vec<Vector<D>>,
    /// Load fraction at its start.
    pub start: f64,
    /// What its length is.
    pub measure: Length,
    /// How long it should be; if left out, as long as the step of `seed`, and then set.
    pub aim: Option<f64>,
    /// Change of the load fraction that the first guess begins with where there is no predictor.
    pub seed: f64,
    /// Largest change of the load fraction, in one correction and in all.
    pub reach: f64,
    /// The last step, if there is one of the same kind.
    pub predictor: Option<Arc<Predictor<D>>>,
    /// Where the iteration begins.
    pub guess: FirstGuess,
    /// Load fraction at its end; outside 0 to 1 where the path leads there.
    pub end: f64,
    /// The length that it has in the end.
    pub length: f64,
}

/// Where the iteration of a step along the path begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FirstGuess {
    /// At the last step in proportion, where there is one.
    LastStep,
    /// On the tangent.
    Tangent,
}

/// Balances the forces of a step that ends at load fraction `end`, and measures its length.
///
/// # Errors
/// As [`newton::solve`], and where the step may have jumped over a limit point.
pub(crate) fn solve_measured<const D: usize>(
    problem: &Problem<'_, D>,
    step: &mut PathStep<D>,
    end: LoadFraction,
    solver: &mut Solver<D>,
) -> Result<Equilibrium<D>, StepFailure> {
    step.end = end.get();
    let equilibrium = newton::solve(problem, None, solver)?;
    if step.measure == Length::Dissipation && equilibrium.effort.is_unstable && end.get() < 1.0 {
        return Err(StepFailure::Path(PathFailure::LimitPoint));
    }
    step.length = gauge(problem, &weights(problem), step.measure, &equilibrium.increment, &[])?.length;
    Ok(equilibrium)
}

/// Balances the forces of a step of given length.
///
/// # Errors
/// No equilibrium of this length is found, or not the next one on the path.
pub(crate) fn solve<const D: usize>(
    problem: &Problem<'_, D>,
    loading: &StepLoading<'_, D>,
    step: &mut PathStep<D>,
    solver: &mut Solver<D>,
) -> Result<Equilibrium<D>, StepFailure> {
    let mut path = PathIteration { problem, loading, weights: weights(problem), origin: Vec::new(), solver };
    let (iterate, end, length) = path.iterate(step)?;
    step.origin = path.origin;
    (step.end, step.length) = (end, length);
    if !(0.0..=1.0).contains(&end) {
        return Err(StepFailure::Path(PathFailure::Leaves { fraction: end }));
    }
    let change = end - step.start;
    if change.abs() > step.reach {
        return Err(StepFailure::Path(PathFailure::Jump { change }));
    }
    Ok(iterate.into_equilibrium())
}

impl<'a, const D: usize> Problem<'a, D> {
    /// The same under other loading.
    fn under<'b>(&self, loading: &'b LoadingAt<D>) -> Problem<'b, D>
    where
        'a: 'b,
    {
        Problem { constraints: &loading.rates, external: &loading.external, end: loading.at, ..*self }
    }
}

/// The loading at an iterate; the tangent is in the solver.
struct Trial<const D: usize> {
    loading: LoadingAt<D>,
    /// `∂f_ext/∂t - ∂f_int/∂t - K ∂ū/∂t`, zero on prescribed components `[F]`.
    rate: UnknownVector<D>,
}

/// A length and its derivative with respect to nodal displacements.
struct Gauge<const D: usize> {
    length: f64,
    gradient: Vec<Vector<D>>,
}

impl<const D: usize> Gauge<D> {
    fn slope(&self, direction: &[Vector<D>], shared: &Shared<D>) -> f64 {
        shared.dot_nodes(&self.gradient, direction)
    }
}

/// Newton's iteration on displacement and load fraction.
struct PathIteration<'s, 'p, const D: usize> {
    problem: &'s Problem<'p, D>,
    loading: &'s StepLoading<'s, D>,
    weights: Vec<f64>,
    /// See [`PathStep::origin`].
    origin: Vec<Vector<D>>,
    solver: &'s mut Solver<D>,
}

impl<const D: usize> PathIteration<'_, '_, D> {
    /// The balanced iterate, its load fraction and its length.
    fn iterate(&mut self, step: &mut PathStep<D>) -> Result<(Iterate<D>, f64, f64), StepFailure> {
        let mut iterate = self.solver.at_rest(self.problem);
        let mut at = self.guess(step, &mut iterate)?;
        let mut trial = self.evaluate(&mut iterate, at)?;
        let mut gauge = self.gauge(step.measure, &iterate.increment)?;
        let aim = step.aim.expect("the first guess sets it");
        let shared = &self.problem.connected.shared;

        for _ in 0..self.problem.tolerance.iterations {
            let solution = self.directions(&trial, &mut iterate)?;
            // The row of the load fraction: the length is to become `aim`.
            let row = BorderRow {
                gradient: &gauge.gradient,
                border: vec![gauge.slope(trial.loading.rates.increment(), shared)],
                wanted: aim - gauge.length,
            };
            let change = solution.border_unknowns(&[row], shared);
            let change = change.ok_or(StepFailure::Path(PathFailure::NoLength))?;
            // Far from the path the linear model of the length is worth nothing; half its way is.
            let mut part = f64::min(1.0, step.reach / change[0].abs());
            let (from, at_before, mut halvings) = (iterate.increment.clone(), at, 0);
            (trial, gauge) = loop {
                at = at_before + part * change[0];
                for (v, increment) in iterate.increment.nodes.iter_mut().enumerate() {
                    *increment = from.nodes[v] + solution.displacement(v, &change) * part;
                }
                for (k, increment) in iterate.increment.own.iter_mut().enumerate() {
                    *increment = from.own[k] + solution.own(k, &change) * part;
                }
                let tried = self.evaluate(&mut iterate, at);
                match tried.and_then(|trial| Ok((trial, self.gauge(step.measure, &iterate.increment)?))) {
                    Err(failure) if failure.is_of_trial() && halvings < HALVINGS => {}
                    // Where nothing yields any more there is no way back.
                    Ok((_, gauge)) if gauge.length == 0.0 && halvings < HALVINGS => {}
                    result => break result?,
                }
                (part, halvings) = (0.5 * part, halvings + 1);
            };
            iterate.effort.shortened += u32::from(part < 1.0);
            let now = self.problem.under(&trial.loading);
            let residual = now.residual(&iterate);
            iterate.effort.residuals.push(residual);
            iterate.effort.residual = residual;
            let is_as_long = (gauge.length - aim).abs() <= LENGTH_TOLERANCE * aim;
            if is_as_long && now.is_balanced(&iterate, now.tolerance.residual) {
                return Ok((iterate, at, gauge.length));
            }
        }
        Err(StepFailure::NotConverged { residuals: iterate.effort.residuals })
    }

    /// Forces and tangent at load fraction `at`, with the displacements that are prescribed there.
    fn evaluate(&mut self, iterate: &mut Iterate<D>, at: f64) -> Result<Trial<D>, StepFailure> {
        let loading = self.loading.linearised(at)?;
        impose(&loading.rates, &loading.prescribed, &mut iterate.increment.nodes);
        let problem = self.problem.under(&loading);
        let mut rate = UnknownVector::zeros(problem.unknowns());
        self.solver.evaluate(&problem, iterate, Wanted::ForceAndTangent, Some(&mut rate))?;
        for (rate, external) in rate.nodes.iter_mut().zip(&loading.external_rate) {
            *rate = external - *rate;
        }
        rate.own.iter_mut().for_each(|rate| *rate = -*rate);
        if problem.contributions.iter().any(|it| it.moves_with_load()) {
            rate.subtract(&problem.force_rate(iterate, HALF_DIFFERENCE)?);
        }
        loading.rates.free_part(&mut rate.nodes);
        Ok(Trial { loading, rate })
    }

    /// `K⁻¹` on the out-of-balance force, and on the rate of the loading: the column of the load fraction.
    fn directions(
        &mut self,
        trial: &Trial<D>,
        iterate: &mut Iterate<D>,
    ) -> Result<BorderedSolution<D>, StepFailure> {
        let problem = self.problem.under(&trial.loading);
        self.solver.solve_bordered(&problem, &iterate.out_of_balance, &[&trial.rate], &mut iterate.effort)
    }

    fn gauge(&mut self, measure: Length, increment: &UnknownVector<D>) -> Result<Gauge<D>, StepFailure> {
        let Self { problem, weights, origin, solver, .. } = self;
        solver.timings.time(Phase::Stress, || gauge(problem, weights, measure, increment, origin))
    }

    fn weighted(&self, a: &[Vector<D>], b: &[Vector<D>]) -> f64 {
        let shared = &self.problem.connected.shared;
        let nodes = shared.counted(self.weights.iter().zip(a.iter().zip(b)));
        total(&*shared.ranks, nodes.map(|(_, (weight, (a, b)))| weight * a.dot(b)).sum())
    }

    /// Sets the iterate to the first guess of displacement; returns that of the load fraction.
    fn guess(&mut self, step: &mut PathStep<D>, iterate: &mut Iterate<D>) -> Result<f64, StepFailure> {
        let mut at = step.start;
        let mut tangent = None;
        if step.measure == Length::Displacement {
            let trial = self.evaluate(iterate, at)?;
            let mut solution = self.directions(&trial, iterate)?;
            let (first, second) = (&mut solution.of_force, &solution.of_columns[0]);
            // Across the path: along it the tangent is singular at a limit point.
            let shift = step.predictor.as_ref().map_or(0.0, |last| {
                let onwards = last.carried(self.problem.connected);
                -self.weighted(&onwards, &first.nodes) / self.weighted(&onwards, &second.nodes)
            });
            first.add(shift, second);
            at += shift;
            self.origin.clone_from(&first.nodes);
            tangent = Some((trial, solution));
        }
        if let Some(end) = self.guess_from_last_step(step, iterate, at)? {
            return Ok(end);
        }
        let (trial, solution) = match tangent {
            Some(tangent) => tangent,
            None => {
                let trial = self.evaluate(iterate, at)?;
                let solution = self.directions(&trial, iterate)?;
                (trial, solution)
            }
        };
        let change = match step.measure {
            Length::Displacement => self.displacing(step, &solution.of_columns[0])?,
            Length::Dissipation => {
                let rates = &trial.loading.rates;
                let connected = self.problem.connected;
                self.dissipating(step, |change| {
                    let mut increment = solution.changed(connected.at_rest(), change);
                    let prescribed: Vec<Vector<D>> =
                        rates.increment().iter().map(|rate| rate * change).collect();
                    impose(rates, &prescribed, &mut increment.nodes);
                    increment
                })?
            }
        };
        iterate.increment = solution.changed(self.problem.connected.at_rest(), change);
        Ok(at + change)
    }

    /// Sets the iterate to the last step in proportion to the lengths, from load fraction `at` on, and returns the load
    /// fraction at its end; none where there is no last step, or where it makes no length.
    fn guess_from_last_step(
        &mut self,
        step: &PathStep<D>,
        iterate: &mut Iterate<D>,
        at: f64,
    ) -> Result<Option<f64>, StepFailure> {
        let (Some(last), Some(aim), FirstGuess::LastStep) = (&step.predictor, step.aim, step.guess) else {
            return Ok(None);
        };
        let scale = aim / last.length;
        iterate.increment = self.problem.connected.onwards(scale);
        iterate.increment.nodes = last.carried(self.problem.connected);
        for (v, increment) in iterate.increment.nodes.iter_mut().enumerate() {
            *increment *= scale;
            *increment += self.origin.get(v).copied().unwrap_or_else(Vector::zeros);
        }
        let end = at + scale * last.fraction;
        let loading = self.loading.linearised(end)?;
        impose(&loading.rates, &loading.prescribed, &mut iterate.increment.nodes);
        if matches!(self.gauge(step.measure, &iterate.increment), Ok(gauge) if gauge.length > 0.0) {
            return Ok(Some(end));
        }
        iterate.increment = self.problem.connected.at_rest();
        Ok(None)
    }

    /// The change of load fraction along the tangent `per_fraction` that is as long as the step should be.
    fn displacing(&self, step: &mut PathStep<D>, per_fraction: &UnknownVector<D>) -> Result<f64, StepFailure> {
        let unit = gauge(self.problem, &self.weights, Length::Displacement, per_fraction, &[])?;
        let aim = *step.aim.get_or_insert(unit.length * step.seed);
        // Onwards is where the last step went.
        let connected = self.problem.connected;
        let along = |last: &Arc<Predictor<D>>| unit.slope(&last.carried(connected), &connected.shared);
        let onwards = step.predictor.as_ref().map_or(1.0, along);
        Ok((aim / unit.length).copysign(onwards))
    }

    /// The step of load fraction along the tangent that dissipates what it should. The tangent is that of
    /// points that are about to yield, taken as elastic or as plastic as rounding has it: elastic, only
    /// forwards does anything dissipate; plastic and past a limit point, backwards.
    fn dissipating(
        &mut self,
        step: &mut PathStep<D>,
        along: impl Fn(f64) -> UnknownVector<D>,
    ) -> Result<f64, StepFailure> {
        let mut energy = |change: f64| match self.gauge(Length::Dissipation, &along(change)) {
            // A step that inverts a point is too long as well.
            Err(failure) if failure.is_of_trial() => Ok(f64::INFINITY),
            gauge => gauge.map(|gauge| gauge.length),
        };
        let longest = step.reach.max(8.0 * step.seed);
        let (mut low, mut high, mut size) = (0.0, f64::INFINITY, step.seed);
        let mut least: Option<(f64, f64)> = None;
        for _ in 0..SEARCHES {
            let (forwards, backwards) = (energy(size)?, energy(-size)?);
            let (change, energy) = if forwards >= backwards { (size, forwards) } else { (-size, backwards) };
            if energy.is_finite() && energy > 0.0 {
                let aim = *step.aim.get_or_insert(0.5 * energy);
                if (0.5 * aim..=2.0 * aim).contains(&energy) {
                    return Ok(change);
                }
                if least.is_none_or(|(_, least)| energy < least) {
                    least = Some((change, energy));
                }
            }
            if energy > step.aim.unwrap_or(f64::MAX) {
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
        let (change, energy) = least.ok_or(StepFailure::Path(PathFailure::NoLength))?;
        step.aim = Some(energy);
        Ok(change)
    }
}

/// Share of the stiffness that each node carries; they sum to 1.
fn weights<const D: usize>(problem: &Problem<'_, D>) -> Vec<f64> {
    let mut weights = vec![0.0; problem.n_nodes()];
    for (named, assembly_plan) in problem.bodies.iter().zip(&problem.connected.assembly_plans) {
        named.body.stiffness_force(assembly_plan.connectivity(), &mut weights);
    }
    let shared = &problem.connected.shared;
    shared.ranks.complete_numbers(&mut weights);
    let sum = total(&*shared.ranks, shared.counted(weights.iter()).map(|it| it.1).sum());
    weights.iter_mut().for_each(|weight| *weight /= sum);
    weights
}

fn gauge<const D: usize>(
    problem: &Problem<'_, D>,
    weights: &[f64],
    measure: Length,
    increment: &UnknownVector<D>,
    origin: &[Vector<D>],
) -> Result<Gauge<D>, StepFailure> {
    let UnknownVector { nodes: increment, own } = increment;
    let (mut gradient, shared) = (vec![Vector::zeros(); increment.len()], &problem.connected.shared);
    let mut length = 0.0;
    match measure {
        Length::Displacement => {
            gradient.copy_from_slice(increment);
            for (u, origin) in gradient.iter_mut().zip(origin) {
                *u -= origin;
            }
            problem.constraints.free_part(&mut gradient);
            for (_, (u, weight)) in shared.counted(gradient.iter().zip(weights)) {
                length += weight * u.norm_squared();
            }
            length = total(&*shared.ranks, length).sqrt();
            gradient.iter_mut().zip(weights).for_each(|(u, weight)| *u *= *weight);
            if length > 0.0 {
                gradient.iter_mut().for_each(|g| *g /= length);
            }
        }
        Length::Dissipation => {
            let bodies = problem.bodies.iter().enumerate().zip(&problem.connected.assembly_plans);
            for (body, assembly_plan) in bodies {
                let energy = body.1.body.dissipation(assembly_plan, (increment, own), &mut gradient);
                length += agreed(&*shared.ranks, energy.map_err(|it| inadmissible(body, it, &*shared.ranks)))?;
            }
            length = total(&*shared.ranks, length);
            shared.ranks.complete(&mut gradient);
        }
    }
    Ok(Gauge { length, gradient })
}

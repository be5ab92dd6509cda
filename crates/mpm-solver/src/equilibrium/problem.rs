//! The equations of a load step: out-of-balance force and tangent of a trial displacement.

use super::round_off::{BodyScale, RoundOff};
use crate::connection::Connected;
use crate::failure::StepFailure;
use crate::model::{NamedBody, NamedContribution, Tolerance};
use crate::ranks::{Ranks, agreed, least, norm};
use crate::timing::{Phase, Timings};
use mpm_assembly::{
    Constraints, Contribution, Inadmissible, InadmissiblePoint, InadmissibleState, SystemSums, SystemTangent,
    Trial, UnknownVector, Unknowns, finish_tangent,
};
use mpm_basis::parallel;
use mpm_grid::{LoadFraction, Mesh, NodeId, Vector};
use mpm_linear::Method;

/// Everything that stays fixed while one load step is balanced.
#[derive(Clone, Copy)]
pub(crate) struct Problem<'a, const D: usize> {
    pub bodies: &'a [NamedBody<D>],
    /// What adds to force and tangent: the bodies, then the contributions of the model.
    pub contributions: &'a [&'a dyn Contribution<D>],
    /// The contributions of the model, for their names.
    pub named: &'a [NamedContribution<D>],
    /// The mesh at the start of the step.
    pub mesh: &'a Mesh<D>,
    pub connected: &'a Connected<D>,
    pub constraints: &'a Constraints<D>,
    /// Load fraction at the end of the step.
    pub end: LoadFraction,
    /// `f_ext` of every active node `[F]`.
    pub external: &'a [Vector<D>],
    /// What rounding can cause.
    pub round_off: &'a RoundOff,
    pub tolerance: Tolerance,
}

/// Trial values of the unknowns, their forces, and what has been spent on them.
#[derive(Clone)]
pub(crate) struct Iterate<const D: usize> {
    /// `Δu_v` of every active node `[L]`, and the other unknowns.
    pub increment: UnknownVector<D>,
    /// `f_int - f_ext` `[F]`.
    pub reaction: UnknownVector<D>,
    /// `f_ext - f_int`, zero on prescribed components `[F]`.
    pub out_of_balance: UnknownVector<D>,
    /// Whether the forces have not been evaluated since the iteration began at rest.
    pub is_first: bool,
    /// `|f_int|` of every body, where there are several `[F]`.
    pub body_forces: Vec<f64>,
    /// The scales of the contributions that have told them with their forces `[F]`.
    pub scales: Vec<Option<f64>>,
    /// Smallest `det ΔF` of any point.
    pub smallest_determinant: f64,
    pub effort: Effort,
}

/// Nodal displacement (with the other unknowns) that balances the forces of a load step.
pub(crate) struct Equilibrium<const D: usize> {
    /// `Δu_v` of every active node `[L]`, and the other unknowns.
    pub increment: UnknownVector<D>,
    /// `f_int - f_ext`: on prescribed components the reaction `[F]`.
    pub reaction: UnknownVector<D>,
    /// Smallest `det ΔF` of any point.
    pub smallest_determinant: f64,
    pub effort: Effort,
}

/// What it takes to balance a load step, and how well its linear systems are solved.
#[derive(Clone)]
pub(crate) struct Effort {
    /// Relative out-of-balance force after each linear solution.
    pub residuals: Vec<f64>,
    /// That of the last iterate, also where nothing was solved.
    pub residual: f64,
    /// The method of the last linear solution.
    pub method: Method,
    /// Whether a tangent was seen not to be positive definite.
    pub is_unstable: bool,
    /// Iterations of conjugate gradients or GMRES.
    pub linear_iterations: u64,
    /// Corrections of which only a part was taken.
    pub shortened: u32,
    /// Number of linear solves spent on a predictor that was discarded; not counted in `residuals`.
    pub dropped: u64,
    /// Parts in which relaxation balanced the step; 0 where it was balanced at once.
    pub relaxations: u32,
    /// Node at which LLᵀ last met a pivot that was not positive.
    pub unstable_node: Option<NodeId>,
    /// Largest backward error of a linear solution, of those whose backward error is known.
    pub backward_error: Option<f64>,
    /// Steps of iterative refinement of linear solutions, in all.
    pub refinements: u32,
    /// Largest ratio of the pivots of a factorisation; the condition number is as large or larger. None without pivots.
    pub pivot_spread: Option<f64>,
}

/// The larger of two numbers, of which each may be unknown.
pub(crate) fn larger(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    a.into_iter().chain(b).reduce(f64::max)
}

impl Effort {
    /// Counts what was spent on the step before.
    pub(crate) fn add_earlier(&mut self, earlier: Self) {
        let later = std::mem::replace(&mut self.residuals, earlier.residuals);
        self.residuals.extend(later);
        self.is_unstable |= earlier.is_unstable;
        self.linear_iterations += earlier.linear_iterations;
        self.shortened += earlier.shortened;
        self.dropped += earlier.dropped;
        self.relaxations += earlier.relaxations;
        self.unstable_node = self.unstable_node.or(earlier.unstable_node);
        self.backward_error = larger(self.backward_error, earlier.backward_error);
        self.refinements += earlier.refinements;
        self.pivot_spread = larger(self.pivot_spread, earlier.pivot_spread);
    }
}

impl<const D: usize> Iterate<D> {
    /// [Nothing has moved](Connected::at_rest), and linear systems will be solved by `method` until it fails.
    pub(crate) fn at_rest(connected: &Connected<D>, method: Method) -> Self {
        let effort = Effort {
            residuals: Vec::new(),
            residual: 0.0,
            method,
            is_unstable: false,
            linear_iterations: 0,
            shortened: 0,
            dropped: 0,
            relaxations: 0,
            unstable_node: None,
            backward_error: None,
            refinements: 0,
            pivot_spread: None,
        };
        let unknowns = connected.unknowns();
        Self {
            increment: connected.at_rest(),
            reaction: UnknownVector::zeros(unknowns),
            out_of_balance: UnknownVector::zeros(unknowns),
            is_first: true,
            body_forces: Vec::new(),
            scales: Vec::new(),
            smallest_determinant: f64::INFINITY,
            effort,
        }
    }

    /// The iterate as the step's equilibrium, once it is balanced.
    pub(crate) fn into_equilibrium(self) -> Equilibrium<D> {
        let Self { increment, reaction, smallest_determinant, effort, .. } = self;
        Equilibrium { increment, reaction, smallest_determinant, effort }
    }
}

/// Whether a pass over the points also sums the tangent.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Wanted {
    Force,
    ForceAndTangent,
}

/// What a pass with a tangent writes to besides the iterate; untouched by a pass without.
pub(crate) struct TangentTarget<'a, const D: usize> {
    /// Entries of the tangent K.
    pub values: &'a mut [f64],
    /// The product of K and the prescribed increments `[F]`, where it is wanted.
    pub lift: Option<&'a mut UnknownVector<D>>,
}

impl<const D: usize> Problem<'_, D> {
    /// Nodes that carry material.
    pub(crate) fn n_nodes(&self) -> usize {
        self.connected.active.len()
    }

    /// Unknowns of the step.
    pub(crate) fn unknowns(&self) -> &Unknowns<D> {
        self.connected.unknowns()
    }

    /// The increment of an iterate as contributions see it.
    pub(crate) fn trial<'a>(&'a self, increment: &'a UnknownVector<D>, is_first: bool) -> Trial<'a, D> {
        let (pattern, constraints) = (&self.connected.pattern, self.constraints);
        Trial { pattern, constraints, increment, end: self.end, is_first }
    }

    /// Sets the forces of the iterate (and the tangent) under its increment.
    ///
    /// # Errors
    /// The increment is not admissible, for example because it inverts a point; the forces are then undefined.
    pub(crate) fn evaluate(
        &self,
        iterate: &mut Iterate<D>,
        wanted: Wanted,
        target: TangentTarget<'_, D>,
        timings: &mut Timings,
    ) -> Result<(), StepFailure> {
        let TangentTarget { values, lift } = target;
        let phase = match wanted {
            Wanted::Force => Phase::Stress,
            Wanted::ForceAndTangent => Phase::Assemble,
        };
        for named in self.bodies {
            timings.skipped.count_pass(&*named.body);
        }
        let (pattern, shared) = (&self.connected.pattern, &self.connected.shared);
        timings.time(phase, || {
            iterate.reaction.clear();
            if wanted == Wanted::ForceAndTangent {
                parallel::set(values, 0.0);
            }
            let is_first = std::mem::take(&mut iterate.is_first);
            let mut lift = lift;
            let lifted = lift.as_deref_mut();
            let tangent = (wanted == Wanted::ForceAndTangent)
                .then_some(SystemTangent { values: &mut *values, lift: lifted });
            let mut sums = SystemSums::new(&mut iterate.reaction, tangent);
            iterate.scales.clear();
            let trial = self.trial(&iterate.increment, is_first);
            for (index, contribution) in self.contributions.iter().enumerate() {
                // A body's own force is the difference that it makes.
                let own = self.round_off.bodies.get(index);
                for &v in own.iter().flat_map(|body| &body.nodes) {
                    iterate.out_of_balance.nodes[v as usize] = sums.force.nodes[v as usize];
                }
                agreed(&*shared.ranks, self.added(index, contribution.add(&trial, &mut sums)))?;
                // Forces of a first trial are a prediction.
                let scale = sums.scale.take().filter(|_| !is_first);
                iterate.scales.push(scale.map(|scale| shared.scale(scale)));
                if let Some(body) = own {
                    let force = &mut iterate.out_of_balance.nodes;
                    for &v in &body.nodes {
                        force[v as usize] = sums.force.nodes[v as usize] - force[v as usize];
                    }
                    shared.ranks.complete(force);
                    iterate.body_forces.resize(self.round_off.bodies.len(), 0.0);
                    iterate.body_forces[index] = norm(&*shared.ranks, self.counted(body).map(|v| force[v]));
                }
            }
            iterate.smallest_determinant = least(&*shared.ranks, sums.smallest_determinant);
            if wanted == Wanted::ForceAndTangent {
                finish_tangent(pattern, self.constraints, values);
                shared.leave_to_owners(pattern, self.constraints, values);
            }
            self.connected.complete(&mut iterate.reaction);
            if let Some(lift) = lift {
                self.connected.complete(lift);
            }
            // Internal force becomes f_int - f_ext; its free components must vanish.
            let Iterate { reaction, out_of_balance, .. } = iterate;
            for (v, (reaction, external)) in reaction.nodes.iter_mut().zip(self.external).enumerate() {
                *reaction -= external;
                out_of_balance.nodes[v] = -*reaction;
            }
            for (out_of_balance, residual) in out_of_balance.own.iter_mut().zip(&reaction.own) {
                *out_of_balance = -residual;
            }
            self.constraints.free_part(&mut out_of_balance.nodes);
            Ok(())
        })
    }

    /// `∂f_int/∂t` of contributions that move with the load fraction t, by central differences over `half` on either
    /// side `[F]`; zero without any.
    ///
    /// # Errors
    /// As [`Self::evaluate`].
    pub(crate) fn force_rate(&self, iterate: &Iterate<D>, half: f64) -> Result<UnknownVector<D>, StepFailure> {
        let (mut rate, ranks) = (UnknownVector::zeros(self.unknowns()), &self.connected.shared.ranks);
        let (before, after) =
            (self.end.with_value(self.end.get() - half), self.end.with_value(self.end.get() + half));
        for (index, contribution) in self.contributions.iter().enumerate().filter(|it| it.1.moves_with_load()) {
            for (end, sign) in [(after, 1.0), (before, -1.0)] {
                let mut force = UnknownVector::zeros(self.unknowns());
                let trial = Trial { end, ..self.trial(&iterate.increment, false) };
                let mut sums = SystemSums::new(&mut force, None);
                agreed(&**ranks, self.added(index, contribution.add(&trial, &mut sums)))?;
                rate.add(sign / (after.get() - before.get()), &force);
            }
        }
        self.connected.complete(&mut rate);
        Ok(rate)
    }

    /// What the contribution with this index has answered, as a failure of the step.
    fn added(&self, index: usize, answer: Result<(), Inadmissible>) -> Result<(), StepFailure> {
        answer.map_err(|it| refuse((self.bodies, self.named), index, it, &*self.connected.shared.ranks))
    }

    /// Those of the nodes of a body that this rank counts.
    pub(super) fn counted<'b>(&'b self, body: &'b BodyScale) -> impl Iterator<Item = usize> + Clone + 'b {
        let shared = &self.connected.shared;
        body.nodes.iter().map(|&v| v as usize).filter(|&v| shared.counts(v))
    }
}

/// The failure of a trial that is not admissible for the contribution with this index: the bodies come first.
pub(crate) fn refuse<const D: usize>(
    (bodies, named): (&[NamedBody<D>], &[NamedContribution<D>]),
    index: usize,
    it: Inadmissible,
    ranks: &dyn Ranks<D>,
) -> StepFailure {
    match it {
        Inadmissible::Point(it) => inadmissible((index, &bodies[index]), it, ranks),
        Inadmissible::Contribution(reason) => {
            StepFailure::Inadmissible { contribution: named[index - bodies.len()].name.clone(), reason }
        }
    }
}

/// The failure of a trial under which a point has no admissible state.
pub(crate) fn inadmissible<const D: usize>(
    (index, named): (usize, &NamedBody<D>),
    it: InadmissiblePoint,
    ranks: &dyn Ranks<D>,
) -> StepFailure {
    let (body, basis) = (named.name.clone(), named.body.basis());
    let position = named.body.point(it.point).position.iter().copied().collect();
    let point = ranks.number_of_point(index, it.point);
    match it.reason {
        InadmissibleState::Inverted { determinant } => {
            StepFailure::Inverted { body, basis, point, position, determinant }
        }
        InadmissibleState::ReachesAxis { hoop } => {
            StepFailure::ReachesAxis { body, basis, point, position, hoop }
        }
        InadmissibleState::NoReturn(reason) => StepFailure::NoReturn { body, point, position, reason },
    }
}

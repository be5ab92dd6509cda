//! Energies of a run: what is stored, what is dissipated, what was done from outside, and whether they agree.

use crate::equilibrium::problem::{Equilibrium, Problem, inadmissible, refuse};
use crate::failure::StepFailure;
use crate::loading::StepLoading;
use crate::model::NamedBody;
use crate::ranks::agreed;
use mpm_assembly::{Constraints, Contribution, SystemSums, Trial, of_points};
use mpm_grid::{LoadFraction, Vector};

/// What a load step dissipates and what is done on it from outside `[F L]` (in the plane: per unit thickness).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct StepEnergy {
    /// `Σ_p V⁰_p τ_p : (ε_p,tr - ε_p,e)`, see [`mpm_assembly::dissipation`].
    pub dissipated: f64,
    /// `½ Σ_v (f_v,start + f_v,end) · Δu_v`, with f the external force, on prescribed components with the reaction.
    pub work: f64,
    /// Stored in contributions at the end of the step.
    pub stored: f64,
}

impl StepEnergy {
    /// Of a load step from one load fraction to another, in equilibrium, whose points are not committed yet.
    ///
    /// The work is that of forces that change linearly through the step: exact to second order in it. Forces that
    /// the change of the mesh has let go of between two steps do no work.
    pub(crate) fn of_step<const D: usize>(
        problem: &Problem<'_, D>,
        loading: &StepLoading<'_, D>,
        [start, end]: [LoadFraction; 2],
        equilibrium: &Equilibrium<D>,
    ) -> Result<Self, StepFailure> {
        let (before, after) = (loading.external_force(start), loading.external_force(end));
        let problem = &Problem { external: &after, end, ..*problem };
        let (increment, shared) = (&equilibrium.increment.nodes, &problem.connected.shared);
        let ranks = &*shared.ranks;
        let rest = problem.connected.at_rest();
        let free = Constraints::none(increment.len());
        let (mut internal, mut unused) = (rest.clone(), vec![Vector::zeros(); increment.len()]);
        internal.clear();
        let mut dissipated = 0.0;
        let mut sums = SystemSums::new(&mut internal, None);
        let at_rest = Trial { constraints: &free, ..problem.trial(&rest, false) };
        let bodies = problem.connected.bodies(problem.bodies);
        for (index, (named, connected)) in problem.bodies.iter().zip(&bodies).enumerate() {
            let added = connected.add(&at_rest, &mut sums);
            let all = (problem.bodies, problem.named);
            agreed(ranks, added.map_err(|it| refuse(all, index, it, ranks)))?;
            let trial = (&increment[..], &equilibrium.increment.own[..]);
            let energy = named.body.dissipation(connected.plan, trial, &mut unused);
            dissipated += agreed(ranks, energy.map_err(|it| inadmissible((index, named), it, ranks)))?;
        }
        let mut internal = internal.nodes;
        ranks.complete(&mut internal);
        let mut work = 0.0;
        for (v, u) in shared.counted(increment.iter()) {
            for i in 0..D {
                // On prescribed components what holds the body is internal force and external force in one.
                let prescribed = problem.constraints.is_prescribed(v, i);
                let start = if prescribed { internal[v][i] } else { before[v][i] };
                let end =
                    problem.external[v][i] + if prescribed { equilibrium.reaction.nodes[v][i] } else { 0.0 };
                work += 0.5 * (start + end) * u[i];
            }
        }
        let (trial, mut stored) = (problem.trial(&equilibrium.increment, false), 0.0);
        for named in problem.named {
            let energy = named.contribution.energy(&trial);
            stored += energy.stored;
            dissipated += energy.dissipated;
            work += energy.work;
        }
        let mut all = [dissipated, work, stored];
        ranks.sum(&mut all);
        let [dissipated, work, stored] = all;
        Ok(Self { dissipated, work, stored })
    }
}

/// Energy stored in the points, `Σ_p V⁰_p ψ_p` with ψ the law's elastic energy `[F L]` (in the plane: per unit
/// thickness).
pub(crate) fn elastic<const D: usize>(bodies: &[NamedBody<D>]) -> f64 {
    let mut energy = 0.0;
    for named in bodies {
        let body = &*named.body;
        for of_point in of_points(body, |p| body.point(p).reference_volume * body.stored_energy(p)) {
            energy += of_point;
        }
    }
    energy
}

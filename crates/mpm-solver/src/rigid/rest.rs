//! Rigid motions that nothing holds are refused, or kept at zero.
//!
//! A motion is kept at zero by *pins*: as many components of nodes as there are motions, held in such places that they
//! hold these motions and nothing else. If no load has a part in the motions the pins carry no force, so that any
//! translation may be added afterwards: the one that leaves the material's mean place where it is.

use super::{FreeMotions, Unheld};
use crate::connection::Connected;
use crate::equilibrium::problem::{Equilibrium, Problem};
use crate::equilibrium::system::solve_dense;
use crate::failure::StepFailure;
use crate::model::{Model, UnheldMotion};
use crate::ranks::{any, largest, least, total};
use mpm_assembly::{Constraints, SystemSums};
use mpm_grid::Vector;

/// Part of the loads' work that may remain in a motion although the loads cancel.
const NO_WORK: f64 = 1e-9;

/// Part of the largest entry of a field from which on entries count as large as it: rounding does not decide between them.
const ALIKE: f64 = 1.0 - 1e-9;

/// Part of the largest force on a node that a pin may carry: what unbalanced forces leave.
const NO_FORCE: f64 = 1e-6;

/// Motions that are kept at zero in a load step; mostly none.
#[derive(Default)]
pub(crate) struct AtRest<const D: usize> {
    unheld: Unheld<D>,
    pins: Vec<(usize, usize)>,
}

/// The rigid motions that nothing holds in this load step, where the model allows them.
///
/// Motions that are refused are looked for only where the connectivity is new: what held a part before still does.
///
/// # Errors
/// There are some, and they are refused, or the loads have a part in them.
pub(crate) fn unheld<const D: usize>(
    model: &Model<D>,
    problem: &Problem<'_, D>,
) -> Result<AtRest<D>, StepFailure> {
    let Problem { mesh, connected, constraints, external, .. } = *problem;
    if connected.is_analysed.get() && model.unheld_motion == UnheldMotion::Refuse {
        return Ok(AtRest::default());
    }
    let free = FreeMotions::of(model, mesh, connected, constraints);
    if free.is_empty() {
        return Ok(AtRest::default());
    }
    let Some(unheld) = free.unheld(model, connected, constraints, problem.end) else {
        return Ok(AtRest::default());
    };
    if model.unheld_motion == UnheldMotion::Refuse {
        return Err(StepFailure::Unheld { motion: unheld.clauses.join("; nor ") });
    }
    let (loads, shared) = (of_loads(problem), &connected.shared);
    let has_work = |field: &Vec<Vector<D>>| {
        let mut sums = [0.0; 2];
        for forces in [external, &loads[..]] {
            for (_, (force, u)) in shared.counted(forces.iter().zip(field)) {
                sums[0] += force.dot(u);
                sums[1] += force.abs().dot(&u.abs());
            }
        }
        shared.ranks.sum(&mut sums);
        sums[0].abs() > NO_WORK * sums[1]
    };
    if unheld.fields.iter().any(has_work) {
        return Err(loaded(&unheld));
    }
    let pins = pins(&unheld.fields, connected);
    Ok(AtRest { unheld, pins })
}

/// Forces on the nodes of loads that are contributions, where nothing has moved yet `[F]`.
fn of_loads<const D: usize>(problem: &Problem<'_, D>) -> Vec<Vector<D>> {
    let rest = problem.connected.at_rest();
    let (trial, mut force) = (problem.trial(&rest, false), rest.clone());
    force.clear();
    let mut sums = SystemSums::new(&mut force, None);
    for named in problem.named.iter().filter(|named| named.contribution.is_load()) {
        // One that is not admissible at rest is refused by the first iteration.
        let _ = named.contribution.add(&trial, &mut sums);
    }
    problem.connected.shared.ranks.complete(&mut force.nodes);
    force.nodes.iter().map(|force| -force).collect()
}

fn loaded<const D: usize>(unheld: &Unheld<D>) -> StepFailure {
    StepFailure::UnheldLoaded { motion: unheld.clauses.join("; nor ") }
}

/// As many components of nodes as there are fields, of which no combination of fields leaves all at zero: elimination
/// with the first of the largest entries as the next pivot. Those that this rank has, by their active numbers.
fn pins<const D: usize>(fields: &[Vec<Vector<D>>], connected: &Connected<D>) -> Vec<(usize, usize)> {
    let (shared, nodes) = (&connected.shared, connected.active.nodes());
    let ranks = &*shared.ranks;
    let mut left: Vec<Vec<Vector<D>>> = fields.to_vec();
    let mut pins = Vec::new();
    while let Some(field) = left.pop() {
        let largest = largest(ranks, field.iter().map(|u| u.amax()).fold(0.0, f64::max));
        let entries = shared.counted(field.iter()).flat_map(|(v, u)| (0..D).map(move |i| (v, i, u[i].abs())));
        let first = entries.clone().find(|it| it.2 >= ALIKE * largest);
        // Of all ranks: nodes and components as one number, in their order.
        let number = first.map(|(v, i, _)| (nodes[v].index() * D + i) as f64);
        let first_of_all = least(ranks, number.unwrap_or(f64::INFINITY));
        let is_pivot = |v: usize, i: usize| (nodes[v].index() * D + i) as f64 == first_of_all;
        // The entries of all fields there, from who counts the node.
        let pivot = first.filter(|it| is_pivot(it.0, it.1));
        let of_pivot = |u: &Vec<Vector<D>>| pivot.map_or(0.0, |(v, i, _)| u[v][i]);
        let mut there: Vec<f64> = left.iter().chain([&field]).map(of_pivot).collect();
        ranks.sum(&mut there);
        let own = there[left.len()];
        for (other, there) in left.iter_mut().zip(&there) {
            other.iter_mut().zip(&field).for_each(|(other, u)| *other -= u * (there / own));
        }
        pins.extend(
            (0..nodes.len()).flat_map(|v| (0..D).map(move |i| (v, i))).filter(|it| is_pivot(it.0, it.1)),
        );
    }
    pins
}

impl<const D: usize> AtRest<D> {
    /// Active nodes and components that are held.
    pub(crate) fn pins(&self) -> &[(usize, usize)] {
        &self.pins
    }

    /// The constraints with the pins.
    pub(crate) fn constraints(&self, supports: &Constraints<D>) -> Constraints<D> {
        let mut constraints = supports.clone();
        self.pins.iter().for_each(|&(node, component)| constraints.prescribe(node, component, 0.0));
        constraints
    }

    /// Takes the translations out of an equilibrium that the pins have let in.
    ///
    /// # Errors
    /// The pins carry force.
    pub(crate) fn settle(
        &self,
        model: &Model<D>,
        problem: &Problem<'_, D>,
        equilibrium: &mut Equilibrium<D>,
    ) -> Result<(), StepFailure> {
        if self.unheld.fields.is_empty() {
            return Ok(());
        }
        let shared = &problem.connected.shared;
        let ranks = &*shared.ranks;
        let reaction = &equilibrium.reaction.nodes;
        let forces = reaction.iter().chain(problem.external);
        let largest = largest(ranks, forces.map(|force| force.amax()).fold(0.0, f64::max));
        let trial = problem.trial(&equilibrium.increment, false);
        let of_contributions: f64 = problem.contributions.iter().map(|it| shared.scale(it.scale(&trial))).sum();
        let most = problem.round_off.all.max(NO_FORCE * largest.max(of_contributions));
        let carries_force = |&(node, component): &(usize, usize)| reaction[node][component].abs() > most;
        if any(ranks, self.pins.iter().any(carries_force)) {
            return Err(loaded(&self.unheld));
        }
        let fields = &self.unheld.fields[self.unheld.fields.len() - self.unheld.translations..];
        let volumes = volumes(model, problem.connected);
        let moved = |field: &Vec<Vector<D>>, other: &[Vector<D>]| {
            let nodes = shared.counted(volumes.iter().zip(field.iter().zip(other)));
            total(ranks, nodes.map(|(_, (volume, (u, other)))| volume * u.dot(other)).sum::<f64>())
        };
        let increment = &mut equilibrium.increment.nodes;
        let rows =
            fields.iter().map(|field| fields.iter().map(|other| moved(field, other)).collect()).collect();
        let means = fields.iter().map(|field| moved(field, increment)).collect();
        for (field, amount) in fields.iter().zip(solve_dense(rows, means).unwrap_or_default()) {
            increment.iter_mut().zip(field).for_each(|(u, field)| *u -= field * amount);
        }
        Ok(())
    }
}

/// Volume at rest of the material that moves with each node, `Σ_p V⁰_p S_vp` `[L^D]`.
fn volumes<const D: usize>(model: &Model<D>, connected: &Connected<D>) -> Vec<f64> {
    let mut volumes = vec![0.0; connected.active.len()];
    for (named, plan) in model.bodies.iter().zip(&connected.assembly_plans) {
        let connectivity = plan.connectivity();
        for group in (0..connectivity.n_groups()).map(|group| connectivity.group(group)) {
            for k in 0..group.points {
                let volume = named.body.point(group.first_point + k).reference_volume;
                for (&node, value) in group.nodes.iter().zip(group.point(k).0) {
                    volumes[node as usize] += volume * value;
                }
            }
        }
    }
    connected.shared.ranks.complete_numbers(&mut volumes);
    volumes
}

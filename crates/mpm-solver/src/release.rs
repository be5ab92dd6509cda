//! What supports carry that have ended: a force from outside that falls to 0 over the stage in which they end.
//!
//! At the start of each load step it is `f_int - f_ext` there, and what is left of it at load fraction t of a step from
//! t₀ on is `(1 - t)/(1 - t₀)` of that. Because it is what the points carry, a run that is resumed knows it.

use crate::connection::contributions;
use crate::equilibrium::problem::refuse;
use crate::failure::StepFailure;
use crate::loading::{Carried, StepLoading};
use crate::ranks::agreed;
use mpm_assembly::{Constraints, SystemSums, Trial};

/// What the supports carry that end in the stage of a load step, at the start of that step; nothing on components that
/// another support holds now.
///
/// # Errors
/// The points cannot be assembled.
pub(crate) fn carried<const D: usize>(
    loading: &StepLoading<'_, D>,
    constraints: &Constraints<D>,
) -> Result<Vec<Carried>, StepFailure> {
    let StepLoading { model, connected, start, .. } = *loading;
    let released = |stage| model.supports.iter().filter(move |support| support.is_released_in(stage));
    if released(start.stage()).next().is_none() {
        return Ok(Vec::new());
    }
    let (increment, ranks) = (connected.at_rest(), &*connected.shared.ranks);
    let mut force = increment.clone();
    let trial =
        Trial { pattern: &connected.pattern, constraints, increment: &increment, end: start, is_first: false };
    let mut sums = SystemSums::new(&mut force, None);
    let bodies = connected.bodies(&model.bodies);
    for (index, contribution) in contributions(&bodies, &model.contributions).into_iter().enumerate() {
        let added = contribution.add(&trial, &mut sums);
        let all = (&model.bodies[..], &model.contributions[..]);
        agreed(ranks, added.map_err(|it| refuse(all, index, it, ranks)))?;
    }
    ranks.complete(&mut force.nodes);
    // The forces that act there now, or at the end of the stage before.
    let external = loading.external_force(start.reached());
    let mut is_counted = vec![[false; D]; connected.active.len()];
    let mut carried = Vec::new();
    for support in released(start.stage()) {
        for node in support.nodes.iter().filter_map(|&node| connected.active.number(node)) {
            for component in (0..D).filter(|&i| support.components[i].is_some()) {
                let is_held = constraints.is_prescribed(node, component);
                if !is_held && !std::mem::replace(&mut is_counted[node][component], true) {
                    let force = force.nodes[node][component] - external[node][component];
                    carried.push(Carried { node, component, force });
                }
            }
        }
    }
    Ok(carried)
}

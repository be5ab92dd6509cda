//! What supports carry and how far they have moved.

use super::StepResult;
use crate::model::Support;
use crate::observe::Entry;
use crate::ranks::count;
use mpm_grid::Vector;
use std::array::from_fn;

/// Reaction of a support, its mean displacement so far (`displacement`, which grows by this step), and the moment of
/// the reaction where it is recorded; of bodies that turn about their axis with the torque and the mean angle.
pub(super) fn support_entries<const D: usize>(
    support: &Support<D>,
    result: &StepResult<D>,
    turns: bool,
    displacement: &mut [f64],
) -> Vec<Entry> {
    let StepResult { mesh, connected, balanced, .. } = result;
    let equilibrium = &balanced.equilibrium;
    let (ranks, shared) = (&*connected.shared.ranks, &connected.shared);
    let (mut reaction, mut moved, mut carrying) = (Vector::<D>::zeros(), Vector::<D>::zeros(), 0_u64);
    let mut moment = [0.0; 3];
    let acts = support.acts_in(balanced.end.stage());
    for &node in support.nodes.iter().filter(|_| acts) {
        let Some(number) = connected.active.number(node).filter(|&it| shared.counts(it)) else { continue };
        moved += equilibrium.increment.nodes[number];
        carrying += 1;
        let mut force = equilibrium.reaction.nodes[number];
        for i in (0..D).filter(|&i| support.components[i].is_none()) {
            force[i] = 0.0;
        }
        reaction += force;
        if let Some(about) = support.moment_about {
            // The arm reaches to where the node is at the end of the step.
            let end = connected.active.space().position(mesh, node) + equilibrium.increment.nodes[number];
            let arm: [f64; 3] = from_fn(|d| if d < D { end[d] - about[d] } else { 0.0 });
            let force: [f64; 3] = from_fn(|d| if d < D { force[d] } else { 0.0 });
            for (d, moment) in moment.iter_mut().enumerate() {
                let (e, f) = ((d + 1) % 3, (d + 2) % 3);
                *moment += arm[e] * force[f] - arm[f] * force[e];
            }
        }
    }
    ranks.sum(reaction.as_mut_slice());
    ranks.sum(moved.as_mut_slice());
    ranks.sum(&mut moment);
    let carrying = count(ranks, carrying).max(1) as f64;
    for (total, moved) in displacement.iter_mut().zip(moved.iter()) {
        *total += moved / carrying;
    }
    let mut entries = match turns {
        false => vec![Entry::Real(reaction.iter().copied().collect()), Entry::Real(displacement.to_vec())],
        // The last components are a torque and an angle.
        true => vec![
            Entry::Real(reaction.iter().take(D - 1).copied().collect()),
            Entry::Real(displacement[..D - 1].to_vec()),
            Entry::Real(vec![reaction[D - 1]]),
            Entry::Real(vec![displacement[D - 1].to_degrees()]),
        ],
    };
    if support.moment_about.is_some() {
        entries.push(Entry::Real(if D == 3 { moment.to_vec() } else { vec![moment[2]] }));
    }
    entries
}

/// Sum of the reactions of all supports, each component of a node once, and that of the torques of bodies that turn about
/// their axis; nothing where there are no supports.
pub(super) fn total_reaction<const D: usize>(
    supports: &[Support<D>],
    result: &StepResult<D>,
    turns: bool,
) -> Vec<Entry> {
    if supports.is_empty() {
        return Vec::new();
    }
    let StepResult { connected, balanced, .. } = result;
    let shared = &connected.shared;
    let mut counted = vec![[false; D]; connected.active.len()];
    let mut total = vec![0.0; D];
    for support in supports.iter().filter(|support| support.acts_in(balanced.end.stage())) {
        let numbers = support.nodes.iter().filter_map(|&node| connected.active.number(node));
        for number in numbers.filter(|&number| shared.counts(number)) {
            for i in (0..D).filter(|&i| support.components[i].is_some()) {
                if !std::mem::replace(&mut counted[number][i], true) {
                    total[i] += balanced.equilibrium.reaction.nodes[number][i];
                }
            }
        }
    }
    shared.ranks.sum(&mut total);
    let torque = if turns { Some(Entry::Real(total.split_off(D - 1))) } else { None };
    std::iter::once(Entry::Real(total)).chain(torque).collect()
}

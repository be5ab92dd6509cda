//! Initial stress that does not balance the loads.

use super::remarks::place;
use crate::connection::Connected;
use crate::loading::StepLoading;
use crate::model::Model;
use mpm_assembly::{Constraints, Contribution, SystemSums, Trial};
use mpm_grid::{LoadFraction, Mesh, Vector, six_digits};

/// Out-of-balance force, as a part of the forces of the initial stress, that is told; rounding leaves some 1e-12.
const TOLD: f64 = 1e-6;

/// A sentence about the forces that the first load step finds: those of the stress in which the points begin, less the loads
/// at load fraction 0. None where they balance, or where no point begins under stress.
pub(super) fn of<const D: usize>(
    model: &Model<D>,
    mesh: &Mesh<D>,
    connected: &Connected<D>,
    constraints: &Constraints<D>,
) -> Option<String> {
    let rest = connected.at_rest();
    let mut force = rest.clone();
    let mut sums = SystemSums::new(&mut force, None);
    let trial = Trial {
        pattern: &connected.pattern,
        constraints,
        increment: &rest,
        end: LoadFraction::START,
        is_first: false,
    };
    for body in connected.bodies(&model.bodies) {
        body.add(&trial, &mut sums).ok()?;
    }
    let size = norm(sums.force.nodes.iter());
    if size == 0.0 {
        return None;
    }
    for load in model.contributions.iter().filter(|named| named.contribution.is_load()) {
        load.contribution.add(&trial, &mut sums).ok()?;
    }
    let start = LoadFraction::START;
    let loading = StepLoading { model, mesh, connected, start, pins: &[], carried: &[] };
    let external = loading.external_force(LoadFraction::START);
    let mut left = Vec::with_capacity(external.len());
    for (number, (internal, external)) in force.nodes.iter().zip(&external).enumerate() {
        let free = |i: usize| !constraints.is_prescribed(number, i);
        left.push(Vector::<D>::from_fn(|i, _| if free(i) { external[i] - internal[i] } else { 0.0 }));
    }
    let part = norm(left.iter()) / size;
    if part <= TOLD || part.is_nan() {
        return None;
    }
    // Beside what is wished in place the ground is held from the first load step on only.
    let rigid = model
        .contributions
        .iter()
        .any(|named| !named.contribution.is_load() && !named.contribution.stabilises());
    let or_held = if rigid { ", or tools and walls hold what presses against them" } else { "" };
    let worst = (0..left.len()).max_by(|&a, &b| left[a].norm().total_cmp(&left[b].norm()))?;
    let at = connected.active.space().position(mesh, connected.active.nodes()[worst]);
    Some(format!(
        "the initial stress does not balance the loads at load fraction 0: {} of its forces are left, most at {}; the first \
         load step moves the bodies until they balance{or_held}",
        six_digits(part),
        place(model.space(), &at)
    ))
}

fn norm<'a, const D: usize>(forces: impl Iterator<Item = &'a Vector<D>>) -> f64 {
    forces.map(|force| force.norm_squared()).sum::<f64>().sqrt()
}

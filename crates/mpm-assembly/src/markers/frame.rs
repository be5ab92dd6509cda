//! Walls that a load moves: a frame that holds all of a side, driven in some components of its motion and free in the others.
//!
//! The unknowns r are those of [loaded tools](crate::contact::ToolLoad). With the markers' forces `F = L q` on the frame, its
//! velocity `v_i` at their feet, and `W = Σ_b L (λ·g + ½ β g²) − load·r` under all unknowns:
//!
//! ```text
//! r_i = −Σ_b F·v_i − load_i      K_ui = −Σ_b N_v L β v_i      K_ij = Σ_b (L β v_i·v_j − F·∂v_i/∂r_j)
//! ```

use super::held::Held;
use super::wall::WallContact;
use crate::contact::loaded::Driven;
use crate::trial::{SystemSums, Trial};
use crate::unknowns::UnknownId;
use mpm_contact::{Increment, Pose};
use mpm_grid::{LoadFraction, Vector};

impl<const D: usize> WallContact<D> {
    /// The pose at the end of a trial.
    pub(super) fn pose(&self, trial: &Trial<'_, D>) -> Pose<D> {
        self.driven(trial).map_or_else(|| self.wall.motion.pose(trial.end), |driven| driven.pose)
    }

    /// A wall with a load under a trial.
    pub(super) fn driven(&self, trial: &Trial<'_, D>) -> Option<Driven<'_, D>> {
        let load = self.wall.load.as_ref()?;
        let unknowns = self.block.map_or(&[][..], |block| block.of(&trial.increment.own));
        let increment = load.increment(unknowns, &self.prescribed_shift(trial.end));
        let (about, start) = (&self.wall.moment_about, &self.standing.pose);
        let pose = start.moved(about, &increment);
        Some(Driven { load, increment, pose, centre: pose.place(about) })
    }

    /// What is prescribed of the reference point's motion in the step `[L]`.
    fn prescribed_shift(&self, end: LoadFraction) -> Vector<D> {
        let at = |fraction| self.wall.motion.pose(fraction).place(&self.wall.moment_about);
        at(end) - at(self.from)
    }

    /// Adds what the unknowns of a wall with a load have of its markers and of its load.
    pub(super) fn add_frame(
        &self,
        (trial, driven): (&Trial<'_, D>, &Driven<'_, D>),
        held: &[Held<D>],
        sums: &mut SystemSums<'_, D>,
    ) {
        let Some(block) = self.block else { return };
        let (numbering, free) = (trial.pattern.unknowns(), &driven.load.free);
        let own: Vec<UnknownId> = (0..free.len()).map(|k| block.unknown(0, k)).collect();
        let load: Vec<f64> = driven.loads(trial.end).iter().map(|load| -load).collect();
        if self.adds_load {
            sums.add(trial, &own, &load, &driven.load_stiffness(trial.end));
        }
        for held in held {
            let carriers = &self.markers.carriers[held.marker];
            let arm = held.foot - driven.centre;
            let velocity = |&k: &usize| driven.increment.velocity(k, &arm);
            let velocities: Vec<Vector<D>> = free.iter().map(velocity).collect();
            let nodes = carriers.len() * D;
            let (n, mut dense) = (nodes + free.len(), Vec::new());
            let mut force = vec![0.0; nodes];
            force.extend(velocities.iter().map(|velocity| -held.force.dot(velocity)));
            let mut unknowns: Vec<UnknownId> = Vec::with_capacity(n);
            let of_nodes = carriers.iter().flat_map(|&(node, _)| (0..D).map(move |i| (node as usize, i)));
            unknowns.extend(of_nodes.map(|(node, i)| numbering.displacement(node, i)));
            unknowns.extend(&own);
            if sums.wants_tangent() {
                dense = vec![0.0; n * n];
                for (i, of) in velocities.iter().enumerate() {
                    let column = -held.stiffness * of;
                    for (k, &(_, value)) in carriers.iter().enumerate() {
                        for d in 0..D {
                            let entry = value * column[d];
                            dense[(nodes + i) * n + D * k + d] = entry;
                            dense[(D * k + d) * n + nodes + i] = entry;
                        }
                    }
                    for (j, by) in velocities.iter().enumerate() {
                        // In the plane a turn changes its own velocity by minus the arm; nothing else changes any.
                        let both = [free[i], free[j]].map(|k| Increment::<D>::turn_axis(k).is_some());
                        let bent = if both == [true; 2] { held.force.dot(&arm) } else { 0.0 };
                        dense[(nodes + j) * n + nodes + i] = of.dot(&(held.stiffness * by)) + bent;
                    }
                }
            }
            sums.add(trial, &unknowns, &force, &dense);
        }
    }
}

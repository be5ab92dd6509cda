//! Tools whose motion a balance of forces decides.
//!
//! The unknowns q are shifts of the tool's reference point and turns about it, counted from the start of the step. With the
//! force F on a corner, `k = -∂F/∂x`, the velocity `v_i = ∂X/∂q_i` of the tool there and its spin `ω_i`:
//!
//! ```text
//! r_i   = Σ_c F·v_i - load_i                      ∂F/∂q_i = k v_i + ω_i × F
//! K_uq  = -Σ_c W_c (k v_i + ω_i × F)              K_qq = Σ_c v_i · (k v_j + ω_j × F)
//! ```

use super::corners::{Acting, NearCorner};
use mpm_contact::{Increment, Pose, cross, force_by_motion};
use mpm_grid::{Block, LoadFraction, Ramp, Vector};
use mpm_linear::Symmetry;
use nalgebra::Vector3;

/// Part of its terms below which a sum of them is rounding.
const ROUNDING: f64 = 1e-12;

/// A sum of terms of a size, or 0 where they cancel up to rounding, as where a smooth disc turns about its centre: what
/// nothing resists must not seem to be resisted.
fn unless_rounding<const D: usize>(sum: Vector<D>, size: f64) -> Vector<D> {
    if sum.norm() > ROUNDING * size { sum } else { Vector::zeros() }
}

/// The load on a tool, and the components of its motion that follow from it.
#[derive(Clone, Debug)]
pub struct ToolLoad<const D: usize> {
    /// Components that are unknown, as [`Increment`] counts them: shifts, then turns. Others move as prescribed.
    pub free: Vec<usize>,
    /// Force at full load `[F]`.
    pub force: Vector<D>,
    /// Moment about the reference point at full load `[F L]`; in the plane its third component counts.
    pub moment: Vector3<f64>,
    /// Part of both against the load fraction.
    pub ramp: Ramp,
    /// Whether the force turns with the tool.
    pub follows: bool,
}

impl<const D: usize> ToolLoad<D> {
    /// The increment with these unknowns, and `driven` in the other components.
    pub(crate) fn increment(&self, unknowns: &[f64], driven: &Vector<D>) -> Increment<D> {
        let mut increment = Increment { shift: *driven, turn: Vector3::zeros() };
        for (&component, &value) in self.free.iter().zip(unknowns) {
            match Increment::<D>::turn_axis(component) {
                None => increment.shift[component] = value,
                Some(axis) => increment.turn[axis] = value,
            }
        }
        increment
    }

    /// What the `k`-th of its unknowns is; `axes` are the names of the directions.
    pub(crate) fn describe(&self, k: usize, axes: [&'static str; 3]) -> String {
        match Increment::<D>::turn_axis(self.free[k]) {
            None => format!("the shift along {}", axes[self.free[k]]),
            Some(axis) => format!("the turn about {}", axes[axis]),
        }
    }

    /// Of its derivative: a force that turns with the tool is no derivative of an energy.
    pub(crate) fn symmetry(&self) -> Symmetry {
        let turns = |&component: &usize| Increment::<D>::turn_axis(component).is_some();
        let (some, all) = (self.free.iter().any(turns), self.free.iter().all(turns));
        if self.follows && some && !all { Symmetry::Unsymmetric } else { Symmetry::Symmetric }
    }
}

/// The pose of a tool, and how far it has turned `[rad]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Standing<const D: usize> {
    pub pose: Pose<D>,
    pub angle: f64,
}

impl<const D: usize> Standing<D> {
    /// Numbers in a file.
    pub const NUMBERS: usize = D * D + D + 1;

    pub fn save(&self, to: &mut Vec<f64>) {
        to.extend(self.pose.rotation().iter().chain(self.pose.shift().iter()));
        to.push(self.angle);
    }

    /// What was saved.
    ///
    /// # Errors
    /// A number that is not finite.
    pub fn restore(from: &[f64]) -> Result<Self, String> {
        if let Some(number) = from.iter().find(|number| !number.is_finite()) {
            return Err(format!("stands at the number {number}, expected finite ones"));
        }
        let rotation = Block::from_column_slice(&from[..D * D]);
        let shift = Vector::from_column_slice(&from[D * D..D * D + D]);
        Ok(Self { pose: Pose::new(rotation, shift), angle: from[D * D + D] })
    }
}

/// Unknowns of the displacement of a corner's nodes and of the tool's motion: the force on each, and the dense stiffness
/// column by column.
pub(super) struct Dense {
    pub force: Vec<f64>,
    pub stiffness: Vec<f64>,
}

/// A loaded tool under a trial.
pub(crate) struct Driven<'a, const D: usize> {
    pub load: &'a ToolLoad<D>,
    pub increment: Increment<D>,
    pub pose: Pose<D>,
    /// Where the reference point stands `[L]`.
    pub centre: Vector<D>,
}

impl<const D: usize> Driven<'_, D> {
    /// The force at a load fraction `[F]`.
    fn force(&self, end: LoadFraction) -> Vector<D> {
        let force = self.load.force * self.load.ramp.value(end);
        if self.load.follows { self.pose.rotation() * force } else { force }
    }

    /// What the load does in each unknown at a load fraction `[F]` or `[F L]`.
    pub fn loads(&self, end: LoadFraction) -> Vec<f64> {
        let (force, part) = (self.force(end), self.load.ramp.value(end));
        let in_component = |&component: &usize| match Increment::<D>::turn_axis(component) {
            None => force[component],
            Some(_) => part * self.load.moment.dot(&self.increment.spin(component)),
        };
        self.load.free.iter().map(in_component).collect()
    }

    /// Minus the derivative of what a force that follows does in each unknown, by each unknown, column by column.
    pub fn load_stiffness(&self, end: LoadFraction) -> Vec<f64> {
        let (n, free) = (self.load.free.len(), &self.load.free);
        let mut dense = vec![0.0; n * n];
        if self.load.follows {
            let force = self.force(end);
            for (column, &by) in free.iter().enumerate() {
                let rate = cross(&self.increment.spin(by), &force);
                let shifts = free.iter().enumerate().filter(|it| Increment::<D>::turn_axis(*it.1).is_none());
                shifts.for_each(|(row, &of)| dense[n * column + row] = -rate[of]);
            }
        }
        dense
    }

    /// Velocity of the tool at `x`, and its spin, in each unknown.
    fn motions(&self, x: &Vector<D>) -> Vec<(Vector<D>, Vector3<f64>)> {
        let arm = x - self.centre;
        let of = |&k: &usize| (self.increment.velocity(k, &arm), self.increment.spin(k));
        self.load.free.iter().map(of).collect()
    }

    /// What a force on a body at `x` does in each unknown.
    pub fn work(&self, x: &Vector<D>, force: &Vector<D>) -> Vec<f64> {
        self.motions(x).iter().map(|(velocity, _)| force.dot(velocity)).collect()
    }

    /// Force and stiffness of a corner, the unknowns of the tool behind those of the nodes.
    pub(super) fn dense(
        &self,
        corner: &NearCorner<D>,
        Acting { position, force, stiffness }: &Acting<D>,
    ) -> Dense {
        let motions = self.motions(position);
        let weights: Vec<f64> = corner.weights().map(|(_, weight)| weight).collect();
        let nodal = weights.iter().flat_map(|weight| (0..D).map(move |i| -force[i] * weight));
        let of_tool = motions.iter().map(|(velocity, _)| force.dot(velocity));
        let mut dense = Dense { force: nodal.chain(of_tool).collect(), stiffness: Vec::new() };
        let Some(block) = stiffness else { return dense };
        // By each unknown of the tool: ∂F/∂q, and what replaces it in the rows of the tool.
        let (mut by_motion, mut of_motion) = (Vec::new(), Vec::new());
        for (velocity, spin) in &motions {
            let size = block.norm() * velocity.norm() + cross(spin, force).norm();
            by_motion.push(unless_rounding(force_by_motion(block, force, velocity, spin), size));
            of_motion.push(unless_rounding(block.tr_mul(velocity) + cross(spin, force), size));
        }
        let mut stiffness = Vec::with_capacity(dense.force.len().pow(2));
        for w in &weights {
            for j in 0..D {
                for v in &weights {
                    stiffness.extend((0..D).map(|i| v * w * block[(i, j)]));
                }
                stiffness.extend(of_motion.iter().map(|of| -w * of[j]));
            }
        }
        for (column, by) in by_motion.iter().enumerate() {
            for v in &weights {
                stiffness.extend((0..D).map(|i| -v * by[i]));
            }
            // A turn's arm changes with a shift, so that the couplings of both are the same either way.
            let of_shift = Increment::<D>::turn_axis(self.load.free[column]).is_none();
            let shift = motions[column].0;
            stiffness.extend(motions.iter().zip(&of_motion).map(|((velocity, _), of)| match of_shift {
                true => of.dot(&shift),
                false => velocity.dot(by),
            }));
        }
        dense.stiffness = stiffness;
        dense
    }
}

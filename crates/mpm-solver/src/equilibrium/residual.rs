//! When the forces of a load step are balanced: in all, and body by body.
//!
//! The out-of-balance force of all nodes is compared with the forces on them. A stiff or heavy body would hide that of
//! a soft one in this sum, so that the nodes of each body are compared with the body's own force as well. Rounding can
//! keep a node from coming nearer: it then counts as balanced at the round-off of the stresses around it.

use super::problem::{Iterate, Problem};
use super::round_off::BodyScale;
use crate::nodal_field::NodalField;
use crate::ranks::{any, norm, norm_of};
use mpm_assembly::FieldStart;
use mpm_grid::Vector;

/// Residual of a contribution's own unknowns, over its own scale, that rounding alone can cause.
const OWN_ROUND_OFF: f64 = 1e-14;

/// Units in the last place of each strain by which a node's force may be off: those of the gradient's sum, of the
/// stress, and of the sum over points.
const UNITS: f64 = 16.0;

/// Strain, over the tolerance, up to which a body counts as free of stress.
const NO_STRAIN: f64 = 2.0 * f64::EPSILON;

/// The residual no longer falls where it keeps this part of the one before.
const STAGNANT: f64 = 0.5;

/// The largest of residuals; one that is not a number is never passed over.
fn worst(residuals: impl Iterator<Item = f64>) -> f64 {
    residuals.fold(0.0, |worst: f64, it| if worst.is_nan() || it <= worst { worst } else { it })
}

impl<const D: usize> Problem<'_, D> {
    /// The largest of the relative out-of-balance forces:
    /// * `|f_oob| / (|f_ext| + |f_reaction| + Σ scale)` with the [scales](mpm_assembly::Contribution::scale) of
    ///   contributions,
    /// * where there are several bodies, `|f_oob| / |f_int|` over the nodes of each with its own internal force, which
    ///   supports, loads and its neighbours balance,
    /// * the residuals of contributions' own unknowns over their own scales.
    pub(crate) fn residual(&self, iterate: &Iterate<D>) -> f64 {
        let bodies = (0..self.round_off.bodies.len()).map(|body| self.body_residual(iterate, body, |_| true));
        let own = self.own_residuals(iterate).map(|(residual, _)| residual);
        worst(bodies.chain(own).chain([self.total_residual(iterate)]))
    }

    fn total_residual(&self, iterate: &Iterate<D>) -> f64 {
        let shared = &self.connected.shared;
        let supported = shared.counted(iterate.reaction.nodes.iter()).flat_map(|(v, force)| {
            let prescribed = (0..D).filter(move |&i| self.constraints.is_prescribed(v, i));
            prescribed.map(move |i| Vector::<1>::new(force[i]))
        });
        let trial = self.trial(&iterate.increment, false);
        let told = |index: usize| iterate.scales.get(index).copied().flatten();
        let scales = self.contributions.iter().enumerate();
        let of_contributions: f64 =
            scales.map(|(k, it)| told(k).unwrap_or_else(|| shared.scale(it.scale(&trial)))).sum();
        let scale = shared.norm(self.external) + norm(&*shared.ranks, supported) + of_contributions;
        let force = shared.norm(&iterate.out_of_balance.nodes);
        if force == 0.0 { 0.0 } else { force / scale }
    }

    /// Relative out-of-balance force of those of a body's nodes that count.
    fn body_residual(&self, iterate: &Iterate<D>, body: usize, counts: impl Fn(usize) -> bool + Clone) -> f64 {
        let scale @ BodyScale { stiffness, .. } = &self.round_off.bodies[body];
        let counted = self.counted(scale).filter(|&v| counts(v));
        let force = norm(&*self.connected.shared.ranks, counted.map(|v| iterate.out_of_balance.nodes[v]));
        // Rounding leaves a body without stress a residual below the tolerance.
        let scale = iterate.body_forces[body] + NO_STRAIN / self.tolerance.residual * stiffness;
        if force == 0.0 { 0.0 } else { force / scale }
    }

    /// Residuals of the nodal field, and of contributions' own unknowns over their own scales; each with the residual that
    /// rounding alone can cause.
    fn own_residuals<'a>(&'a self, iterate: &'a Iterate<D>) -> impl Iterator<Item = (f64, f64)> + 'a {
        let trial = self.trial(&iterate.increment, false);
        let of_field =
            self.connected.field.iter().map(|field| (self.field_residual(iterate, field), OWN_ROUND_OFF));
        let with_own = self.named.iter().zip(&self.connected.own).filter(|(_, own)| !own.is_empty());
        let of_contributions = with_own.map(move |(named, own)| {
            let residual = norm_of(&iterate.out_of_balance.own[own.clone()]);
            let scale = self.own_size(named.contribution.own_scale(&trial)).unwrap_or(1.0);
            let rounding = self.own_size(named.contribution.own_round_off(&trial)).unwrap_or(0.0) / scale;
            let rounding = OWN_ROUND_OFF.max(rounding);
            (if residual == 0.0 { 0.0 } else { residual / scale }, rounding)
        });
        of_field.chain(of_contributions)
    }

    /// The norm of numbers that all ranks have in parts; none of none.
    fn own_size(&self, mut sizes: Vec<f64>) -> Option<f64> {
        if sizes.is_empty() {
            return None;
        }
        self.connected.shared.ranks.sum(&mut sizes);
        let size = norm_of(&sizes);
        Some(if size == 0.0 { f64::MIN_POSITIVE } else { size })
    }

    /// Residual of the nodal field over `Σ_p V⁰_p h S_vp k_v`, which its drivers balance. Rounding leaves a field that is
    /// nothing a residual below the tolerance.
    fn field_residual(&self, iterate: &Iterate<D>, field: &NodalField) -> f64 {
        let (n, FieldStart { field: start, weight, .. }) = (field.nodes.len(), &field.start);
        let norm_of = |numbers: &[f64]| self.connected.shared.norm_at(&field.active, numbers);
        let residual = norm_of(&iterate.out_of_balance.own[..n]);
        let sizes = iterate.increment.own.iter().zip(start).zip(weight);
        let sizes: Vec<f64> =
            sizes.map(|((value, start), weight)| weight * value.abs().max(start.abs())).collect();
        let scale = norm_of(&sizes) + NO_STRAIN / self.tolerance.residual * norm_of(weight);
        if residual == 0.0 { 0.0 } else { residual / scale }
    }

    /// Whether the forces are balanced to `goal`, or as well as rounding lets them. `iterate.effort` holds the
    /// residual of the iterate.
    ///
    /// Rounding in a stiff body must not pass for balance in a soft one: nodes are judged by the round-off of the
    /// strains around them, and by that of strains of one only where iterations bring nothing more.
    pub(crate) fn is_balanced(&self, iterate: &Iterate<D>, goal: f64) -> bool {
        if iterate.effort.residual < goal {
            return true;
        }
        if !iterate.effort.residual.is_finite() {
            return false;
        }
        let is_own_rounding = self.own_residuals(iterate).all(|(residual, rounding)| residual <= rounding);
        let total = self.total_residual(iterate);
        let shared = &self.connected.shared;
        let is_rounding = shared.norm(&iterate.out_of_balance.nodes) <= self.round_off.all;
        if !(is_own_rounding && (total < goal || is_rounding)) {
            return false;
        }
        let tolerance = self.tolerance.residual;
        if iterate.effort.residual < tolerance {
            return true;
        }
        let is_stagnant = match iterate.effort.residuals[..] {
            [.., before, last] => last > STAGNANT * before,
            _ => false,
        };
        let own = self.node_round_off(iterate, is_stagnant);
        let is_beyond = |v: usize| iterate.out_of_balance.nodes[v].amax() > own[v];
        let bodies = 0..self.round_off.bodies.len();
        let any_is_beyond = any(&*shared.ranks, (0..own.len()).any(is_beyond));
        (total < tolerance || !any_is_beyond)
            && bodies.into_iter().all(|body| self.body_residual(iterate, body, is_beyond) < tolerance)
    }

    /// Out-of-balance force of every node that rounding alone can cause `[F]`.
    fn node_round_off(&self, iterate: &Iterate<D>, is_stagnant: bool) -> Vec<f64> {
        let mut scale = vec![0.0; self.n_nodes()];
        for (named, plan) in self.bodies.iter().zip(&self.connected.assembly_plans) {
            named.body.strain_force(plan.connectivity(), &iterate.increment.nodes, &mut scale);
        }
        self.connected.shared.ranks.complete_numbers(&mut scale);
        for ((scale, external), stiffness) in scale.iter_mut().zip(self.external).zip(&self.round_off.stiffness)
        {
            *scale = UNITS * f64::EPSILON * (*scale + external.norm());
            if is_stagnant {
                *scale = scale.max(UNITS * f64::EPSILON * stiffness);
            }
        }
        scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_residual_that_is_not_a_number_is_worst_wherever_it_stands() {
        assert_eq!(worst([0.5, 2.0, 1.0].into_iter()), 2.0);
        for place in 0..3 {
            let mut residuals = [0.5, 2.0, 1.0];
            residuals[place] = f64::NAN;
            assert!(worst(residuals.into_iter()).is_nan(), "{residuals:?}");
        }
    }
}

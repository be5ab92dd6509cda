//! One pass over the points of a regularised body: forces and residuals of the field, and the tangent where it is wanted.
//!
//! Per point, with g = ΔF⁻ᵀ∇S and r = F_nᵀ∇S,
//!
//! ```text
//! f_v  = V⁰ τ g_v                                   K_vw = V⁰ g_v · a · g_w       K_vk = V⁰ (∂τ/∂k g_v) S_w
//! r_v  = V⁰ [−h (d − k) S_v + A Grad k · r_v]       K_kk = V⁰ [h (1 − ∂d/∂k) S_v S_w + A r_v · r_w]
//! ```
//!
//! The order of sums is that of the pass without a field (`strips.rs`); nothing is allocated.

use super::plan::{FieldPlan, FieldScratch};
use super::scatter::{DenseField, FieldInput, FieldPart, FieldSums, add_field_lift, add_field_tangent};
use super::trial::{FieldTrial, Regularised, at_rest};
use crate::body::assembly_plan::AssemblyPlan;
use crate::body::point_tangent::add_tangent_of_point;
use crate::body::scatter::{ALL, DenseTangent, FORCE, LOWER, Part, add_lift, add_tangent, n_blocks};
use crate::body::strips::Strip;
use crate::body::trial::InadmissiblePoint;
use crate::unknowns::node_equation;
use mpm_basis::parallel::both;
use mpm_grid::{Block, Vector};
use std::sync::{Mutex, PoisonError};

/// Adds a body's internal force and the residuals of the field, and the tangent where `sums` has one.
///
/// Returns the smallest `det ΔF` of its points.
///
/// # Errors
/// The first point (in order) that has no admissible state under the trial; `sums` is then meaningless.
pub(super) fn assemble<const D: usize>(
    of: Regularised<'_, D>,
    plan: &AssemblyPlan<D>,
    input: FieldInput<'_, D>,
    sums: FieldSums<'_, D>,
) -> Result<f64, InadmissiblePoint> {
    let FieldSums { nodes: sums, own, own_lift } = sums;
    let (internal, mut tangent) = (sums.internal, sums.tangent);
    let field = plan.field();
    let pass = Pass { of, plan, field, input, values: field.nodes.values(input.own) };
    let (n_nodes, count) = (input.nodes.constraints.n_nodes(), field.nodes.len());
    let starts = input.nodes.pattern.column_start();
    let (first, end) = (starts[node_equation::<D>(n_nodes, 0)], starts[node_equation::<D>(n_nodes, 0) + count]);
    let mut smallest = f64::INFINITY;
    for strips in plan.sums.strips.phases() {
        let (mut values, mut lift): (&mut [f64], &mut [Vector<D>]) = (&mut [], &mut []);
        if let Some(tangent) = &mut tangent {
            values = &mut *tangent.values;
            lift = tangent.lift.as_deref_mut().unwrap_or_default();
        }
        let wants_tangent = !values.is_empty();
        let (nodes, columns) = values.split_at_mut(first.min(values.len()));
        let columns = if wants_tangent { &mut columns[..end - first] } else { columns };
        let part = FieldPart {
            nodes: Part { node: 0, internal: &mut *internal, values: nodes, lift },
            first: 0,
            own: &mut own[..count],
            values: columns,
            lift: if own_lift.is_empty() { &mut [] } else { &mut own_lift[..count] },
        };
        let scratch = &field.scratch[..];
        smallest = smallest.min(match (wants_tangent, of.law.has_symmetric_tangent()) {
            (false, _) => pass.sum::<FORCE>(strips, scratch, part)?,
            (true, true) => pass.sum::<LOWER>(strips, scratch, part)?,
            (true, false) => pass.sum::<ALL>(strips, scratch, part)?,
        });
    }
    Ok(smallest)
}

/// What all tasks of a pass read.
struct Pass<'a, const D: usize> {
    of: Regularised<'a, D>,
    plan: &'a AssemblyPlan<D>,
    field: &'a FieldPlan<D>,
    input: FieldInput<'a, D>,
    /// The field at its nodes.
    values: &'a [f64],
}

impl<const D: usize> Pass<'_, D> {
    /// Sums strips, halving the list until there is one task for each scratch.
    fn sum<const TANGENT: u8>(
        &self,
        strips: &[Strip],
        scratch: &[Mutex<FieldScratch<D>>],
        mut part: FieldPart<'_, D>,
    ) -> Result<f64, InadmissiblePoint> {
        if scratch.len() > 1 && strips.len() > 1 {
            let (low, high) = strips.split_at(strips.len() / 2);
            let (low_scratch, high_scratch) = scratch.split_at(scratch.len() / 2);
            let nodes = &self.field.nodes;
            let (low_part, high_part) = part.split_at(high[0].nodes.start, nodes, self.input.nodes.pattern);
            let (low, high) = both(
                || self.sum::<TANGENT>(low, low_scratch, low_part),
                || self.sum::<TANGENT>(high, high_scratch, high_part),
            );
            return Ok(low?.min(high?));
        }
        // What a task that panicked has left is overwritten.
        let mut scratch = scratch[0].lock().unwrap_or_else(PoisonError::into_inner);
        let mut smallest = f64::INFINITY;
        for position in strips.iter().flat_map(|strip| strip.sets.clone()) {
            let set = self.plan.sums.strips.set(position);
            smallest = smallest.min(self.sum_dense::<TANGENT>(set, &mut scratch)?);
            self.scatter::<TANGENT>(set, &scratch, &mut part);
        }
        Ok(smallest)
    }

    /// Sums the points of a node set densely.
    fn sum_dense<const TANGENT: u8>(
        &self,
        set: usize,
        scratch: &mut FieldScratch<D>,
    ) -> Result<f64, InadmissiblePoint> {
        let connectivity = self.plan.connectivity();
        let nodes = connectivity.node_set(set);
        let n = nodes.len();
        for (k, &node) in nodes.iter().enumerate() {
            scratch.increment[k] = self.input.nodes.increment[node as usize];
            scratch.field[k] = self.values[self.field.nodes.entry(node as usize)];
        }
        scratch.force[..n].fill(Vector::zeros());
        scratch.field_force[..n].fill(0.0);
        if TANGENT != FORCE {
            scratch.tangent[..n_blocks::<TANGENT>(n)].fill(Block::zeros());
            scratch.mixed[..n * n].fill(Vector::zeros());
            scratch.field_tangent[..n * (n + 1) / 2].fill(0.0);
        }
        let mut smallest = f64::INFINITY;
        for &group in connectivity.node_set_groups(set) {
            let group = connectivity.group(group as usize);
            for k in 0..group.points {
                let (p, influences) = (group.first_point + k, group.point(k));
                let trial = self.of.trial(p, &scratch.increment[..n], &scratch.field[..n], influences)?;
                smallest = smallest.min(trial.step.determinant);
                self.add_point::<TANGENT>(p, &trial, influences, scratch);
            }
        }
        Ok(smallest)
    }

    /// Adds a point to the dense sums.
    fn add_point<const TANGENT: u8>(
        &self,
        p: usize,
        trial: &FieldTrial<D>,
        (values, gradients): (&[f64], &[Vector<D>]),
        scratch: &mut FieldScratch<D>,
    ) {
        let n = values.len();
        let Regularised { points, regularisation, .. } = self.of;
        let volume = points.reference_volume[p];
        let (modulus, gradient_modulus) =
            (regularisation.modulus() * volume, regularisation.gradient_modulus() * volume);
        let g = &mut scratch.gradient[..n];
        let r = &mut scratch.rest_gradient[..n];
        let stress = trial.kirchhoff * volume;
        let difference = modulus * (trial.driver - trial.field);
        for v in 0..n {
            g[v] = trial.step.inverse.tr_mul(&gradients[v]);
            r[v] = at_rest(&points.deformation_gradient[p], &gradients[v]);
            scratch.force[v] += stress * g[v];
            scratch.field_force[v] +=
                gradient_modulus * trial.field_gradient.dot(&r[v]) - difference * values[v];
        }
        if TANGENT == FORCE {
            return;
        }
        let a = trial.tangent(&regularisation);
        let tangent = &mut scratch.tangent[..n_blocks::<TANGENT>(n)];
        add_tangent_of_point::<D, TANGENT, false>((&*g, &[]), (&a, None), volume, tangent);
        // Elastic points of a law under its plastic strain do not feel the field.
        if trial.by_field != Block::<D>::zeros() {
            let by_field = trial.by_field * volume;
            g.iter_mut().for_each(|g| *g = by_field * *g);
            for (row, value) in scratch.mixed[..n * n].chunks_exact_mut(n).zip(values) {
                row.iter_mut().zip(&*g).for_each(|(sum, g)| *sum += g * *value);
            }
        }
        let own = modulus * (1.0 - trial.driver_by_field);
        let mut sums = scratch.field_tangent.iter_mut();
        for w in 0..n {
            let (value, gradient) = (own * values[w], r[w] * gradient_modulus);
            for (v, sum) in (w..n).zip(&mut sums) {
                *sum += value * values[v] + gradient.dot(&r[v]);
            }
        }
    }

    /// Adds the dense sums of a set of nodes to the global arrays.
    fn scatter<const TANGENT: u8>(&self, set: usize, scratch: &FieldScratch<D>, part: &mut FieldPart<'_, D>) {
        let nodes = self.plan.connectivity().node_set(set);
        let (n, field, input) = (nodes.len(), &*self.field.nodes, self.input.nodes);
        for (k, &node) in nodes.iter().enumerate() {
            part.nodes.internal[node as usize - part.nodes.node] += scratch.force[k];
            part.own[field.entry(node as usize) - part.first] += scratch.field_force[k];
        }
        if TANGENT == FORCE {
            return;
        }
        let tangent = DenseTangent::of::<TANGENT>(&scratch.tangent[..n_blocks::<TANGENT>(n)]);
        let mixed = &scratch.mixed[..n * n];
        let dense = DenseField { mixed, tangent: &scratch.field_tangent[..n * (n + 1) / 2] };
        if !part.nodes.lift.is_empty() {
            add_lift(nodes, tangent, input.constraints, &mut part.nodes);
            add_field_lift((nodes, field), dense, input, part);
        }
        let sums = &self.plan.sums;
        add_tangent(nodes, &sums.slots[sums.slot_start[set]..], tangent, input, &mut part.nodes);
        let offsets = self.field.offsets(set, n, input.pattern.symmetry());
        add_field_tangent((nodes, field), offsets, dense, input, part);
    }
}

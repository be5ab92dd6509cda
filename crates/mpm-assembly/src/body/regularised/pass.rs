//! One pass over the points of a regularised body: forces and residuals of the field, and the tangent where it is wanted.
//!
//! Per point, with g = ΔF⁻ᵀ∇S,
//!
//! ```text
//! f_v  = V⁰ τ g_v                                   K_vw = V⁰ g_v · a · g_w       K_vk = V⁰ (∂τ/∂k g_v) S_w
//! r_v  = Σ_w H_vw k_w − V⁰ h d S_v                  K_kk = H_vw − V⁰ h ∂d/∂k S_v S_w
//! ```
//!
//! H is the Helmholtz matrix of the [plan](FieldPlan::helmholtz), which no trial changes. The order of sums is that of the
//! pass without a field (`strips.rs`); nothing is allocated.

use super::plan::{FieldPlan, FieldScratch};
use super::scatter::{DenseField, FieldPart, add_field_lift, add_field_tangent};
use super::trial::Regularised;
use crate::body::assembly_plan::AssemblyPlan;
use crate::body::point_tangent::add_tangent_of_point;
use crate::body::scatter::{
    ALL, DenseTangent, FORCE, LOWER, Part, PassInput, Sums, add_lift, add_tangent, n_blocks,
};
use crate::body::strips::{Strip, sum_strips};
use crate::body::trial::InadmissiblePoint;
use crate::unknowns::node_equation;
use mpm_grid::{Block, Vector};

/// Adds a body's internal force and the residuals of the field, and the tangent where `sums` has one.
///
/// Returns the smallest `det ΔF` of its points.
///
/// # Errors
/// The first point (in order) that has no admissible state under the trial; `sums` is then meaningless.
pub(super) fn assemble<const D: usize>(
    of: Regularised<'_, D>,
    plan: &AssemblyPlan<D>,
    input: PassInput<'_, D>,
    sums: Sums<'_, D>,
) -> Result<f64, InadmissiblePoint> {
    let Sums { internal, own, mut tangent } = sums;
    let field = plan.field();
    let pass = Pass { of, plan, field, input, values: field.nodes.values(input.own) };
    let (n_nodes, count) = (input.constraints.n_nodes(), field.nodes.len());
    let starts = input.pattern.column_start();
    let (first, end) = (starts[node_equation::<D>(n_nodes, 0)], starts[node_equation::<D>(n_nodes, 0) + count]);
    let mut smallest = f64::INFINITY;
    for strips in plan.sums.strips.phases() {
        let (mut values, mut lift): (&mut [f64], &mut [Vector<D>]) = (&mut [], &mut []);
        let mut own_lift: &mut [f64] = &mut [];
        if let Some(tangent) = &mut tangent {
            values = &mut *tangent.values;
            lift = tangent.lift.as_deref_mut().unwrap_or_default();
            own_lift = &mut *tangent.own_lift;
        }
        let wants_tangent = !values.is_empty();
        let (nodes, columns) = values.split_at_mut(first.min(values.len()));
        let part = FieldPart {
            nodes: Part { node: 0, internal: &mut *internal, values: nodes, lift },
            first: 0,
            own: &mut own[..count],
            values: if wants_tangent { &mut columns[..end - first] } else { columns },
            lift: if own_lift.is_empty() { own_lift } else { &mut own_lift[..count] },
        };
        smallest = smallest.min(match (wants_tangent, of.law.has_symmetric_tangent()) {
            (false, _) => pass.sum::<FORCE>(strips, part)?,
            (true, true) => pass.sum::<LOWER>(strips, part)?,
            (true, false) => pass.sum::<ALL>(strips, part)?,
        });
    }
    Ok(smallest)
}

/// What all tasks of a pass read.
struct Pass<'a, const D: usize> {
    of: Regularised<'a, D>,
    plan: &'a AssemblyPlan<D>,
    field: &'a FieldPlan<D>,
    input: PassInput<'a, D>,
    /// The field at its nodes.
    values: &'a [f64],
}

/// The dense sums of a node set, as in [`FieldScratch`].
struct Dense<'a, const D: usize> {
    force: &'a mut [Vector<D>],
    field_force: &'a mut [f64],
    gradient: &'a mut [Vector<D>],
    tangent: &'a mut [Block<D>],
    mixed: &'a mut [Vector<D>],
    is_mixed: &'a mut bool,
    field_tangent: &'a mut [f64],
}

impl<const D: usize> Pass<'_, D> {
    /// Sums the strips of a phase.
    fn sum<'p, const TANGENT: u8>(
        &self,
        strips: &[Strip],
        part: FieldPart<'p, D>,
    ) -> Result<f64, InadmissiblePoint> {
        let parted = |part: FieldPart<'p, D>, node| part.split_at(node, &self.field.nodes, self.input.pattern);
        sum_strips(strips, &self.field.scratch, part, &parted, &|strips, scratch, mut part| {
            let mut smallest = f64::INFINITY;
            for position in strips.iter().flat_map(|strip| strip.sets.clone()) {
                let set = self.plan.sums.strips.set(position);
                // The commonest node sets are compiled with their size known.
                smallest = smallest.min(match self.plan.connectivity().node_set(set).len() {
                    4 => self.sum_dense::<TANGENT>(4, set, scratch)?,
                    8 => self.sum_dense::<TANGENT>(8, set, scratch)?,
                    9 => self.sum_dense::<TANGENT>(9, set, scratch)?,
                    n => self.sum_dense::<TANGENT>(n, set, scratch)?,
                });
                self.scatter::<TANGENT>(set, scratch, &mut part);
            }
            Ok(smallest)
        })
    }

    /// Sums the points of a set of n nodes densely.
    #[inline(always)]
    fn sum_dense<const TANGENT: u8>(
        &self,
        n: usize,
        set: usize,
        scratch: &mut FieldScratch<D>,
    ) -> Result<f64, InadmissiblePoint> {
        let connectivity = self.plan.connectivity();
        let (increment, field) = (&mut scratch.increment[..n], &mut scratch.field[..n]);
        for (k, &node) in connectivity.node_set(set).iter().enumerate() {
            increment[k] = self.input.increment[node as usize];
            field[k] = self.values[self.field.nodes.entry(node as usize)];
        }
        let wants_tangent = TANGENT != FORCE;
        let n_field = if wants_tangent { n * (n + 1) / 2 } else { 0 };
        let mut dense = Dense {
            force: &mut scratch.force[..n],
            field_force: &mut scratch.field_force[..n],
            gradient: &mut scratch.gradient[..n],
            tangent: &mut scratch.tangent[..n_blocks::<TANGENT>(n)],
            mixed: &mut scratch.mixed[..if wants_tangent { n * n } else { 0 }],
            is_mixed: &mut scratch.is_mixed,
            field_tangent: &mut scratch.field_tangent[..n_field],
        };
        let helmholtz = self.field.helmholtz(set);
        dense.force.fill(Vector::zeros());
        dense.tangent.fill(Block::zeros());
        dense.mixed.fill(Vector::zeros());
        dense.field_tangent.copy_from_slice(&helmholtz[..n_field]);
        *dense.is_mixed = false;
        product(n, helmholtz, field, dense.field_force);
        let mut smallest = f64::INFINITY;
        for &group in connectivity.node_set_groups(set) {
            let group = connectivity.group(group as usize);
            for k in 0..group.points {
                let influences = (&group.values[k * n..(k + 1) * n], &group.gradients[k * n..(k + 1) * n]);
                let determinant = self.add_point::<TANGENT>(
                    group.first_point + k,
                    (increment, field),
                    influences,
                    &mut dense,
                )?;
                smallest = smallest.min(determinant);
            }
        }
        Ok(smallest)
    }

    /// Adds a point to the dense sums; returns its `det ΔF`.
    #[inline(always)]
    fn add_point<const TANGENT: u8>(
        &self,
        p: usize,
        (increment, field): (&[Vector<D>], &[f64]),
        (values, gradients): (&[f64], &[Vector<D>]),
        dense: &mut Dense<'_, D>,
    ) -> Result<f64, InadmissiblePoint> {
        let trial = self.of.trial(p, increment, field, (values, gradients))?;
        let n = values.len();
        let Regularised { points, regularisation, .. } = self.of;
        let volume = points.reference_volume[p];
        let modulus = regularisation.modulus() * volume;
        let g = &mut dense.gradient[..n];
        let (stress, driven) = (trial.kirchhoff * volume, modulus * trial.driver);
        for v in 0..n {
            g[v] = trial.step.inverse.tr_mul(&gradients[v]);
            dense.force[v] += stress * g[v];
            dense.field_force[v] -= driven * values[v];
        }
        if TANGENT == FORCE {
            return Ok(trial.step.determinant);
        }
        let a = trial.tangent(&regularisation);
        add_tangent_of_point::<D, TANGENT, false>((&*g, &[]), (&a, None), volume, dense.tangent);
        // Elastic points of a law under its plastic strain do not feel the field.
        if trial.by_field != Block::<D>::zeros() {
            *dense.is_mixed = true;
            let by_field = trial.by_field * volume;
            for (g, sums) in g.iter().zip(dense.mixed.chunks_exact_mut(n)) {
                let by_field = by_field * *g;
                sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += by_field * *value);
            }
        }
        if trial.driver_by_field != 0.0 {
            let mut sums = &mut dense.field_tangent[..];
            for w in 0..n {
                let (column, rest) = sums.split_at_mut(n - w);
                let value = modulus * trial.driver_by_field * values[w];
                column.iter_mut().zip(&values[w..]).for_each(|(sum, other)| *sum -= value * other);
                sums = rest;
            }
        }
        Ok(trial.step.determinant)
    }

    /// Adds the dense sums of a set of nodes to the global arrays.
    fn scatter<const TANGENT: u8>(&self, set: usize, scratch: &FieldScratch<D>, part: &mut FieldPart<'_, D>) {
        let nodes = self.plan.connectivity().node_set(set);
        let (n, field, input) = (nodes.len(), &*self.field.nodes, self.input);
        for (k, &node) in nodes.iter().enumerate() {
            part.nodes.internal[node as usize - part.nodes.node] += scratch.force[k];
            part.own[field.entry(node as usize) - part.first] += scratch.field_force[k];
        }
        if TANGENT == FORCE {
            return;
        }
        let tangent = DenseTangent::of::<TANGENT>(&scratch.tangent[..n_blocks::<TANGENT>(n)]);
        let mixed = scratch.is_mixed.then(|| &scratch.mixed[..n * n]);
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

/// The product of a dense symmetric matrix, from the diagonal down, and a vector.
#[inline(always)]
fn product(n: usize, matrix: &[f64], vector: &[f64], image: &mut [f64]) {
    image.fill(0.0);
    let mut rest = matrix;
    for w in 0..n {
        let (column, next) = rest.split_at(n - w);
        let (value, mut sum) = (vector[w], column[0] * vector[w]);
        for ((entry, other), image) in column[1..].iter().zip(&vector[w + 1..]).zip(&mut image[w + 1..]) {
            sum += entry * other;
            *image += entry * value;
        }
        image[w] += sum;
        rest = next;
    }
}

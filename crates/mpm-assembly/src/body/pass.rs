//! One pass over the points of a body: internal force, and the tangent where it is wanted.
//!
//! Per point (method of Wang et al. 2018, slides 5-8; Charlton, Coombs & Augarde 2017):
//!
//! * `ΔF = I + Σ_v Δu_v ⊗ ∇S_vp`, `b_tr = ΔF b_e,n ΔFᵀ`, the law gives `τ` and its tangent `a`,
//! * `g_vp = ΔF⁻ᵀ ∇S_vp`,
//! * `fⁱⁿᵗ_v = Σ_p V⁰_p τ_p g_vp` (the same as `σ V` with `V = J V⁰`),
//! * `K_vw = Σ_p V⁰_p g_vp · a_p · g_wp`.
//!
//! In a body of revolution with the stretch of the hoop `ΔF_θθ = 1 + Σ_v S_vp Δu_v,r / r_p`, with
//! `t_vp = S_vp / (r_p ΔF_θθ)` and the parts of `a` that belong to the hoop
//! ([`mpm_material::PrincipalTangent::hoop_tangent`], c by the hoop and c' of the hoop),
//!
//! * `fⁱⁿᵗ_v = Σ_p V⁰_p (τ_p g_vp + τ_θθ t_vp e_r)`,
//! * `K_vw = Σ_p V⁰_p (g_vp · a_p · g_wp + c g_vp ⊗ e_r t_wp + e_r t_vp ⊗ c' g_wp + e_r ⊗ e_r t_vp a_θθθθ t_wp)`.
//!
//! Of a body that turns about its axis (D = 3) see `turning_tangent.rs`.
//!
//! Points that share their nodes are summed densely, wherever they stand in the list of points, and
//! their sum is added to the global arrays once. The strips of `strips.rs` fix the order of all
//! sums. Points are worked on in batches (`batch.rs`): states and laws four points at a time (`batch_trial.rs`;
//! `batch_law.rs` is all of a pass that is compiled for each law), blocks four nodes at a time (`node_sums.rs`). A pass allocates nothing, but for bodies with
//! mean dilatation.

use crate::InadmissiblePoint;
use crate::body::assembly_plan::{AssemblyPlan, Scratch};
use crate::body::batch::Gathered;
use crate::body::batch_law::{BatchLaw, LawOfPoints};
use crate::body::batch_trial::Question;
use crate::body::dilatation::{self, Dilated};
use crate::body::node_sums::{RUN, SummedPoint};
use crate::body::points::Points;
use crate::body::scatter::{
    ALL, DenseTangent, FORCE, LOWER, Part, PassInput, Sums, add_lift, add_tangent, n_blocks,
};
use crate::body::strips::{Strip, sum_strips};
use crate::body::trial::Committed;
use mpm_grid::Vector;
use mpm_material::Material;
use mpm_material::lanes::{Work, vectorised};

/// Adds a body's internal force, and its tangent where `sums` has one.
///
/// Returns the smallest `det ΔF` of its points.
///
/// # Errors
/// The first point (in order) that has no admissible state under the trial displacement; `sums` is
/// then meaningless.
pub fn assemble<const D: usize, M: Material, const HOOP: bool>(
    committed: Committed<'_, D, M>,
    plan: &AssemblyPlan<D>,
    input: PassInput<'_, D>,
    sums: Sums<'_, D>,
) -> Result<f64, InadmissiblePoint> {
    let is_symmetric = committed.law.has_symmetric_tangent();
    if plan.dilatation().is_some() {
        return sum(&DilatedPass::<D, M, HOOP> { committed, plan, input }, plan, input, (sums, is_symmetric));
    }
    let Committed { law, points, history } = committed;
    let law = &LawOfPoints { law, history };
    sum(&Pass::<D, HOOP> { law, points, plan, input }, plan, input, (sums, is_symmetric))
}

/// What tasks do with their strips.
trait Task<const D: usize>: Sync {
    /// Sums the strips of a task.
    fn sum<const TANGENT: u8>(
        &self,
        strips: &[Strip],
        scratch: &mut Scratch<D>,
        part: Part<'_, D>,
    ) -> Result<f64, InadmissiblePoint>;
}

/// Sums all strips; the flag says whether all tangents are symmetric.
fn sum<const D: usize, T: Task<D>>(
    task: &T,
    plan: &AssemblyPlan<D>,
    input: PassInput<'_, D>,
    (sums, is_symmetric): (Sums<'_, D>, bool),
) -> Result<f64, InadmissiblePoint> {
    let Sums { internal, mut tangent, .. } = sums;
    let mut smallest = f64::INFINITY;
    for strips in plan.sums.strips.phases() {
        let (mut values, mut lift): (&mut [f64], &mut [Vector<D>]) = (&mut [], &mut []);
        if let Some(tangent) = &mut tangent {
            values = &mut *tangent.values;
            lift = tangent.lift.as_deref_mut().unwrap_or_default();
        }
        let wants_tangent = !values.is_empty();
        let part = Part { node: 0, internal: &mut *internal, values, lift };
        smallest = smallest.min(match (wants_tangent, is_symmetric) {
            (false, _) => sum_phase::<D, T, FORCE>(task, (plan, input), strips, part)?,
            (true, true) => sum_phase::<D, T, LOWER>(task, (plan, input), strips, part)?,
            (true, false) => sum_phase::<D, T, ALL>(task, (plan, input), strips, part)?,
        });
    }
    Ok(smallest)
}

/// Sums the strips of a phase.
fn sum_phase<'p, const D: usize, T: Task<D>, const TANGENT: u8>(
    task: &T,
    (plan, input): (&AssemblyPlan<D>, PassInput<'_, D>),
    strips: &[Strip],
    part: Part<'p, D>,
) -> Result<f64, InadmissiblePoint> {
    let parted = |part: Part<'p, D>, node| part.split_at(node, input.pattern);
    sum_strips(strips, &plan.sums.scratch, part, &parted, &|strips, scratch, part| {
        task.sum::<TANGENT>(strips, scratch, part)
    })
}

/// Adds the dense sums of set `set` of nodes to the global arrays.
#[inline(always)]
fn scatter<const D: usize>(
    (plan, input): (&AssemblyPlan<D>, PassInput<'_, D>),
    (nodes, set): (&[u32], usize),
    force: impl Fn(usize) -> Vector<D>,
    tangent: Option<DenseTangent<'_, D>>,
    part: &mut Part<'_, D>,
) {
    for (v, node) in nodes.iter().enumerate() {
        part.internal[*node as usize - part.node] += force(v);
    }
    if let Some(tangent) = tangent {
        if !part.lift.is_empty() {
            add_lift(nodes, tangent, input.constraints, part);
        }
        let sums = &plan.sums;
        add_tangent(nodes, &sums.slots[sums.slot_start[set]..], tangent, input, part);
    }
}

/// What all tasks of a pass read.
struct Pass<'a, const D: usize, const HOOP: bool> {
    law: &'a dyn BatchLaw,
    points: &'a Points<D>,
    plan: &'a AssemblyPlan<D>,
    input: PassInput<'a, D>,
}

impl<const D: usize, const HOOP: bool> Task<D> for Pass<'_, D, HOOP> {
    fn sum<const TANGENT: u8>(
        &self,
        strips: &[Strip],
        scratch: &mut Scratch<D>,
        mut part: Part<'_, D>,
    ) -> Result<f64, InadmissiblePoint> {
        let connectivity = self.plan.connectivity();
        let mut smallest = f64::INFINITY;
        let mut gathered = Gathered::new();
        for position in strips.iter().flat_map(|strip| strip.sets.clone()) {
            let set = self.plan.sums.strips.set(position);
            let groups = connectivity.node_set_groups(set);
            for (index, &group) in groups.iter().enumerate() {
                let group = connectivity.group(group as usize);
                let mut from = 0;
                while from < group.points {
                    from = gathered.push((set, group), from, (index == 0, index + 1 == groups.len()));
                    if gathered.is_full() {
                        smallest = smallest.min(self.sum_batch::<TANGENT>(&gathered, scratch, &mut part)?);
                        gathered.clear();
                    }
                }
            }
        }
        if !gathered.points().is_empty() {
            smallest = smallest.min(self.sum_batch::<TANGENT>(&gathered, scratch, &mut part)?);
        }
        Ok(smallest)
    }
}

impl<const D: usize, const HOOP: bool> Pass<'_, D, HOOP> {
    /// Sums the points of a batch.
    fn sum_batch<const TANGENT: u8>(
        &self,
        gathered: &Gathered<'_, D>,
        scratch: &mut Scratch<D>,
        part: &mut Part<'_, D>,
    ) -> Result<f64, InadmissiblePoint> {
        let Self { law, points, input, .. } = *self;
        let batch = &mut scratch.batch;
        batch.steps.measure::<HOOP>(gathered, input.increment, &points.position);
        let question = Question { law, points, numbers: gathered.points() };
        let smallest = match TANGENT {
            FORCE => question.answer::<HOOP, false>(batch)?,
            _ => question.answer::<HOOP, true>(batch)?,
        };
        vectorised(Summing::<D, HOOP, TANGENT> { pass: self, gathered, scratch, part });
        Ok(smallest)
    }
}

/// Sums the points of a batch, whose laws have answered.
struct Summing<'a, 'p, const D: usize, const HOOP: bool, const TANGENT: u8> {
    pass: &'a Pass<'a, D, HOOP>,
    gathered: &'a Gathered<'a, D>,
    scratch: &'a mut Scratch<D>,
    part: &'a mut Part<'p, D>,
}

impl<const D: usize, const HOOP: bool, const TANGENT: u8> Work for Summing<'_, '_, D, HOOP, TANGENT> {
    type Output = ();

    #[inline(always)]
    fn run<const VECTORS: bool>(self) {
        let Self { pass: &Pass { points, plan, input, .. }, gathered, scratch, part } = self;
        let Scratch { batch, sums, .. } = scratch;
        let mut run = [SummedPoint::NONE; RUN];
        let (mut in_run, mut at) = (0, 0);
        for segment in gathered.segments() {
            let group = &segment.group;
            let n = group.nodes.len();
            if segment.begins {
                sums.begin::<TANGENT>(n);
            }
            for k in segment.from..segment.to {
                let influences = (&group.values[k * n..(k + 1) * n], &group.gradients[k * n..(k + 1) * n]);
                let radius = if HOOP { points.position[group.first_point + k][0] } else { 1.0 };
                run[in_run] = SummedPoint { answered: batch.answers.answered(at), influences, radius };
                in_run += 1;
                at += 1;
                // The last set of a batch goes on in the next one.
                let is_last = k + 1 == segment.to && (segment.ends || at == gathered.points().len());
                if in_run == RUN || is_last {
                    sums.add::<TANGENT, HOOP, VECTORS>(&run[..in_run]);
                    in_run = 0;
                }
            }
            if segment.ends {
                sums.end::<TANGENT>();
                let tangent = (TANGENT != FORCE).then(|| DenseTangent::of_nodes::<TANGENT>(sums.blocks()));
                scatter((plan, input), (group.nodes, segment.set), |v| sums.force(v), tangent, part);
            }
        }
    }
}

/// The same of a body under mean dilatation, whose sets are cells.
struct DilatedPass<'a, const D: usize, M: Material, const HOOP: bool> {
    committed: Committed<'a, D, M>,
    plan: &'a AssemblyPlan<D>,
    input: PassInput<'a, D>,
}

impl<const D: usize, M: Material, const HOOP: bool> Task<D> for DilatedPass<'_, D, M, HOOP> {
    fn sum<const TANGENT: u8>(
        &self,
        strips: &[Strip],
        scratch: &mut Scratch<D>,
        mut part: Part<'_, D>,
    ) -> Result<f64, InadmissiblePoint> {
        let Self { committed, plan, input } = *self;
        let Some(dilatation) = plan.dilatation() else { unreachable!("the plan has been asked") };
        let (connectivity, increment) = (plan.connectivity(), input.increment);
        let dilated = Dilated::<D, M, HOOP> { committed, connectivity, dilatation, increment };
        let mut of_cell = dilatation::Scratch::default();
        let mut smallest = f64::INFINITY;
        for position in strips.iter().flat_map(|strip| strip.sets.clone()) {
            let cell = plan.sums.strips.set(position);
            let nodes = dilatation.cells().nodes(cell);
            let n = nodes.len();
            let force = &mut scratch.force[..n];
            let tangent = &mut scratch.tangent[..n_blocks::<TANGENT>(n)];
            smallest = smallest.min(dilated.sum::<TANGENT>(cell, force, tangent, &mut of_cell)?);
            let tangent = (TANGENT != FORCE).then(|| DenseTangent::of::<TANGENT>(tangent));
            scatter((plan, input), (nodes, cell), |v| force[v], tangent, &mut part);
        }
        Ok(smallest)
    }
}

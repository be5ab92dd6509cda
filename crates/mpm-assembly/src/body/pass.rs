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
//! sums. A pass allocates nothing, but for bodies with mean dilatation.

use crate::InadmissiblePoint;
use crate::body::assembly_plan::{AssemblyPlan, Scratch};
use crate::body::dilatation::{self, Dilated};
use crate::body::kinematics::block;
use crate::body::point_tangent::add_tangent_of_point;
use crate::body::scatter::{
    ALL, DenseTangent, FORCE, LOWER, Part, PassInput, Sums, add_lift, add_tangent, n_blocks,
};
use crate::body::strips::{Strip, sum_strips};
use crate::body::trial::{Committed, trial};
use crate::body::turning_tangent::{Turned, add_turning_tangent};
use mpm_basis::Group;
use mpm_grid::{Block, Vector};
use mpm_material::Material;
use std::sync::Mutex;

/// The dense sums of a node set, and what its points need of its nodes.
struct Dense<'a, const D: usize> {
    increment: &'a mut [Vector<D>],
    force: &'a mut [Vector<D>],
    gradient: &'a mut [Vector<D>],
    /// `t_vp`; empty where there is no hoop.
    hoop: &'a mut [f64],
    /// As in [`DenseTangent`]; none where no tangent is wanted.
    tangent: &'a mut [Block<D>],
    /// Of a pass for [`ALL`] blocks: the sum of the points whose tangent is symmetric, from the diagonal down.
    symmetric: &'a mut [Block<D>],
}

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
    let Sums { internal, mut tangent, .. } = sums;
    let pass = Pass::<D, M, HOOP> { committed, plan, input };
    let mut smallest = f64::INFINITY;
    for strips in plan.sums.strips.phases() {
        let (mut values, mut lift): (&mut [f64], &mut [Vector<D>]) = (&mut [], &mut []);
        if let Some(tangent) = &mut tangent {
            values = &mut *tangent.values;
            lift = tangent.lift.as_deref_mut().unwrap_or_default();
        }
        let wants_tangent = !values.is_empty();
        let part = Part { node: 0, internal: &mut *internal, values, lift };
        let scratch = &plan.sums.scratch[..];
        smallest = smallest.min(match (wants_tangent, committed.law.has_symmetric_tangent()) {
            (false, _) => pass.sum::<FORCE>(strips, scratch, part)?,
            (true, true) => pass.sum::<LOWER>(strips, scratch, part)?,
            (true, false) => pass.sum::<ALL>(strips, scratch, part)?,
        });
    }
    Ok(smallest)
}

/// What all tasks of a pass read.
struct Pass<'a, const D: usize, M: Material, const HOOP: bool> {
    committed: Committed<'a, D, M>,
    plan: &'a AssemblyPlan<D>,
    input: PassInput<'a, D>,
}

impl<const D: usize, M: Material, const HOOP: bool> Pass<'_, D, M, HOOP> {
    /// Sums the strips of a phase.
    fn sum<'p, const TANGENT: u8>(
        &self,
        strips: &[Strip],
        scratch: &[Mutex<Scratch<D>>],
        part: Part<'p, D>,
    ) -> Result<f64, InadmissiblePoint> {
        let parted = |part: Part<'p, D>, node| part.split_at(node, self.input.pattern);
        sum_strips(strips, scratch, part, &parted, &|strips, scratch, part| {
            self.sum_task::<TANGENT>(strips, scratch, part)
        })
    }

    /// Sums the strips of a task.
    fn sum_task<const TANGENT: u8>(
        &self,
        strips: &[Strip],
        scratch: &mut Scratch<D>,
        mut part: Part<'_, D>,
    ) -> Result<f64, InadmissiblePoint> {
        let positions = strips.iter().flat_map(|strip| strip.sets.clone());
        let sets = positions.map(|position| self.plan.sums.strips.set(position));
        let mut smallest = f64::INFINITY;
        match self.plan.dilatation() {
            None => {
                for set in sets {
                    smallest = smallest.min(self.sum_node_set::<TANGENT>(set, scratch, &mut part)?);
                }
            }
            Some(dilatation) => {
                let Self { committed, plan, input } = *self;
                let connectivity = plan.connectivity();
                let increment = input.increment;
                let dilated = Dilated::<D, M, HOOP> { committed, connectivity, dilatation, increment };
                let mut of_cell = dilatation::Scratch::default();
                let Scratch { force, tangent, .. } = scratch;
                for cell in sets {
                    let nodes = dilatation.cells().nodes(cell);
                    let n = nodes.len();
                    let force = &mut force[..n];
                    let tangent = &mut tangent[..n_blocks::<TANGENT>(n)];
                    smallest = smallest.min(dilated.sum::<TANGENT>(cell, force, tangent, &mut of_cell)?);
                    self.scatter::<TANGENT>(nodes, cell, force, tangent, &mut part);
                }
            }
        }
        Ok(smallest)
    }

    /// Adds the dense sums of set `set` of nodes to the global arrays.
    #[inline(always)]
    fn scatter<const TANGENT: u8>(
        &self,
        nodes: &[u32],
        set: usize,
        force: &[Vector<D>],
        tangent: &[Block<D>],
        part: &mut Part<'_, D>,
    ) {
        for (node, force) in nodes.iter().zip(force) {
            part.internal[*node as usize - part.node] += force;
        }
        if TANGENT != FORCE {
            let tangent = DenseTangent::of::<TANGENT>(tangent);
            if !part.lift.is_empty() {
                add_lift(nodes, tangent, self.input.constraints, part);
            }
            let sums = &self.plan.sums;
            add_tangent(nodes, &sums.slots[sums.slot_start[set]..], tangent, self.input, part);
        }
    }

    /// Sums the points of a node set and adds the sum to the global arrays.
    #[inline]
    fn sum_node_set<const TANGENT: u8>(
        &self,
        set: usize,
        scratch: &mut Scratch<D>,
        part: &mut Part<'_, D>,
    ) -> Result<f64, InadmissiblePoint> {
        let n = self.plan.connectivity().node_set(set).len();
        let Scratch { increment, force, gradient, hoop, tangent, symmetric } = scratch;
        if HOOP {
            hoop.resize(n, 0.0);
        }
        let dense = Dense {
            increment: &mut increment[..n],
            force: &mut force[..n],
            gradient: &mut gradient[..n],
            hoop,
            tangent: &mut tangent[..n_blocks::<TANGENT>(n)],
            symmetric: if TANGENT == ALL { &mut symmetric[..n_blocks::<LOWER>(n)] } else { &mut [] },
        };
        // The commonest node sets are compiled with their size known.
        match n {
            4 => self.sum_dense::<TANGENT>(4, set, dense, part),
            8 => self.sum_dense::<TANGENT>(8, set, dense, part),
            9 => self.sum_dense::<TANGENT>(9, set, dense, part),
            n => self.sum_dense::<TANGENT>(n, set, dense, part),
        }
    }

    /// Sums the points of a node set of `n` nodes densely and adds the sum to the global arrays.
    #[inline(always)]
    fn sum_dense<const TANGENT: u8>(
        &self,
        n: usize,
        set: usize,
        mut dense: Dense<'_, D>,
        part: &mut Part<'_, D>,
    ) -> Result<f64, InadmissiblePoint> {
        let Self { plan, input, .. } = *self;
        let nodes = plan.connectivity().node_set(set);
        for (du, node) in dense.increment.iter_mut().zip(nodes) {
            *du = input.increment[*node as usize];
        }
        dense.force.fill(Vector::zeros());
        dense.tangent.fill(Block::zeros());
        dense.symmetric.fill(Block::zeros());
        let mut smallest = f64::INFINITY;
        for &group in plan.connectivity().node_set_groups(set) {
            let group = plan.connectivity().group(group as usize);
            let least = sum_group::<D, M, TANGENT, HOOP>(n, self.committed, group, &mut dense)?;
            smallest = smallest.min(least);
        }
        if TANGENT == ALL {
            add_symmetric(n, dense.symmetric, dense.tangent);
        }
        self.scatter::<TANGENT>(nodes, set, dense.force, dense.tangent, part);
        Ok(smallest)
    }
}

/// Adds the sum of symmetric tangents, which holds the rows from the diagonal down, to all blocks.
#[inline(always)]
fn add_symmetric<const D: usize>(n: usize, symmetric: &[Block<D>], all: &mut [Block<D>]) {
    let mut blocks = symmetric.iter();
    for w in 0..n {
        for (v, block) in (w..n).zip(&mut blocks) {
            all[w * n + v] += block;
            if v > w {
                all[v * n + w] += block.transpose();
            }
        }
    }
}

/// Adds the points of a group to the dense sums; returns the smallest `det ΔF`.
#[inline(always)]
fn sum_group<const D: usize, M: Material, const TANGENT: u8, const HOOP: bool>(
    n: usize,
    committed: Committed<'_, D, M>,
    group: Group<'_, D>,
    dense: &mut Dense<'_, D>,
) -> Result<f64, InadmissiblePoint> {
    let du = &dense.increment[..n];
    let force = &mut dense.force[..n];
    let g = &mut dense.gradient[..n];
    let t = if HOOP { &mut dense.hoop[..n] } else { &mut [] };
    let tangent = &mut dense.tangent[..n_blocks::<TANGENT>(n)];
    let symmetric = &mut *dense.symmetric;

    let mut smallest = f64::INFINITY;
    for k in 0..group.points {
        let p = group.first_point + k;
        let (values, gradients) = (&group.values[k * n..(k + 1) * n], &group.gradients[k * n..(k + 1) * n]);
        let trial = trial::<D, M, HOOP>(committed, p, du, (values, gradients))?;
        smallest = smallest.min(trial.determinant);

        let volume = committed.points.reference_volume[p];
        let stress = block::<D>(&trial.response.kirchhoff) * volume;
        let turned = Turned { stress: &stress, radius: committed.points.position[p][0] * trial.hoop };
        for ((g, force), gradient) in g.iter_mut().zip(&mut *force).zip(gradients) {
            *g = trial.inverse.tr_mul(gradient);
            *force += if HOOP && D == 3 { turned.force(g) } else { stress * *g };
        }
        if HOOP {
            let stress = trial.response.kirchhoff.zz * volume;
            let per_radius = 1.0 / (committed.points.position[p][0] * trial.hoop);
            for ((t, force), value) in t.iter_mut().zip(&mut *force).zip(values) {
                *t = value * per_radius;
                force[0] += stress * *t;
            }
        }
        if TANGENT != FORCE {
            let modes = &trial.response.tangent;
            let a = modes.spatial_tangent::<D>();
            if HOOP && D == 3 {
                match TANGENT == LOWER || !modes.is_symmetric() {
                    true => add_turning_tangent::<D, TANGENT>((g, t), &a, turned, volume, tangent),
                    false => add_turning_tangent::<D, LOWER>((g, t), &a, turned, volume, symmetric),
                }
                continue;
            }
            let a = (&a, if HOOP { Some(modes.hoop_tangent()) } else { None });
            // Most points of an unsymmetric law are elastic, and half of their blocks are enough.
            if TANGENT == LOWER {
                add_tangent_of_point::<D, LOWER, HOOP>((g, t), a, volume, tangent);
            } else if modes.is_symmetric() {
                add_tangent_of_point::<D, LOWER, HOOP>((g, t), a, volume, symmetric);
            } else {
                add_tangent_of_point::<D, ALL, HOOP>((g, t), a, volume, tangent);
            }
        }
    }
    Ok(smallest)
}

//! One pass over the points of a body: internal force, and the tangent where it is wanted.
//!
//! Per point (method of Wang et al. 2018, slides 5-8; Charlton, Coombs & Augarde 2017):
//!
//! * `ΔF = I + Σ_v Δu_v ⊗ ∇S_vp`, `b_tr = ΔF b_e,n ΔFᵀ`, the law gives `τ` and its tangent `a`,
//! * `g_vp = ΔF⁻ᵀ ∇S_vp`,
//! * `fⁱⁿᵗ_v = Σ_p V⁰_p τ_p g_vp` (the same as `σ V` with `V = J V⁰`),
//! * `K_vw = Σ_p V⁰_p g_vp · a_p · g_wp`.
//!
//! Points that share their nodes are summed densely, wherever they stand in the list of points, and
//! their sum is added to the global arrays once. The strips of [`crate::strips`] fix the order of all
//! sums. A pass allocates nothing, but for bodies with mean dilatation.

use crate::dilatation::{self, Dilated};
use crate::kinematics::{block, gradient, inverse_and_determinant, trial_excess};
use crate::strips::{Strip, Strips};
use crate::{Constraints, Couplings, Dilatation, Linked, Pattern, Points};
use mpm_basis::{Basis, Group, Links};
use mpm_grid::{Block, Vector};
use mpm_material::{Material, Response, respond};
use std::sync::{Mutex, PoisonError};

/// Tasks per phase at most, each with its scratch; fixed, so that nothing depends on the number of
/// threads.
const TASKS: usize = 32;

/// A trial displacement under which a point has no admissible state.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("material point {point} would be inverted (det ΔF = {determinant:e})")]
pub struct InvertedPoint {
    /// Index of the point in its body.
    pub point: usize,
    /// `det ΔF` of the trial; not a number where the trial itself was not finite.
    pub determinant: f64,
}

/// What a pass adds to: nodal forces, and where wanted the tangent.
pub struct Sums<'a, const D: usize> {
    /// `fⁱⁿᵗ_v` of every active node `[F]`.
    pub internal: &'a mut [Vector<D>],
    /// The tangent.
    pub tangent: Option<TangentSums<'a, D>>,
}

/// Tangent values, and optionally the product of the tangent with prescribed increments.
pub struct TangentSums<'a, const D: usize> {
    /// One value per entry of the [`Pattern`] `[F/L]`.
    pub values: &'a mut [f64],
    /// `Σ_w K_vw Δū_w` of the prescribed increments of the [`Constraints`], where asked for `[F]`.
    pub lift: Option<&'a mut [Vector<D>]>,
}

/// What a pass reads besides the points.
#[derive(Clone, Copy)]
pub struct PassInput<'a, const D: usize> {
    /// Nodes of the tangent.
    pub pattern: &'a Pattern<D>,
    /// Prescribed components: their rows and columns get nothing but the diagonal.
    pub constraints: &'a Constraints<D>,
    /// Trial displacement `Δu_v` of every active node `[L]`.
    pub increment: &'a [Vector<D>],
}

/// Connectivity of a body in a load step, with what makes sums over it quick.
#[derive(Debug)]
pub struct Connection<const D: usize> {
    links: Links<D>,
    dilatation: Option<Dilatation<D>>,
    sums: Summation<D>,
}

/// What sums over a body's points need; the same for all links that connect the same points and nodes.
#[derive(Debug)]
struct Summation<const D: usize> {
    strips: Strips,
    slots: Vec<u32>,
    /// Start of the slots of every support, or cell where there is mean dilatation.
    slot_start: Vec<usize>,
    /// One for each task of a phase.
    scratch: Vec<Mutex<Scratch<D>>>,
}

impl<const D: usize> Connection<D> {
    /// Prepares sums over `linked` points into `pattern`.
    pub fn new(linked: impl Into<Linked<D>>, pattern: &Pattern<D>) -> Self {
        let linked = linked.into();
        let strips = Strips::of(&linked);
        let slots = pattern.slots(&linked);
        let mut slot_start = Vec::with_capacity(linked.n_sets());
        let (mut at, mut most_nodes) = (0, 0);
        for set in 0..linked.n_sets() {
            let n = linked.set(set).len();
            slot_start.push(at);
            at += n * n.saturating_sub(1) / 2;
            most_nodes = most_nodes.max(n);
        }
        let tasks = strips.phases()[0].len().clamp(1, TASKS);
        let scratch = (0..tasks).map(|_| Mutex::new(Scratch::new(most_nodes))).collect();
        let Linked { links, dilatation } = linked;
        Self { links, dilatation, sums: Summation { strips, slots, slot_start, scratch } }
    }

    /// Whether the same points have the same nodes in `linked`, and nothing else couples them.
    pub fn is_connected_as(&self, linked: &Linked<D>) -> bool {
        self.dilatation.is_none() && linked.dilatation.is_none() && self.links.is_connected_as(&linked.links)
    }

    /// Sums over `links`, which connect the same points and nodes as the present ones, into the same
    /// pattern.
    pub fn relinked(self, links: Links<D>) -> Self {
        debug_assert!(links.is_connected_as(&self.links), "the same points and nodes");
        Self { links, ..self }
    }

    /// Groups of points and their influences.
    pub fn links(&self) -> &Links<D> {
        &self.links
    }

    /// Cells over which volume changes are averaged, where they are.
    pub fn dilatation(&self) -> Option<&Dilatation<D>> {
        self.dilatation.as_ref()
    }

    /// Bytes of all that is kept.
    pub fn bytes(&self) -> usize {
        self.links.bytes() + size_of_val(&self.sums.slots[..]) + size_of_val(&self.sums.slot_start[..])
    }
}

/// Memory for the [`Dense`] sums of a support, reused from support to support.
#[derive(Debug)]
struct Scratch<const D: usize> {
    increment: Vec<Vector<D>>,
    force: Vec<Vector<D>>,
    gradient: Vec<Vector<D>>,
    tangent: Vec<Block<D>>,
}

impl<const D: usize> Scratch<D> {
    fn new(most_nodes: usize) -> Self {
        Self {
            increment: vec![Vector::zeros(); most_nodes],
            force: vec![Vector::zeros(); most_nodes],
            gradient: vec![Vector::zeros(); most_nodes],
            tangent: vec![Block::zeros(); most_nodes * (most_nodes + 1) / 2],
        }
    }
}

/// The dense sums of a support, and what its points need of its nodes.
struct Dense<'a, const D: usize> {
    increment: &'a mut [Vector<D>],
    force: &'a mut [Vector<D>],
    gradient: &'a mut [Vector<D>],
    /// Blocks (row node ≥ column node), column by column; none where no tangent is wanted.
    tangent: &'a mut [Block<D>],
}

/// The parts of the global arrays that some strips write to.
struct Part<'a, const D: usize> {
    /// The first of its nodes.
    node: usize,
    internal: &'a mut [Vector<D>],
    /// Empty where no tangent is wanted.
    values: &'a mut [f64],
    /// Empty where it is not wanted.
    lift: &'a mut [Vector<D>],
}

impl<const D: usize> Part<'_, D> {
    /// The parts before and from `node` on.
    fn split_at(self, node: usize, pattern: &Pattern<D>) -> (Self, Self) {
        let nodes = node - self.node;
        let entries = pattern.column_start()[node * D] - pattern.column_start()[self.node * D];
        let (internal, internal_rest) = self.internal.split_at_mut(nodes);
        let (values, values_rest) = self.values.split_at_mut(entries.min(self.values.len()));
        let (lift, lift_rest) = self.lift.split_at_mut(nodes.min(self.lift.len()));
        (
            Self { node: self.node, internal, values, lift },
            Self { node, internal: internal_rest, values: values_rest, lift: lift_rest },
        )
    }
}

/// Adds a body's internal force, and its tangent where `sums` has one.
///
/// Returns the smallest `det ΔF` of its points.
///
/// # Errors
/// The first point (in order) that the trial displacement inverts or that is not finite; `sums` is
/// then meaningless.
pub fn assemble<const D: usize, B: Basis<D>, M: Material>(
    law: &M,
    points: &Points<D, B, M>,
    connection: &Connection<D>,
    input: PassInput<'_, D>,
    sums: Sums<'_, D>,
) -> Result<f64, InvertedPoint> {
    let Sums { internal, mut tangent } = sums;
    let pass = Pass { law, points, connection, input };
    let mut smallest = f64::INFINITY;
    for strips in connection.sums.strips.phases() {
        let (mut values, mut lift): (&mut [f64], &mut [Vector<D>]) = (&mut [], &mut []);
        if let Some(tangent) = &mut tangent {
            values = &mut *tangent.values;
            lift = tangent.lift.as_deref_mut().unwrap_or_default();
        }
        let wants_tangent = !values.is_empty();
        let part = Part { node: 0, internal: &mut *internal, values, lift };
        let scratch = &connection.sums.scratch[..];
        smallest = smallest.min(if wants_tangent {
            pass.sum::<true>(strips, scratch, part)?
        } else {
            pass.sum::<false>(strips, scratch, part)?
        });
    }
    Ok(smallest)
}

/// What all tasks of a pass read.
struct Pass<'a, const D: usize, B: Basis<D>, M: Material> {
    law: &'a M,
    points: &'a Points<D, B, M>,
    connection: &'a Connection<D>,
    input: PassInput<'a, D>,
}

impl<const D: usize, B: Basis<D>, M: Material> Pass<'_, D, B, M> {
    /// Sums strips, halving the list until there is one task for each scratch.
    fn sum<const TANGENT: bool>(
        &self,
        strips: &[Strip],
        scratch: &[Mutex<Scratch<D>>],
        mut part: Part<'_, D>,
    ) -> Result<f64, InvertedPoint> {
        if scratch.len() > 1 && strips.len() > 1 {
            let (low, high) = strips.split_at(strips.len() / 2);
            let (low_scratch, high_scratch) = scratch.split_at(scratch.len() / 2);
            let (low_part, high_part) = part.split_at(high[0].nodes.start, self.input.pattern);
            let (low, high) = rayon::join(
                || self.sum::<TANGENT>(low, low_scratch, low_part),
                || self.sum::<TANGENT>(high, high_scratch, high_part),
            );
            return Ok(low?.min(high?));
        }
        // What a task that panicked has left is overwritten.
        let mut scratch = scratch[0].lock().unwrap_or_else(PoisonError::into_inner);
        let positions = strips.iter().flat_map(|strip| strip.sets.clone());
        let sets = positions.map(|position| self.connection.sums.strips.set(position));
        let mut smallest = f64::INFINITY;
        match &self.connection.dilatation {
            None => {
                for support in sets {
                    smallest = smallest.min(self.sum_support::<TANGENT>(support, &mut scratch, &mut part)?);
                }
            }
            Some(dilatation) => {
                let Self { law, points, connection, input } = *self;
                let links = &connection.links;
                let dilated = Dilated { law, points, links, dilatation, increment: input.increment };
                let mut of_cell = dilatation::Scratch::default();
                let Scratch { force, tangent, .. } = &mut *scratch;
                for cell in sets {
                    let nodes = dilatation.cells().nodes(cell);
                    let n = nodes.len();
                    let force = &mut force[..n];
                    let tangent = if TANGENT { &mut tangent[..n * (n + 1) / 2] } else { &mut [] };
                    smallest = smallest.min(dilated.sum::<TANGENT>(cell, force, tangent, &mut of_cell)?);
                    self.scatter::<TANGENT>(nodes, cell, force, tangent, &mut part);
                }
            }
        }
        Ok(smallest)
    }

    /// Adds the dense sums of set `set` of nodes to the global arrays.
    #[inline(always)]
    fn scatter<const TANGENT: bool>(
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
        if TANGENT {
            if !part.lift.is_empty() {
                add_lift(nodes, tangent, self.input.constraints, part);
            }
            let sums = &self.connection.sums;
            add_tangent(nodes, &sums.slots[sums.slot_start[set]..], tangent, self.input, part);
        }
    }

    /// Sums the points of a support and adds the sum to the global arrays.
    #[inline]
    fn sum_support<const TANGENT: bool>(
        &self,
        support: usize,
        scratch: &mut Scratch<D>,
        part: &mut Part<'_, D>,
    ) -> Result<f64, InvertedPoint> {
        let n = self.connection.links.support_nodes(support).len();
        let Scratch { increment, force, gradient, tangent } = scratch;
        let pairs = if TANGENT { n * (n + 1) / 2 } else { 0 };
        let dense = Dense {
            increment: &mut increment[..n],
            force: &mut force[..n],
            gradient: &mut gradient[..n],
            tangent: &mut tangent[..pairs],
        };
        // The commonest supports are compiled with their size known.
        match n {
            4 => self.sum_dense::<TANGENT>(4, support, dense, part),
            8 => self.sum_dense::<TANGENT>(8, support, dense, part),
            9 => self.sum_dense::<TANGENT>(9, support, dense, part),
            n => self.sum_dense::<TANGENT>(n, support, dense, part),
        }
    }

    /// Sums the points of a support of `n` nodes densely and adds the sum to the global arrays.
    #[inline(always)]
    fn sum_dense<const TANGENT: bool>(
        &self,
        n: usize,
        support: usize,
        mut dense: Dense<'_, D>,
        part: &mut Part<'_, D>,
    ) -> Result<f64, InvertedPoint> {
        let Self { connection, input, .. } = *self;
        let nodes = connection.links.support_nodes(support);
        for (du, node) in dense.increment.iter_mut().zip(nodes) {
            *du = input.increment[*node as usize];
        }
        dense.force.fill(Vector::zeros());
        dense.tangent.fill(Block::zeros());
        let mut smallest = f64::INFINITY;
        for &group in connection.links.support_groups(support) {
            let group = connection.links.group(group as usize);
            let least = sum_group::<D, B, M, TANGENT>(n, self.law, self.points, group, &mut dense)?;
            smallest = smallest.min(least);
        }
        self.scatter::<TANGENT>(nodes, support, dense.force, dense.tangent, part);
        Ok(smallest)
    }
}

/// Adds the points of a group to the dense sums; returns the smallest `det ΔF`.
#[inline(always)]
fn sum_group<const D: usize, B: Basis<D>, M: Material, const TANGENT: bool>(
    n: usize,
    law: &M,
    points: &Points<D, B, M>,
    group: Group<'_, D>,
    dense: &mut Dense<'_, D>,
) -> Result<f64, InvertedPoint> {
    let du = &dense.increment[..n];
    let force = &mut dense.force[..n];
    let g = &mut dense.gradient[..n];
    let tangent = if TANGENT { &mut dense.tangent[..n * (n + 1) / 2] } else { &mut [] };

    let mut smallest = f64::INFINITY;
    for k in 0..group.points {
        let p = group.first_point + k;
        let gradients = &group.gradients[k * n..(k + 1) * n];
        let trial = trial(law, points, p, du, gradients)?;
        smallest = smallest.min(trial.determinant);

        let volume = points.reference_volume[p];
        let stress = block::<D>(&trial.response.kirchhoff) * volume;
        for ((g, force), gradient) in g.iter_mut().zip(&mut *force).zip(gradients) {
            *g = trial.inverse.tr_mul(gradient);
            *force += stress * *g;
        }
        if TANGENT {
            let a = trial.response.modes.spatial_tangent::<D>();
            let mut at = 0;
            for w in 0..n {
                // half[k](i, j) = V⁰ a_ikjl g_w,l
                let weighted = g[w] * volume;
                let half: [Block<D>; D] = std::array::from_fn(|k| {
                    let mut sum = a[k][0] * weighted[0];
                    for l in 1..D {
                        sum += a[k][l] * weighted[l];
                    }
                    sum
                });
                for (sum, g) in tangent[at..].iter_mut().zip(&g[w..]) {
                    for k in 0..D {
                        *sum += half[k] * g[k];
                    }
                }
                at += n - w;
            }
        }
    }
    Ok(smallest)
}

/// State of one point under a trial displacement: a pure function of its committed state.
pub(crate) struct Trial<const D: usize, H> {
    /// `ΔF`.
    pub step: Block<D>,
    /// `ΔF⁻¹`.
    pub inverse: Block<D>,
    /// `det ΔF`.
    pub determinant: f64,
    pub response: Response<H>,
}

/// Kinematics and law of point `p`; `du` and `gradients` run over the nodes of its group.
#[inline(always)]
pub(crate) fn trial<const D: usize, B: Basis<D>, M: Material>(
    law: &M,
    points: &Points<D, B, M>,
    p: usize,
    du: &[Vector<D>],
    gradients: &[Vector<D>],
) -> Result<Trial<D, M::History>, InvertedPoint> {
    trial_of(law, points, p, gradient(du, gradients))
}

/// As [`trial`], of a displacement gradient.
#[inline(always)]
pub(crate) fn trial_of<const D: usize, B: Basis<D>, M: Material>(
    law: &M,
    points: &Points<D, B, M>,
    p: usize,
    h: Block<D>,
) -> Result<Trial<D, M::History>, InvertedPoint> {
    let step = Block::identity() + h;
    let (inverse, determinant) = inverse_and_determinant(&step);
    // Written so that a trial that is not a number is refused as well.
    if !(determinant > 0.0 && determinant.is_finite()) {
        return Err(InvertedPoint { point: p, determinant });
    }
    let response = respond(law, &trial_excess(&h, &points.elastic_excess[p]), &points.history[p]);
    Ok(Trial { step, inverse, determinant, response })
}

/// `lift_v += K_vw Δū_w` for the support's nodes with prescribed increments.
fn add_lift<const D: usize>(
    nodes: &[u32],
    tangent: &[Block<D>],
    constraints: &Constraints<D>,
    part: &mut Part<'_, D>,
) {
    let lifted = |v: usize| constraints.increment()[nodes[v] as usize];
    if (0..nodes.len()).all(|v| lifted(v) == Vector::<D>::zeros()) {
        return;
    }
    let base = part.node;
    let mut at = 0;
    for w in 0..nodes.len() {
        for v in w..nodes.len() {
            part.lift[nodes[v] as usize - base] += tangent[at] * lifted(w);
            if v > w {
                part.lift[nodes[w] as usize - base] += tangent[at].tr_mul(&lifted(v));
            }
            at += 1;
        }
    }
}

/// Adds a support's dense tangent to the stored lower triangle, leaving out what is prescribed.
#[inline]
fn add_tangent<const D: usize>(
    nodes: &[u32],
    slots: &[u32],
    tangent: &[Block<D>],
    input: PassInput<'_, D>,
    part: &mut Part<'_, D>,
) {
    let columns = input.pattern.column_start();
    let base = columns[part.node * D];
    let (mut at, mut slot) = (0, 0);
    for w in 0..nodes.len() {
        let column_node = nodes[w] as usize;
        let column_mask = input.constraints.mask(column_node);
        let starts: [usize; D] = std::array::from_fn(|j| columns[column_node * D + j] - base);

        let diagonal = &tangent[at];
        at += 1;
        for (j, start) in starts.iter().enumerate() {
            for i in j..D {
                // A prescribed component keeps its own stiffness, alone in its row and column.
                let coupled = column_mask & (1 << i | 1 << j) == 0;
                if i == j || coupled {
                    part.values[start + i - j] += diagonal[(i, j)];
                }
            }
        }
        for &node in &nodes[w + 1..] {
            let block = &tangent[at];
            let row = slots[slot] as usize * D;
            at += 1;
            slot += 1;
            let row_mask = input.constraints.mask(node as usize);
            if row_mask | column_mask == 0 {
                for (j, start) in starts.iter().enumerate() {
                    let start = start + (D - j) + row;
                    for (value, add) in part.values[start..start + D].iter_mut().zip(block.column(j).iter()) {
                        *value += add;
                    }
                }
            } else {
                for j in (0..D).filter(|j| column_mask & (1 << j) == 0) {
                    let start = starts[j] + (D - j) + row;
                    for i in (0..D).filter(|i| row_mask & (1 << i) == 0) {
                        part.values[start + i] += block[(i, j)];
                    }
                }
            }
        }
    }
}

/// Makes the diagonal of every prescribed component positive: its own stiffness where it has one,
/// so that the scale of the pivots is that of the problem.
pub fn finish_tangent<const D: usize>(pattern: &Pattern<D>, constraints: &Constraints<D>, values: &mut [f64]) {
    for node in 0..constraints.n_nodes() {
        for i in (0..D).filter(|&i| constraints.is_prescribed(node, i)) {
            let value = &mut values[pattern.column_start()[node * D + i]];
            *value = if *value == 0.0 { 1.0 } else { value.abs() };
        }
    }
}

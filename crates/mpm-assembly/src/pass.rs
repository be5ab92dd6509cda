//! One pass over the points of a body: internal force, and the tangent where it is wanted.
//!
//! Per point (method of Wang et al. 2018, slides 5-8; Charlton, Coombs & Augarde 2017):
//!
//! * `ΔF = I + Σ_v Δu_v ⊗ ∇S_vp`, `b_tr = ΔF b_e,n ΔFᵀ`, the law gives `τ` and its tangent `a`,
//! * `g_vp = ΔF⁻ᵀ ∇S_vp`,
//! * `fⁱⁿᵗ_v = Σ_p V⁰_p τ_p g_vp` (the same as `σ V` with `V = J V⁰`),
//! * `K_vw = Σ_p V⁰_p g_vp · a_p · g_wp`.
//!
//! Points of a group share their nodes: they are summed densely, and the group's sum is added to the
//! global arrays once. The strips of [`crate::strips`] fix the order of all sums.

use crate::dilatation::{self, Dilated};
use crate::kinematics::{block, gradient, inverse_and_determinant, trial_excess};
use crate::strips::{Strip, Strips};
use crate::{Constraints, Couplings, Dilatation, Linked, Pattern, Points};
use mpm_basis::{Basis, Group, Links};
use mpm_grid::{Block, Vector};
use mpm_material::{Material, Response, respond};
use rayon::prelude::*;

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
#[derive(Clone, Debug)]
pub struct Connection<const D: usize> {
    links: Links<D>,
    strips: Strips,
    slots: Vec<u32>,
    /// Start of the slots of every group, or cell where there is mean dilatation.
    slot_start: Vec<usize>,
    most_nodes: usize,
    dilatation: Option<Dilatation<D>>,
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
        let Linked { links, dilatation } = linked;
        Self { links, strips, slots, slot_start, most_nodes, dilatation }
    }

    /// Groups of points and their influences.
    pub fn links(&self) -> &Links<D> {
        &self.links
    }

    /// Cells over which volume changes are averaged, where they are.
    pub fn dilatation(&self) -> Option<&Dilatation<D>> {
        self.dilatation.as_ref()
    }
}

/// Dense sums of one group, reused from group to group.
struct Scratch<const D: usize> {
    increment: Vec<Vector<D>>,
    force: Vec<Vector<D>>,
    gradient: Vec<Vector<D>>,
    /// Blocks (row node ≥ column node), column by column.
    tangent: Vec<Block<D>>,
}

impl<const D: usize> Scratch<D> {
    fn new(most_nodes: usize, tangent: bool) -> Self {
        let blocks = if tangent { most_nodes * (most_nodes + 1) / 2 } else { 0 };
        Self {
            increment: vec![Vector::zeros(); most_nodes],
            force: vec![Vector::zeros(); most_nodes],
            gradient: vec![Vector::zeros(); most_nodes],
            tangent: vec![Block::zeros(); blocks],
        }
    }
}

/// The parts of the global arrays that one strip writes to.
struct StripSums<'a, const D: usize> {
    strip: &'a Strip,
    internal: &'a mut [Vector<D>],
    values: &'a mut [f64],
    lift: &'a mut [Vector<D>],
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
    let (mut values, mut lift): (&mut [f64], &mut [Vector<D>]) = (&mut [], &mut []);
    let wants_tangent = sums.tangent.is_some();
    if let Some(tangent) = sums.tangent {
        values = tangent.values;
        lift = tangent.lift.unwrap_or_default();
    }
    let work = |part: StripSums<'_, D>| match (&connection.dilatation, wants_tangent) {
        (None, true) => sum_strip::<D, B, M, true>(law, points, connection, input, part),
        (None, false) => sum_strip::<D, B, M, false>(law, points, connection, input, part),
        (Some(dilatation), wants_tangent) => {
            let links = &connection.links;
            let dilated = Dilated { law, points, links, dilatation, increment: input.increment };
            if wants_tangent {
                sum_cells::<D, B, M, true>(&dilated, connection, input, part)
            } else {
                sum_cells::<D, B, M, false>(&dilated, connection, input, part)
            }
        }
    };

    let mut smallest = f64::INFINITY;
    for phase in connection.strips.phases() {
        let parts = split(phase, input.pattern, &mut *sums.internal, &mut *values, &mut *lift);
        let results: Vec<Result<f64, InvertedPoint>> = if parts.len() == 1 {
            parts.into_iter().map(work).collect()
        } else {
            parts.into_par_iter().map(work).collect()
        };
        for result in results {
            smallest = smallest.min(result?);
        }
    }
    Ok(smallest)
}

/// Hands every strip of a phase its own part of the arrays.
fn split<'a, 's: 'a, const D: usize>(
    phase: impl Iterator<Item = &'s Strip>,
    pattern: &Pattern<D>,
    mut internal: &'a mut [Vector<D>],
    mut values: &'a mut [f64],
    mut lift: &'a mut [Vector<D>],
) -> Vec<StripSums<'a, D>> {
    let (has_values, has_lift) = (!values.is_empty(), !lift.is_empty());
    let mut parts = Vec::new();
    let (mut node_base, mut value_base) = (0, 0);
    for strip in phase {
        let cut = |array: &mut &'a mut [Vector<D>]| {
            let (_, rest) = std::mem::take(array).split_at_mut(strip.nodes.start - node_base);
            let (part, rest) = rest.split_at_mut(strip.nodes.len());
            *array = rest;
            part
        };
        let internal_part = cut(&mut internal);
        let lift_part = if has_lift { cut(&mut lift) } else { Default::default() };
        let mut values_part: &mut [f64] = Default::default();
        if has_values {
            let first = pattern.column_start()[strip.nodes.start * D];
            let end = pattern.column_start()[strip.nodes.end * D];
            let (_, rest) = std::mem::take(&mut values).split_at_mut(first - value_base);
            let (part, rest) = rest.split_at_mut(end - first);
            values_part = part;
            values = rest;
            value_base = end;
        }
        node_base = strip.nodes.end;
        parts.push(StripSums { strip, internal: internal_part, values: values_part, lift: lift_part });
    }
    parts
}

fn sum_strip<const D: usize, B: Basis<D>, M: Material, const TANGENT: bool>(
    law: &M,
    points: &Points<D, B, M>,
    connection: &Connection<D>,
    input: PassInput<'_, D>,
    mut part: StripSums<'_, D>,
) -> Result<f64, InvertedPoint> {
    let mut scratch = Scratch::new(connection.most_nodes, TANGENT);
    let mut smallest = f64::INFINITY;
    for position in part.strip.groups.clone() {
        let group = connection.strips.group(position);
        let view = connection.links.group(group);
        // The two commonest supports are compiled with their size known.
        let determinant = match view.nodes.len() {
            4 => sum_group::<D, B, M, TANGENT>(4, law, points, view, input.increment, &mut scratch)?,
            8 => sum_group::<D, B, M, TANGENT>(8, law, points, view, input.increment, &mut scratch)?,
            n => sum_group::<D, B, M, TANGENT>(n, law, points, view, input.increment, &mut scratch)?,
        };
        smallest = smallest.min(determinant);
        scatter::<D, TANGENT>(view.nodes, group, connection, input, &scratch, &mut part);
    }
    Ok(smallest)
}

/// As [`sum_strip`], by cells with mean dilatation.
fn sum_cells<const D: usize, B: Basis<D>, M: Material, const TANGENT: bool>(
    dilated: &Dilated<'_, D, B, M>,
    connection: &Connection<D>,
    input: PassInput<'_, D>,
    mut part: StripSums<'_, D>,
) -> Result<f64, InvertedPoint> {
    let mut scratch = Scratch::new(connection.most_nodes, TANGENT);
    let mut of_cell = dilatation::Scratch::default();
    let mut smallest = f64::INFINITY;
    for position in part.strip.groups.clone() {
        let cell = connection.strips.group(position);
        let nodes = dilated.dilatation.cells().nodes(cell);
        let n = nodes.len();
        let force = &mut scratch.force[..n];
        let tangent = if TANGENT { &mut scratch.tangent[..n * (n + 1) / 2] } else { &mut [] };
        let determinant = dilated.sum::<TANGENT>(cell, force, tangent, &mut of_cell)?;
        smallest = smallest.min(determinant);
        scatter::<D, TANGENT>(nodes, cell, connection, input, &scratch, &mut part);
    }
    Ok(smallest)
}

/// Adds the dense sums of set `set` of nodes to the global arrays.
#[inline(always)]
fn scatter<const D: usize, const TANGENT: bool>(
    nodes: &[u32],
    set: usize,
    connection: &Connection<D>,
    input: PassInput<'_, D>,
    scratch: &Scratch<D>,
    part: &mut StripSums<'_, D>,
) {
    for (node, force) in nodes.iter().zip(&scratch.force) {
        part.internal[*node as usize - part.strip.nodes.start] += force;
    }
    if TANGENT {
        if !part.lift.is_empty() {
            add_lift(nodes, &scratch.tangent, input.constraints, part);
        }
        add_tangent(nodes, &connection.slots[connection.slot_start[set]..], &scratch.tangent, input, part);
    }
}

/// Sums the points of a group into the scratch; returns the smallest `det ΔF`.
#[inline(always)]
fn sum_group<const D: usize, B: Basis<D>, M: Material, const TANGENT: bool>(
    n: usize,
    law: &M,
    points: &Points<D, B, M>,
    group: Group<'_, D>,
    increment: &[Vector<D>],
    scratch: &mut Scratch<D>,
) -> Result<f64, InvertedPoint> {
    let du = &mut scratch.increment[..n];
    let force = &mut scratch.force[..n];
    let g = &mut scratch.gradient[..n];
    for (du, node) in du.iter_mut().zip(&group.nodes[..n]) {
        *du = increment[*node as usize];
    }
    force.fill(Vector::zeros());
    let tangent = if TANGENT { &mut scratch.tangent[..n * (n + 1) / 2] } else { &mut [] };
    tangent.fill(Block::zeros());

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
            let mut a = trial.response.modes.spatial_tangent::<D>();
            for row in &mut a {
                for entry in row {
                    *entry *= volume;
                }
            }
            let mut at = 0;
            for w in 0..n {
                // half[k](i, j) = a_ikjl g_w,l
                let half: [Block<D>; D] = std::array::from_fn(|k| {
                    let mut sum = Block::zeros();
                    for l in 0..D {
                        sum += a[k][l] * g[w][l];
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

/// `lift_v += K_vw Δū_w` for the group's nodes with prescribed increments.
fn add_lift<const D: usize>(
    nodes: &[u32],
    tangent: &[Block<D>],
    constraints: &Constraints<D>,
    part: &mut StripSums<'_, D>,
) {
    let lifted = |v: usize| constraints.increment()[nodes[v] as usize];
    if (0..nodes.len()).all(|v| lifted(v) == Vector::<D>::zeros()) {
        return;
    }
    let base = part.strip.nodes.start;
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

/// Adds a group's dense tangent to the stored lower triangle, leaving out what is prescribed.
#[inline]
fn add_tangent<const D: usize>(
    nodes: &[u32],
    slots: &[u32],
    tangent: &[Block<D>],
    input: PassInput<'_, D>,
    part: &mut StripSums<'_, D>,
) {
    let columns = input.pattern.column_start();
    let base = columns[part.strip.nodes.start * D];
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

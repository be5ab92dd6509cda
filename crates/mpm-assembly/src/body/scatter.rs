//! From the dense sums of a set of nodes to the global arrays.

use crate::body::node_blocks::NodeBlocks;
use crate::unknowns::{Constraints, SparsityPattern, node_equation};
use mpm_grid::{Block, Vector};
use mpm_linear::Symmetry;

/// What a pass adds to: nodal forces, and where wanted the tangent. Only bodies under a nodal field add to what belongs to
/// no node's displacement, so that it may be empty for others.
pub struct Sums<'a, const D: usize> {
    /// `fⁱⁿᵗ_v` of every active node `[F]`.
    pub internal: &'a mut [Vector<D>],
    /// Residuals of the other unknowns.
    pub own: &'a mut [f64],
    /// The tangent.
    pub tangent: Option<TangentSums<'a, D>>,
}

/// Tangent values, and optionally the product of the tangent with prescribed increments.
pub struct TangentSums<'a, const D: usize> {
    /// One value per entry of the [`SparsityPattern`] `[F/L]`.
    pub values: &'a mut [f64],
    /// `Σ_w K_vw Δū_w` of the prescribed increments of the [`Constraints`], where asked for `[F]`.
    pub lift: Option<&'a mut [Vector<D>]>,
    /// The same product in the equations of the other unknowns; empty where it is not asked for.
    pub own_lift: &'a mut [f64],
}

/// What a pass reads besides the points.
#[derive(Clone, Copy)]
pub struct PassInput<'a, const D: usize> {
    /// Nodes of the tangent.
    pub pattern: &'a SparsityPattern<D>,
    /// Prescribed components: their rows and columns get nothing but the diagonal.
    pub constraints: &'a Constraints<D>,
    /// Trial displacement `Δu_v` of every active node `[L]`.
    pub increment: &'a [Vector<D>],
    /// Trial values of the other unknowns; only bodies under a nodal field read them.
    pub own: &'a [f64],
}

/// The parts of the global arrays that some strips write to.
pub(crate) struct Part<'a, const D: usize> {
    /// The first of its nodes.
    pub node: usize,
    pub internal: &'a mut [Vector<D>],
    /// Empty where no tangent is wanted.
    pub values: &'a mut [f64],
    /// Empty where it is not wanted.
    pub lift: &'a mut [Vector<D>],
}

impl<const D: usize> Part<'_, D> {
    /// The parts before and from `node` on.
    pub fn split_at(self, node: usize, pattern: &SparsityPattern<D>) -> (Self, Self) {
        let nodes = node - self.node;
        let start = |node| pattern.column_start()[node_equation::<D>(node, 0)];
        let entries = start(node) - start(self.node);
        let (internal, internal_rest) = self.internal.split_at_mut(nodes);
        let (values, values_rest) = self.values.split_at_mut(entries.min(self.values.len()));
        let (lift, lift_rest) = self.lift.split_at_mut(nodes.min(self.lift.len()));
        (
            Self { node: self.node, internal, values, lift },
            Self { node, internal: internal_rest, values: values_rest, lift: lift_rest },
        )
    }
}

/// The dense tangent of a set of nodes, blocks (row node, column node) column by column.
#[derive(Clone, Copy)]
pub(crate) enum DenseTangent<'a, const D: usize> {
    /// The rows from the diagonal down, of a law with a symmetric tangent.
    Lower(&'a [Block<D>]),
    /// All rows.
    All(&'a [Block<D>]),
    /// As [`Self::Lower`], as it is summed with nodes side by side.
    LowerOfNodes(NodeBlocks<'a, D>),
    /// As [`Self::All`], as it is summed with nodes side by side.
    AllOfNodes(NodeBlocks<'a, D>),
}

/// A pass sums the force only.
pub(crate) const FORCE: u8 = 0;
/// A pass sums the [lower](DenseTangent::Lower) blocks of the tangent, too.
pub(crate) const LOWER: u8 = 1;
/// A pass sums [all](DenseTangent::All) blocks of the tangent, too.
pub(crate) const ALL: u8 = 2;

/// Number of dense blocks that a pass sums for `n` nodes.
#[inline(always)]
pub(crate) const fn n_blocks<const TANGENT: u8>(n: usize) -> usize {
    match TANGENT {
        FORCE => 0,
        LOWER => n * (n + 1) / 2,
        _ => n * n,
    }
}

/// Position of the block of the nodes `v` and `w` of `n`, in row v of column w, among [`n_blocks`] blocks.
#[inline(always)]
pub(crate) const fn block_position<const TANGENT: u8>(n: usize, v: u32, w: u32) -> usize {
    let (v, w) = (v as usize, w as usize);
    match TANGENT {
        LOWER => w * n - w * (w + 1) / 2 + v,
        _ => w * n + v,
    }
}

impl<'a, const D: usize> DenseTangent<'a, D> {
    /// The blocks that a pass has summed.
    #[inline(always)]
    pub fn of<const TANGENT: u8>(blocks: &'a [Block<D>]) -> Self {
        if TANGENT == LOWER { Self::Lower(blocks) } else { Self::All(blocks) }
    }

    /// The blocks that a pass has summed with nodes side by side.
    #[inline(always)]
    pub fn of_nodes<const TANGENT: u8>(blocks: NodeBlocks<'a, D>) -> Self {
        if TANGENT == LOWER { Self::LowerOfNodes(blocks) } else { Self::AllOfNodes(blocks) }
    }

    /// Whether the rows above the diagonal follow from the others.
    #[inline(always)]
    fn is_symmetric(&self) -> bool {
        matches!(self, Self::Lower(_) | Self::LowerOfNodes(_))
    }

    /// The block of row node v and column node w of n nodes.
    #[inline(always)]
    fn block(&self, n: usize, v: usize, w: usize) -> Block<D> {
        if v < w && self.is_symmetric() { self.stored(n, w, v).transpose() } else { self.stored(n, v, w) }
    }

    /// The same, from the diagonal down where no other is stored.
    #[inline(always)]
    fn stored(&self, n: usize, v: usize, w: usize) -> Block<D> {
        match self {
            Self::All(blocks) => blocks[w * n + v],
            Self::Lower(blocks) => blocks[w * n - w * (w + 1) / 2 + v],
            Self::LowerOfNodes(blocks) | Self::AllOfNodes(blocks) => blocks.block(v, w),
        }
    }
}

/// `lift_v += K_vw Δū_w` for the set's nodes with prescribed increments.
pub(crate) fn add_lift<const D: usize>(
    nodes: &[u32],
    tangent: DenseTangent<'_, D>,
    constraints: &Constraints<D>,
    part: &mut Part<'_, D>,
) {
    let lifted = |v: usize| constraints.increment()[nodes[v] as usize];
    if (0..nodes.len()).all(|v| lifted(v) == Vector::<D>::zeros()) {
        return;
    }
    let (n, base) = (nodes.len(), part.node);
    if !tangent.is_symmetric() {
        for w in (0..n).filter(|&w| lifted(w) != Vector::<D>::zeros()) {
            for (v, &node) in nodes.iter().enumerate() {
                part.lift[node as usize - base] += tangent.block(n, v, w) * lifted(w);
            }
        }
        return;
    }
    for w in 0..n {
        for v in w..n {
            let block = tangent.block(n, v, w);
            part.lift[nodes[v] as usize - base] += block * lifted(w);
            if v > w {
                part.lift[nodes[w] as usize - base] += block.tr_mul(&lifted(v));
            }
        }
    }
}

/// Adds a set's dense tangent to the stored one, leaving out what is prescribed.
#[inline(always)]
pub(crate) fn add_tangent<const D: usize>(
    nodes: &[u32],
    slots: &[u32],
    tangent: DenseTangent<'_, D>,
    input: PassInput<'_, D>,
    part: &mut Part<'_, D>,
) {
    match input.pattern.symmetry() {
        Symmetry::Symmetric => {
            assert!(tangent.is_symmetric(), "the pattern takes the worst symmetry");
            match tangent {
                DenseTangent::LowerOfNodes(blocks)
                    if nodes.iter().all(|&node| input.constraints.mask(node as usize) == 0) =>
                {
                    add_lower_of_free_nodes(nodes, slots, blocks, input, part);
                }
                _ => add_lower(nodes, slots, tangent, input, part),
            }
        }
        Symmetry::Unsymmetric => add_all(nodes, slots, tangent, input, part),
    }
}

/// As [`add_tangent`], where both triangles are stored.
fn add_all<const D: usize>(
    nodes: &[u32],
    slots: &[u32],
    tangent: DenseTangent<'_, D>,
    input: PassInput<'_, D>,
    part: &mut Part<'_, D>,
) {
    let n = nodes.len();
    let columns = input.pattern.column_start();
    let base = columns[node_equation::<D>(part.node, 0)];
    for (w, &column_node) in nodes.iter().enumerate() {
        let column_node = column_node as usize;
        let column_mask = input.constraints.mask(column_node);
        let starts: [usize; D] = std::array::from_fn(|j| columns[node_equation::<D>(column_node, j)] - base);
        for (v, &row_node) in nodes.iter().enumerate() {
            let block = tangent.block(n, v, w);
            let row = node_equation::<D>(slots[w * n + v] as usize, 0);
            let row_mask = input.constraints.mask(row_node as usize);
            if row_mask | column_mask == 0 {
                for (j, start) in starts.iter().enumerate() {
                    let start = start + row;
                    for (value, add) in part.values[start..start + D].iter_mut().zip(block.column(j).iter()) {
                        *value += add;
                    }
                }
                continue;
            }
            for (j, start) in starts.iter().enumerate() {
                for i in 0..D {
                    // A prescribed component keeps its own stiffness, alone in its row and column.
                    if (v == w && i == j) || (row_mask & (1 << i) == 0 && column_mask & (1 << j) == 0) {
                        part.values[start + row + i] += block[(i, j)];
                    }
                }
            }
        }
    }
}

/// As [`add_tangent`], where the lower triangle is stored. Not inlined, because few sets have nodes that are prescribed.
#[inline(never)]
fn add_lower<const D: usize>(
    nodes: &[u32],
    slots: &[u32],
    tangent: DenseTangent<'_, D>,
    input: PassInput<'_, D>,
    part: &mut Part<'_, D>,
) {
    let columns = input.pattern.column_start();
    let base = columns[node_equation::<D>(part.node, 0)];
    let (n, mut slot) = (nodes.len(), 0);
    for w in 0..n {
        let column_node = nodes[w] as usize;
        let column_mask = input.constraints.mask(column_node);
        let starts: [usize; D] = std::array::from_fn(|j| columns[node_equation::<D>(column_node, j)] - base);

        let diagonal = tangent.stored(n, w, w);
        for (j, start) in starts.iter().enumerate() {
            for i in j..D {
                // A prescribed component keeps its own stiffness, alone in its row and column.
                let coupled = column_mask & (1 << i | 1 << j) == 0;
                if i == j || coupled {
                    part.values[start + i - j] += diagonal[(i, j)];
                }
            }
        }
        for (v, &node) in nodes.iter().enumerate().skip(w + 1) {
            let block = tangent.stored(n, v, w);
            let row = node_equation::<D>(slots[slot] as usize, 0);
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

/// As [`add_lower`], of nodes side by side of which none is prescribed.
#[inline(always)]
fn add_lower_of_free_nodes<const D: usize>(
    nodes: &[u32],
    slots: &[u32],
    blocks: NodeBlocks<'_, D>,
    input: PassInput<'_, D>,
    part: &mut Part<'_, D>,
) {
    let columns = input.pattern.column_start();
    let base = columns[node_equation::<D>(part.node, 0)];
    let mut slots = slots.iter();
    for (w, &column_node) in nodes.iter().enumerate() {
        let starts: [usize; D] =
            std::array::from_fn(|j| columns[node_equation::<D>(column_node as usize, j)] - base);
        let diagonal = blocks.lane(w, w);
        for (j, start) in starts.iter().enumerate() {
            let values = &mut part.values[*start..*start + D - j];
            for (value, add) in values.iter_mut().zip(diagonal.column(j).skip(j)) {
                *value += add;
            }
        }
        for (v, &slot) in (w + 1..nodes.len()).zip(&mut slots) {
            let (row, block) = (node_equation::<D>(slot as usize, 0), blocks.lane(v, w));
            for (j, start) in starts.iter().enumerate() {
                let start = start + (D - j) + row;
                for (value, add) in part.values[start..start + D].iter_mut().zip(block.column(j)) {
                    *value += add;
                }
            }
        }
    }
}

/// Makes the diagonal of every prescribed component positive: its own stiffness where it has one,
/// so that the scale of the pivots is that of the problem; on an axis that of the second component.
pub fn finish_tangent<const D: usize>(
    pattern: &SparsityPattern<D>,
    constraints: &Constraints<D>,
    values: &mut [f64],
) {
    for node in 0..constraints.n_nodes() {
        if constraints.is_on_axis(node) {
            values[pattern.diagonal(node_equation::<D>(node, 0))] =
                values[pattern.diagonal(node_equation::<D>(node, 1))];
        }
        for i in (0..D).filter(|&i| constraints.is_prescribed(node, i)) {
            let value = &mut values[pattern.diagonal(node_equation::<D>(node, i))];
            *value = if *value == 0.0 { 1.0 } else { value.abs() };
        }
    }
}

/// Clears the diagonal of prescribed components of nodes that are not `owned`: where several sum a matrix together, the
/// owner of a node gives it.
pub fn leave_to_owners<const D: usize>(
    pattern: &SparsityPattern<D>,
    constraints: &Constraints<D>,
    values: &mut [f64],
    owned: &[bool],
) {
    for node in (0..constraints.n_nodes()).filter(|&node| !owned[node]) {
        for i in (0..D).filter(|&i| constraints.is_prescribed(node, i)) {
            values[pattern.diagonal(node_equation::<D>(node, i))] = 0.0;
        }
    }
}

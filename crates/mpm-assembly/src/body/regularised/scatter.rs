//! From the dense sums of a set of nodes to the global arrays, with the nodal field.

use super::nodes::FieldNodes;
use super::plan::Offsets;
use crate::body::scatter::{Part, PassInput};
use crate::unknowns::{SparsityPattern, node_equation};
use mpm_grid::Vector;
use mpm_linear::Symmetry;

/// The parts of the global arrays that some strips write to.
pub(super) struct FieldPart<'a, const D: usize> {
    pub nodes: Part<'a, D>,
    /// The first of the field's nodes.
    pub first: usize,
    pub own: &'a mut [f64],
    /// Columns of the field; empty where no tangent is wanted.
    pub values: &'a mut [f64],
    /// Empty where it is not wanted.
    pub lift: &'a mut [f64],
}

impl<const D: usize> FieldPart<'_, D> {
    /// The parts before and from the active node `node` on.
    pub fn split_at(self, node: usize, field: &FieldNodes, pattern: &SparsityPattern<D>) -> (Self, Self) {
        let Self { nodes, first, own, values, lift } = self;
        let (low, high) = nodes.split_at(node, pattern);
        let middle = field.entry(node);
        let start = |entry: usize| pattern.column_start()[field.unknown(0).equation() + entry];
        let entries = start(middle) - start(first);
        let (own, own_rest) = own.split_at_mut(middle - first);
        let (values, values_rest) = values.split_at_mut(entries.min(values.len()));
        let (lift, lift_rest) = lift.split_at_mut((middle - first).min(lift.len()));
        (
            Self { nodes: low, first, own, values, lift },
            Self { nodes: high, first: middle, own: own_rest, values: values_rest, lift: lift_rest },
        )
    }
}

/// Dense blocks of a node set that belong to the field, as in [`super::plan::FieldScratch`].
#[derive(Clone, Copy)]
pub(super) struct DenseField<'a, const D: usize> {
    /// None where all of it is nothing.
    pub mixed: Option<&'a [Vector<D>]>,
    pub tangent: &'a [f64],
}

impl<'a, const D: usize> DenseField<'a, D> {
    /// Rows of the field of all n nodes in the columns of node w.
    #[inline]
    fn mixed(&self, n: usize, w: usize) -> &'a [Vector<D>] {
        self.mixed.map_or(&[], |mixed| &mixed[w * n..(w + 1) * n])
    }
}

/// Adds a set's dense blocks of the field to the tangent, leaving out prescribed displacements.
pub(super) fn add_field_tangent<const D: usize>(
    (nodes, field): (&[u32], &FieldNodes),
    offsets: Offsets<'_>,
    dense: DenseField<'_, D>,
    input: PassInput<'_, D>,
    part: &mut FieldPart<'_, D>,
) {
    let (n, columns) = (nodes.len(), input.pattern.column_start());
    let is_symmetric = input.pattern.symmetry() == Symmetry::Symmetric;
    let base = columns[node_equation::<D>(part.nodes.node, 0)];
    for (w, &node) in nodes.iter().enumerate().filter(|_| dense.mixed.is_some()) {
        let mask = input.constraints.mask(node as usize);
        let rows = &offsets.field_rows[w * n..(w + 1) * n];
        for j in (0..D).filter(|j| mask & (1 << j) == 0) {
            let start = columns[node_equation::<D>(node as usize, j)] - base;
            let column = &mut part.nodes.values[start - if is_symmetric { j } else { 0 }..];
            for (&row, add) in rows.iter().zip(dense.mixed(n, w)) {
                column[row as usize] += add[j];
            }
        }
    }
    let first = field.unknown(0).equation();
    let base = columns[first + part.first];
    let lower = |v: usize, w: usize| w * n - w * (w + 1) / 2 + v;
    let mut at = 0;
    for (w, &node) in nodes.iter().enumerate() {
        let start = columns[first + field.entry(node as usize)] - base;
        for v in if is_symmetric { w } else { 0 }..n {
            let value = dense.tangent[if v >= w { lower(v, w) } else { lower(w, v) }];
            part.values[start + offsets.field_columns[at] as usize] += value;
            at += 1;
        }
        if is_symmetric || dense.mixed.is_none() {
            continue;
        }
        for (v, &node) in nodes.iter().enumerate() {
            let mask = input.constraints.mask(node as usize);
            let row = start + offsets.node_rows[w * n + v] as usize;
            for i in (0..D).filter(|i| mask & (1 << i) == 0) {
                part.values[row + i] += dense.mixed(n, v)[w][i];
            }
        }
    }
}

/// `lift_k += Σ_w K_kw Δū_w` for the set's nodes with prescribed increments.
pub(super) fn add_field_lift<const D: usize>(
    (nodes, field): (&[u32], &FieldNodes),
    dense: DenseField<'_, D>,
    input: PassInput<'_, D>,
    part: &mut FieldPart<'_, D>,
) {
    let n = nodes.len();
    for (w, &node) in nodes.iter().enumerate().filter(|_| dense.mixed.is_some()) {
        let prescribed = input.constraints.increment()[node as usize];
        if prescribed == Vector::<D>::zeros() {
            continue;
        }
        for (&other, mixed) in nodes.iter().zip(dense.mixed(n, w)) {
            part.lift[field.entry(other as usize) - part.first] += mixed.dot(&prescribed);
        }
    }
}

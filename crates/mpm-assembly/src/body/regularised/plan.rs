//! Where the entries of the nodal field stand in the tangent.

use super::nodes::FieldNodes;
use crate::unknowns::{SparsityPattern, node_equation};
use mpm_basis::Connectivity;
use mpm_grid::{Block, Vector};
use mpm_linear::Symmetry;
use std::sync::{Arc, Mutex};

/// Nodal field of a regularised body in a load step.
#[derive(Debug)]
pub(crate) struct FieldPlan<const D: usize> {
    pub nodes: Arc<FieldNodes>,
    /// Of every node set, where entries stand from the start of their column on; see [`Offsets`].
    offsets: Vec<u32>,
    /// Where each set begins in them.
    start: Vec<usize>,
    /// One for each task of a phase.
    pub scratch: Vec<Mutex<FieldScratch<D>>>,
}

/// Offsets of a set of n nodes. A symmetric tangent has none for the rows of displacements in the columns of the field.
#[derive(Clone, Copy)]
pub(super) struct Offsets<'a> {
    /// Row of the field of node v, in the first column of node w: entry w n + v. The first entries of later columns of
    /// a symmetric tangent are missing, so that its offsets are less by the component.
    pub field_rows: &'a [u32],
    /// Row of the field of node v in the column of that of node w; of a symmetric tangent for v ≥ w, column by column,
    /// else entry w n + v.
    pub field_columns: &'a [u32],
    /// First row of node v in the column of the field of node w: entry w n + v.
    pub node_rows: &'a [u32],
}

impl Offsets<'_> {
    /// Row of the field of the v-th of n nodes in the column of the w-th, v ≥ w.
    #[inline]
    pub fn below(&self, w: usize, v: usize, n: usize, symmetry: Symmetry) -> usize {
        let at = match symmetry {
            Symmetry::Symmetric => w * n - w * (w + 1) / 2 + v,
            Symmetry::Unsymmetric => w * n + v,
        };
        self.field_columns[at] as usize
    }
}

impl<const D: usize> FieldPlan<D> {
    /// Finds the entries of a body in a pattern that [couples](FieldNodes::couplings) them; `tasks` are those of a phase.
    pub fn new(
        nodes: Arc<FieldNodes>,
        connectivity: &Connectivity<D>,
        pattern: &SparsityPattern<D>,
        tasks: usize,
    ) -> Self {
        let is_symmetric = pattern.symmetry() == Symmetry::Symmetric;
        let (mut offsets, mut start, mut most_nodes) = (Vec::new(), Vec::new(), 0);
        for set in 0..connectivity.n_node_sets() {
            start.push(offsets.len());
            let set = connectivity.node_set(set);
            most_nodes = most_nodes.max(set.len());
            let field: Vec<usize> =
                set.iter().map(|&node| nodes.unknown(nodes.entry(node as usize)).equation()).collect();
            let first = |node: u32| node_equation::<D>(node as usize, 0);
            let mut push = |row: usize, column: usize| offsets.push(pattern.offset(row, column));
            for &w in set {
                field.iter().for_each(|&v| push(v, first(w)));
            }
            for (w, &column) in field.iter().enumerate() {
                field[if is_symmetric { w } else { 0 }..].iter().for_each(|&v| push(v, column));
            }
            if !is_symmetric {
                for &column in &field {
                    set.iter().for_each(|&v| push(first(v), column));
                }
            }
        }
        let scratch = (0..tasks).map(|_| Mutex::new(FieldScratch::new(most_nodes))).collect();
        Self { nodes, offsets, start, scratch }
    }

    /// Offsets of a set of n nodes.
    #[inline]
    pub(super) fn offsets(&self, set: usize, n: usize, symmetry: Symmetry) -> Offsets<'_> {
        let (field_rows, rest) = self.offsets[self.start[set]..].split_at(n * n);
        match symmetry {
            Symmetry::Symmetric => {
                Offsets { field_rows, field_columns: &rest[..n * (n + 1) / 2], node_rows: &[] }
            }
            Symmetry::Unsymmetric => {
                let (field_columns, rest) = rest.split_at(n * n);
                Offsets { field_rows, field_columns, node_rows: &rest[..n * n] }
            }
        }
    }

    /// Bytes of what is kept.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.offsets[..]) + size_of_val(&self.start[..])
    }
}

/// Memory for the dense sums of a node set, reused from set to set.
#[derive(Debug)]
pub(crate) struct FieldScratch<const D: usize> {
    pub increment: Vec<Vector<D>>,
    /// The field at the nodes.
    pub field: Vec<f64>,
    pub force: Vec<Vector<D>>,
    pub field_force: Vec<f64>,
    pub gradient: Vec<Vector<D>>,
    /// Gradients at rest.
    pub rest_gradient: Vec<Vector<D>>,
    pub tangent: Vec<Block<D>>,
    /// Row of node v, column of the field of node w: entry w n + v.
    pub mixed: Vec<Vector<D>>,
    /// From the diagonal down.
    pub field_tangent: Vec<f64>,
}

impl<const D: usize> FieldScratch<D> {
    fn new(n: usize) -> Self {
        Self {
            increment: vec![Vector::zeros(); n],
            field: vec![0.0; n],
            force: vec![Vector::zeros(); n],
            field_force: vec![0.0; n],
            gradient: vec![Vector::zeros(); n],
            rest_gradient: vec![Vector::zeros(); n],
            tangent: vec![Block::zeros(); n * n],
            mixed: vec![Vector::zeros(); n * n],
            field_tangent: vec![0.0; n * (n + 1) / 2],
        }
    }
}

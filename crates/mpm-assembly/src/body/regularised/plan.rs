//! Where the entries of the nodal field stand in the tangent, and the part of it that no trial changes.

use super::nodes::FieldNodes;
use super::trial::at_rest;
use crate::unknowns::{SparsityPattern, node_equation};
use mpm_basis::Connectivity;
use mpm_grid::{Block, Vector};
use mpm_linear::Symmetry;
use mpm_material::Regularisation;
use std::ops::Range;
use std::sync::{Arc, Mutex};

/// Part ε of the weight `h V⁰ S_v` of a node that stands on the diagonal: without it nothing would determine k at nodes
/// that points barely reach. It acts as a length of at most ½ √ε of a cell would besides l.
const LUMPED: f64 = 1e-3;

/// A point of a regularised body as the field sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldPoint<const D: usize> {
    /// V⁰ `[L^D]`.
    pub volume: f64,
    /// F `[-]`.
    pub deformation_gradient: Block<D>,
    /// d `[-]`.
    pub driver: f64,
    /// By how much the last load step changed d.
    pub driver_step: f64,
}

/// Nodal field of a regularised body in a load step.
#[derive(Debug)]
pub(crate) struct FieldPlan<const D: usize> {
    pub nodes: Arc<FieldNodes>,
    /// Of every node set, where entries stand from the start of their column on; see [`Offsets`].
    offsets: Vec<u32>,
    /// Where each set begins in them.
    start: Vec<usize>,
    /// Of every node set the sum over its points of
    /// `V⁰ [h ((1 − ε) S_v S_w + ε S_v δ_vw) + A Grad S_v · Grad S_w]`, from the diagonal down, column by column.
    helmholtz: Vec<f64>,
    /// Where each set begins in it.
    helmholtz_start: Vec<usize>,
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
        let mut helmholtz_start = vec![0];
        for set in 0..connectivity.n_node_sets() {
            start.push(offsets.len());
            let set = connectivity.node_set(set);
            let n = set.len();
            most_nodes = most_nodes.max(n);
            helmholtz_start.push(helmholtz_start[helmholtz_start.len() - 1] + n * (n + 1) / 2);
            let field: Vec<usize> =
                set.iter().map(|&node| nodes.unknown(nodes.entry(node as usize)).equation()).collect();
            let first = |node: u32| node_equation::<D>(node as usize, 0);
            for &w in set {
                pattern.push_offsets(first(w), &field, &mut offsets);
            }
            for (w, &column) in field.iter().enumerate() {
                pattern.push_offsets(column, &field[if is_symmetric { w } else { 0 }..], &mut offsets);
            }
            if !is_symmetric {
                let displacements: Vec<usize> = set.iter().map(|&node| first(node)).collect();
                field.iter().for_each(|&column| pattern.push_offsets(column, &displacements, &mut offsets));
            }
        }
        let scratch = (0..tasks).map(|_| Mutex::new(FieldScratch::new(most_nodes))).collect();
        Self { nodes, offsets, start, helmholtz: Vec::new(), helmholtz_start, scratch }
    }

    /// Sums what no trial of a load step changes; `point` are the points at its start.
    pub fn begin(
        &mut self,
        connectivity: &Connectivity<D>,
        regularisation: &Regularisation,
        point: impl Fn(usize) -> FieldPoint<D>,
    ) {
        self.helmholtz.clear();
        self.helmholtz.resize(self.helmholtz_start[connectivity.n_node_sets()], 0.0);
        let mut gradients: Vec<Vector<D>> = Vec::new();
        for set in 0..connectivity.n_node_sets() {
            let range = self.range(set);
            let dense = &mut self.helmholtz[range];
            for &group in connectivity.node_set_groups(set) {
                let group = connectivity.group(group as usize);
                for k in 0..group.points {
                    let of = point(group.first_point + k);
                    let (values, slopes) = group.point(k);
                    let modulus = of.volume * regularisation.modulus();
                    let gradient_modulus = of.volume * regularisation.gradient_modulus();
                    gradients.clear();
                    gradients.extend(slopes.iter().map(|slope| at_rest(&of.deformation_gradient, slope)));
                    let mut sums = &mut dense[..];
                    for (w, &value) in values.iter().enumerate() {
                        let (column, rest) = sums.split_at_mut(values.len() - w);
                        let (own, gradient) =
                            ((1.0 - LUMPED) * modulus * value, gradients[w] * gradient_modulus);
                        column[0] += LUMPED * modulus * value;
                        for ((sum, value), other) in column.iter_mut().zip(&values[w..]).zip(&gradients[w..]) {
                            *sum += own * value + gradient.dot(other);
                        }
                        sums = rest;
                    }
                }
            }
        }
    }

    /// See [`Self::helmholtz`].
    fn range(&self, set: usize) -> Range<usize> {
        self.helmholtz_start[set]..self.helmholtz_start[set + 1]
    }

    /// Of a node set, from the diagonal down.
    ///
    /// # Panics
    /// The load step has not [begun](Self::begin).
    #[inline]
    pub(super) fn helmholtz(&self, set: usize) -> &[f64] {
        &self.helmholtz[self.range(set)]
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
        size_of_val(&self.offsets[..])
            + size_of_val(&self.start[..])
            + size_of_val(&self.helmholtz[..])
            + size_of_val(&self.helmholtz_start[..])
    }
}

/// By how much ½ h k² of a point is exceeded by the energy of a field that stands in part on the diagonal, per volume at rest
/// `[F/L²]`.
pub(super) fn lumped_energy(regularisation: &Regularisation, mean_of_squares: f64, value: f64) -> f64 {
    0.5 * LUMPED * regularisation.modulus() * (mean_of_squares - value * value)
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
    pub tangent: Vec<Block<D>>,
    /// Row of the field of node v, columns of node w: entry w n + v.
    pub mixed: Vec<Vector<D>>,
    /// Whether any of them is not nothing.
    pub is_mixed: bool,
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
            tangent: vec![Block::zeros(); n * n],
            mixed: vec![Vector::zeros(); n * n],
            is_mixed: false,
            field_tangent: vec![0.0; n * (n + 1) / 2],
        }
    }
}

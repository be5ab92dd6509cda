//! Connectivity of a body in a load step, with what makes sums over it quick.

use super::body_connectivity::BodyConnectivity;
use super::dilatation::Dilatation;
use super::regularised::{FieldNodes, FieldPlan, FieldPoint};
use crate::body::batch_trial::Batch;
use crate::body::node_sums::NodeSums;
use crate::body::strips::Strips;
use crate::unknowns::{Couplings, SparsityPattern};
use mpm_basis::Connectivity;
use mpm_grid::{Block, Vector};
use mpm_linear::Symmetry;
use mpm_material::Regularisation;
use std::sync::{Arc, Mutex};

/// Tasks per phase at most, each with its scratch; fixed, so that nothing depends on the number of
/// threads.
const TASKS: usize = 32;

/// Connectivity of a body in a load step, with what makes sums over it quick.
#[derive(Debug)]
pub struct AssemblyPlan<const D: usize> {
    body: BodyConnectivity<D>,
    pub(crate) sums: Summation<D>,
    field: Option<FieldPlan<D>>,
}

/// What sums over a body's points need; the same for all lists that connect the same points and nodes.
#[derive(Debug)]
pub(crate) struct Summation<const D: usize> {
    pub strips: Strips,
    pub slots: Vec<u32>,
    /// Start of the slots of every node set, or cell where there is mean dilatation.
    pub slot_start: Vec<usize>,
    /// One for each task of a phase.
    pub scratch: Vec<Mutex<Scratch<D>>>,
}

impl<const D: usize> AssemblyPlan<D> {
    /// Prepares sums over the points of `body` into `pattern`.
    pub fn new(body: impl Into<BodyConnectivity<D>>, pattern: &SparsityPattern<D>) -> Self {
        let body = body.into();
        let strips = Strips::of(&body);
        let slots = pattern.slots(&body);
        let mut slot_start = Vec::with_capacity(body.n_sets());
        let (mut at, mut most_nodes) = (0, 0);
        for set in 0..body.n_sets() {
            let n = body.set(set).len();
            slot_start.push(at);
            at += pattern.n_slots(n);
            most_nodes = most_nodes.max(n);
        }
        let tasks = strips.phases()[0].len().clamp(1, TASKS);
        let scratch = || Scratch::new(most_nodes, pattern.symmetry(), body.dilatation.is_some());
        let scratch = (0..tasks).map(|_| Mutex::new(scratch())).collect();
        Self { body, sums: Summation { strips, slots, slot_start, scratch }, field: None }
    }

    /// The same of a regularised body, whose nodal field lives on `nodes`; the pattern
    /// [couples](FieldNodes::couplings) it.
    pub fn with_field(self, nodes: Arc<FieldNodes>, pattern: &SparsityPattern<D>) -> Self {
        let field = FieldPlan::new(nodes, self.connectivity(), pattern, self.sums.scratch.len());
        Self { field: Some(field), ..self }
    }

    /// Sums what no trial of a load step changes in the equations of the nodal field; `point` are the points at its start.
    /// Sums over the points of a regularised body come after it.
    pub fn begin_field(&mut self, regularisation: &Regularisation, point: &dyn Fn(usize) -> FieldPoint<D>) {
        if let Some(field) = &mut self.field {
            field.begin(&self.body.connectivity, regularisation, point);
        }
    }

    /// Where the nodal field of a regularised body stands.
    ///
    /// # Panics
    /// The plan has been made without one.
    pub(crate) fn field(&self) -> &FieldPlan<D> {
        self.field.as_ref().expect("the plan of a regularised body has its field")
    }

    /// Whether the same points have the same nodes in `body`, and nothing else couples them.
    pub fn is_connected_as(&self, body: &BodyConnectivity<D>) -> bool {
        let is_plain = self.body.dilatation.is_none() && body.dilatation.is_none();
        is_plain && self.body.connectivity.is_connected_as(&body.connectivity)
    }

    /// Sums over `connectivity`, which connect the same points and nodes as the present ones, into the same
    /// pattern.
    pub fn relinked(self, connectivity: Connectivity<D>) -> Self {
        debug_assert!(connectivity.is_connected_as(&self.body.connectivity), "the same points and nodes");
        Self { body: connectivity.into(), ..self }
    }

    /// The points and their nodes.
    pub fn body_connectivity(&self) -> &BodyConnectivity<D> {
        &self.body
    }

    /// The points and their nodes, without what depends on the pattern.
    pub fn into_body_connectivity(self) -> BodyConnectivity<D> {
        self.body
    }

    /// Groups of points and their influences.
    pub fn connectivity(&self) -> &Connectivity<D> {
        &self.body.connectivity
    }

    /// Cells over which volume changes are averaged, where they are.
    pub fn dilatation(&self) -> Option<&Dilatation<D>> {
        self.body.dilatation.as_ref()
    }

    /// Bytes of all that is kept.
    pub fn bytes(&self) -> usize {
        self.body.connectivity.bytes()
            + size_of_val(&self.sums.slots[..])
            + size_of_val(&self.sums.slot_start[..])
            + self.field.as_ref().map_or(0, FieldPlan::bytes)
    }
}

/// Memory of a task, reused from batch to batch.
#[derive(Debug)]
pub(crate) struct Scratch<const D: usize> {
    pub batch: Batch<D>,
    pub sums: NodeSums<D>,
    /// Dense sums of a cell where there is mean dilatation; empty where there is none.
    pub force: Vec<Vector<D>>,
    pub tangent: Vec<Block<D>>,
}

impl<const D: usize> Scratch<D> {
    fn new(most_nodes: usize, symmetry: Symmetry, has_cells: bool) -> Self {
        let (of_set, of_cell) = if has_cells { (0, most_nodes) } else { (most_nodes, 0) };
        let n_blocks = match symmetry {
            Symmetry::Symmetric => of_cell * (of_cell + 1) / 2,
            Symmetry::Unsymmetric => of_cell * of_cell,
        };
        Self {
            batch: Batch::new(of_set),
            sums: NodeSums::new(of_set, symmetry == Symmetry::Unsymmetric),
            force: vec![Vector::zeros(); of_cell],
            tangent: vec![Block::zeros(); n_blocks],
        }
    }
}

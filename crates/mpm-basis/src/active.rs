//! The nodes that carry material, numbered.

use crate::stencils::{ACTIVE, Bounds, Stencils, narrow, widen};
use mpm_grid::{NodeId, NodeSpace};

/// The nodes that carry material in this load step, numbered in ascending order.
#[derive(Clone, Debug, PartialEq)]
pub struct ActiveNodes<const D: usize> {
    nodes: Vec<NodeId>,
    window: Window<D>,
    /// Active number of each node of the window, `INACTIVE` elsewhere.
    number: Vec<u32>,
}

const INACTIVE: u32 = u32::MAX;

/// The box of lattice indices that the stencils touch.
#[derive(Clone, Debug, PartialEq)]
struct Window<const D: usize> {
    space: NodeSpace<D>,
    low: [u32; D],
    extent: [u32; D],
}

impl<const D: usize> Window<D> {
    fn around(space: &NodeSpace<D>, stencils: &[Stencils<D>]) -> Self {
        let nothing = ([u32::MAX; D], [0; D]);
        let chunks = stencils.iter().flat_map(|body| &body.chunks).filter(|chunk| !chunk.nodes.is_empty());
        Self::of(space, chunks.fold(nothing, |all, chunk| widen(widen(all, chunk.bounds.0), chunk.bounds.1)))
    }

    fn of(space: &NodeSpace<D>, (low, high): Bounds<D>) -> Self {
        let mut extent = [0; D];
        for d in 0..D {
            extent[d] = (high[d] + 1).saturating_sub(low[d]);
        }
        Self { space: space.clone(), low, extent }
    }

    fn size(&self) -> usize {
        self.extent.iter().map(|&n| n as usize).product()
    }

    #[inline]
    fn slot(&self, node: NodeId) -> Option<usize> {
        let index = self.space.lattice().node_index(node);
        let mut slot = 0;
        for d in (0..D).rev() {
            let offset = index[d].wrapping_sub(self.low[d]);
            if offset >= self.extent[d] {
                return None;
            }
            slot = slot * self.extent[d] as usize + offset as usize;
        }
        Some(slot)
    }

    fn node(&self, mut slot: usize) -> NodeId {
        let mut index = self.low;
        for (index, &extent) in index.iter_mut().zip(&self.extent) {
            let extent = extent as usize;
            *index += narrow(slot % extent);
            slot /= extent;
        }
        self.space.lattice().node(index)
    }
}

impl ActiveNodes<3> {
    /// The same nodes in the plane whose layer they are in, with the same numbers; `space` are the nodes of that.
    pub fn section(&self, space: NodeSpace<2>) -> ActiveNodes<2> {
        let Window { low, extent, .. } = self.window;
        let window = Window { space, low: [low[0], low[1]], extent: [extent[0], extent[1]] };
        ActiveNodes { nodes: self.nodes.clone(), window, number: self.number.clone() }
    }
}

impl<const D: usize> ActiveNodes<D> {
    /// Nodes of `space` with `Σ_p (|S_vp| + |∇S_vp|/g_p) > 1e-14` over the points of all bodies, `g_p` the largest
    /// gradient of the point: about `1/h`.
    pub fn of(space: &NodeSpace<D>, stencils: &[Stencils<D>]) -> Self {
        let window = Window::around(space, stencils);
        let slot = |node| window.slot(node).expect("the window holds every node of the stencils");
        let mut number = vec![INACTIVE; window.size()];
        let chunks = || stencils.iter().flat_map(|body| &body.chunks);
        for chunk in chunks() {
            for (&node, _) in chunk.nodes.iter().zip(&chunk.strong).filter(|(_, strong)| **strong) {
                number[slot(node)] = 0;
            }
        }
        let faint = chunks().flat_map(|chunk| &chunk.faint).map(|&(node, weight)| (slot(node), weight));
        let mut faint: Vec<(usize, f64)> = faint.filter(|&(slot, _)| number[slot] == INACTIVE).collect();
        // Stable, so that each node's weights are summed in the order of the points.
        faint.sort_by_key(|&(slot, _)| slot);
        for weights in faint.chunk_by(|a, b| a.0 == b.0) {
            if weights.iter().map(|it| it.1).sum::<f64>() > ACTIVE {
                number[weights[0].0] = 0;
            }
        }

        let mut nodes = Vec::new();
        for (slot, number) in number.iter_mut().enumerate().filter(|(_, number)| **number != INACTIVE) {
            *number = narrow(nodes.len());
            nodes.push(window.node(slot));
        }
        Self { nodes, window, number }
    }

    /// Nodes of `space` that points of this process influence, ascending, with `Σ_p (|S_vp| + |∇S_vp|/g_p)`, see [`Self::of`];
    /// 1 in place of the sum, where a single point makes the node active. Several processes that share a model add what they
    /// have of a node, and take those for active that have more than [`ACTIVE`](crate::ACTIVE).
    pub fn touched(space: &NodeSpace<D>, stencils: &[Stencils<D>]) -> Vec<(NodeId, f64)> {
        let window = Window::around(space, stencils);
        let slot = |node| window.slot(node).expect("the window holds every node of the stencils");
        let mut weight: Vec<Option<f64>> = vec![None; window.size()];
        let chunks = || stencils.iter().flat_map(|body| &body.chunks);
        for (node, of_node) in chunks().flat_map(|chunk| &chunk.faint) {
            *weight[slot(*node)].get_or_insert(0.0) += of_node;
        }
        for chunk in chunks() {
            for (&node, _) in chunk.nodes.iter().zip(&chunk.strong).filter(|(_, strong)| **strong) {
                weight[slot(node)] = Some(1.0);
            }
        }
        let touched =
            weight.iter().enumerate().filter_map(|(slot, weight)| Some((window.node(slot), (*weight)?)));
        touched.collect()
    }

    /// These nodes of `space`, ascending: active for what others have found.
    pub fn listed(space: &NodeSpace<D>, nodes: Vec<NodeId>) -> Self {
        let nothing = ([u32::MAX; D], [0; D]);
        let index = |node: &NodeId| space.lattice().node_index(*node);
        let window = Window::of(space, nodes.iter().fold(nothing, |all, node| widen(all, index(node))));
        let mut number = vec![INACTIVE; window.size()];
        for (v, &node) in nodes.iter().enumerate() {
            number[window.slot(node).expect("the window holds every node")] = narrow(v);
        }
        Self { nodes, window, number }
    }

    /// Nodes, active or not, in the box of lattice indices that the stencils touch: a table of that length
    /// is made of them.
    pub fn nodes_around(space: &NodeSpace<D>, stencils: &[Stencils<D>]) -> usize {
        Window::around(space, stencils).size()
    }

    /// The nodes among which these are.
    pub fn space(&self) -> &NodeSpace<D> {
        &self.window.space
    }

    /// Number of active nodes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether no node is active.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The active nodes, ascending; position in this list is the active number.
    pub fn nodes(&self) -> &[NodeId] {
        &self.nodes
    }

    /// Active number of a node, if it is active.
    #[inline]
    pub fn number(&self, node: NodeId) -> Option<usize> {
        let number = self.number[self.window.slot(node)?];
        (number != INACTIVE).then_some(number as usize)
    }

    /// Lattice index of every active node, padded with zeros to three directions.
    pub fn lattice_indices(&self) -> Vec<[u32; 3]> {
        self.nodes
            .iter()
            .map(|&node| {
                let index = self.window.space.lattice().node_index(node);
                std::array::from_fn(|d| if d < D { index[d] } else { 0 })
            })
            .collect()
    }

    /// Bytes of the tables: they follow the box round the material, not the grid.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.number[..])
    }
}

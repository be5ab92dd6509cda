//! Connectivity as data: which point influences which node, and everything derived from that list.
//!
//! [`Stencils`] is the raw list of one body, by node of the grid. [`ActiveNodes`] numbers the nodes
//! that the stencils of all bodies name. [`Links`] is a body's list in that numbering, with points
//! that share the same nodes gathered in groups. No support width is assumed anywhere, and the cost
//! of all three follows the material, not the grid.

use crate::{Basis, Influence, Stencil};
use mpm_grid::{Lattice, Mesh, NodeId, OutsideMesh, Vector};
use rayon::prelude::*;
use std::ops::Range;

/// Points per parallel task; fixed, so that nothing depends on the number of threads.
const CHUNK: usize = 256;

/// A node is active where `Σ_p |S_vp|` exceeds this `[-]`.
const ACTIVE: f64 = 1e-14;

/// A point that the mesh does not cover.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("material point {point}: {reason}")]
pub struct UnconnectedPoint<const D: usize> {
    /// Index of the point in its body.
    pub point: usize,
    /// What left the mesh, and how far.
    pub reason: OutsideMesh<D>,
}

/// Influences of all points of one body on the nodes of the grid.
#[derive(Clone, Debug)]
pub struct Stencils<const D: usize> {
    chunks: Vec<ChunkStencils<D>>,
}

#[derive(Clone, Debug)]
struct ChunkStencils<const D: usize> {
    /// End of each point's influences in `influences`.
    end: Vec<u32>,
    influences: Vec<Influence<D>>,
}

impl<const D: usize> Stencils<D> {
    /// Asks `basis` for the influences of every point; `x` and `domain` have one entry per point.
    ///
    /// # Errors
    /// The first point (in order) that the mesh does not cover.
    pub fn of<B: Basis<D>>(
        basis: &B,
        mesh: &Mesh<D>,
        x: &[Vector<D>],
        domain: &[B::Domain],
    ) -> Result<Self, UnconnectedPoint<D>> {
        assert_eq!(x.len(), domain.len(), "one domain per point");
        let chunks: Vec<Result<_, UnconnectedPoint<D>>> = (0..x.len().div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let first = chunk * CHUNK;
                let points = first..(first + CHUNK).min(x.len());
                let mut end = Vec::with_capacity(points.len());
                let mut influences = Vec::with_capacity(points.len() << D);
                let mut stencil = Stencil::new();
                for point in points {
                    stencil.clear();
                    basis
                        .influences(mesh, &x[point], &domain[point], &mut stencil)
                        .map_err(|reason| UnconnectedPoint { point, reason })?;
                    stencil.finish();
                    influences.extend_from_slice(stencil.entries());
                    end.push(narrow(influences.len()));
                }
                Ok(ChunkStencils { end, influences })
            })
            .collect();
        Ok(Self { chunks: chunks.into_iter().collect::<Result<_, _>>()? })
    }

    /// Influences of every point, in order.
    fn points(&self) -> impl Iterator<Item = &[Influence<D>]> {
        self.chunks.iter().flat_map(|chunk| {
            (0..chunk.end.len()).map(|k| {
                let begin = if k == 0 { 0 } else { chunk.end[k - 1] as usize };
                &chunk.influences[begin..chunk.end[k] as usize]
            })
        })
    }
}

/// The nodes that carry material in this load step, numbered in ascending order.
#[derive(Clone, Debug)]
pub struct ActiveNodes<const D: usize> {
    nodes: Vec<NodeId>,
    window: Window<D>,
    /// Active number of each node of the window, `INACTIVE` elsewhere.
    number: Vec<u32>,
}

const INACTIVE: u32 = u32::MAX;

/// The box of lattice indices that the stencils touch.
#[derive(Clone, Debug)]
struct Window<const D: usize> {
    lattice: Lattice<D>,
    low: [u32; D],
    extent: [u32; D],
}

impl<const D: usize> Window<D> {
    fn around(lattice: &Lattice<D>, stencils: &[Stencils<D>]) -> Self {
        let nothing = ([u32::MAX; D], [0; D]);
        let bounds: Vec<([u32; D], [u32; D])> = stencils
            .iter()
            .flat_map(|body| &body.chunks)
            .collect::<Vec<_>>()
            .into_par_iter()
            .map(|chunk| {
                chunk.influences.iter().fold(nothing, |bounds, it| widen(bounds, lattice.node_index(it.node)))
            })
            .collect();
        let (low, high) = bounds.into_iter().fold(nothing, |all, (low, high)| {
            if low[0] == u32::MAX { all } else { widen(widen(all, low), high) }
        });
        let mut extent = [0; D];
        for d in 0..D {
            extent[d] = (high[d] + 1).saturating_sub(low[d]);
        }
        Self { lattice: lattice.clone(), low, extent }
    }

    fn size(&self) -> usize {
        self.extent.iter().map(|&n| n as usize).product()
    }

    #[inline]
    fn slot(&self, node: NodeId) -> Option<usize> {
        let index = self.lattice.node_index(node);
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
        self.lattice.node(index)
    }
}

fn widen<const D: usize>((mut low, mut high): ([u32; D], [u32; D]), index: [u32; D]) -> ([u32; D], [u32; D]) {
    for d in 0..D {
        low[d] = low[d].min(index[d]);
        high[d] = high[d].max(index[d]);
    }
    (low, high)
}

impl<const D: usize> ActiveNodes<D> {
    /// Nodes with `Σ_p |S_vp| > 1e-14` over the points of all bodies.
    pub fn of(lattice: &Lattice<D>, stencils: &[Stencils<D>]) -> Self {
        let window = Window::around(lattice, stencils);
        let mut weight = vec![0.0; window.size()];
        for influence in stencils.iter().flat_map(|body| &body.chunks).flat_map(|chunk| &chunk.influences) {
            let slot = window.slot(influence.node).expect("the window holds every node of the stencils");
            weight[slot] += influence.value.abs();
        }
        let mut nodes = Vec::new();
        let mut number = vec![INACTIVE; window.size()];
        for (slot, weight) in weight.into_iter().enumerate() {
            if weight > ACTIVE {
                number[slot] = narrow(nodes.len());
                nodes.push(window.node(slot));
            }
        }
        Self { nodes, window, number }
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
                let index = self.window.lattice.node_index(node);
                std::array::from_fn(|d| if d < D { index[d] } else { 0 })
            })
            .collect()
    }
}

/// A body's points and the active nodes they influence, by groups of points that share their nodes.
///
/// Points of a group are consecutive; with points in the order of their cells, a group of standard
/// MPM is a cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Links<const D: usize> {
    /// First point of every group, and the number of points at the end.
    group_point: Vec<u32>,
    /// Start of every group's nodes in `node`, and its length at the end.
    group_node: Vec<u32>,
    /// Active numbers, ascending within a group.
    node: Vec<u32>,
    /// Start of every group's influences in `value` and `gradient`.
    group_influence: Vec<usize>,
    value: Vec<f64>,
    gradient: Vec<Vector<D>>,
}

/// Points of one group: every point has one value and gradient per node.
#[derive(Clone, Copy, Debug)]
pub struct Group<'a, const D: usize> {
    /// Index of the first point.
    pub first_point: usize,
    /// Number of points.
    pub points: usize,
    /// Active numbers of the nodes, ascending.
    pub nodes: &'a [u32],
    /// `S_vp`, `[points][nodes]`.
    pub values: &'a [f64],
    /// `∂S_vp/∂X̃`, `[points][nodes]`.
    pub gradients: &'a [Vector<D>],
}

impl<const D: usize> Links<D> {
    /// Renumbers one body's stencils by active node; influences on inactive nodes are dropped.
    pub fn of(stencils: Stencils<D>, active: &ActiveNodes<D>) -> Self {
        let total: usize = stencils.chunks.iter().map(|chunk| chunk.influences.len()).sum();
        let mut links = Self {
            group_point: Vec::new(),
            group_node: Vec::new(),
            node: Vec::new(),
            group_influence: Vec::new(),
            value: Vec::with_capacity(total),
            gradient: Vec::with_capacity(total),
        };
        let mut nodes: Vec<u32> = Vec::new();
        let mut shared: &[Influence<D>] = &[];
        let mut n_points = 0;
        for influences in stencils.points() {
            let same = n_points > 0
                && influences.len() == shared.len()
                && influences.iter().zip(shared).all(|(a, b)| a.node == b.node);
            if !same {
                links.group_point.push(n_points);
                links.group_node.push(narrow(links.node.len()));
                links.group_influence.push(links.value.len());
                nodes.clear();
                nodes.extend(influences.iter().filter_map(|it| active.number(it.node).map(narrow)));
                links.node.extend_from_slice(&nodes);
                shared = influences;
            }
            for influence in influences {
                if nodes.len() == influences.len() || active.number(influence.node).is_some() {
                    links.value.push(influence.value);
                    links.gradient.push(influence.gradient);
                }
            }
            n_points += 1;
        }
        links.group_point.push(n_points);
        links.group_node.push(narrow(links.node.len()));
        links.group_influence.push(links.value.len());
        links
    }

    /// Number of groups.
    pub fn n_groups(&self) -> usize {
        self.group_point.len() - 1
    }

    /// Number of points.
    pub fn n_points(&self) -> usize {
        self.group_point[self.n_groups()] as usize
    }

    /// Number of influences, that is of pairs (point, node).
    pub fn n_influences(&self) -> usize {
        self.value.len()
    }

    /// One group.
    #[inline]
    pub fn group(&self, group: usize) -> Group<'_, D> {
        let points = self.group_points(group);
        let influences = self.group_influence[group]..self.group_influence[group + 1];
        Group {
            first_point: points.start,
            points: points.len(),
            nodes: self.group_nodes(group),
            values: &self.value[influences.clone()],
            gradients: &self.gradient[influences],
        }
    }

    /// Points of one group.
    pub fn group_points(&self, group: usize) -> Range<usize> {
        self.group_point[group] as usize..self.group_point[group + 1] as usize
    }

    /// Active numbers of the nodes of one group, ascending.
    #[inline]
    pub fn group_nodes(&self, group: usize) -> &[u32] {
        &self.node[self.group_node[group] as usize..self.group_node[group + 1] as usize]
    }
}

impl<'a, const D: usize> Group<'a, D> {
    /// Values and gradients of the `k`-th point of the group, one per node.
    #[inline]
    pub fn point(&self, k: usize) -> (&'a [f64], &'a [Vector<D>]) {
        let n = self.nodes.len();
        (&self.values[k * n..(k + 1) * n], &self.gradients[k * n..(k + 1) * n])
    }
}

fn narrow(n: usize) -> u32 {
    u32::try_from(n).expect("fewer than 2^32 points, nodes and group entries")
}

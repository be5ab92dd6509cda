//! Stencils: which point influences which node of the grid.
//!
//! [`Stencils`] is the raw list of one body, by node of the grid. [`ActiveNodes`](crate::ActiveNodes) numbers the nodes
//! that the stencils of all bodies name. [`Connectivity`](crate::Connectivity) is a
//! body's list in that numbering, with points that share the same nodes gathered. No width of stencils is assumed, and the cost of all
//! three follows the material, not the grid.

use crate::influence::Influence;
use mpm_grid::{Lattice, NodeId, OutsideMesh, Position, Vector};
use std::ops::Range;

/// A node is active where `Σ_p (|S_vp| + |∇S_vp|/g_p)` exceeds this `[-]`, with `g_p` the largest gradient of the
/// point, about one over the edge of its cell: a point on a mesh line has nodes with value 0 whose gradients the sum
/// `Σ_v ∇S_vp = 0` needs.
pub const ACTIVE: f64 = 1e-14;

/// A point that the mesh does not cover.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("material point {point} at {}: {}", Position(position), part(position, reason))]
pub struct UnconnectedPoint<const D: usize> {
    /// Index of the point in its body.
    pub point: usize,
    /// What left the mesh, and how far.
    pub reason: OutsideMesh<D>,
    /// Where the point itself is `[L]`.
    pub position: Vector<D>,
}

/// Which part of the point's domain lies outside, and how far.
fn part<const D: usize>(position: &Vector<D>, reason: &OutsideMesh<D>) -> String {
    if *position == reason.position { reason.to_string() } else { format!("a corner of its domain: {reason}") }
}

/// Influences of all points of one body on the nodes of the grid.
#[derive(Clone, Debug)]
pub struct Stencils<const D: usize> {
    pub(crate) chunks: Vec<Chunk<D>>,
}

/// Influences of consecutive points. Nodes are kept once for every run of points that share them.
#[derive(Clone, Debug)]
pub(crate) struct Chunk<const D: usize> {
    /// Its runs, in order.
    pub runs: Vec<Run>,
    /// Nodes of the runs, ascending in each.
    pub nodes: Vec<NodeId>,
    /// Whether a single point of its run makes the node active.
    pub strong: Vec<bool>,
    /// Lowest and highest lattice index of any node.
    pub bounds: Bounds<D>,
    /// The nodes that are not strong, run by run, and `Σ(|S_vp| + |∇S_vp|/g_p)` over the run.
    pub faint: Vec<(NodeId, f64)>,
    pub influences: Influences<D>,
}

/// The end of a run of points that share their nodes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    /// Points of the chunk up to the end of the run.
    pub points: u32,
    /// Nodes of the chunk up to the end of the run.
    pub nodes: u32,
    /// Whether one of its points makes all its nodes active.
    strong: bool,
}

/// `S_vp` and `∂S_vp/∂X̃`, point by point.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Influences<const D: usize> {
    pub value: Vec<f64>,
    pub gradient: Vec<Vector<D>>,
    /// Parts of the points' masses `[-]`; empty where they are the values.
    pub mass: Vec<f64>,
}

/// Lowest and highest lattice index, both inclusive.
pub(crate) type Bounds<const D: usize> = ([u32; D], [u32; D]);

impl<const D: usize> Default for Chunk<D> {
    fn default() -> Self {
        Self {
            runs: Vec::new(),
            nodes: Vec::new(),
            strong: Vec::new(),
            bounds: ([u32::MAX; D], [0; D]),
            faint: Vec::new(),
            influences: Influences::default(),
        }
    }
}

impl<const D: usize> Chunk<D> {
    /// Nothing, in the same memory.
    pub(crate) fn clear(&mut self) {
        self.runs.clear();
        self.nodes.clear();
        self.strong.clear();
        self.bounds = ([u32::MAX; D], [0; D]);
        self.faint.clear();
        let Influences { value, gradient, mass } = &mut self.influences;
        value.clear();
        gradient.clear();
        mass.clear();
    }

    /// Its nodes alone.
    pub(crate) fn without_influences(&self) -> Self {
        let Self { runs, nodes, strong, bounds, faint, .. } = self;
        Self {
            runs: runs.clone(),
            nodes: nodes.clone(),
            strong: strong.clone(),
            bounds: *bounds,
            faint: faint.clone(),
            influences: Influences::default(),
        }
    }

    /// Nodes of the present run begin here.
    fn run_start(&self) -> usize {
        match self.runs[..] {
            [.., before, _] => before.nodes as usize,
            _ => 0,
        }
    }

    /// Adds a point.
    #[inline]
    pub(crate) fn push(&mut self, entries: &[Influence<D>]) {
        let strong = entries.iter().all(|it| it.value.abs() > ACTIVE);
        let shared = if self.runs.is_empty() { &[] } else { &self.nodes[self.run_start()..] };
        let same = !self.runs.is_empty()
            && entries.len() == shared.len()
            && entries.iter().zip(shared).all(|(a, b)| a.node == *b);
        match self.runs.last_mut() {
            Some(run) if same => {
                run.points += 1;
                run.strong |= strong;
            }
            last => {
                let points = last.map_or(0, |run| run.points) + 1;
                self.nodes.extend(entries.iter().map(|it| it.node));
                self.runs.push(Run { points, nodes: narrow(self.nodes.len()), strong });
            }
        }
        self.influences.value.extend(entries.iter().map(|it| it.value));
        self.influences.gradient.extend(entries.iter().map(|it| it.gradient));
    }

    /// Adds the parts of the mass of the point that was added last with `entries`, by node as these.
    pub(crate) fn push_masses(&mut self, entries: &[Influence<D>], masses: &[Influence<D>]) {
        let of_node = |node: NodeId| match masses.binary_search_by_key(&node, |it| it.node) {
            Ok(at) => masses[at].value,
            Err(_) => 0.0,
        };
        self.influences.mass.extend(entries.iter().map(|it| of_node(it.node)));
    }

    /// `|S_vp| + |∇S_vp|/g_p` of points that share `n` nodes `[-]`.
    fn weights(&self, of: Range<usize>, n: usize) -> Vec<f64> {
        let points = self.influences.value[of.clone()].chunks(n).zip(self.influences.gradient[of].chunks(n));
        let weights = points.flat_map(|(values, gradients)| {
            let largest = gradients.iter().map(|g| g.norm()).fold(f64::MIN_POSITIVE, f64::max);
            values.iter().zip(gradients).map(move |(value, gradient)| value.abs() + gradient.norm() / largest)
        });
        weights.collect()
    }

    /// Finds the bounds, and the influences on nodes that might not be active.
    pub(crate) fn finish(&mut self, lattice: &Lattice<D>) {
        for &node in &self.nodes {
            self.bounds = widen(self.bounds, lattice.node_index(node));
        }
        self.strong.resize(self.nodes.len(), true);
        let (mut point, mut node, mut at) = (0, 0, 0);
        for run in &self.runs {
            let n = run.nodes as usize - node;
            let influences = (run.points - point) as usize * n;
            if !run.strong {
                let weights = self.weights(at..at + influences, n);
                for k in 0..n {
                    let of_node = weights.iter().skip(k).step_by(n);
                    self.strong[node + k] = of_node.clone().any(|weight| *weight > ACTIVE);
                    if !self.strong[node + k] {
                        self.faint.push((self.nodes[node + k], of_node.sum()));
                    }
                }
            }
            (point, node) = (run.points, run.nodes as usize);
            at += influences;
        }
    }
}

#[inline]
pub(crate) fn widen<const D: usize>((mut low, mut high): Bounds<D>, index: [u32; D]) -> Bounds<D> {
    for d in 0..D {
        low[d] = low[d].min(index[d]);
        high[d] = high[d].max(index[d]);
    }
    (low, high)
}

#[inline]
pub(crate) fn narrow(n: usize) -> u32 {
    u32::try_from(n).expect("fewer than 2^32 points, nodes and group entries")
}

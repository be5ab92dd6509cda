//! How far bodies are from the nodes that drive them.
//!
//! Nodes with `displace` or `turn` take along whatever material is in their cells. In a mesh that does not move with them
//! the body leaves: the force then falls without a sign, or is that of other material. The *gap* of a node is the larger
//! of two distances, in cells, of at most 1:
//! * from the node to the nearest domain of a point in its cells, 1 where there is none;
//! * of nodes over which material enters or leaves the driven region, how far that has gone (`departures.rs`).
//!
//! The gap of a support is the larger of those within which nodes of half the weight lie, of all that carried material at the
//! start, and of all over which material passes; the weight of a node is the volume of its cells at rest.

use super::departures::{Departures, cell_around};
use crate::model::{Model, Prescribed, Support};
use crate::ranks::Ranks;
use mpm_assembly::{PointView, determinant, views};
use mpm_grid::{Block, LoadFraction, Mesh, MeshMotion, NodeId, NodeKind, Vector, inverse};
use serde::{Deserialize, Serialize};

/// A gap that has grown by more than this ends the run `[cells]`.
pub(crate) const MOST: f64 = 0.5;

/// How a support holds its body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Grip {
    /// The gap at the start `[cells]`.
    pub at_start: f64,
    /// In the last row: to the nearest domains `[cells]`.
    near: f64,
    /// In the last row: how far material has passed its edges `[cells]`.
    passed: f64,
    /// Weight of the nodes with material `[L^D]`.
    weight: f64,
}

/// Whether a support drives its nodes by a motion of its own.
pub(crate) fn is_driven<const D: usize>(support: &Support<D>) -> bool {
    let ramps = support.components.iter().flatten().filter_map(Prescribed::ramp);
    ramps.flat_map(|ramp| ramp.knots()).any(|(_, value)| value != 0.0)
}

/// The supports whose gap is recorded.
pub(crate) fn driven<const D: usize>(model: &Model<D>) -> impl Iterator<Item = &Support<D>> {
    let nodes_are_vertices = model.nodes.kind() == NodeKind::Vertices;
    model.supports.iter().filter(move |support| nodes_are_vertices && is_driven(support))
}

/// How far a mesh that moves has taken the nodes of a support away from the body that they hold: from where they took hold of
/// it, and from its nearest domain. 0 where the support moves its nodes, too, which is what [`Grip`] is for `[cells]`.
pub(crate) fn taken_away<const D: usize>(
    model: &Model<D>,
    support: &Support<D>,
    (mesh, at): (&Mesh<D>, LoadFraction),
    ranks: &dyn Ranks<D>,
) -> f64 {
    if !is_held_in_moving_mesh(model, support) {
        return 0.0;
    }
    let departures = Departures::of(model, support, (mesh, at));
    if !departures.any() {
        return 0.0;
    }
    let nodes = Nodes::near(model, support, mesh, ranks);
    departed(&departures, nodes.carrying()).min(nodes.gap())
}

/// Whether a support holds nodes that the mesh may move.
pub(crate) fn is_held_in_moving_mesh<const D: usize>(model: &Model<D>, support: &Support<D>) -> bool {
    let is_held = || support.components.iter().flatten().any(|it| *it == Prescribed::Held);
    !matches!(model.motion, MeshMotion::Fixed)
        && model.nodes.kind() == NodeKind::Vertices
        && is_held()
        && !is_driven(support)
}

impl Grip {
    /// At the start, in the mesh there.
    pub(crate) fn at_start<const D: usize>(
        model: &Model<D>,
        support: &Support<D>,
        mesh: &Mesh<D>,
        ranks: &dyn Ranks<D>,
    ) -> Self {
        let nodes = Nodes::near(model, support, mesh, ranks);
        let (gap, weight) = (nodes.gap(), nodes.carrying().map(|node| node.weight).sum());
        Self { at_start: gap, near: gap, passed: 0.0, weight }
    }

    /// The gap in the last row `[cells]`.
    pub(crate) fn now(&self) -> f64 {
        self.near.max(self.passed)
    }

    /// Looks again, in the mesh that the points meet next.
    pub(crate) fn look<const D: usize>(
        &mut self,
        model: &Model<D>,
        support: &Support<D>,
        (mesh, at): (&Mesh<D>, LoadFraction),
        ranks: &dyn Ranks<D>,
    ) {
        let nodes = Nodes::near(model, support, mesh, ranks);
        self.near = within(nodes.carrying().map(|node| (node.gap, node.weight)).collect(), 0.5 * self.weight);
        self.passed = departed(&Departures::of(model, support, (mesh, at)), nodes.carrying());
    }

    /// Holds nothing, in a stage in which its support does not act.
    pub(crate) fn rest(&mut self) {
        (self.near, self.passed) = (0.0, 0.0);
    }

    /// Whether it can be that of a support.
    pub(crate) fn is_possible(&self) -> bool {
        [self.at_start, self.near, self.passed].iter().all(|gap| (0.0..=1.0).contains(gap))
            && self.weight >= 0.0
            && self.weight.is_finite()
    }

    /// Whether the body is lost.
    pub(crate) fn is_lost(&self) -> bool {
        self.weight > 0.0 && (self.now() >= 1.0 || self.near > self.at_start + MOST || self.passed > MOST)
    }
}

/// The smallest of some values up to which their weights reach `half`; 1 if none does.
fn within(mut values: Vec<(f64, f64)>, half: f64) -> f64 {
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut sum = 0.0;
    for (value, weight) in values {
        sum += weight;
        if sum >= half {
            return value;
        }
    }
    1.0
}

/// How far material has passed nodes of half the weight of those that it passes, of some of a support; 0 if it passes none
/// `[cells]`.
pub(crate) fn departed<'a, const D: usize>(
    departures: &Departures<'_, D>,
    nodes: impl Iterator<Item = &'a Near>,
) -> f64 {
    let passed = |node: &Near| Some((departures.at(node.id, node.filled)?, node.weight));
    let weighted: Vec<(f64, f64)> = nodes.filter_map(passed).collect();
    if weighted.is_empty() {
        return 0.0;
    }
    let half = 0.5 * weighted.iter().map(|it| it.1).sum::<f64>();
    within(weighted, half)
}

/// A driven node and the material around it.
pub(crate) struct Near {
    id: NodeId,
    /// To the nearest domain in its cells, at most 1 `[cells]`.
    gap: f64,
    weight: f64,
    /// Which of its cells hold points: the cell in which the node is corner c is bit c.
    filled: u8,
}

/// The nodes of a support.
pub(crate) struct Nodes {
    all: Vec<Near>,
}

impl Nodes {
    /// Those with material in their cells.
    pub(crate) fn carrying(&self) -> impl Iterator<Item = &Near> {
        self.all.iter().filter(|node| node.gap < 1.0)
    }

    /// The distance from the nearest domain within which nodes of half the weight lie of those with material; 1 if none has
    /// any `[cells]`.
    pub(crate) fn gap(&self) -> f64 {
        let weight: f64 = self.carrying().map(|node| node.weight).sum();
        within(self.carrying().map(|node| (node.gap, node.weight)).collect(), 0.5 * weight)
    }

    pub(crate) fn near<const D: usize>(
        model: &Model<D>,
        support: &Support<D>,
        mesh: &Mesh<D>,
        ranks: &dyn Ranks<D>,
    ) -> Self {
        let (lattice, rest) = (mesh.lattice(), Mesh::at_rest(&model.layout));
        let mut gaps = vec![1.0; support.nodes.len()];
        let mut filled = vec![0_u8; support.nodes.len()];
        let bounds = Bounds::of(support, lattice.periodic(), |node| lattice.node_index(node));
        for view in model.bodies.iter().flat_map(|named| views(&*named.body)) {
            let Ok(place) = mesh.locate(&view.position, 0.5) else { continue };
            if !bounds.may_hold(place.cell) {
                continue;
            }
            let mut half = None;
            for (c, node) in lattice.corners(place.cell)[..1 << D].iter().enumerate() {
                let Some(k) = find(&support.nodes, *node) else { continue };
                let half = half.get_or_insert_with(|| {
                    let edges = [edges(mesh, place.cell), edges(&rest, place.cell)];
                    half_extent(&view, edges, model.coordinates())
                });
                let apart = Vector::<D>::from_fn(|d, _| {
                    if d >= model.coordinates() {
                        return 0.0;
                    }
                    let side = if c >> d & 1 == 0 { -1.0 } else { 1.0 };
                    (0.5 * (place.local[d] - side).abs() - half[d]).max(0.0)
                });
                gaps[k] = f64::min(gaps[k], apart.norm());
                filled[k] |= 1 << c;
            }
        }
        ranks.least(&mut gaps);
        ranks.unite(&mut filled);
        let near = |(k, &id): (usize, &NodeId)| {
            let index = lattice.node_index(id);
            let around =
                (0..1_u8 << D).filter_map(|c| cell_around(&index, lattice.cells(), lattice.periodic(), c));
            let weight = around.map(|cell| determinant(&edges(&rest, cell)).abs()).sum();
            Near { id, gap: gaps[k], weight, filled: filled[k] }
        };
        Self { all: support.nodes.iter().enumerate().map(near).collect() }
    }
}

/// Lowest and highest index of a support's nodes.
struct Bounds<const D: usize> {
    low: [u32; D],
    high: [u32; D],
    periodic: [bool; D],
}

impl<const D: usize> Bounds<D> {
    fn of(support: &Support<D>, periodic: [bool; D], index: impl Fn(NodeId) -> [u32; D]) -> Self {
        let (mut low, mut high) = ([u32::MAX; D], [0; D]);
        for index in support.nodes.iter().map(|&node| index(node)) {
            for d in 0..D {
                (low[d], high[d]) = (low[d].min(index[d]), high[d].max(index[d]));
            }
        }
        Self { low, high, periodic }
    }

    /// Whether a cell can have one of the nodes as a corner.
    fn may_hold(&self, cell: [u32; D]) -> bool {
        (0..D).all(|d| self.periodic[d] || (cell[d] + 1 >= self.low[d] && cell[d] <= self.high[d]))
    }
}

/// Number of a node among some that ascend.
fn find(nodes: &[NodeId], node: NodeId) -> Option<usize> {
    let guess = node.index().checked_sub(nodes.first()?.index())?;
    if nodes.get(guess) == Some(&node) { Some(guess) } else { nodes.binary_search(&node).ok() }
}

/// Edges of a cell at its first corner, as columns `[L]`.
fn edges<const D: usize>(mesh: &Mesh<D>, cell: [u32; D]) -> Block<D> {
    let corners = mesh.corner_positions(cell);
    Block::from_fn(|i, d| corners[1 << d][i] - corners[0][i])
}

/// Half extents of a point's domain along the edges of its cell, now and at rest `[cells]`: at rest it is taken for a cell
/// made smaller in so many coordinates. A layer is 1 thick.
fn half_extent<const D: usize>(
    view: &PointView<D>,
    [now, rest]: [Block<D>; 2],
    coordinates: usize,
) -> Vector<D> {
    let half = 0.5 * (view.reference_size / determinant(&rest).abs()).powf(1.0 / coordinates as f64);
    let sides = inverse(&now) * view.deformation_gradient * rest;
    Vector::from_fn(|d, _| half * (0..D).map(|j| sides[(d, j)].abs()).sum::<f64>())
}

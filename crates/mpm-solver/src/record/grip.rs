//! How far bodies are from the nodes that drive them.
//!
//! Nodes with `displace` or `turn` take along whatever material is in their cells. In a mesh that does not move with them
//! the body leaves: the force then falls without a sign, or is that of other material. The *gap* of a node is the larger
//! of two distances, in cells, of at most 1:
//! * from the node to the nearest domain of a point in its cells, 1 where there is none;
//! * if nodes of the support were at the body's surface at the start, `1 - Σ S_w(x_v - r)` over the driven nodes w, where
//!   r is the prescribed displacement so far less that of the mesh. What is at the node has come from there; from lines or
//!   faces of driven nodes, along which a body slides, that is 0. Turned nodes have no such part.
//!
//! The gap of a support is the one within which nodes of half the weight lie that carried material at the start; the
//! weight of a node is the volume of its cells at rest.

use crate::model::{Model, Prescribed, Support};
use mpm_assembly::{PointView, determinant, views};
use mpm_grid::{Block, LoadFraction, Mesh, MeshMotion, NodeId, NodeKind, Vector, inverse};
use serde::{Deserialize, Serialize};
use std::array::from_fn;

/// A gap that has grown by more than this ends the run `[cells]`.
pub(crate) const MOST: f64 = 0.5;

/// How a support holds its body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Grip {
    /// The gap at the start `[cells]`.
    pub at_start: f64,
    /// The gap in the last row `[cells]`.
    pub now: f64,
    /// Weight of the nodes with material `[L^D]`.
    weight: f64,
    /// Whether nodes of half that weight are at the body's surface.
    at_surface: bool,
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

impl Grip {
    /// At the start, in the mesh there.
    pub(crate) fn at_start<const D: usize>(model: &Model<D>, support: &Support<D>, mesh: &Mesh<D>) -> Self {
        let nodes = Nodes::near(model, support, mesh);
        let carrying = || nodes.all.iter().filter(|node| node.gap < 1.0);
        let weight: f64 = carrying().map(|node| node.weight).sum();
        let surface: f64 = carrying().filter(|node| node.is_at_surface).map(|node| node.weight).sum();
        let gap = within(carrying().map(|node| (node.gap, node.weight)).collect(), 0.5 * weight);
        Self { at_start: gap, now: gap, weight, at_surface: surface >= 0.5 * weight }
    }

    /// The gap later, in the mesh that the points meet next `[cells]`.
    pub(crate) fn gap_at<const D: usize>(
        &self,
        model: &Model<D>,
        support: &Support<D>,
        (mesh, at): (&Mesh<D>, LoadFraction),
    ) -> f64 {
        let nodes = Nodes::near(model, support, mesh);
        let carrying = || nodes.all.iter().filter(|node| node.gap < 1.0);
        let gap = within(carrying().map(|node| (node.gap, node.weight)).collect(), 0.5 * self.weight);
        if !self.at_surface {
            return gap;
        }
        let gone = departures(model, support, (mesh, at), carrying().map(|node| node.id), -1.0);
        let weighted: Vec<(f64, f64)> = gone.into_iter().zip(carrying().map(|node| node.weight)).collect();
        let half = 0.5 * weighted.iter().map(|it| it.1).sum::<f64>();
        gap.max(within(weighted, half))
    }

    /// Whether it can be that of a support.
    pub(crate) fn is_possible(&self) -> bool {
        [self.at_start, self.now].iter().all(|gap| (0.0..=1.0).contains(gap))
            && self.weight >= 0.0
            && self.weight.is_finite()
    }

    /// Whether the body is lost.
    pub(crate) fn is_lost(&self) -> bool {
        self.weight > 0.0 && (self.now >= 1.0 || self.now > self.at_start + MOST)
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

/// `1 - Σ S_w(x_v + s r)` of some nodes v of a support, s being 1 or -1 `[cells]`; 0 where that has no meaning.
pub(crate) fn departures<const D: usize>(
    model: &Model<D>,
    support: &Support<D>,
    (mesh, at): (&Mesh<D>, LoadFraction),
    nodes: impl Iterator<Item = NodeId>,
    sign: f64,
) -> Vec<f64> {
    let turns = support.components.iter().flatten().any(|it| matches!(it, Prescribed::Turned(_)));
    let renames = matches!(model.motion, MeshMotion::Rotate { .. } | MeshMotion::Twist { .. });
    let rest = Mesh::at_rest(&model.layout);
    // The mesh in which a support of a later stage took hold.
    let from = LoadFraction::start_of(support.active.from);
    let begun = (from.stage() > 0).then(|| model.motion.mesh_at(&model.layout, from).ok()).flatten();
    let departure = |node: NodeId| {
        if turns || renames {
            return 0.0;
        }
        let x = mesh.position(node);
        let carried = x - begun.as_ref().unwrap_or(&rest).position(node);
        let relative = Vector::from_fn(|d, _| match &support.components[d] {
            Some(Prescribed::Driven(ramp)) => ramp.from_rest(at) - carried[d],
            _ => 0.0,
        });
        let Ok(place) = mesh.locate(&(x + relative * sign), 0.5) else { return 1.0 };
        let mut held = 0.0;
        mesh.values(&place, |corner, value| {
            if support.nodes.binary_search(&corner).is_ok() {
                held += value;
            }
        });
        (1.0 - held).clamp(0.0, 1.0)
    };
    nodes.map(departure).collect()
}

/// A driven node and the material around it.
struct Near {
    id: NodeId,
    /// To the nearest domain in its cells, at most 1 `[cells]`.
    gap: f64,
    weight: f64,
    /// Whether some of its cells hold no point.
    is_at_surface: bool,
}

/// The nodes of a support.
struct Nodes {
    all: Vec<Near>,
}

impl Nodes {
    fn near<const D: usize>(model: &Model<D>, support: &Support<D>, mesh: &Mesh<D>) -> Self {
        let (lattice, rest) = (mesh.lattice(), Mesh::at_rest(&model.layout));
        let mut gaps = vec![1.0; support.nodes.len()];
        // Which of its cells hold points: the cell in which the node is corner c is bit c.
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
                    half_extent(&view, &edges(mesh, place.cell), &edges(&rest, place.cell))
                });
                let apart = Vector::<D>::from_fn(|d, _| {
                    let side = if c >> d & 1 == 0 { -1.0 } else { 1.0 };
                    (0.5 * (place.local[d] - side).abs() - half[d]).max(0.0)
                });
                gaps[k] = f64::min(gaps[k], apart.norm());
                filled[k] |= 1 << c;
            }
        }
        let near = |(k, &id): (usize, &NodeId)| {
            let (mut weight, mut cells) = (0.0, 0);
            for c in 0..1_u8 << D {
                let Some(cell) = cell_around(&lattice.node_index(id), lattice.cells(), lattice.periodic(), c)
                else {
                    continue;
                };
                weight += determinant(&edges(&rest, cell)).abs();
                cells |= 1 << c;
            }
            Near { id, gap: gaps[k], weight, is_at_surface: filled[k] != cells }
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

/// The cell of which a node is corner `c`, if there is one.
pub(crate) fn cell_around<const D: usize>(
    node: &[u32; D],
    cells: [u32; D],
    periodic: [bool; D],
    c: u8,
) -> Option<[u32; D]> {
    let along = |d: usize| {
        let cell = if c >> d & 1 == 0 { Some(node[d]) } else { node[d].checked_sub(1) };
        let wrapped =
            if periodic[d] { cell.unwrap_or(cells[d] - 1) % cells[d] } else { cell.unwrap_or(cells[d]) };
        (wrapped < cells[d]).then_some(wrapped)
    };
    let found: [Option<u32>; D] = from_fn(along);
    found.iter().all(Option::is_some).then(|| from_fn(|d| found[d].unwrap_or_default()))
}

/// Edges of a cell at its first corner, as columns `[L]`.
fn edges<const D: usize>(mesh: &Mesh<D>, cell: [u32; D]) -> Block<D> {
    let corners = mesh.corner_positions(cell);
    Block::from_fn(|i, d| corners[1 << d][i] - corners[0][i])
}

/// Half extents of a point's domain along the edges of its cell `[cells]`: at rest it is taken for a cell made smaller.
fn half_extent<const D: usize>(view: &PointView<D>, now: &Block<D>, rest: &Block<D>) -> Vector<D> {
    let half = 0.5 * (view.reference_size / determinant(rest).abs()).powf(1.0 / D as f64);
    let sides = inverse(now) * view.deformation_gradient * rest;
    Vector::from_fn(|d, _| half * (0..D).map(|j| sides[(d, j)].abs()).sum::<f64>())
}

//! Material that has passed the edge of a region of driven nodes.
//!
//! A rigid thing that drives its nodes takes along what was in its cells at the start. In a mesh that does not move with it
//! the nodes stay: at the front of the region that material leaves them, at the back other material comes to them, and
//! the force is that of a thing that lags behind. With r the displacement that is prescribed, that at a node X is now at
//! X + r, and what is at a node x was at x - r; both are looked for among the driven nodes w of the mesh of their time:
//! `1 - Σ S_w(X + r)` at the front, `1 - Σ S_w(x - r)` at the back. A region along which material slides, such as a line of
//! nodes that moves lengthwise, has no front but its end, which is left out, as are edges without material.

use crate::model::{Model, Prescribed, Support, Turn};
use mpm_grid::{Block, Layout, LoadFraction, Mesh, MeshMotion, NodeId, Span, Vector, inverse};
use std::array::from_fn;

/// What is less is rounding `[cells]`.
const ROUNDING: f64 = 1e-9;

/// How far from a node the edge of its region is looked for, over an edge of its cells.
const LOOK: f64 = 0.25;

/// How far into a cell a place on its face is moved, over its diagonal.
const INTO: f64 = 1e-3;

/// A support and the meshes between which it has moved its nodes.
pub(crate) struct Departures<'a, const D: usize> {
    support: &'a Support<D>,
    /// When the support took hold, and the mesh at that time.
    begun: (LoadFraction, Mesh<D>),
    /// The mesh now.
    mesh: &'a Mesh<D>,
    at: LoadFraction,
    /// Along rings of nodes about whose centre the support turns: by how much. Their cells are straight, places on the arc
    /// between two nodes are not in them `[cells]`.
    along_ring: Option<f64>,
    /// Coordinates of a place.
    coordinates: usize,
}

impl<'a, const D: usize> Departures<'a, D> {
    pub(crate) fn of(
        model: &Model<D>,
        support: &'a Support<D>,
        (mesh, at): (&'a Mesh<D>, LoadFraction),
    ) -> Self {
        let from = LoadFraction::start_of(support.active.from);
        let begun = model.motion.mesh_at(&model.layout, from);
        let begun = begun.unwrap_or_else(|_| Mesh::at_rest(&model.layout));
        let along_ring = along_ring(model, support, [from, at]);
        Self { support, begun: (from, begun), mesh, at, along_ring, coordinates: model.coordinates() }
    }

    /// How far material has passed a node, at most 1; none where none passes, as far as the cells around it tell in which
    /// there is any: bit c stands for the cell in which the node is corner c `[cells]`.
    pub(crate) fn at(&self, node: NodeId, filled: u8) -> Option<f64> {
        if let Some(cells) = self.along_ring {
            return self.along_ring(node, filled, cells);
        }
        let ((from, begun), at) = (&self.begun, self.at);
        let now = self.mesh.position(node);
        let (to, carried) = self.goes_to(node);
        let came_from = now + self.prescribed(&now, [at, *from], &carried, -1.0);
        let along = self.direction(&now, &(to - now))?;
        if !self.is_across(node, self.lattice_direction(node, &along)?) {
            return None;
        }
        let front = self.is_edge(node, &along, filled).then(|| self.outside(self.mesh, &to));
        let back = self.is_edge(node, &-along, filled).then(|| self.outside(begun, &came_from));
        // The rim of a round region has steps, over which little passes; the rest of the rim counts against them.
        let rest = (self.turns() && self.is_rim(node, filled)).then_some(0.0);
        let passed = front.into_iter().chain(back).chain(rest).reduce(f64::max)?;
        Some(if passed < ROUNDING { 0.0 } else { passed })
    }

    /// The same for a turn by so many cells along the ring of the node.
    fn along_ring(&self, node: NodeId, filled: u8, cells: f64) -> Option<f64> {
        if cells == 0.0 || !self.is_across(node, 0) {
            return None;
        }
        let lattice = self.mesh.lattice();
        let (index, n) = (lattice.node_index(node), i64::from(lattice.cells()[0]));
        let drives = |by: f64| {
            let at = i64::from(index[0]) + by as i64;
            let at = if lattice.periodic()[0] { at.rem_euclid(n) } else { at };
            let other = u32::try_from(at).ok().filter(|_| at <= n);
            other.is_some_and(|at| {
                let mut other = index;
                other[0] = at;
                self.drives(lattice.node(other))
            })
        };
        let outside = |by: f64| {
            let (whole, part) = (by.floor(), by - by.floor());
            let held = |by: f64| f64::from(u8::from(drives(by)));
            1.0 - (1.0 - part) * held(whole) - part * held(whole + 1.0)
        };
        // Ahead of a node are the cells of which it is a first corner.
        let has_material = |side: u8| (0..1_u8 << D).any(|c| filled >> c & 1 == 1 && c & 1 == side);
        let passes = |sign: f64| {
            let side = u8::from(sign * cells < 0.0);
            (!drives((sign * cells).signum()) && has_material(side)).then(|| outside(sign * cells))
        };
        let rest = self.is_rim(node, filled).then_some(0.0);
        passes(1.0).into_iter().chain(passes(-1.0)).chain(rest).reduce(f64::max)
    }

    /// The direction of the lattice along which something moves most, in cells.
    fn lattice_direction(&self, node: NodeId, along: &Vector<D>) -> Option<usize> {
        let lattice = self.mesh.lattice();
        let index = lattice.node_index(node);
        let around = |c| Some((c, cell_around(&index, lattice.cells(), lattice.periodic(), c)?));
        let (c, cell) = (0..1_u8 << D).find_map(around)?;
        let corners = self.mesh.corner_positions(cell);
        let edges =
            Block::<D>::from_fn(|i, d| corners[usize::from(c ^ (1 << d))][i] - corners[usize::from(c)][i]);
        Some((inverse(&edges) * along).iamax())
    }

    /// Where the material of a node now is, and by how much the mesh has carried the node `[L]`.
    fn goes_to(&self, node: NodeId) -> (Vector<D>, Vector<D>) {
        let before = self.begun.1.position(node);
        let carried = self.mesh.position(node) - before;
        (before + self.prescribed(&before, [self.begun.0, self.at], &carried, 1.0), carried)
    }

    /// Whether material of any of the nodes is no longer at driven nodes.
    pub(crate) fn any(&self) -> bool {
        self.support.nodes.iter().any(|&node| {
            let (to, _) = self.goes_to(node);
            to != self.mesh.position(node) && self.outside(self.mesh, &to) > ROUNDING
        })
    }

    /// Displacement that is prescribed at a place between two load fractions, where the mesh has been carried by `carried`
    /// times `sign` `[L]`.
    fn prescribed(
        &self,
        x: &Vector<D>,
        [from, to]: [LoadFraction; 2],
        carried: &Vector<D>,
        sign: f64,
    ) -> Vector<D> {
        Vector::from_fn(|d, _| match &self.support.components[d] {
            // A turn about the axis of a body of revolution leads to no other place.
            _ if d >= self.coordinates => 0.0,
            Some(Prescribed::Driven(ramp)) => ramp.from_rest(to) - ramp.from_rest(from),
            Some(Prescribed::Turned(turn)) => turn.displacement(x, from, to)[d],
            Some(Prescribed::Held) => 0.0,
            Some(Prescribed::FollowMesh) | None => sign * carried[d],
        })
    }

    /// In which direction material moves past a node, and as far as that is a quarter of its cells' edges; none if it
    /// does not `[L]`.
    fn direction(&self, now: &Vector<D>, past: &Vector<D>) -> Option<Vector<D>> {
        // Along the arc, not its chord.
        let arc = |turn: &Turn| {
            let angle = turn.angle.from_rest(self.at);
            let [d, e] = turn.across();
            let sign = if turn.axis == 1 { -angle } else { angle };
            let mut arc = Vector::<D>::zeros();
            (arc[d], arc[e]) = (sign * (turn.centre[1] - now[e]), sign * (now[d] - turn.centre[0]));
            arc
        };
        let turned = self.support.components.iter().flatten().find_map(|it| match it {
            Prescribed::Turned(turn) if past.amax() > 0.0 => Some(arc(turn)),
            _ => None,
        });
        let along = Vector::<D>::from_fn(|d, _| match (&turned, &self.support.components[d]) {
            (Some(arc), Some(Prescribed::Turned(_))) => arc[d],
            _ => past[d],
        });
        (along.amax() > 0.0).then_some(along)
    }

    /// Whether driven nodes lie beside a node in every direction across its motion, or none before or behind it: the
    /// region is a face there, not the end of a line or of a sheet.
    fn is_across(&self, node: NodeId, along: usize) -> bool {
        let lattice = self.mesh.lattice();
        let index = lattice.node_index(node);
        let has_neighbour = |d: usize| {
            let beside = neighbours(index, lattice.cells(), lattice.periodic(), d);
            beside.into_iter().any(|other| self.drives(lattice.node(other)))
        };
        (0..self.coordinates).filter(|&d| d != along).all(has_neighbour) || !has_neighbour(along)
    }

    /// Whether the region ends beside a node in a direction, and material is there.
    fn is_edge(&self, node: NodeId, along: &Vector<D>, filled: u8) -> bool {
        let lattice = self.mesh.lattice();
        let index = lattice.node_index(node);
        (0..1_u8 << D).filter(|c| filled >> c & 1 == 1).any(|c| {
            let Some(cell) = cell_around(&index, lattice.cells(), lattice.periodic(), c) else { return false };
            let corners = self.mesh.corner_positions(cell);
            let corner = corners[usize::from(c)];
            let edge = |d: usize| (corners[usize::from(c ^ (1 << d))] - corner).norm();
            let shortest = (0..self.coordinates).map(edge).fold(f64::INFINITY, f64::min);
            let place = corner + along * (LOOK * shortest / along.norm());
            // Of the cells that share a face, each is asked with a place that is in it.
            let inside = place + (corners[usize::from(c ^ ((1 << D) - 1))] - corner) * INTO;
            let found = self.mesh.locate(&inside, 0.0);
            found.is_ok_and(|found| found.cell == cell) && self.outside(self.mesh, &place) > ROUNDING
        })
    }

    fn turns(&self) -> bool {
        self.support.components.iter().flatten().any(Prescribed::is_turn)
    }

    /// Whether a cell around a node has material and free nodes.
    fn is_rim(&self, node: NodeId, filled: u8) -> bool {
        let lattice = self.mesh.lattice();
        let index = lattice.node_index(node);
        (0..1_u8 << D).filter(|c| filled >> c & 1 == 1).any(|c| {
            let cell = cell_around(&index, lattice.cells(), lattice.periodic(), c);
            cell.is_some_and(|cell| {
                lattice.corners(cell)[..1 << self.coordinates].iter().any(|&node| !self.drives(node))
            })
        })
    }

    fn drives(&self, node: NodeId) -> bool {
        self.support.nodes.binary_search(&node).is_ok()
    }

    /// Share of a place that free nodes have; 1 outside of the mesh.
    fn outside(&self, mesh: &Mesh<D>, x: &Vector<D>) -> f64 {
        let Ok(place) = mesh.locate(x, 0.5) else { return 1.0 };
        let mut held = 0.0;
        mesh.values(&place, |corner, value| {
            if self.drives(corner) {
                held += value;
            }
        });
        (1.0 - held).clamp(0.0, 1.0)
    }
}

/// By how many cells a support turns along the rings of a mesh about their centre; 0 where the mesh moves, too. None if it does
/// not.
fn along_ring<const D: usize>(
    model: &Model<D>,
    support: &Support<D>,
    [from, to]: [LoadFraction; 2],
) -> Option<f64> {
    let Layout::Ring { centre, sectors, span, .. } = &model.layout else { return None };
    let turn = support.components.iter().flatten().find_map(|it| match it {
        Prescribed::Turned(turn) if turn.axis == 2 && turn.centre == *centre => Some(turn),
        _ => None,
    })?;
    let span = match span {
        Span::Full => std::f64::consts::TAU,
        Span::Sector { from, to } => to - from,
    };
    let angle = turn.angle.from_rest(to) - turn.angle.from_rest(from);
    let is_fixed = matches!(model.motion, MeshMotion::Fixed);
    Some(if is_fixed { angle * f64::from(*sectors) / span } else { 0.0 })
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

/// Indices of the nodes before and after one in a direction.
pub(crate) fn neighbours<const D: usize>(
    index: [u32; D],
    cells: [u32; D],
    periodic: [bool; D],
    d: usize,
) -> Vec<[u32; D]> {
    let n = cells[d];
    let before = if index[d] > 0 { Some(index[d] - 1) } else { periodic[d].then(|| n - 1) };
    let after = if periodic[d] { Some((index[d] + 1) % n) } else { (index[d] < n).then(|| index[d] + 1) };
    let with = |k: u32| {
        let mut other = index;
        other[d] = k;
        other
    };
    [before, after].into_iter().flatten().map(with).collect()
}

//! Supports that are not at their body, or will lose it, and driven nodes that material can pass.

use crate::model::{Model, Prescribed, Support};
use crate::ranks::Alone;
use crate::record::departures::{Departures, cell_around, neighbours};
use crate::record::grip::{MOST, Nodes, departed, is_driven, is_held_in_moving_mesh, taken_away};
use mpm_basis::ActiveNodes;
use mpm_grid::{LoadFraction, Mesh, NodeId, NodeKind, Position, Vector, six_digits};

/// A body that will be this far from its driven nodes is named `[cells]`.
const FAR: f64 = 0.1;

/// Supports that hold a body from farther away are named; nodes around a curved end are half a cell away in the middle `[cells]`.
const FAR_HELD: f64 = 0.75;

/// Nodes that move less are not asked whether material can pass them `[cells]`.
const FEW: f64 = 0.25;

/// Load fractions that are looked at: the ends of so many equal parts.
const PARTS: u32 = 20;

/// Sentences about supports.
pub(super) fn of<const D: usize>(model: &Model<D>, mesh: &Mesh<D>, active: &ActiveNodes<D>) -> Vec<String> {
    if model.nodes.kind() != NodeKind::Vertices {
        return Vec::new();
    }
    let supports = || model.supports.iter();
    let mut remarks: Vec<String> = supports().filter_map(|it| leaves(model, it, mesh)).collect();
    remarks.extend(supports().filter_map(|support| passes(model, support, mesh, active)));
    remarks.extend(supports().filter_map(|support| is_far(model, support, mesh, active)));
    remarks
}

/// Load fractions of the stages in which a support acts.
fn fractions<const D: usize>(model: &Model<D>, support: &Support<D>) -> impl Iterator<Item = LoadFraction> {
    let stages = (0..model.stages.len() as u32).filter(|&stage| support.acts_in(stage)).collect::<Vec<_>>();
    let parts = |stage| {
        let part = move |k| LoadFraction::in_stage(stage, f64::from(k) / f64::from(PARTS)).ok();
        (1..=PARTS).filter_map(part)
    };
    stages.into_iter().flat_map(parts)
}

/// Nodes whose mesh stays while the body goes with what is prescribed of them.
fn leaves<const D: usize>(model: &Model<D>, support: &Support<D>, mesh: &Mesh<D>) -> Option<String> {
    let is_driven = is_driven(support);
    if !is_driven && !is_held_in_moving_mesh(model, support) {
        return None;
    }
    let nodes = Nodes::near(model, support, mesh, &Alone);
    let (mut most, mut lost) = (0.0, None);
    for at in fractions(model, support) {
        let Ok(moved) = model.motion.mesh_at(&model.layout, at) else { continue };
        let gone = match is_driven {
            true => departed(&Departures::of(model, support, (&moved, at)), nodes.carrying()),
            false => taken_away(model, support, (&moved, at), &Alone),
        };
        most = f64::max(most, gone);
        if gone > MOST && lost.is_none() {
            lost = Some(at);
        }
    }
    if most <= FAR {
        return None;
    }
    let how = match lost {
        Some(at) => format!(
            "by more than half a cell from load fraction {} on, where a run ends that has lost its body",
            six_digits(at.total())
        ),
        None => format!("by up to {} cells, and the reaction is off as far", six_digits(most)),
    };
    let name = &support.name;
    Some(match is_driven {
        true => format!(
            "support `{name}` moves in a mesh that does not move with it: the body leaves its nodes {how}; in a mesh whose \
             `motion` follows, nodes with `follow_mesh` keep it"
        ),
        false => format!(
            "support `{name}` holds the body in a mesh that moves: its nodes leave the body {how}; hold nodes that the \
             `motion` leaves where they are"
        ),
    })
}

/// Nodes that hold a body across cells that it hardly reaches into.
fn is_far<const D: usize>(
    model: &Model<D>,
    support: &Support<D>,
    mesh: &Mesh<D>,
    active: &ActiveNodes<D>,
) -> Option<String> {
    let acts = support.acts_in(0) && support.components.iter().any(Option::is_some);
    if !acts || !support.nodes.iter().any(|&node| active.number(node).is_some()) {
        return None;
    }
    let gap = Nodes::near(model, support, mesh, &Alone).gap();
    (gap > FAR_HELD).then(|| {
        let cells = if gap < 1.0 { format!("{} cells", six_digits(gap)) } else { "nearly a cell".into() };
        format!(
            "support `{}` is {cells} away from the body that it holds: cells that are filled in part are as much softer, and \
             a body that is pulled comes off; put a line of the mesh where the body ends, or hold the next nodes inside",
            support.name
        )
    })
}

/// Nodes of a line or sheet, with free material beside them and room behind.
fn passes<const D: usize>(
    model: &Model<D>,
    support: &Support<D>,
    mesh: &Mesh<D>,
    active: &ActiveNodes<D>,
) -> Option<String> {
    let lattice = mesh.lattice();
    let (cells, periodic) = (lattice.cells(), lattice.periodic());
    let is_driven = |node: NodeId| support.nodes.binary_search(&node).is_ok();
    let is_closed = |cell: [u32; D]| lattice.corners(cell)[..1 << D].iter().all(|&node| is_driven(node));
    let around = |node: NodeId| {
        let index = lattice.node_index(node);
        (0..1_u8 << D).filter_map(move |c| cell_around(&index, cells, periodic, c))
    };
    if support.nodes.iter().any(|&node| around(node).any(is_closed)) {
        return None;
    }
    // Where free material stands beside a driven node, across its motion, and cells on both sides along it.
    let mut leak = None;
    for &node in support.nodes.iter().filter(|&&node| active.number(node).is_some()) {
        let motion = farthest(model, support, mesh, node);
        let size =
            around(node).map(|cell| diameter(mesh, cell, model.coordinates())).fold(f64::INFINITY, f64::min);
        if motion.norm() * (model.coordinates() as f64).sqrt() <= FEW * size {
            continue;
        }
        let along = motion.iamax();
        let index = lattice.node_index(node);
        let has_cells = |d: usize| periodic[d] || (index[d] > 0 && index[d] < cells[d]);
        let beside = (0..D).filter(|&d| d != along).flat_map(|d| neighbours(index, cells, periodic, d));
        let free = |other: [u32; D]| {
            let other = lattice.node(other);
            active.number(other).is_some() && !is_driven(other)
        };
        // Along a line of driven nodes it moves within that line.
        let goes_on =
            neighbours(index, cells, periodic, along).into_iter().any(|next| is_driven(lattice.node(next)));
        if has_cells(along) && !goes_on && beside.into_iter().any(free) {
            leak = Some(mesh.position(node));
            break;
        }
    }
    leak.map(|at| {
        format!(
            "support `{}` is a line of driven nodes with cells on both sides, and material beside it at {} can pass to the other \
             side: nodes that fill cells, a block of them, keep it out",
            support.name,
            Position(&at)
        )
    })
}

/// The largest of the displacements that are prescribed of a node `[L]`.
fn farthest<const D: usize>(model: &Model<D>, support: &Support<D>, mesh: &Mesh<D>, node: NodeId) -> Vector<D> {
    let x = mesh.position(node);
    let displacement = |at: LoadFraction| {
        let moved = model.motion.mesh_at(&model.layout, at).map_or(x, |mesh| mesh.position(node));
        Vector::from_fn(|d, _| match &support.components[d] {
            // A turn about the axis leads to no other place.
            _ if d >= model.coordinates() => 0.0,
            Some(Prescribed::Driven(ramp)) => ramp.from_rest(at),
            Some(Prescribed::Turned(turn)) => turn.displacement(&x, LoadFraction::START, at)[d],
            Some(Prescribed::FollowMesh) => moved[d] - x[d],
            Some(Prescribed::Held) | None => 0.0,
        })
    };
    let stages = (0..model.stages.len() as u32).filter(|&stage| support.acts_in(stage));
    let knots = stages.flat_map(|stage| {
        let knots = model.knots_in(stage).into_iter().chain([1.0]);
        knots.filter_map(move |knot| LoadFraction::in_stage(stage, knot).ok())
    });
    let mut all: Vec<Vector<D>> = knots.map(displacement).collect();
    all.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
    all.pop().unwrap_or_else(Vector::zeros)
}

/// The longest diagonal of a cell from its first corner, in so many coordinates `[L]`.
fn diameter<const D: usize>(mesh: &Mesh<D>, cell: [u32; D], coordinates: usize) -> f64 {
    let corners = mesh.corner_positions(cell);
    (corners[(1 << coordinates) - 1] - corners[0]).norm()
}

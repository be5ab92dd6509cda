//! Cells in which several ranks have points: what is asked for whole, and the nodes that this needs.

use crate::cuts::Cuts;
use crate::message::{Reader, Writer};
use crate::wire::Wire;
use mpm_assembly::{OccupiedCell, Sharing};
use mpm_grid::{CellId, Lattice, Mesh, NodeId, NodeKind, Place, Vector};
use mpm_solver::Model;

/// Ghost faces look at the cells around both cells of a face.
const LAYERS: i64 = 2;

/// Whether a model needs nodes that the points of a rank may not reach, though those of another do: corners of the cells over
/// which volume changes are averaged, and of both cells of ghost faces, and of cells that hold markers.
pub(crate) fn needs_more<const D: usize>(model: &Model<D>) -> bool {
    model.bodies.iter().any(|named| named.body.mean_dilatation().is_some())
        || model.contributions.iter().any(|named| named.contribution.needs_functions_of_mesh())
}

/// These nodes: of cells that hold points of this rank, around the cells whose lowest corner it owns, and those that
/// contributions ask for.
pub(crate) fn more<const D: usize>(
    model: &Model<D>,
    mesh: &Mesh<D>,
    own: &[NodeId],
    sharing: &dyn Sharing<D>,
) -> Vec<NodeId> {
    let (lattice, mut nodes) = (mesh.lattice(), Vec::new());
    nodes.extend(model.contributions.iter().flat_map(|named| named.contribution.nodes(mesh, sharing)));
    let corners = |cell| lattice.corners(cell).into_iter().take(1 << D);
    for named in model.bodies.iter().filter(|named| named.body.mean_dilatation().is_some()) {
        let cells =
            (0..named.body.n_points()).filter_map(|p| mesh.locate(&named.body.point(p).position, 0.5).ok());
        let mut cells: Vec<[u32; D]> = cells.map(|place| place.cell).collect();
        cells.sort_unstable();
        cells.dedup();
        nodes.extend(cells.into_iter().flat_map(corners));
    }
    let stabilised = model.contributions.iter().any(|named| named.contribution.stabilises());
    if stabilised && mesh.functions() != NodeKind::Vertices {
        nodes.extend(around_faces(model, mesh, own, sharing));
    } else if stabilised {
        for cell in own.iter().map(|&node| lattice.node_index(node)) {
            if (0..D).any(|d| cell[d] >= lattice.cells()[d]) {
                continue;
            }
            let above = (0..D).filter_map(|d| lattice.above(cell, d));
            nodes.extend(std::iter::once(cell).chain(above).flat_map(corners));
        }
    }
    nodes
}

/// Nodes of the cells beside both cells of the faces above cells of this rank, where the functions are splines: a cell counts
/// there if all its nodes are active.
fn around_faces<const D: usize>(
    model: &Model<D>,
    mesh: &Mesh<D>,
    own: &[NodeId],
    sharing: &dyn Sharing<D>,
) -> Vec<NodeId> {
    let (lattice, reach) = (mesh.lattice(), model.nodes.degrees().into_iter().max().unwrap_or(1));
    let index = own.iter().map(|&node| model.nodes.lattice().node_index(node));
    // A node with an index of a cell is one of the nodes of that cell, or of one that is as far away as functions reach.
    let mut cells = near(lattice, index.map(|it| clamped(it, lattice)).collect(), reach);
    cells.retain(|&cell| sharing.is_own(cell));
    let above: Vec<[u32; D]> =
        cells.iter().flat_map(|&cell| (0..D).filter_map(move |d| lattice.above(cell, d))).collect();
    cells.extend(above);
    let mut nodes = Vec::new();
    for cell in near(lattice, cells, 1) {
        mesh.values(&Place { cell, local: Vector::zeros() }, |node, _| nodes.push(node));
    }
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// The cell with the index of a node, or the last one.
fn clamped<const D: usize>(index: [u32; D], lattice: &Lattice<D>) -> [u32; D] {
    std::array::from_fn(|d| index[d].min(lattice.cells()[d] - 1))
}

/// Cells at most so many steps away from some, along every direction.
fn near<const D: usize>(lattice: &Lattice<D>, mut cells: Vec<[u32; D]>, steps: u32) -> Vec<[u32; D]> {
    for (d, _) in (0..D).flat_map(|d| (0..steps).map(move |k| (d, k))) {
        let beside = |&cell: &[u32; D]| [lattice.below(cell, d), lattice.above(cell, d)];
        let next: Vec<[u32; D]> = cells.iter().flat_map(beside).flatten().collect();
        cells.extend(next);
        cells.sort_unstable();
        cells.dedup();
    }
    cells
}

/// What all ranks occupy together, of the cells of this rank and those around them: every rank tells the owners, who add it up
/// in the order of the ranks and tell those around.
pub(crate) fn joined<const D: usize>(
    lattice: &Lattice<D>,
    occupied: &[OccupiedCell],
    cuts: &Cuts<D>,
    wire: &impl Wire,
) -> Vec<OccupiedCell> {
    let own = sums(&told(occupied, wire, |cell| vec![cuts.owner(lattice.cell_index(cell.cell))]));
    told(&own, wire, |cell| around(lattice, lattice.cell_index(cell.cell), cuts))
}

/// The ranks that own cells around one, ascending.
fn around<const D: usize>(lattice: &Lattice<D>, cell: [u32; D], cuts: &Cuts<D>) -> Vec<usize> {
    let (cells, periodic) = (lattice.cells(), lattice.periodic());
    let mut owners = Vec::new();
    for k in 0..(2 * LAYERS + 1).pow(D as u32) {
        let (mut index, mut rest, mut is_there) = (cell, k, true);
        for d in 0..D {
            let at = i64::from(cell[d]) + rest % (2 * LAYERS + 1) - LAYERS;
            rest /= 2 * LAYERS + 1;
            let n = i64::from(cells[d]);
            let at = if periodic[d] { at.rem_euclid(n) } else { at };
            is_there &= (0..n).contains(&at);
            index[d] = at.clamp(0, n - 1) as u32;
        }
        if is_there {
            owners.push(cuts.owner(index));
        }
    }
    owners.sort_unstable();
    owners.dedup();
    owners
}

/// Sends every cell to the ranks that `to` names, and returns what came, in the order of the ranks.
fn told(
    cells: &[OccupiedCell],
    wire: &impl Wire,
    to: impl Fn(&OccupiedCell) -> Vec<usize>,
) -> Vec<OccupiedCell> {
    let mut out: Vec<Writer> = vec![Writer::default(); wire.size()];
    for cell in cells {
        for rank in to(cell) {
            out[rank].count(cell.cell.index() as u64);
            out[rank].number(cell.volume);
            out[rank].number(cell.stiffness);
        }
    }
    let out = out.into_iter().map(Writer::finish).enumerate().filter(|it| !it.1.is_empty());
    let mut came = Vec::new();
    for (_, bytes) in wire.exchange(&out.collect::<Vec<_>>()) {
        let mut from = Reader::new(&bytes);
        while !from.is_at_end() {
            let cell = CellId::from_index(from.index()).expect("the number of a cell");
            came.push(OccupiedCell { cell, volume: from.number(), stiffness: from.number() });
        }
    }
    came
}

/// Every cell once, with what was told of it in order.
fn sums(told: &[OccupiedCell]) -> Vec<OccupiedCell> {
    let mut all = told.to_vec();
    // Stable.
    all.sort_by_key(|it| it.cell);
    let of_cell = |of: &[OccupiedCell]| OccupiedCell {
        cell: of[0].cell,
        volume: of.iter().map(|it| it.volume).sum(),
        stiffness: of.iter().map(|it| it.stiffness).sum(),
    };
    all.chunk_by(|a, b| a.cell == b.cell).map(of_cell).collect()
}

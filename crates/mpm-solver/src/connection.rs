//! Points to nodes: what the bodies' points reach in the mesh of a load step, and the pattern of the tangent.

use crate::error::StepFailure;
use crate::model::{Model, NamedBody};
use crate::skipped::Skipped;
use crate::timing::{Phase, Timings};
use mpm_assembly::{Connection, GhostFaces, Linked, Pattern};
use mpm_basis::{ActiveNodes, Links, Stencils, UnconnectedPoint};
use mpm_grid::{Layout, LoadFraction, Mesh, MeshMotion};

/// Points to nodes: the active nodes, each body's connection to them, and the tangent's pattern.
pub(crate) struct Connected<const D: usize> {
    pub active: ActiveNodes<D>,
    /// Of every body.
    pub connections: Vec<Connection<D>>,
    pub pattern: Pattern<D>,
    pub ghost: Option<Ghost<D>>,
}

/// Penalised faces, and where their stiffness goes in the pattern.
pub(crate) struct Ghost<const D: usize> {
    pub faces: GhostFaces<D>,
    pub slots: Vec<u32>,
}

/// The connectivity of the load step that was tried last.
pub(crate) struct Former<const D: usize> {
    pub connected: Connected<D>,
    /// Load fraction at the start of that step, if it failed: the points are still as they were there.
    pub start_of_failed_step: Option<LoadFraction>,
}

/// Connects the points to the nodes of `mesh` for a load step that begins at load fraction `start`, and counts what
/// need not be done anew.
///
/// # Errors
/// A point, or a part of its domain, lies outside the mesh.
pub(crate) fn connect_step<const D: usize>(
    model: &Model<D>,
    mesh: &Mesh<D>,
    start: LoadFraction,
    former: &mut Option<Former<D>>,
    timings: &mut Timings,
) -> Result<Connected<D>, StepFailure> {
    let (connected, kept) = match former.take() {
        // Neither points nor mesh have changed since the step failed.
        Some(former) if former.start_of_failed_step == Some(start) => (former.connected, Kept::All),
        former => {
            let former = former.map(|former| former.connected);
            timings.time(Phase::Connect, || connect(model, mesh, former))?
        }
    };
    let skipped = &mut timings.skipped;
    kept.count(skipped);
    skipped.nodes = (mesh.lattice().n_nodes() - connected.active.len()) as u64;
    skipped.upper_triangle = (connected.pattern.n_entries() - connected.pattern.n_equations()) as u64;
    skipped.mesh_moves += u64::from(model.motion == MeshMotion::Fixed);
    Ok(connected)
}

/// Influences of all bodies' points on the nodes of `mesh`.
pub(crate) fn stencils<const D: usize>(
    model: &Model<D>,
    mesh: &Mesh<D>,
) -> Result<Vec<Stencils<D>>, StepFailure> {
    model.bodies.iter().map(|named| named.body.stencils(mesh).map_err(|it| outside(named, &it))).collect()
}

fn outside<const D: usize>(named: &NamedBody<D>, it: &UnconnectedPoint<D>) -> StepFailure {
    StepFailure::Outside { body: named.name.clone(), basis: named.body.basis(), reason: it.to_string() }
}

/// How much of the connectivity before could be kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kept {
    /// Its memory.
    Memory,
    /// The pattern and the order of sums: no point has changed its nodes.
    Pattern,
    /// All of it: neither points nor mesh have changed.
    All,
}

impl Kept {
    /// Counts what need not be made anew.
    pub(crate) fn count(self, skipped: &mut Skipped) {
        match self {
            Kept::Memory => {}
            Kept::Pattern => skipped.patterns += 1,
            Kept::All => skipped.connections += 1,
        }
    }
}

/// Connects the points to the nodes of `mesh`; `former` is the connectivity of the step before.
pub(crate) fn connect<const D: usize>(
    model: &Model<D>,
    mesh: &Mesh<D>,
    former: Option<Connected<D>>,
) -> Result<(Connected<D>, Kept), StepFailure> {
    let stencils = stencils(model, mesh)?;
    let active = ActiveNodes::of(mesh.lattice(), &stencils);
    let linked: Vec<Linked<D>> = stencils
        .into_iter()
        .zip(&model.bodies)
        .map(|(stencils, named)| {
            let links = Links::of(stencils, &active);
            let dilatation = named.body.dilatation(&links, mesh, &active).map_err(|it| outside(named, &it))?;
            Ok(Linked { links, dilatation })
        })
        .collect::<Result<_, _>>()?;
    let faces = model.ghost.map(|factor| {
        let mut cells = Vec::new();
        for (named, linked) in model.bodies.iter().zip(&linked) {
            named.body.occupied_cells(&linked.links, mesh.lattice(), &active, &mut cells);
        }
        GhostFaces::of(mesh, &active, cells, factor)
    });
    // Faces are taken anew, and with them what they couple.
    let same = faces.is_none()
        && former.as_ref().is_some_and(|former| {
            former.active == active
                && linked.iter().zip(&former.connections).all(|(now, before)| before.is_connected_as(now))
        });
    match former {
        Some(Connected { connections, pattern, .. }) if same => {
            let connections =
                connections.into_iter().zip(linked).map(|(kept, now)| kept.relinked(now.links)).collect();
            Ok((Connected { active, connections, pattern, ghost: None }, Kept::Pattern))
        }
        former => {
            let former = former.map(|former| former.pattern);
            let pattern = Pattern::reusing(former, active.len(), &linked, faces.as_ref());
            let connections = linked.into_iter().map(|linked| Connection::new(linked, &pattern)).collect();
            let ghost = faces.map(|faces| Ghost { slots: faces.slots(&pattern), faces });
            Ok((Connected { active, connections, pattern, ghost }, Kept::Memory))
        }
    }
}

/// Where the lattice lines of each direction stand at rest `[L]`; in directions that do not exist there is one.
pub(crate) fn lines<const D: usize>(layout: &Layout<D>) -> [Vec<f64>; 3] {
    let mut lines: [Vec<f64>; 3] = std::array::from_fn(|_| vec![0.0]);
    for (padded, lines) in lines.iter_mut().zip(layout.lines()) {
        *padded = lines;
    }
    lines
}

/// Lattice lines of the directions that close on themselves.
pub(crate) fn periods<const D: usize>(mesh: &Mesh<D>) -> [Option<u32>; 3] {
    let (periodic, nodes) = (mesh.lattice().periodic(), mesh.lattice().nodes());
    std::array::from_fn(|d| (d < D && periodic[d]).then(|| nodes[d]))
}

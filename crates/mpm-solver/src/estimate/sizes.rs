//! The memory of what connects points, nodes and unknowns, at the start or once bodies have moved.

use super::rehearsal::{Rehearsal, are_pushed, factor_size, is_iterative};
use super::start::{connected, supported};
use crate::connection::{Connected, lines, places};
use crate::error::Error;
use crate::model::Model;
use mpm_grid::{Layout, LoadFraction, Mesh, MeshMotion, Ramp};
use mpm_linear::predict;

/// Vectors over all components of displacement that Newton's iteration holds: trial, correction, residual, reaction,
/// external force, and those of the step before.
const VECTORS: usize = 8;

/// Part of a cell by which bodies are taken to have moved: domains that filled cells reach into others, and no domain is
/// beyond its mesh.
const MOVED: f64 = 1e-3;

/// Lines of a direction up to which they are moved: each of them then has a coordinate of its own in memory.
const MOST_LINES: u32 = 1 << 24;

/// Bytes held at the peak of a load step, by owner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Memory {
    /// Material points: the committed state and the state being prepared.
    pub points: usize,
    /// Influences of points on nodes, and where their sums go.
    pub connectivity: usize,
    /// The tangent, its pattern, and the pattern that the factorisation keeps.
    pub tangent: usize,
    /// The factor and its structure, or the multigrid hierarchy; where tools push the bodies, also the vectors of GMRES.
    pub solver: usize,
    /// What is taken besides once a tangent is factorised that the iteration does not solve, where tools push the bodies; 0
    /// where that is not to be expected, or not done. Not part of the sum.
    pub factorised: usize,
    /// What contributions hold besides, such as the corners of domains near tools; most have nothing.
    pub contributions: usize,
    /// Vectors of the iteration, and the positions of the points as they are recorded.
    pub work: usize,
    /// The program with its libraries, whatever the scene.
    pub program: usize,
}

impl Memory {
    /// The sum of what every load step takes.
    pub fn total(&self) -> usize {
        let of_bodies = self.points + self.connectivity + self.tangent + self.solver;
        of_bodies + self.contributions + self.work + self.program
    }
}

/// What the smallest run takes, HDF5 and what it holds of an empty results file included: measured (x86-64, Linux)
/// `[bytes]`.
const PROGRAM: usize = 28 << 20;

/// What is held beside the points.
pub(super) struct Sizes {
    /// See [`super::Estimate::factor_entries`].
    pub factor_entries: usize,
    /// Without the points, and with none of what is held for them in the iteration.
    pub memory: Memory,
}

/// What is held with this connectivity.
///
/// # Errors
/// Not even the structure of the factor fits into memory.
pub(super) fn sizes<const D: usize>(stage: &Rehearsal<'_, D>) -> Result<Sizes, Error> {
    let Connected { active, assembly_plans, pattern, .. } = stage.connected;
    let (entries, n, real) = (pattern.n_entries(), pattern.n_equations(), size_of::<f64>());
    let solver = size_of_solver(stage)?;
    let tangent = match is_iterative(stage) {
        true => entries * (real + size_of::<usize>()) + (n + 1) * size_of::<usize>(),
        false => entries * (real + 2 * size_of::<usize>()) + 2 * (n + 1) * size_of::<usize>(),
    };
    let memory = Memory {
        points: 0,
        connectivity: active.bytes() + assembly_plans.iter().map(|it| it.bytes()).sum::<usize>(),
        tangent,
        solver: solver.bytes,
        factorised: solver.factorised,
        contributions: stage.model.contributions.iter().map(|named| named.contribution.bytes()).sum(),
        work: VECTORS * n * real,
        program: PROGRAM,
    };
    Ok(Sizes { factor_entries: solver.factor_entries, memory })
}

/// The same once bodies have moved: domains that fill cells at the start then reach into others and couple more nodes.
/// Nothing where no body has domains, and on meshes with very many lines.
///
/// # Errors
/// As of [`sizes`].
pub(super) fn sizes_once_moved<const D: usize>(model: &mut Model<D>) -> Result<Option<Sizes>, Error> {
    let reach = model.bodies.iter().any(|named| named.body.has_domains());
    let are_few = model.layout.lattice().nodes().iter().all(|&lines| lines <= MOST_LINES);
    if !reach || !are_few {
        return Ok(None);
    }
    let Some(mesh) = mesh_under_moved_bodies(&model.layout) else { return Ok(None) };
    // What cannot be connected is told of the bodies at the start.
    let Ok((connected, connect)) = connected(model, &mesh) else { return Ok(None) };
    let (lattice, lines) = (connected.active.lattice_indices(), lines(model));
    let places = places(model, &lattice, &lines);
    let prediction = predict(connected.pattern.for_solver(), places);
    let constraints = supported(model, &connected.active, 0);
    let (constraints, prediction) = (&constraints, &prediction);
    let stage =
        Rehearsal { model, mesh: &mesh, connected: &connected, connect, constraints, places, prediction };
    sizes(&stage).map(Some)
}

/// A mesh that stands to the bodies as the mesh of the run once they have moved: its lines have moved by a little, and its outer
/// ones stay. Of sectors of rings the lines along the radii stay, too.
fn mesh_under_moved_bodies<const D: usize>(layout: &Layout<D>) -> Option<Mesh<D>> {
    let moved = layout.with_lines_moved(MOVED);
    let motion = match &moved {
        Layout::Ring { centre, span, sectors, .. } if span.is_full() => {
            let angle = Ramp::new(vec![(0.0, 0.0), (1.0, MOVED * span.step(*sectors))]).ok()?;
            MeshMotion::rotate(*centre, angle).ok()?
        }
        _ => MeshMotion::Fixed,
    };
    motion.mesh_at(&moved, LoadFraction::START.with_value(1.0)).ok()
}

/// What the linear solver holds.
struct SolverSize {
    factor_entries: usize,
    bytes: usize,
    /// See [`Memory::factorised`].
    factorised: usize,
}

fn size_of_solver<const D: usize>(stage: &Rehearsal<'_, D>) -> Result<SolverSize, Error> {
    let prediction = stage.prediction;
    let entries = prediction.factor_entries as usize;
    let iterative = prediction.iterative_bytes as usize;
    match (is_iterative(stage), are_pushed(stage.model)) {
        (true, false) => Ok(SolverSize { factor_entries: entries, bytes: iterative, factorised: 0 }),
        (true, true) => {
            let bytes = iterative + prediction.indefinite_bytes as usize;
            if !prediction.is_factorised_as_help() {
                return Ok(SolverSize { factor_entries: entries, bytes, factorised: 0 });
            }
            let size = factor_size(stage)?;
            Ok(SolverSize { factor_entries: size.entries, bytes, factorised: size.bytes })
        }
        (false, _) => {
            let size = factor_size(stage)?;
            Ok(SolverSize { factor_entries: size.entries, bytes: size.bytes, factorised: 0 })
        }
    }
}

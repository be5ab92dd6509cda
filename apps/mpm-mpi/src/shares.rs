//! What every rank will have of a scene.

use mpm_basis::Connectivity;
use mpm_cluster::{Cluster, Wire};
use mpm_grid::LoadFraction;
use mpm_solver::{Model, Ranks};
use std::fmt::Write;

/// Newton iterations of a load step, about.
const ITERATIONS: usize = 5;

/// Bytes of a rank beside what its points and nodes take: program, MPI, PETSc.
const PROGRAM: usize = 65 << 20;

/// Bytes of an entry of the tangent: the caller's value and row, and of both triangles value and column of PETSc's matrix, the block in
/// single precision, where it goes, and the coarse images.
const ENTRY: usize = 16 + 2 * (8 + 4 + 6 + 2 + 3);

/// Bytes of a point besides its columns and influences: its place at the start, messages, what is worked out for a record. Measured, as
/// the next two, on blocks in the plane and in space of a quarter of a million points to a million.
const POINT: usize = 300;

/// Bytes of an equation in the vectors of Newton's method, of the iteration, and of its levels.
const EQUATION: usize = 250;

/// Bytes of every point of the scene on rank 0, which puts records in order.
const RECORDED: f64 = 110.0;

/// Lines for all ranks: points, nodes, memory and bytes of messages in a load step, about.
pub(crate) fn shares<const D: usize, W: Wire + 'static>(
    cluster: &Cluster<D, W>,
    model: &mut Model<D>,
) -> Result<String, String> {
    cluster.divide(model, LoadFraction::START)?;
    let mesh = model.motion.mesh_at(&model.layout, LoadFraction::START).map_err(|it| it.to_string())?;
    let stencils: Result<Vec<_>, _> = model.bodies.iter().map(|named| named.body.stencils(&mesh)).collect();
    // The estimate has refused points outside the mesh before.
    let stencils = stencils.map_err(|it| it.to_string())?;
    let points: usize = model.bodies.iter().map(|named| named.body.n_points()).sum();
    let active = cluster.activate(model, &mesh, &stencils);
    let connected = stencils.into_iter().map(|stencils| Connectivity::of(stencils, &active));
    let influences: usize = connected.map(|it| it.n_influences()).sum();
    // Nodes that a point reaches along a direction, and nodes that one couples with, on both of its sides.
    let reach = (influences as f64 / points.max(1) as f64).max(1.0).powf(1.0 / D as f64);
    let coupled = (2.0 * reach - 1.0).powi(D as i32);
    let exchange = cluster.exchange();
    let numbering = exchange.numbering();
    let (nodes, shared) = (numbering.nodes.len(), numbering.n_shared());
    let sent: usize = numbering.of_owner.iter().chain(&numbering.of_sharer).map(|it| it.nodes.len()).sum();
    let to_owners: usize = numbering.of_owner.iter().map(|it| it.nodes.len()).sum();
    // Internal forces go to the owner and back, corrections come from the owner, and rows of the tangent go there: nodes at the
    // side of a rank couple with about as many of its own as stand on one side of them.
    let rows = to_owners as f64 * coupled * reach / (2.0 * reach - 1.0);
    let bytes = ITERATIONS * size_of::<f64>() * D * (3 * sent + D * rows as usize);
    let stored: usize = model.bodies.iter().map(|it| it.body.stored_columns()).flatten().map(|it| it.1).sum();
    let of_points = points * 2 * stored / model.bodies.len().max(1) * size_of::<f64>()
        + influences * (D + 1) * size_of::<f64>();
    // The lower triangle.
    let entries = (nodes * D * D) as f64 * coupled / 2.0;
    let memory = PROGRAM + of_points + points * POINT + nodes * D * EQUATION + entries as usize * ENTRY;
    drop(numbering);
    let own = [points, nodes, shared, memory, bytes].map(|it| it as f64);
    let mut all = vec![0.0; own.len() * exchange.wire().size()];
    exchange.wire().gather(&own, &mut all);
    let mut text = format!(
        "{:>6}  {:>12}  {:>12}  {:>12}  {:>12}  {:>12}\n",
        "rank", "points", "nodes", "shared", "memory MB", "kB a step"
    );
    let points_of_all: f64 = all.chunks_exact(5).map(|own| own[0]).sum();
    for (rank, own) in all.chunks_exact(5).enumerate() {
        let [points, nodes, shared, memory, bytes] = [0, 1, 2, 3, 4].map(|k| own[k]);
        let memory = if rank == 0 { memory + RECORDED * points_of_all } else { memory };
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{rank:>6}  {points:>12}  {nodes:>12}  {shared:>12}  {:>12.0}  {:>12.1}",
            memory / 1e6,
            bytes / 1e3
        );
    }
    Ok(text)
}

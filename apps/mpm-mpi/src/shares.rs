//! What every rank will have of a scene.

use mpm_cluster::{Cluster, Wire};
use mpm_grid::LoadFraction;
use mpm_solver::{Model, Ranks};
use std::fmt::Write;

/// Newton iterations of a load step, about.
const ITERATIONS: usize = 5;

/// Bytes of a rank beside what its points and nodes take: program, MPI, PETSc.
const PROGRAM: usize = 65 << 20;

/// Nodes that a point reaches along a direction, at most.
const INFLUENCES: usize = 3;

/// Bytes of an entry of the tangent: the caller's value and row, and of both triangles value, row and column as PETSc is told of
/// them, where they go in its matrix, and the matrix with its coarse images.
const ENTRY: usize = 16 + 2 * (8 + 4 + 4 + 16 + 12 + 4);

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
    let influences = points * INFLUENCES.pow(D as u32);
    cluster.activate(model, &mesh, &stencils);
    let exchange = cluster.exchange();
    let numbering = exchange.numbering();
    let (nodes, shared) = (numbering.nodes.len(), numbering.n_shared());
    let sent: usize = numbering.of_owner.iter().chain(&numbering.of_sharer).map(|it| it.nodes.len()).sum();
    // Internal forces go to the owner and back, corrections come from the owner.
    let bytes = ITERATIONS * 3 * sent * D * size_of::<f64>();
    let stored: usize = model.bodies.iter().map(|it| it.body.stored_columns()).flatten().map(|it| it.1).sum();
    let of_points = points * 2 * stored / model.bodies.len().max(1) * size_of::<f64>()
        + influences * (D + 1) * size_of::<f64>();
    // Half of the 5^D nodes that one couples with.
    let entries = nodes * D * D * 5_usize.pow(D as u32) / 2;
    let memory = PROGRAM + of_points + entries * ENTRY;
    drop(numbering);
    let own = [points, nodes, shared, memory, bytes].map(|it| it as f64);
    let mut all = vec![0.0; own.len() * exchange.wire().size()];
    exchange.wire().gather(&own, &mut all);
    let mut text = format!(
        "{:>6}  {:>12}  {:>12}  {:>12}  {:>12}  {:>12}\n",
        "rank", "points", "nodes", "shared", "memory MB", "kB a step"
    );
    for (rank, own) in all.chunks_exact(5).enumerate() {
        let [points, nodes, shared, memory, bytes] = [0, 1, 2, 3, 4].map(|k| own[k]);
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

//! A basis is asked for the stencils of all points of a body.

use crate::basis::Basis;
use crate::influence::Stencil;
use crate::parallel::each;
use crate::stencils::{Chunk, Stencils, UnconnectedPoint};
use mpm_grid::{Mesh, NodeSpace, Vector};

/// Points per parallel task; fixed, so that nothing depends on the number of threads. A run of points
/// that share their nodes ends with its task.
const CHUNK: usize = 512;

impl<const D: usize> Stencils<D> {
    /// Asks `basis` for the influences of every point; `x` and `domain` have one entry per point.
    ///
    /// # Errors
    /// The first point (in order) that the mesh does not cover.
    ///
    /// # Panics
    /// The mesh has no nodes of the basis' kind.
    pub fn of<B: Basis<D>>(
        basis: &B,
        mesh: &Mesh<D>,
        x: &[Vector<D>],
        domain: &[B::Domain],
    ) -> Result<Self, UnconnectedPoint<D>> {
        assert_eq!(x.len(), domain.len(), "one domain per point");
        let nodes = NodeSpace::of(basis.node_kind(), mesh).expect("the mesh has nodes of the basis' kind");
        let chunks: Vec<Result<_, UnconnectedPoint<D>>> = each(x.len().div_ceil(CHUNK), &|chunk| {
            let first = chunk * CHUNK;
            let points = first..(first + CHUNK).min(x.len());
            let mut made = Chunk::with_capacity(points.len());
            let mut stencil = Stencil::new();
            for point in points {
                stencil.clear();
                basis
                    .influences(mesh, &x[point], &domain[point], &mut stencil)
                    .map_err(|reason| UnconnectedPoint { point, position: x[point], reason })?;
                stencil.finish();
                made.push(stencil.entries());
            }
            made.finish(nodes.lattice());
            Ok(made)
        });
        Ok(Self { chunks: chunks.into_iter().collect::<Result<_, _>>()? })
    }
}

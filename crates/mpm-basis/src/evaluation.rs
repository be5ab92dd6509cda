//! A basis is asked for the stencils of all points of a body.

use crate::basis::Basis;
use crate::influence::Stencil;
use crate::parallel::each;
use crate::stencils::{Chunk, Stencils, UnconnectedPoint};
use mpm_grid::{Mesh, NodeKind, NodeSpace, OutsideMesh, Vector};
use std::sync::{Mutex, PoisonError};

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
        Self::gather(basis.node_kind(mesh), mesh, (x, domain), Chunk::clone, |x, domain, stencil, made| {
            basis.influences(mesh, x, domain, stencil)?;
            stencil.finish();
            made.push(stencil.entries());
            Ok(())
        })
    }

    /// As [`Self::of`] for rings in the half plane (r, z), see [`Basis::ring_influences`]; with the parts of the points'
    /// masses where these are wanted.
    ///
    /// # Errors
    /// As [`Self::of`].
    ///
    /// # Panics
    /// As [`Self::of`].
    pub fn of_rings<B: Basis<D>>(
        basis: &B,
        mesh: &Mesh<D>,
        (x, domain): (&[Vector<D>], &[B::Domain]),
        with_masses: bool,
    ) -> Result<Self, UnconnectedPoint<D>> {
        Self::gather(basis.node_kind(mesh), mesh, (x, domain), Chunk::clone, |x, domain, stencil, made| {
            basis.ring_influences(mesh, x, domain, stencil)?;
            stencil.finish();
            made.push(stencil.entries());
            if with_masses {
                let mut masses = Stencil::new();
                basis.ring_masses(mesh, x, domain, &mut masses)?;
                masses.finish();
                made.push_masses(stencil.entries(), masses.entries());
            }
            Ok(())
        })
    }

    /// The nodes of [`Self::of`], or of [`Self::of_rings`], without the influences: they tell which nodes are
    /// [active](crate::ActiveNodes), and no more.
    ///
    /// # Errors
    /// As [`Self::of`].
    ///
    /// # Panics
    /// As [`Self::of`].
    pub fn of_nodes<B: Basis<D>>(
        basis: &B,
        mesh: &Mesh<D>,
        (x, domain): (&[Vector<D>], &[B::Domain]),
        are_rings: bool,
    ) -> Result<Self, UnconnectedPoint<D>> {
        let keep = Chunk::without_influences;
        Self::gather(basis.node_kind(mesh), mesh, (x, domain), keep, |x, domain, stencil, made| {
            match are_rings {
                true => basis.ring_influences(mesh, x, domain, stencil)?,
                false => basis.influences(mesh, x, domain, stencil)?,
            }
            stencil.finish();
            made.push(stencil.entries());
            Ok(())
        })
    }

    /// Asks for the influences of every point, a chunk at a time, and keeps of a chunk what is to be kept.
    fn gather<Domain: Sync>(
        kind: NodeKind,
        mesh: &Mesh<D>,
        (x, domain): (&[Vector<D>], &[Domain]),
        keep: impl Fn(&Chunk<D>) -> Chunk<D> + Sync,
        add: impl Fn(&Vector<D>, &Domain, &mut Stencil<D>, &mut Chunk<D>) -> Result<(), OutsideMesh<D>> + Sync,
    ) -> Result<Self, UnconnectedPoint<D>> {
        assert_eq!(x.len(), domain.len(), "one domain per point");
        let nodes = NodeSpace::of(kind, mesh).expect("the mesh has nodes of the basis' kind");
        // A list grows in memory that tasks hand on. What is kept is a copy of its exact length.
        let spare: Mutex<Vec<Chunk<D>>> = Mutex::default();
        let spare = || spare.lock().unwrap_or_else(PoisonError::into_inner);
        let chunks: Vec<Result<_, UnconnectedPoint<D>>> =
            each(x.len().div_ceil(CHUNK), &|chunk| {
                let first = chunk * CHUNK;
                let points = first..(first + CHUNK).min(x.len());
                let mut made = spare().pop().unwrap_or_default();
                made.clear();
                let mut stencil = Stencil::new();
                for point in points {
                    stencil.clear();
                    add(&x[point], &domain[point], &mut stencil, &mut made)
                        .map_err(|reason| UnconnectedPoint { point, position: x[point], reason })?;
                }
                made.finish(nodes.lattice());
                let kept = keep(&made);
                spare().push(made);
                Ok(kept)
            });
        Ok(Self { chunks: chunks.into_iter().collect::<Result<_, _>>()? })
    }
}

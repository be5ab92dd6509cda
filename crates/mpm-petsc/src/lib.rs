//! Many machines: linear systems by [PETSc](https://petsc.org), messages by MPI.
//!
//! [`Session`] starts MPI and PETSc. [`MpiWire`] carries bytes between ranks. [`Petsc`] is the linear solver of ranks that
//! share a system: each hands over its part of the matrix, PETSc adds the parts and solves.
//!
//! This is the only crate that binds foreign libraries besides HDF5, and the only one with `unsafe`. It has a workspace of
//! its own (`apps/mpm-mpi`), so that nothing else needs PETSc, MPI or clang.

mod error;
mod ffi;
mod handles;
mod lattices;
mod numbering;
mod session;
mod solver;
mod system;
mod wire;

pub use error::PetscError;
pub use session::Session;
pub use solver::{Owners, Petsc};
pub use wire::MpiWire;

/// Bytes between ranks; a copy until mpm-cluster is there.
pub trait Wire {
    /// Number of this rank.
    fn rank(&self) -> usize;
    /// Number of ranks.
    fn size(&self) -> usize;
    /// All ranks' numbers, in the order of the ranks.
    fn gather(&self, own: &[f64], all: &mut [f64]);
    /// Messages to some ranks; those from others, in the order of the ranks.
    fn exchange(&self, out: &[(usize, Vec<u8>)]) -> Vec<(usize, Vec<u8>)>;
}

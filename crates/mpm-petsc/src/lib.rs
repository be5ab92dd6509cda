//! Many machines: linear systems by [PETSc](https://petsc.org), messages by MPI.
//!
//! [`Session`] starts MPI and PETSc. [`MpiWire`] carries bytes between ranks. [`Petsc`] is the linear solver of ranks that
//! share a system: each hands over its part of the matrix, PETSc adds the parts and solves.
//!
//! This is the only crate that binds foreign libraries besides HDF5, and the only one with `unsafe`. It has a workspace of
//! its own (`apps/mpm-mpi`), so that nothing else needs PETSc, MPI or clang.

mod assembly;
mod blocks;
mod cycle;
mod error;
mod ffi;
mod handles;
mod ksp;
mod lattices;
mod numbering;
mod owners;
mod product;
mod rows;
mod session;
mod solver;
mod sweeps;
mod system;
mod wire;

pub use error::PetscError;
pub use owners::Owners;
pub use session::Session;
pub use solver::Petsc;
pub use wire::{MpiWire, Traffic};

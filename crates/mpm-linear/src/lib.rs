#![doc = include_str!("../README.md")]

mod automatic;
pub mod direct;
mod matrix;
pub mod multigrid;
mod prediction;
mod report;
mod solver;

pub use automatic::{Automatic, Choice};
pub use direct::{FactorSize, Factorization, dense_operation, predict_factor};
pub use matrix::{Matrix, Pattern, Symmetry};
pub use multigrid::{Coarsening, LatticeLines};
pub use prediction::{Prediction, SystemSize, predict};
pub use report::{Analysis, Cause, Factored, Inertia, Method, OutOfMemory, Pivot, Sign, Singular, Solved};
pub use solver::{Hints, LatticePlaces, LinearSolver, NotSavedHere, Saved};

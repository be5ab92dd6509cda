#![doc = include_str!("../README.md")]

mod automatic;
pub mod direct;
mod matrix;
pub mod multigrid;
mod prediction;
mod report;
mod solver;

pub use automatic::{Choice, LinearSolver};
pub use direct::{Factorization, StoredOrder, dense_operation, predict_factor_entries};
pub use matrix::SymmetricPattern;
pub use prediction::{Prediction, predict};
pub use report::{Analysis, Cause, Method, OutOfMemory, Pivot, Report, Singular, SolveReport};
pub use solver::Place;

//! Equilibrium of one load step.
//!
//! `problem.rs` says what is to be balanced and `residual.rs` when it is; `system.rs` solves linear systems with its tangent. Newton's method
//! (`newton.rs` with the line search of `line_search.rs`) balances a load step, in parts where it has to
//! (`relaxation.rs`); `path.rs` balances a step whose load fraction is unknown.

mod line_search;
pub(crate) mod newton;
pub(crate) mod path;
pub(crate) mod problem;
pub(crate) mod relaxation;
mod residual;
pub(crate) mod round_off;
pub(crate) mod system;

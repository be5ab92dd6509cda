#![doc = include_str!("../README.md")]
//!
//! # In more detail
//!
//! Start reading at `cluster.rs`: what a rank does for the solver. Who owns what is in `cuts.rs`, what ranks have in common
//! of the nodes of a load step in `exchange.rs`, the way of the points in `points.rs`.
//!
//! A rank sums the forces and the tangent of its points into its arrays. Several ranks may reach a node: every node has one
//! owner, and what ranks have of it is added there, so that there are no ghost points and no layers of ghost cells. Where a point
//! is changes what has to be sent and not the answer.

mod bordered;
mod cells;
mod cluster;
mod cuts;
mod exchange;
mod gathered;
mod key;
mod memories;
mod message;
mod numbering;
mod observer;
mod points;
mod refusals;
mod threads;
mod wire;

pub use bordered::Bordered;
pub use cluster::{Cluster, Placement, SolverOfRanks};
pub use cuts::Cuts;
pub use exchange::{Exchange, MoreNodes};
pub use gathered::Gathered;
pub use key::Key;
pub use message::{Reader, Writer};
pub use numbering::Numbering;
pub use observer::Whole;
pub use threads::{Threads, on_threads};
pub use wire::Wire;

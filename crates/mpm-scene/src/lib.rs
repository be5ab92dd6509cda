#![doc = include_str!("../README.md")]
//!
//! # In more detail
//!
//! A [`Scene`] is read from RON ([`language`]) and [`compile`]d into a model of `mpm-solver`, in which nothing is left
//! to look up. Bodies are filled with material points on the way. Formats of files stay outside: [`SceneFiles`] turns
//! the names that a scene holds into triangles and tables of points.

mod added_stages;
mod boundary;
mod check;
mod compile;
mod compiled;
mod disc;
mod error;
mod files;
mod fill;
pub mod language;
mod limits;
mod pieces;
mod places;
mod plausibility;
mod seeding;
mod share;
mod vortex;

pub use added_stages::AddedStages;
pub use check::{
    Check, CheckedBody, CheckedMemory, CheckedSeconds, CheckedStage, seconds_of_run, unwritten_fields,
};
pub use compile::{
    Acting, ActingOn, Along, BodyShares, DrawnLoad, DrawnSide, DrivenPath, ToolSurface, acting, compile,
    compile_share, compile_share_within, compile_with, compile_within, drive, in_plane, mesh_of,
    shares_at_rest, tool_surfaces,
};
pub use compiled::Compiled;
pub use error::SceneError;
pub use files::{NamedColumns, NoFiles, PointTable, SceneFiles};
pub use language::Scene;
pub use plausibility::{doubts, implausible};
pub use share::ShareOfPoints;
pub use vortex::Vortex;

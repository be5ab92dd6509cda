//! Contact of bodies with rigid tools: corners of the points' domains against the signed distance to a tool.
//!
//! Everything is frozen when a load step begins (which corners are near, the nodes that carry them, what they remember
//! and which share of the tool's surface is theirs), but the trial displacement and the tool's pose at the end of the
//! step. A corner stands at `x_c + Σ_v W_cv Δu_v`, which is linear in the unknowns, and its nodes are among those that
//! its point influences: contact couples nothing that the body has not coupled.

mod areas;
mod by_point;
mod contributes;
mod corners;
mod fields;
pub(crate) mod loaded;
mod members;
mod memory;
mod search;
mod summary;
mod told;
mod tool_contact;

pub use loaded::ToolLoad;
pub use tool_contact::{RigidTool, ToolContact};

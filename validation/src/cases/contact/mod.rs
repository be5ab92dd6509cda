//! Contact with rigid tools.

mod blocks;
mod circle;
mod cylinder;
mod edges;
mod friction;
mod hertz;
mod motions;
mod rate;
mod turned;

pub(super) use blocks::CASE as BLOCKS;
pub(super) use circle::CASE as CIRCLE;
pub(super) use cylinder::CASE as CYLINDER;
pub(super) use edges::CASE as EDGES;
pub(super) use friction::CASE as FRICTION;
pub(super) use hertz::CASE as HERTZ;
pub(super) use motions::CASE as MOTIONS;
pub(super) use rate::CASE as RATE;
pub(super) use turned::CASE as TURNED;

use crate::history::History;
use crate::variants::{Method, PlaneScene};

/// A component of what the history tells of a tool.
fn of_tool(history: &History, tool: &str, column: &str, component: usize) -> Vec<f64> {
    history.series(&format!("tool/{tool}/{column}"), component)
}

/// The scene with another basis, and the rest as it is.
fn on(method: &Method, mut scene: PlaneScene) -> PlaneScene {
    scene.basis = method.basis;
    scene
}

//! Contact with rigid tools.

mod blocks;
mod circle;
mod cylinder;
mod edges;
mod friction;
mod hertz;
mod motions;
mod pile;
mod plough;
mod rate;
mod sand;
mod space;
mod sphere;
mod turned;
mod vane;

pub(super) use blocks::CASE as BLOCKS;
pub(super) use circle::CASE as CIRCLE;
pub(super) use cylinder::CASE as CYLINDER;
pub(super) use edges::CASE as EDGES;
pub(super) use friction::CASE as FRICTION;
pub(super) use hertz::CASE as HERTZ;
pub(super) use motions::CASE as MOTIONS;
pub(super) use pile::{CASE as PILE, INSTALLED as INSTALLED_PILE};
pub(super) use plough::CASE as PLOUGH;
pub(super) use rate::CASE as RATE;
pub(super) use sand::CASE as PILE_IN_SAND;
pub(super) use space::CASE as SPACE;
pub(super) use sphere::CASE as SPHERE;
pub(super) use turned::CASE as TURNED;
pub(super) use vane::CASE as VANE;

use crate::Broken;
use crate::history::History;
use crate::scenes::{changed, own_text};
use crate::variants::{Method, PlaneScene};
use mpm_scene::language::Scene;

/// A component of what the history tells of a tool.
pub(in crate::cases) fn of_tool(history: &History, tool: &str, column: &str, component: usize) -> Vec<f64> {
    history.series(&format!("tool/{tool}/{column}"), component)
}

/// A scene of `validation/scenes/contact` with other values, each a path and what stands there.
fn scene(name: &str, changes: &[(&str, String)]) -> Result<Scene, Broken> {
    changed(own_text(&format!("contact/{name}"))?, changes)
}

/// Nodes of an axis from 0 to `far`: `cells` of them as long as each other up to `near`, beyond that each longer than the one before
/// by the same factor of at most 1.25.
fn nodes(cells: u32, near: f64, far: f64) -> Vec<f64> {
    let size = near / f64::from(cells);
    let reach = |factor: f64, count: i32| (1..=count).map(|k| size * factor.powi(k)).sum::<f64>();
    let count = (1..).find(|&count| reach(1.25, count) >= far - near).unwrap_or(1);
    let (mut low, mut high) = (1.0, 1.25);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if reach(middle, count) < far - near {
            low = middle;
        } else {
            high = middle;
        }
    }
    let beyond = (1..count).map(|k| near + reach(low, k)).chain([far]);
    (0..=cells).map(|k| size * f64::from(k)).chain(beyond).collect()
}

/// Nodes of an axis as the scene language writes them.
fn written(nodes: impl IntoIterator<Item = f64>) -> String {
    let list: Vec<String> = nodes.into_iter().map(|node| node.to_string()).collect();
    format!("Nodes([{}])", list.join(", "))
}

/// The value at no size of cells, of two with errors of first order.
fn extrapolated([coarse, fine]: [(f64, f64); 2]) -> f64 {
    fine.1 - fine.0 * (coarse.1 - fine.1) / (coarse.0 - fine.0)
}

/// The scene with another basis, and the rest as it is.
fn on(method: &Method, mut scene: PlaneScene) -> PlaneScene {
    scene.basis = method.basis;
    scene
}

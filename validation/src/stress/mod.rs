//! Attempts to break the code, in the order of the report.

mod cuts;
mod grids;
mod loads;
mod scales;

use crate::history::History;
use crate::scenes::{Run, run};
use crate::variants::{Method, PlaneScene, plane};
use crate::{Broken, Case};
use mpm_scene::language::{Positive, Scene, StabilisationInput};

/// All stress tests.
pub const STRESS: &[Case] = &[
    cuts::CONDITION,
    cuts::ANSWER,
    grids::OFFSETS,
    grids::PERTURBED,
    grids::GRADED,
    loads::STEPS,
    loads::ROUNDING,
    loads::EXTREMES,
    loads::TINY,
    loads::CYCLES,
    scales::UNITS,
];

/// A scene in plane strain from its text.
fn scene(text: &str) -> Result<PlaneScene, Broken> {
    plane(Scene::from_ron(text)?)
}

/// The scene with another basis, with and without ghost stabilisation.
fn variant(scene: &PlaneScene, method: &Method, ghost: bool) -> PlaneScene {
    let mut scene = method.of(scene.clone());
    scene.stabilisation = ghost.then_some(StabilisationInput::Ghost { factor: Some(Positive(1.0 / 30.0)) });
    scene
}

fn run_plane(scene: PlaneScene) -> Result<Run, Broken> {
    run(&Scene::PlaneStrain(scene))
}

/// Linear solutions, halvings of a run.
fn effort(history: &History) -> [f64; 2] {
    ["newton_iterations", "cuts"].map(|column| history.series(column, 0).iter().sum())
}

/// Why a run ended, where it did not reach its end.
fn reason(run: &Run) -> String {
    run.outcome.as_ref().err().map_or(String::new(), ToString::to_string)
}

/// Smallest, median and largest.
fn spread(mut values: Vec<f64>) -> Option<[f64; 3]> {
    values.sort_by(f64::total_cmp);
    Some([*values.first()?, values[values.len() / 2], *values.last()?])
}

//! The same bits on any number of threads.

use crate::history::Row;
use crate::scenes::{load_own, run};
use crate::{Broken, Case, Check};
use mpm_solver::scene::{AxisInput, Count, MeshInput, Positive, Scene};

pub(super) const CASE: Case = Case {
    name: "determinism",
    goal: "The number of threads changes nothing, not one bit.",
    setup: "The pulled block with 180 × 180 cells (129,600 points, more than 60,000 equations; with debug assertions 40 × 40) in two load steps, partly plastic.",
    reference: "The run on one thread: history (but for the wall time), residuals, positions and stresses on 2, 3 and 8 threads.",
    run: determinism,
};

fn determinism() -> Result<Vec<Check>, Broken> {
    let cells = if cfg!(debug_assertions) { 40 } else { 180 };
    let scene = resized(load_own("pulled_block")?, cells);
    let alone = on_threads(&scene, 1)?;
    let rows = alone.len();
    let mut checks = Vec::new();
    for threads in [2, 3, 8] {
        let rows = on_threads(&scene, threads)?;
        let differing =
            rows.iter().zip(&alone).flat_map(|(a, b)| a.iter().zip(b)).filter(|(a, b)| a != b).count();
        let missing = rows.iter().flatten().count().abs_diff(alone.iter().flatten().count());
        checks.push(Check::none(format!("numbers that differ on {threads} threads"), differing + missing));
    }
    let numbers = alone.iter().flatten().count();
    checks[0] = checks[0].clone().remark(format!("{numbers} numbers in {rows} rows, {cells} × {cells} cells"));
    Ok(checks)
}

/// The rows of a run on so many threads, as bits.
fn on_threads(scene: &Scene, threads: usize) -> Result<Vec<Vec<u64>>, Broken> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let history = pool.install(|| run(scene))?.completed()?;
    Ok(history.reproducible().iter().map(Row::bits).collect())
}

/// The pulled block with so many cells along its sides, in two load steps.
fn resized(mut scene: Scene, cells: u32) -> Scene {
    if let Scene::PlaneStrain(scene) = &mut scene {
        if let MeshInput::Box { axes } = &mut scene.mesh {
            for axis in axes {
                if let AxisInput::Uniform { cells: n, .. } = axis {
                    *n = Count(cells);
                }
            }
        }
        scene.schedule.steps = Count(2);
        scene.tolerance.residual = Positive(1e-9);
    }
    scene
}

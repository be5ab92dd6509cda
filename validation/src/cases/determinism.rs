//! The same bits on any number of threads.

use crate::history::{History, Row};
use crate::scenes::{load_own, run};
use crate::{Broken, Case, Check, Extent, Findings};
use mpm_scene::language::{AxisInput, Count, MeshInput, Positive, Scene};
use mpm_solver::observe::Field;

pub(super) const CASE: Case = Case {
    name: "determinism",
    goal: "The number of threads changes nothing, not one bit.",
    setup: "The pulled block with 180 × 180 cells (129,600 points, more than 60,000 equations) in two load steps, partly plastic.",
    reference: "The run on one thread: history (but for the wall time), residuals, positions and stresses on 2, 3 and 8 threads.",
    run: determinism,
};

fn determinism(_: Extent) -> Result<Findings, Broken> {
    let scene = resized(load_own("pulled_block")?, 180);
    let alone = on_threads(&scene, 1)?;
    let equations = alone.series("equations", 0)[1];
    let plastic = alone.field(Field::PLASTIC, alone.rows().len() - 1).iter().sum::<f64>();
    let expected = bits(&alone);

    let mut checks = vec![
        Check::none("equations too few for a test", usize::from(equations < 60_000.0))
            .remark(format!("{equations} equations, {plastic} points plastic")),
        Check::none("lack of plastic points", usize::from(plastic == 0.0)),
    ];
    for threads in [2, 3, 8] {
        let found = bits(&on_threads(&scene, threads)?);
        let differing = found.iter().zip(&expected).filter(|(a, b)| a != b).count();
        checks.push(
            Check::none(
                format!("numbers that differ on {threads} threads"),
                differing + found.len().abs_diff(expected.len()),
            )
            .remark(format!("of {}", expected.len())),
        );
    }
    Ok(checks.into())
}

fn on_threads(scene: &Scene, threads: usize) -> Result<History, Broken> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    pool.install(|| run(scene))?.completed()
}

/// Everything the run showed but its wall time, as bits.
fn bits(history: &History) -> Vec<u64> {
    history.reproducible().iter().flat_map(Row::bits).collect()
}

/// The pulled block with so many cells along its sides, in two load steps.
fn resized(mut scene: Scene, cells: u32) -> Scene {
    if let Scene::PlaneStrain(scene) = &mut scene {
        if let MeshInput::Box { axes, .. } = &mut scene.mesh {
            for axis in axes {
                if let AxisInput::Uniform { cells: n, .. } = axis {
                    *n = Count(cells);
                }
            }
        }
        scene.schedule.steps = Some(Count(2));
        scene.tolerance.residual = Positive(1e-9);
    }
    scene
}

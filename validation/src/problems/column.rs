//! The column under its own weight (Coombs & Augarde 2020, AMPLE): exact stress.

use crate::Broken;
use crate::history::History;
use crate::scenes::load;
use crate::variants::{Method, PlaneScene, in_steps, plane};
use mpm_scene::language::{
    AxisInput, Finite, MaterialInput, MeshInput, Positive, RegionInput, Scene, ShapeInput,
};
use mpm_solver::observe::Field;

/// Weight of the column over its base, ρ0 g H `[F/L²]`.
const PRESSURE: f64 = 80.0 * 10.0 * HEIGHT;
/// Its height at rest `[L]`.
pub(crate) const HEIGHT: f64 = 50.0;

/// How soft the ground is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Load {
    /// E = 10⁴ in 40 load steps: compressed to 0.30 at the base.
    Hard,
    /// E = 10⁶ in 20 load steps.
    Mild,
}

/// The column of so many cells.
///
/// # Errors
/// The scene cannot be read.
pub fn column(load_case: Load, method: &Method, cells: u32) -> Result<Scene, Broken> {
    let mut scene: PlaneScene = method.of(plane(load("column")?)?);
    let width = HEIGHT / f64::from(cells);
    if let MeshInput::Box { axes, .. } = &mut scene.mesh {
        narrow(&mut axes[..1], width, 1);
        narrow(&mut axes[1..], HEIGHT, cells);
    }
    if let ShapeInput::Box { to, .. } = &mut scene.bodies[0].shape {
        to.0[0] = width;
    }
    for support in scene.supports.iter_mut().filter(|it| it.name == "right") {
        if let RegionInput::Plane { at, .. } = &mut support.region {
            at.0 = width;
        }
    }
    if load_case == Load::Mild {
        scene = in_steps(scene, 20);
        for law in scene.materials.values_mut() {
            if let MaterialInput::Hencky { young, .. } = law {
                *young = Positive(1e6).into();
            }
        }
    }
    Ok(Scene::PlaneStrain(scene))
}

/// Uniform axes up to another end.
pub(crate) fn narrow(axes: &mut [AxisInput], end: f64, n: u32) {
    for axis in axes {
        if let AxisInput::Uniform { to, cells, .. } = axis {
            *to = Finite(end);
            cells.0 = n;
        }
    }
}

/// Relative error of the vertical stress at the last row (all points have the same volume at rest):
/// `Σ |σ_yy + ρ0 g (50 - Y)| V0 / (ρ0 g 50 ΣV0)` `[-]`.
pub fn stress_error(history: &History) -> f64 {
    let last = history.rows().len() - 1;
    let stress = history.field(Field::CAUCHY_STRESS, last).chunks_exact(9).map(|it| it[4]);
    let rest = history.rows()[0].positions.chunks_exact(3).map(|x| x[1]);
    let errors: Vec<f64> = stress.zip(rest).map(|(s, y)| (s + PRESSURE * (1.0 - y / HEIGHT)).abs()).collect();
    errors.iter().sum::<f64>() / (errors.len() as f64 * PRESSURE)
}

//! The generalised vortex (Brannon, Kamojjala & Sadeghirad 2011): exact motion and stress.

use crate::Broken;
use crate::history::History;
use crate::scenes::load;
use crate::variants::{Method, PlaneScene, plane, refined};
use mpm_grid::{LoadFraction, Ramp, Vector};
use mpm_scene::Vortex;
use mpm_scene::language::{
    Coordinates, HoldInput, LoadInput, MaterialInput, Poisson, Positive, Quantity, SceneIn, StabilisationInput,
    TilingInput, ToolMotionInput, WallInput,
};
use mpm_solver::observe::Field;

/// The vortex on `24·factor` × `24·factor` cells.
///
/// # Errors
/// The scene cannot be read.
pub fn vortex(method: &Method, factor: u32) -> Result<PlaneScene, Broken> {
    Ok(refined(method.of(plane(load("vortex")?)?), factor))
}

/// The same of polar tiles between walls that hold the edges of the ring, which cut the cells, with ghost faces.
///
/// # Errors
/// The scene cannot be read.
pub fn between_walls(method: &Method, factor: u32) -> Result<PlaneScene, Broken> {
    let mut scene = vortex(method, factor)?;
    scene.supports.clear();
    scene.bodies.iter_mut().for_each(|body| body.tiling = TilingInput::Shape);
    scene.stabilisation = Some(StabilisationInput::Ghost { factor: None });
    scene.walls = ["inner", "outer"].map(held).into();
    Ok(scene)
}

/// A wall that holds all of a side of the ring where it is.
fn held(side: &str) -> WallInput<2> {
    WallInput {
        name: side.to_owned(),
        body: "ring".to_owned(),
        side: side.to_owned(),
        hold: HoldInput::All,
        surface: None,
        motion: ToolMotionInput::default(),
        stiffness: Positive(100.0),
        exact: false,
        moment_about: Coordinates::default(),
    }
}

/// Relative error of displacement and of stress, in the mean square over the volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// Of the displacement `[-]`.
    pub displacement: f64,
    /// Of the Cauchy stress `[-]`.
    pub stress: f64,
}

/// The exact solution of the scene.
///
/// # Errors
/// It holds no vortex in an elastic material.
pub fn exact<B>(scene: &SceneIn<2, B>) -> Result<Vortex, Broken> {
    let angle = scene.loads.iter().find_map(|load| match load {
        LoadInput::Vortex { angle, .. } => Some(angle.0),
        _ => None,
    });
    let angle = Ramp::linear(angle.ok_or("expected a vortex")?.to_radians());
    let material = scene.materials.values().next().ok_or("expected a material")?;
    let shear = |young: &Quantity<Positive>, poisson: &Poisson| {
        young.number().map(|young| young / (2.0 * (1.0 + poisson.0))).ok_or("expected a number")
    };
    match material {
        MaterialInput::Hencky { young, poisson, .. } => Ok(Vortex::new(shear(young, poisson)?, angle)),
        MaterialInput::NeoHooke { young, poisson, .. } => Ok(Vortex::of_rubber(shear(young, poisson)?, angle)),
        _ => Err("expected a vortex in an elastic material".into()),
    }
}

/// The errors of the last row of a run.
///
/// # Errors
/// Its load fraction is none.
pub fn errors(history: &History, field: &Vortex) -> Result<Errors, Broken> {
    let last = history.rows().len() - 1;
    let at = LoadFraction::new(history.last().fraction)?;
    let positions = &history.last().positions;
    let (moved, stress) = (history.field(Field::DISPLACEMENT, last), history.field(Field::CAUCHY_STRESS, last));
    let (mut off, mut far, mut wrong, mut strong) = (0.0, 0.0, 0.0, 0.0);
    for ((x, u), s) in positions.chunks_exact(3).zip(moved.chunks_exact(3)).zip(stress.chunks_exact(9)) {
        let rest = Vector::<2>::new(x[0] - u[0], x[1] - u[1]);
        let there = field.position(&rest, at);
        off += (there - Vector::<2>::new(x[0], x[1])).norm_squared();
        far += (there - rest).norm_squared();
        let [xx, yy, xy] = field.stress(&rest, at);
        wrong += (s[0] - xx).powi(2) + (s[4] - yy).powi(2) + 2.0 * (s[1] - xy).powi(2);
        strong += xx * xx + yy * yy + 2.0 * xy * xy;
    }
    Ok(Errors { displacement: (off / far).sqrt(), stress: (wrong / strong).sqrt() })
}

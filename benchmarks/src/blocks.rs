//! Blocks of any size that settle under their weight by the same strain: the scenes of throughput and
//! growth.

use crate::Failure;
use mpm_scene::language::{
    AxisInput, Coordinates, Count, DomainsInput, Finite, LoadInput, MeshInput, PlaneBasis, RegionInput, Scene,
    SceneIn, ShapeInput, SolidBasis,
};
use mpm_validation::variants::Method;

const PLANE: &str = include_str!("../scenes/million_points.ron");
const SOLID: &str = include_str!("../scenes/block_solid.ron");

/// Stress at the base over Young's modulus: points move through whole cells, and their domains lie
/// anywhere in them.
const STRAIN: f64 = 0.1;
/// Young's modulus of the scenes over their density.
const STIFFNESS: f64 = 1e3;

/// A block of `cells` × `cells` unit cells in the plane.
///
/// # Errors
/// The scene cannot be read.
pub fn plane(method: &Method, cells: u32, steps: u32) -> Result<Scene, Failure> {
    let Scene::PlaneStrain(scene) = Scene::from_ron(PLANE)? else {
        return Err("expected a scene in plane strain".into());
    };
    let mut scene: SceneIn<2, PlaneBasis> = method.of(scene);
    resize(&mut scene, cells, steps)?;
    Ok(Scene::PlaneStrain(scene))
}

/// A block of `cells` × `cells` × `cells` unit cells in space.
///
/// # Errors
/// The scene cannot be read.
pub fn solid(basis: SolidBasis, cells: u32, steps: u32) -> Result<Scene, Failure> {
    let Scene::Solid(mut scene) = Scene::from_ron(SOLID)? else {
        return Err("expected a scene in space".into());
    };
    scene.basis = basis;
    scene.domains = DomainsInput::default();
    resize(&mut scene, cells, steps)?;
    Ok(Scene::Solid(scene))
}

fn resize<const D: usize, B>(scene: &mut SceneIn<D, B>, cells: u32, steps: u32) -> Result<(), Failure> {
    let MeshInput::Box { axes, .. } = &mut scene.mesh else { return Err("expected a box mesh".into()) };
    for axis in axes {
        let AxisInput::Uniform { to, cells: n, .. } = axis else { return Err("expected even axes".into()) };
        (*to, n.0) = (Finite(f64::from(cells)), cells);
    }
    for body in &mut scene.bodies {
        let ShapeInput::Box { to, .. } = &mut body.shape else { return Err("expected a block".into()) };
        *to = Coordinates([f64::from(cells); D]);
    }
    for support in scene.supports.iter_mut().filter(|it| ["right", "front"].contains(&it.name.as_str())) {
        let RegionInput::Plane { at, .. } = &mut support.region else { return Err("expected a wall".into()) };
        *at = Finite(f64::from(cells));
    }
    for load in &mut scene.loads {
        let LoadInput::BodyForce { acceleration, .. } = load else { return Err("expected a weight".into()) };
        acceleration.0[1] = -STRAIN * STIFFNESS / f64::from(cells);
    }
    scene.schedule.steps = Some(Count(steps));
    Ok(())
}

//! What a picture of a scene shows: what material points fill at rest, supports and loads.

use super::axisymmetric::in_plane;
use super::basis::FillBody;
use super::bodies::bodies;
use super::mesh::{component, layout};
use super::stages::Stages;
use super::supports::supports;
use super::tools::ToolParts;
use crate::error::SceneError;
use crate::files::SceneFiles;
use crate::language::{BoundsInput, DomainsInput, LoadInput, PlaneBasis, Scene, SceneIn, SolidBasis};
use crate::limits::memory_left;
use mpm_assembly::{Space, views};
use mpm_grid::{Mesh, NodeSpace, Ramp, Vector};
use mpm_solver::Support;

/// The points of a body at rest, in the order of the results.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyShares {
    /// Name of the body.
    pub name: String,
    /// Positions of the points; the third coordinate is 0 in the plane `[L]`.
    pub centres: Vec<[f64; 3]>,
    /// Corners of what each point stands for: round it in the plane, three or four; in space eight of a hexahedron,
    /// the first axis fastest, or four of a tetrahedron `[L]`.
    pub corners: Vec<Vec<[f64; 3]>>,
}

/// What the points of a scene fill at rest, body by body: the pieces of cells that they were made of, under every basis.
///
/// # Errors
/// What is wrong with the mesh or a body, with its path; a file that cannot be read.
pub fn shares_at_rest(scene: &Scene, files: &dyn SceneFiles) -> Result<Vec<BodyShares>, SceneError> {
    let plane = |scene: &SceneIn<2, PlaneBasis>, space| {
        let basis = if scene.basis == PlaneBasis::Cpdi2t { scene.basis } else { PlaneBasis::Cpdi2q };
        filled(scene, basis, space, files)
    };
    match scene {
        Scene::PlaneStrain(scene) => plane(scene, Space::Cartesian),
        Scene::Axisymmetric(scene) => plane(&in_plane(scene)?, Space::Axisymmetric),
        Scene::Solid(scene) => {
            let is_cut = scene.basis == SolidBasis::Cpdi2Tetrahedron;
            let basis = if is_cut { scene.basis } else { SolidBasis::Cpdi2Hexahedron };
            filled(scene, basis, Space::Cartesian, files)
        }
    }
}

/// The bodies under a basis whose domains are the pieces that points are made of.
fn filled<const D: usize, B: FillBody<D> + ToolParts<D> + Clone>(
    scene: &SceneIn<D, B>,
    basis: B,
    space: Space,
    files: &dyn SceneFiles,
) -> Result<Vec<BodyShares>, SceneError> {
    let memory = memory_left();
    let triangles = scene.domains.triangles;
    let mut scene =
        SceneIn { basis, domains: DomainsInput { triangles, ..DomainsInput::default() }, ..scene.clone() };
    scene.loads.clear();
    scene.walls.clear();
    scene.bodies.iter_mut().for_each(|body| body.initial = None);
    let layout = layout(&scene.mesh, memory)?;
    let bodies = bodies(&scene, (&layout, &Mesh::at_rest(&layout), space), files, memory)?.bodies;
    let spatial = |x: &Vector<D>| std::array::from_fn(|d| if d < D { x[d] } else { 0.0 });
    let shares = bodies.iter().map(|named| {
        let points = 0..named.body.n_points();
        let centres = views(&*named.body).map(|view| spatial(&view.position)).collect();
        let corners = |point| named.body.outline(point).iter().map(spatial).collect();
        BodyShares { name: named.name.clone(), centres, corners: points.map(corners).collect() }
    });
    Ok(shares.collect())
}

/// A load as it is drawn.
#[derive(Clone, Debug)]
pub struct DrawnLoad {
    /// What it acts on.
    pub on: ActingOn,
    /// Its direction where the ramp is positive, of any length.
    pub along: [f64; 2],
    /// Its part against the load fraction.
    pub ramp: Ramp,
}

/// What a load acts on.
#[derive(Clone, Debug, PartialEq)]
pub enum ActingOn {
    /// Every body.
    All,
    /// The part of a body's boundary on a line at rest.
    Boundary {
        /// Name of the body.
        body: String,
        /// Axis that the line cuts.
        axis: usize,
        /// Coordinate of the line `[L]`.
        at: f64,
        /// Corners of the loaded part, if it is not all of it `[L]`.
        within: Option<([f64; 2], [f64; 2])>,
    },
    /// A position of a body at rest.
    Position {
        /// Name of the body.
        body: String,
        /// The position `[L]`.
        near: [f64; 2],
    },
}

/// Supports with the nodes that they hold, and loads.
#[derive(Debug, Default)]
pub struct Acting {
    /// The nodes of supports; nothing in space.
    pub nodes: Option<NodeSpace<2>>,
    /// Supports.
    pub supports: Vec<Support<2>>,
    /// Loads.
    pub loads: Vec<DrawnLoad>,
}

/// Supports and loads of a scene; none in space.
///
/// # Errors
/// What is wrong with the mesh, a support or a load, with its path.
pub fn acting(scene: &Scene) -> Result<Acting, SceneError> {
    match scene {
        Scene::PlaneStrain(scene) => acting_in(scene, Space::Cartesian),
        Scene::Axisymmetric(scene) => acting_in(&in_plane(scene)?, Space::Axisymmetric),
        Scene::Solid(_) => Ok(Acting::default()),
    }
}

fn acting_in(scene: &SceneIn<2, PlaneBasis>, space: Space) -> Result<Acting, SceneError> {
    let layout = layout(&scene.mesh, memory_left())?;
    let nodes = NodeSpace::of(layout.functions(), &Mesh::at_rest(&layout))
        .map_err(|error| SceneError::new("mesh", error))?;
    let supports = supports(scene, (&layout, &nodes), space)?;
    let stages = Stages::of(&scene.schedule);
    let mut loads = Vec::new();
    for (k, load) in scene.loads.iter().enumerate() {
        let path = format!("loads[{k}]");
        let (on, along, ramp, active) = match load {
            LoadInput::BodyForce { acceleration, ramp, active } => {
                (ActingOn::All, acceleration.0, ramp, active)
            }
            LoadInput::PointForce { body, near, force, ramp, active, .. } => {
                (ActingOn::Position { body: body.clone(), near: near.0 }, force.0, ramp, active)
            }
            LoadInput::Traction {
                body,
                axis: Some(axis),
                at: Some(at),
                within,
                resultant,
                value,
                ramp,
                active,
                ..
            } => {
                // A torque about the axis has no direction in the section.
                let Some(along) = resultant.as_ref().or(value.as_ref()) else { continue };
                let axis = component::<2>(*axis, &format!("{path}.axis"))?;
                let ends = |it: &BoundsInput<2>| (it.from.0, it.to.0);
                let on = ActingOn::Boundary {
                    body: body.clone(),
                    axis,
                    at: at.0,
                    within: within.as_ref().map(ends),
                };
                (on, along.0, ramp, active)
            }
            LoadInput::Vortex { .. } | LoadInput::Traction { .. } | LoadInput::Pressure { .. } => continue,
        };
        loads.push(DrawnLoad { on, along, ramp: stages.load_ramp(ramp, 1.0, active, &path)? });
    }
    Ok(Acting { nodes: Some(nodes), supports, loads })
}

//! What a picture of a scene shows: what material points fill at rest, supports and loads.

use super::axisymmetric::in_plane;
use super::basis::FillBody;
use super::bodies::bodies;
use super::mesh::{component, layout};
use super::sides::{Sides, are_named};
use super::stages::Stages;
use super::supports::supports;
use super::tools::ToolParts;
use crate::boundary::Boundary;
use crate::error::SceneError;
use crate::files::SceneFiles;
use crate::language::{
    BodyInput, BoundsInput, DomainsInput, HoldInput, LoadInput, PlaneBasis, Scene, SceneIn, SolidBasis,
    WallInput,
};
use crate::limits::{Room, memory_left};
use mpm_assembly::{Space, views};
use mpm_grid::{Layout, Mesh, NodeSpace, Ramp, Vector};
use mpm_solver::{Model, Support};

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
    let bodies =
        bodies(&scene, (&layout, &Mesh::at_rest(&layout), space), files, Room::for_all(memory))?.bodies;
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
    /// Its direction where the ramp is positive.
    pub along: Along,
    /// Its part against the load fraction.
    pub ramp: Ramp,
}

/// The direction of a load, of any length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Along {
    /// One that stays.
    Fixed([f64; 2]),
    /// Against the outward normal of the side, times this number.
    Inwards(f64),
}

/// A side of a body that a scene names.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnSide {
    /// Name of the body.
    pub body: String,
    /// Ends of its parts at rest, with the body on the left on the way from the first to the second `[L]`.
    pub facets: Vec<[[f64; 2]; 2]>,
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
    /// A side by its name.
    Side(DrawnSide),
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
    /// Sides that walls hold, and whether these let them slide.
    pub walls: Vec<(DrawnSide, bool)>,
}

/// Supports, walls and loads of a scene; none in space. Sides are left out where a body cannot be made, as without a file that it
/// names.
///
/// # Errors
/// What is wrong with the mesh, a support or a load, with its path.
pub fn acting(scene: &Scene, files: &dyn SceneFiles) -> Result<Acting, SceneError> {
    match scene {
        Scene::PlaneStrain(scene) => acting_in(scene, Space::Cartesian, files),
        Scene::Axisymmetric(scene) => acting_in(&in_plane(scene)?, Space::Axisymmetric, files),
        Scene::Solid(_) => Ok(Acting::default()),
    }
}

fn acting_in(
    scene: &SceneIn<2, PlaneBasis>,
    space: Space,
    files: &dyn SceneFiles,
) -> Result<Acting, SceneError> {
    let layout = layout(&scene.mesh, memory_left())?;
    let nodes = NodeSpace::of(layout.functions(), &Mesh::at_rest(&layout))
        .map_err(|error| SceneError::new("mesh", error))?;
    let supports = supports(scene, (&layout, &nodes), space)?;
    let stages = Stages::of(&scene.schedule);
    let sides = NamedSides::of(scene, (&layout, &nodes, space), files);
    let side = |body: &str, side: &str, is_wall: bool| sides.as_ref()?.find(body, side, is_wall);
    let mut loads = Vec::new();
    for (k, load) in scene.loads.iter().enumerate() {
        let path = format!("loads[{k}]");
        let (on, along, ramp, active) = match load {
            LoadInput::BodyForce { acceleration, ramp, active } => {
                (ActingOn::All, Along::Fixed(acceleration.0), ramp, active)
            }
            LoadInput::PointForce { body, near, force, ramp, active, .. } => {
                let on = ActingOn::Position { body: body.clone(), near: near.0 };
                (on, Along::Fixed(force.0), ramp, active)
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
                (on, Along::Fixed(along.0), ramp, active)
            }
            LoadInput::Traction { body, side: Some(name), resultant, value, ramp, active, .. } => {
                let Some(along) = resultant.as_ref().or(value.as_ref()) else { continue };
                let Some(side) = side(body, name, false) else { continue };
                (ActingOn::Side(side), Along::Fixed(along.0), ramp, active)
            }
            LoadInput::Pressure { body, side: name, value, ramp, active } => {
                let Some(side) = side(body, name, false) else { continue };
                (ActingOn::Side(side), Along::Inwards(value.0), ramp, active)
            }
            LoadInput::Vortex { .. } | LoadInput::Traction { .. } => continue,
        };
        loads.push(DrawnLoad { on, along, ramp: stages.load_ramp(ramp, 1.0, active, &path)? });
    }
    let slides = |wall: &WallInput<2>| wall.hold != HoldInput::All;
    let walls = scene.walls.iter().filter_map(|wall| Some((side(&wall.body, &wall.side, true)?, slides(wall))));
    let walls = walls.collect();
    Ok(Acting { nodes: Some(nodes), supports, loads, walls })
}

/// The bodies of a scene that names sides of theirs.
struct NamedSides<'a> {
    inputs: &'a [BodyInput<2>],
    boundaries: Vec<Boundary<2>>,
    model: Model<2>,
}

impl<'a> NamedSides<'a> {
    /// None where no side is named, or a body cannot be made.
    fn of(
        scene: &'a SceneIn<2, PlaneBasis>,
        (layout, nodes, space): (&Layout<2>, &NodeSpace<2>, Space),
        files: &dyn SceneFiles,
    ) -> Option<Self> {
        if !scene.bodies.iter().any(|body| are_named(scene, &body.name)) {
            return None;
        }
        let mut filled = scene.clone();
        filled.bodies.iter_mut().for_each(|body| body.initial = None);
        let made =
            bodies(&filled, (layout, &Mesh::at_rest(layout), space), files, Room::for_all(memory_left()))
                .ok()?;
        let mut model = Model::on(layout.clone(), nodes.clone());
        model.bodies = made.bodies;
        Some(Self { inputs: &scene.bodies, boundaries: made.boundaries, model })
    }

    fn find(&self, body: &str, side: &str, is_wall: bool) -> Option<DrawnSide> {
        let sides = Sides { inputs: self.inputs, boundaries: &self.boundaries };
        let found = sides.find(&self.model, (body, side), is_wall, "").ok()?;
        let place = |marker: u32| found.markers[marker as usize].into();
        let facets = found.facets.iter().map(|facet| facet.map(place)).collect();
        Some(DrawnSide { body: body.to_owned(), facets })
    }
}

//! A whole scene.

use super::basis::{DomainsInput, PlaneBasis, SolidBasis, StabilisationInput};
use super::body::{BodyInput, ShapeInput};
use super::boundary::{LoadInput, ProbeInput, SupportInput};
use super::material::MaterialInput;
use super::mesh::{MeshInput, MotionInput};
use super::number;
use super::read::{ReadError, read};
use super::run::{OutputInput, SolverInput, ToleranceInput, UnheldMotionInput};
use super::stage::ScheduleInput;
use super::tools::{ToolInput, ToolPartInput};
use super::walls::WallInput;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A whole scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub enum Scene {
    /// The plane: nothing moves or varies in the third direction; forces and volumes are per unit thickness.
    PlaneStrain(SceneIn<2, PlaneBasis>),
    /// Bodies of revolution about the axis r = 0, in their half plane: positions are (r, z) with r ≥ 0, directions `R` and
    /// `Z`, and the axis is held. Forces, masses and volumes are those of the whole ring. Of a tensor's components xx, yy
    /// and xy are rr, zz and rz, and zz is that of the hoop, θθ.
    Axisymmetric(SceneIn<2, PlaneBasis>),
    /// Three dimensions.
    Solid(SceneIn<3, SolidBasis>),
}

/// A scene in a space of two or three dimensions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneIn<const D: usize, B> {
    /// What the scene shows, for people.
    #[serde(default)]
    pub title: String,
    /// The background mesh at rest.
    pub mesh: MeshInput,
    /// Whether bodies of revolution may turn about their axis, by an angle that varies with r and z; in an `Axisymmetric`
    /// scene only.
    #[serde(default)]
    pub twist: bool,
    /// How the mesh moves with the load fraction.
    #[serde(default)]
    pub motion: MotionInput<D>,
    /// How material points influence the nodes of the mesh.
    pub basis: B,
    /// How the points' domains are made and how they deform.
    #[serde(default)]
    pub domains: DomainsInput,
    /// What is done about cells that bodies barely reach into; nothing if left out.
    #[serde(default)]
    pub stabilisation: Option<StabilisationInput>,
    /// Laws by name.
    #[serde(deserialize_with = "number::unique_keys")]
    pub materials: BTreeMap<String, MaterialInput>,
    /// What is made of material points.
    pub bodies: Vec<BodyInput<D>>,
    /// Where displacements of the mesh's nodes are prescribed.
    #[serde(default)]
    pub supports: Vec<SupportInput<D>>,
    /// Forces.
    #[serde(default)]
    pub loads: Vec<LoadInput<D>>,
    /// Rigid tools that bodies meet.
    #[serde(default)]
    pub tools: Vec<ToolInput<D>>,
    /// Walls that hold sides of bodies off the lines of the mesh.
    #[serde(default)]
    pub walls: Vec<WallInput<D>>,
    /// Material points that the history follows.
    #[serde(default)]
    pub probes: Vec<ProbeInput<D>>,
    /// How the load fraction goes from 0 to 1.
    pub schedule: ScheduleInput,
    /// When a load step counts as solved.
    #[serde(default)]
    pub tolerance: ToleranceInput,
    /// What is done about rigid motions that nothing holds.
    #[serde(default)]
    pub unheld_motion: UnheldMotionInput,
    /// How linear systems are solved.
    #[serde(default)]
    pub solver: SolverInput,
    /// What the results file holds.
    #[serde(default)]
    pub output: OutputInput,
}

impl<const D: usize, B> SceneIn<D, B> {
    fn files(&self) -> impl Iterator<Item = &str> {
        let shapes = self.bodies.iter().flat_map(|body| [&body.shape].into_iter().chain(body.shape.cutouts()));
        let of_bodies = shapes.filter_map(|shape| match shape {
            ShapeInput::Surface { file, .. } | ShapeInput::Points { file } => Some(file.as_str()),
            _ => None,
        });
        let of_tools = self.tools.iter().flat_map(|tool| &tool.parts).filter_map(|part| match part {
            ToolPartInput::Surface { file, .. } => Some(file.as_str()),
            _ => None,
        });
        of_bodies.chain(of_tools)
    }
}

impl Scene {
    /// Reads a scene.
    ///
    /// # Errors
    /// What is wrong, and where in the text.
    pub fn from_ron(text: &str) -> Result<Self, ReadError> {
        read(text)
    }

    /// Files that it names.
    pub fn files(&self) -> Vec<&str> {
        match self {
            Scene::PlaneStrain(scene) | Scene::Axisymmetric(scene) => scene.files().collect(),
            Scene::Solid(scene) => scene.files().collect(),
        }
    }

    /// What the scene wants recorded.
    pub fn output(&self) -> &OutputInput {
        match self {
            Scene::PlaneStrain(scene) | Scene::Axisymmetric(scene) => &scene.output,
            Scene::Solid(scene) => &scene.output,
        }
    }

    /// Its load steps.
    pub fn schedule(&self) -> &ScheduleInput {
        match self {
            Scene::PlaneStrain(scene) | Scene::Axisymmetric(scene) => &scene.schedule,
            Scene::Solid(scene) => &scene.schedule,
        }
    }

    /// What the scene shows.
    pub fn title(&self) -> &str {
        match self {
            Scene::PlaneStrain(scene) | Scene::Axisymmetric(scene) => &scene.title,
            Scene::Solid(scene) => &scene.title,
        }
    }
}

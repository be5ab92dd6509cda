//! Walls that hold sides of bodies.

use super::number::{Coordinates, Positive};
use super::tools::{ToolMotionInput, ToolPartInput};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A rigid wall that holds a side of a body, wherever the mesh has its nodes. Walls need `stabilisation`. What a wall exerts
/// is recorded as `/history/wall/<name>/…`. Not in `Axisymmetric` scenes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WallInput<const D: usize> {
    /// Its name in the results.
    pub name: String,
    /// Name of the body.
    pub body: String,
    /// Name of the side that it holds: of a `Box` `left`, `right`, `bottom`, `top`, in space also `front` and `back`; of a
    /// `Ring` or `Tube` `inner`, `outer`, in a sector also `start` and `end`, in space also `bottom` and `top`; of a `Cylinder`
    /// `outer`, in space also `bottom` and `top`; of a
    /// `Polygon` in the plane `edge 0`, from its first corner to the second, and so on, and `hole 0`, …. A `Cylinder`, a `Tube`
    /// or a `Polygon` that is cut by the cells of a mesh has no domains along its sides: these carry loads, and no wall holds
    /// them.
    pub side: String,
    /// What of the side it holds.
    #[serde(default)]
    pub hold: HoldInput,
    /// The surface, in the place where it stands at rest; a wall that holds all needs none. Its normal points to the body.
    #[serde(default)]
    pub surface: Option<ToolPartInput<D>>,
    /// How it moves with the load fraction. Of a wall that holds all a load may move it.
    #[serde(default)]
    pub motion: ToolMotionInput<D>,
    /// Stiffness c of the wall: under a pressure that changes by p in a load step the body is c⁻¹ p/E cells away from it
    /// `[-]`.
    #[serde(default = "hundred")]
    pub stiffness: Positive,
    /// Whether steps are balanced again until gaps are closed, as far as the functions of the mesh can follow the markers.
    #[serde(default)]
    pub exact: bool,
    /// Point of the wall at rest about which its moment is recorded, and that of a load acts; it moves with the wall `[L]`.
    #[serde(default)]
    pub moment_about: Coordinates<D>,
}

/// What of a side a wall holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum HoldInput {
    /// Every component: the side is glued to the wall.
    All,
    /// The distance from the surface: the side slides along it and does not leave it.
    #[default]
    Normal,
    /// What would enter the surface: the side can leave it and come back.
    Contact,
}

fn hundred() -> Positive {
    Positive(100.0)
}

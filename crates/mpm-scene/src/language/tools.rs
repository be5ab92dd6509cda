//! Rigid tools that bodies meet.

use super::direction::Direction;
use super::number::{self, Coordinates, Finite, PlanePoint, Positive, one};
use super::ramp::RampInput;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A rigid tool: bodies touch it and do not enter it. What it exerts and where it is are recorded as
/// `/history/tool/<name>/…`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ToolInput<const D: usize> {
    /// Its name in the results.
    pub name: String,
    /// What it is made of: the union of these parts.
    pub parts: Vec<ToolPartInput<D>>,
    /// Radius by which its edges are rounded; a quarter of the smallest edge of a cell if left out, and no more than the
    /// parts can bear. With 0 edges are sharp, and forces jump where corners of domains pass them `[L]`.
    #[serde(default, deserialize_with = "number::chosen")]
    pub rounding: Option<Finite>,
    /// How it moves with the load fraction.
    #[serde(default)]
    pub motion: ToolMotionInput<D>,
    /// What holds between its surface and the bodies.
    #[serde(default)]
    pub interface: InterfaceInput,
    /// Names of the bodies that meet it; all if left out.
    #[serde(default)]
    pub bodies: Vec<String>,
    /// Point of the tool at rest about which its moment is recorded; it moves with the tool `[L]`.
    #[serde(default)]
    pub moment_about: Coordinates<D>,
}

/// A part of a tool at rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum ToolPartInput<const D: usize> {
    /// The half space behind a plane.
    Plane {
        /// A point of the plane `[L]`.
        through: Coordinates<D>,
        /// Its normal, from the tool towards the bodies; of any length.
        normal: Coordinates<D>,
    },
    /// A disc; in space, a sphere; of bodies of revolution a sphere with its centre on the axis.
    Disc {
        /// Its centre `[L]`.
        centre: Coordinates<D>,
        /// Its radius `[L]`.
        radius: Positive,
    },
    /// A polygon, in the plane. Of bodies of revolution its vertices have r ≥ 0; with an edge on the axis it is solid, else a
    /// ring.
    Polygon {
        /// Its vertices round the outline, either way `[L]`.
        vertices: Vec<PlanePoint>,
    },
    /// A cylinder along an axis, in space; of bodies of revolution along theirs.
    Cylinder {
        /// Direction of its axis; `Z` if left out.
        #[serde(default = "Direction::z")]
        axis: Direction,
        /// Where the axis passes, by the coordinates across it: (x, y) of `Z`, (y, z) of `X`, (x, z) of `Y` `[L]`.
        #[serde(default)]
        centre: PlanePoint,
        /// Radius `[L]`.
        radius: Positive,
        /// First and last coordinate along the axis `[L]`.
        extent: (Finite, Finite),
    },
    /// A cone along an axis, in space, of bodies of revolution along theirs; a frustum, if its tip is blunt.
    Cone {
        /// Direction of its axis; `Z` if left out.
        #[serde(default = "Direction::z")]
        axis: Direction,
        /// Its tip `[L]`.
        tip: Coordinates<D>,
        /// Radius of its base `[L]`.
        radius: Positive,
        /// Radius of its blunt tip; 0 if left out `[L]`.
        #[serde(default)]
        tip_radius: Finite,
        /// How far its base lies from the tip, along the axis if positive `[L]`.
        length: Finite,
    },
    /// The helical plate of a screw, in space. Its edges are round.
    Helix {
        /// Direction of its axis; `Z` if left out.
        #[serde(default = "Direction::z")]
        axis: Direction,
        /// Where the plate begins on the axis; in the direction of the next coordinate: x for `Z`, y for `X`, z for `Y` `[L]`.
        start: Coordinates<D>,
        /// Inner and outer radius `[L]`.
        radii: (Finite, Finite),
        /// Rise along the axis per turn; positive where it is right-handed `[L]`.
        pitch: Finite,
        /// Number of turns.
        turns: Positive,
        /// Thickness of the plate `[L]`.
        thickness: Positive,
    },
    /// What a closed surface encloses, in space; it grows by the tool's `rounding`.
    Surface {
        /// An STL file, binary or text, beside the scene.
        file: String,
        /// How many times as large the part is as the file says, about the origin.
        #[serde(default = "one")]
        scale: Positive,
        /// How far it is then moved; not at all if left out `[L]`.
        #[serde(default)]
        shift: Coordinates<D>,
    },
}

/// How a tool moves.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum ToolMotionInput<const D: usize> {
    /// It does not.
    #[default]
    Rest,
    /// It is displaced, and turned about a point that is displaced with it.
    Move {
        /// Displacement in all `[L]`.
        #[serde(default)]
        by: Coordinates<D>,
        /// Part of it against the load fraction; linear if left out.
        #[serde(default)]
        ramp: RampInput,
        /// Further displacements, each with its ramp; all are added.
        #[serde(default)]
        then: Vec<ShiftInput<D>>,
        /// The turn.
        #[serde(default)]
        turn: Option<ToolTurnInput<D>>,
    },
    /// It turns about an axis and moves along it, as a screw does.
    Screw {
        /// Direction of the axis; `Z` if left out, and in space only.
        #[serde(default = "Direction::z")]
        axis: Direction,
        /// Where the axis passes, by the coordinates across it: (x, y) of `Z`, (y, z) of `X`, (x, z) of `Y` `[L]`.
        #[serde(default)]
        through: PlanePoint,
        /// Angle in all, right-handed about the axis `[degrees]`.
        angle: Finite,
        /// Way along the axis in all `[L]`.
        advance: Finite,
        /// Part of both against the load fraction; linear if left out.
        #[serde(default)]
        ramp: RampInput,
    },
    /// A load moves it, in some components; in the others it moves as prescribed. The load acts at `moment_about`.
    Loaded {
        /// Components of the motion that follow from the load.
        free: Vec<FreeInput>,
        /// Force in all (in the plane: per unit thickness) `[F]`.
        #[serde(default)]
        force: Coordinates<D>,
        /// Whether the force turns with it, as that of a jet. Not in `Axisymmetric` scenes.
        #[serde(default)]
        follows: bool,
        /// Moment in all, right-handed about an axis along z through `moment_about` `[F L]`.
        #[serde(default)]
        moment: Finite,
        /// Part of the load against the load fraction; linear if left out.
        #[serde(default)]
        ramp: RampInput,
        /// Displacement in all of the components that are not free `[L]`.
        #[serde(default)]
        by: Coordinates<D>,
        /// Part of the displacement against the load fraction; linear if left out.
        #[serde(default)]
        by_ramp: RampInput,
    },
}

/// A component of the motion of a tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum FreeInput {
    /// Displacement along x.
    X,
    /// Displacement along y.
    Y,
    /// Displacement along z, in space only.
    Z,
    /// Turn about an axis along z; of bodies of revolution with `twist` about theirs.
    Turn,
    /// Turn about an axis along x, in space only.
    TurnX,
    /// Turn about an axis along y, in space only.
    TurnY,
}

/// A displacement of a tool.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShiftInput<const D: usize> {
    /// Displacement in all `[L]`.
    pub by: Coordinates<D>,
    /// Part of it against the load fraction; linear if left out.
    #[serde(default)]
    pub ramp: RampInput,
}

/// A turn of a tool.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ToolTurnInput<const D: usize> {
    /// Direction of the axis; `Z` if left out, in the plane, and of bodies of revolution, which need `twist`.
    #[serde(default = "Direction::z")]
    pub axis: Direction,
    /// A point of the axis at rest `[L]`.
    #[serde(default)]
    pub centre: Coordinates<D>,
    /// Angle in all, right-handed about the axis `[degrees]`.
    pub angle: Finite,
    /// Part of the angle against the load fraction; linear if left out.
    #[serde(default)]
    pub ramp: RampInput,
}

/// What holds between a tool and the bodies that meet it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct InterfaceInput {
    /// Coulomb's coefficient of friction μ, no angle: a part of the normal force `[-]`.
    pub friction: Finite,
    /// Shear strength of the surface besides friction `[F/L²]`.
    pub adhesion: Finite,
    /// The same as a part α of the undrained strength s_u that the point at the surface has left, between 0 and 1, in the
    /// place of `adhesion`; its law has to be `VonMises` or `Tresca` `[-]`.
    pub adhesion_factor: Finite,
    /// Stiffness s of the contact: bodies enter the tool by the part p/(s E) of a point's size under a pressure p `[-]`.
    pub stiffness: Positive,
    /// Its stiffness along the surface over that across it, more than 0 and at most 1. Less makes Newton's method find its way where
    /// bodies stick or the slip turns round; they then slip elastically by so much more before they slip `[-]`.
    pub shear_stiffness: Positive,
    /// Whether bodies can part from the tool; if not, what touches it at the start stays on it for good.
    pub separates: bool,
    /// How often at most a step is solved again with the forces that it has found, so that bodies enter the tool less.
    pub augment: u8,
    /// Whether the tangent has the unsymmetric term of friction. Without it the tangent stays symmetric, and Newton's
    /// method takes 4 to 8 times the iterations where bodies slide with friction.
    pub exact_friction: bool,
}

impl Default for InterfaceInput {
    fn default() -> Self {
        Self {
            friction: Finite(0.0),
            adhesion: Finite(0.0),
            adhesion_factor: Finite(0.0),
            stiffness: Positive(20.0),
            shear_stiffness: Positive(1.0),
            separates: true,
            augment: 0,
            exact_friction: true,
        }
    }
}

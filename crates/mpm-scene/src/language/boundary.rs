//! Where bodies are held, what pulls at them, and where they are watched.

use super::direction::Direction;
use super::number::{Coordinates, Count, Finite, PlanePoint, Positive, zero};
use super::ramp::RampInput;
use super::stage::ActiveInput;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Nodes of the mesh, chosen by where they stand at rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum RegionInput<const D: usize> {
    /// Nodes on a plane (in the plane: a line) across an axis.
    Plane {
        /// The axis.
        axis: Direction,
        /// Its coordinate `[L]`.
        at: Finite,
    },
    /// Nodes inside a box or on its faces.
    Box {
        /// Corner with the lowest coordinates `[L]`.
        from: Coordinates<D>,
        /// Corner with the highest coordinates `[L]`.
        to: Coordinates<D>,
    },
    /// The node at a position `[L]`.
    Point(Coordinates<D>),
    /// Nodes at a distance from a centre (in three dimensions, from an axis along z).
    Circle {
        /// Centre (x, y) `[L]`.
        #[serde(default)]
        centre: PlanePoint,
        /// Distance `[L]`.
        radius: Positive,
    },
    /// Nodes between two distances from a centre, both included (in three dimensions, from an axis along z).
    Annulus {
        /// Centre (x, y) `[L]`.
        #[serde(default)]
        centre: PlanePoint,
        /// Smallest distance; 0 if left out `[L]`.
        #[serde(default = "zero")]
        inner: Finite,
        /// Largest distance `[L]`.
        outer: Positive,
    },
    /// Nodes on a half line from a centre, such as a straight end of a sector of a ring (in three dimensions,
    /// on a half plane that ends in a line along z).
    Ray {
        /// Centre (x, y) `[L]`.
        #[serde(default)]
        centre: PlanePoint,
        /// Its angle from the x axis towards the y axis `[degrees]`.
        angle: Finite,
    },
    /// Every node.
    Everywhere,
    /// Nodes that lie in every one of these regions.
    All(Vec<RegionInput<D>>),
}

/// Prescribed displacements of the nodes of a region. Components that are not named are free.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SupportInput<const D: usize> {
    /// Its name in the results: `/history/reaction/<name>`, `/history/displacement/<name>`.
    pub name: String,
    /// Its nodes.
    pub region: RegionInput<D>,
    /// Components held at zero.
    #[serde(default)]
    pub fix: Vec<Direction>,
    /// Components displaced by a given amount.
    #[serde(default)]
    pub displace: Vec<DisplaceInput>,
    /// Components that move as the mesh does.
    #[serde(default)]
    pub follow_mesh: Vec<Direction>,
    /// The nodes are turned about an axis, which prescribes both components across it.
    #[serde(default)]
    pub turn: Option<TurnInput>,
    /// Where the axis passes about which the moment of the reaction is recorded, as `/history/reaction_moment/<name>`
    /// `[F L]`, by the coordinates across it as in `turn`: (x, y) in the plane. If left out, the moment of a support with
    /// `turn` is recorded about the axis of that, and none of others. In space there are three moments, about
    /// lines along x, y and z through the point of the axis whose coordinate along it is 0 `[L]`.
    #[serde(default)]
    pub moment_about: Option<PlanePoint>,
    /// Direction of that axis; that of `turn` if left out, and `Z` without a `turn`.
    #[serde(default)]
    pub moment_axis: Option<Direction>,
    /// In which stages of the schedule it acts. It takes hold of its nodes where they then are.
    #[serde(default)]
    pub active: ActiveInput,
}

/// Prescribed displacement of one component.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DisplaceInput {
    /// The component.
    pub axis: Direction,
    /// Displacement in all `[L]`; of `Theta` an angle `[degrees]`.
    pub by: Finite,
    /// Part of it against the load fraction; linear if left out. Bodies begin at rest: a ramp that is not 0 at load
    /// fraction 0 jumps in the first load step.
    #[serde(default)]
    pub ramp: RampInput,
}

/// A prescribed rotation of nodes. In each load step a node's displacement is that of what stands where the node
/// does at its start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TurnInput {
    /// Direction of the axis; `Z` if left out, and in the plane.
    #[serde(default = "Direction::z")]
    pub axis: Direction,
    /// Where the axis passes, by the coordinates across it: (x, y) of `Z`, (y, z) of `X`, (x, z) of `Y` `[L]`.
    #[serde(default)]
    pub centre: PlanePoint,
    /// Angle in all, right-handed about the axis `[degrees]`.
    pub angle: Finite,
    /// Part of the angle against the load fraction; linear if left out.
    #[serde(default)]
    pub ramp: RampInput,
}

/// A force.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum LoadInput<const D: usize> {
    /// A force on the mass of every body.
    BodyForce {
        /// Force per mass `[L/T²]`.
        acceleration: Coordinates<D>,
        /// Part of it against the load fraction; linear if left out.
        #[serde(default)]
        ramp: RampInput,
        /// In which stages of the schedule it acts.
        #[serde(default)]
        active: ActiveInput,
    },
    /// The body force of the generalised vortex (Brannon, Kamojjala & Sadeghirad 2011), a manufactured solution for a
    /// ring of radii 0.75 and 1.25 around the origin in `Hencky` or `NeoHooke` elasticity, in the plane: every circle of radius R
    /// turns by the angle times 1 - 32 (R - 1)² + 256 (R - 1)⁴.
    Vortex {
        /// Name of the body.
        body: String,
        /// Angle by which the middle circle turns in all `[degrees]`.
        angle: Finite,
        /// Part of the angle against the load fraction; linear if left out.
        #[serde(default)]
        ramp: RampInput,
        /// In which stages of the schedule it acts.
        #[serde(default)]
        active: ActiveInput,
    },
    /// A force at a position of a body at rest, which the material points nearest to it carry with them.
    PointForce {
        /// Name of the body.
        body: String,
        /// The position `[L]`.
        near: Coordinates<D>,
        /// How many points share the force equally at their own positions, at least: of points at equal distance all do
        /// or none. If left out, the nearest points carry it, and force and moment are those of the force at `near`.
        #[serde(default)]
        points: Option<Count>,
        /// The whole force (in the plane: per unit thickness) `[F]`.
        force: Coordinates<D>,
        /// Part of it against the load fraction; linear if left out.
        #[serde(default)]
        ramp: RampInput,
        /// In which stages of the schedule it acts.
        #[serde(default)]
        active: ActiveInput,
    },
    /// A dead traction on a part of a body's boundary at rest: on that which lies on a plane across an axis, or on a named
    /// side. On a plane it is carried by the material points next to it in proportion to their share of the boundary. It
    /// acts on the boundary itself, which the points carry with them: force and moment are those of the traction. On a
    /// side it acts on boundary markers, half of the force on each edge at either end of it.
    Traction {
        /// Name of the body.
        body: String,
        /// The axis that the plane cuts.
        #[serde(default)]
        axis: Option<Direction>,
        /// Coordinate of the plane at rest `[L]`.
        #[serde(default)]
        at: Option<Finite>,
        /// Name of the side, in place of the plane, as in `walls`.
        #[serde(default)]
        side: Option<String>,
        /// Bounds of the loaded part of the plane; all of it if left out.
        #[serde(default)]
        within: Option<BoundsInput<D>>,
        /// The whole force (in the plane: per unit thickness; of a body of revolution along Z only) `[F]`.
        #[serde(default)]
        resultant: Option<Coordinates<D>>,
        /// The traction, in place of the whole force `[F/L²]`.
        #[serde(default)]
        value: Option<Coordinates<D>>,
        /// Torque about the axis of a body of revolution with `twist`, besides the force or alone: a shear traction about the
        /// axis in proportion to r `[F L]`.
        #[serde(default)]
        moment: Option<Finite>,
        /// Part of it against the load fraction; linear if left out.
        #[serde(default)]
        ramp: RampInput,
        /// In which stages of the schedule it acts.
        #[serde(default)]
        active: ActiveInput,
    },
    /// A pressure on a side of a body, which follows it: it acts on the present boundary, against its outward normal. Not in
    /// `Axisymmetric` scenes.
    Pressure {
        /// Name of the body.
        body: String,
        /// Name of the side, as in `walls`.
        side: String,
        /// The pressure `[F/L²]`.
        value: Finite,
        /// Part of it against the load fraction; linear if left out.
        #[serde(default)]
        ramp: RampInput,
        /// In which stages of the schedule it acts.
        #[serde(default)]
        active: ActiveInput,
    },
}

/// Material points of a body whose mean is recorded after every load step: `/history/probe/<name>/position`,
/// `…/displacement` and `…/cauchy_stress` (nine components row by row, the mean over their present volume).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProbeInput<const D: usize> {
    /// Its name in the results.
    pub name: String,
    /// Name of the body.
    pub body: String,
    /// Which of the body's points.
    pub points: ProbePointsInput<D>,
}

/// Which points of a body a probe follows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum ProbePointsInput<const D: usize> {
    /// The one nearest to a position at rest; the first of several `[L]`.
    Near(Coordinates<D>),
    /// Those that lie in a box at rest, or on its faces.
    Within {
        /// Corner with the lowest coordinates `[L]`.
        from: Coordinates<D>,
        /// Corner with the highest coordinates `[L]`.
        to: Coordinates<D>,
    },
    /// All of them.
    All,
}

/// A box.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoundsInput<const D: usize> {
    /// Corner with the lowest coordinates `[L]`.
    pub from: Coordinates<D>,
    /// Corner with the highest coordinates `[L]`.
    pub to: Coordinates<D>,
}

//! The background mesh and how it moves.

use super::direction::Direction;
use super::number::{Coordinates, Count, Finite, PlanePoint, Positive, zero};
use super::ramp::RampInput;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The background mesh at rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum MeshInput {
    /// A box of quadrilaterals or hexahedra.
    Box {
        /// One axis per direction: x, y and, in three dimensions, z.
        axes: Vec<AxisInput>,
        /// Its functions; linear ones if left out.
        #[serde(default, skip_serializing_if = "FunctionsInput::is_linear")]
        functions: FunctionsInput,
    },
    /// Rings of nodes around a centre, joined by straight edges; in three dimensions stacked along z.
    Ring {
        /// Centre (x, y) `[L]`.
        #[serde(default)]
        centre: PlanePoint,
        /// Radii of the rings of nodes, the innermost above 0.
        radii: AxisInput,
        /// Number of cells around.
        sectors: Count,
        /// First and last angle of an open ring, anticlockwise from the x axis `[degrees]`; a full ring if left out.
        #[serde(default)]
        angles: Option<(Finite, Finite)>,
        /// Where nodes stand along z; three dimensions only.
        #[serde(default)]
        height: Option<AxisInput>,
        /// Its functions; linear ones if left out.
        #[serde(default, skip_serializing_if = "FunctionsInput::is_linear")]
        functions: FunctionsInput,
    },
}

/// The functions of which displacement is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum FunctionsInput {
    /// Of the vertices of the mesh, linear along the edges of its cells.
    #[default]
    Linear,
    /// B-splines on the cells, whose nodes are control points: supports hold faces of the mesh. A ring is one of circles,
    /// at rest, rotated or expanded. For `Cpdi1`, `Cpdi2q`, `Cpdi2Hexahedron` and, less accurate, the other bases but `Gimp`.
    Splines {
        /// 1, 2 or 3; 2 is the recommended one. On a body that is n points wide, cells have to be few enough that
        /// n + 1 is at least their number and the degree.
        degree: Count,
    },
}

impl FunctionsInput {
    /// Whether they are the linear ones.
    pub(crate) fn is_linear(&self) -> bool {
        *self == Self::Linear
    }
}

/// Where the mesh's nodes stand along one direction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum AxisInput {
    /// Cells of equal length.
    Uniform {
        /// First coordinate `[L]`.
        from: Finite,
        /// Last coordinate `[L]`.
        to: Finite,
        /// Number of cells.
        cells: Count,
    },
    /// Cells whose lengths form a geometric series.
    Graded {
        /// First coordinate `[L]`.
        from: Finite,
        /// Last coordinate `[L]`.
        to: Finite,
        /// Number of cells.
        cells: Count,
        /// Length of the last cell over that of the first `[-]`.
        ratio: Positive,
    },
    /// The coordinates themselves, increasing `[L]`.
    Nodes(Vec<Finite>),
}

/// How the mesh moves; a pure function of the load fraction. In a schedule of stages its ramps begin with the first stage, unless
/// they name others.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum MotionInput<const D: usize> {
    /// It does not: after every load step the mesh is reset.
    #[default]
    Fixed,
    /// Along each listed axis the nodes between an anchored and a driven plane are evenly re-spaced
    /// as the driven plane moves; nodes beyond the driven plane move with it.
    Stretch(Vec<StretchInput>),
    /// The mesh is the multilinear image of its box as corners of the box move; corners that are not
    /// listed stay.
    Corners(Vec<CornerInput<D>>),
    /// The mesh turns as a rigid body about a centre (in three dimensions, about an axis along z).
    Rotate {
        /// Centre (x, y) `[L]`.
        #[serde(default)]
        centre: PlanePoint,
        /// Angle in all, anticlockwise `[degrees]`.
        angle: Finite,
        /// Part of the angle against the load fraction; linear if left out.
        #[serde(default)]
        ramp: RampInput,
    },
    /// Rings of nodes of a ring mesh turn by an angle that varies linearly with their radius.
    Twist {
        /// Angle of the innermost ring in all, anticlockwise `[degrees]`.
        inner: Finite,
        /// Angle of the outermost ring in all, anticlockwise `[degrees]`.
        #[serde(default = "zero")]
        outer: Finite,
        /// Part of the angles against the load fraction; linear if left out.
        #[serde(default)]
        ramp: RampInput,
        /// Part of the outermost ring's angle, where it is another.
        #[serde(default)]
        outer_ramp: Option<RampInput>,
        /// What becomes of angles larger than a cell.
        #[serde(default)]
        reindexing: ReindexingInput,
        /// Composes the twist with a stretch along `Z`, which follows a screw that advances as it turns; three
        /// dimensions only.
        #[serde(default)]
        stretch: Option<StretchInput>,
    },
    /// Rings of nodes of a ring mesh between an anchored and a driven radius are re-spaced as the driven radius changes, so
    /// that the areas between them change in one ratio, as in ground that keeps its volume; areas beyond the driven
    /// radius are kept.
    Expand {
        /// Radius that stays `[L]`.
        anchor: Positive,
        /// Radius that changes, at rest `[L]`.
        driven: Positive,
        /// By how much it changes in all `[L]`.
        displacement: Finite,
        /// Part of the displacement against the load fraction; linear if left out.
        #[serde(default)]
        ramp: RampInput,
    },
}

/// What a twist of the mesh does with angles larger than a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum ReindexingInput {
    /// Each ring's angle is reduced by whole cells, which leaves the ring's polygon as it is: the mesh
    /// is never sheared by more than a cell.
    #[default]
    WholeCells,
    /// From the outermost ring on inwards, each ring's angle against the next one's is reduced by whole cells: the mesh is never
    /// sheared by more than half a cell, so that rings of few sectors close to each other do not fold.
    Neighbours,
    /// Rings keep their angle; the run ends when a cell folds.
    Off,
}

/// Stretch of the mesh along one axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StretchInput {
    /// The axis.
    pub axis: Direction,
    /// Coordinate of the plane that stays `[L]`.
    pub anchor: Finite,
    /// Coordinate of the plane that moves, at rest `[L]`.
    pub driven: Finite,
    /// How far it moves in all `[L]`.
    pub displacement: Finite,
    /// Part of the displacement against the load fraction; linear if left out.
    #[serde(default)]
    pub ramp: RampInput,
}

/// A corner of the mesh's box that moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CornerInput<const D: usize> {
    /// The corner, by its position at rest `[L]`.
    pub corner: Coordinates<D>,
    /// How far it moves in all `[L]`.
    pub displacement: Coordinates<D>,
    /// Part of the displacement against the load fraction; linear if left out.
    #[serde(default)]
    pub ramp: RampInput,
}

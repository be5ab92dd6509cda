//! Bodies, and what they fill.

use super::direction::Direction;
use super::number::{Coordinates, Count, Finite, PlanePoint, Positive, one, zero};
use super::quantity::Quantity;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A body of material points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyInput<const D: usize> {
    /// Its name.
    pub name: String,
    /// Name of its law.
    pub material: String,
    /// What it fills at rest.
    pub shape: ShapeInput<D>,
    /// Directions along which the body goes on outside the mesh by symmetry: what a `Cylinder`, `Tube`, `Sphere`, `Polygon` or
    /// `Surface`, or a `Ring` with `tiling: Shape`, in a box mesh has beyond the mesh's ends is left out. Supports hold the nodes there across the plane.
    #[serde(default)]
    pub symmetry: Vec<Direction>,
    /// Material points per cell and direction, evenly spaced; needed by every shape but `Points`, which has its own.
    #[serde(default)]
    pub points_per_cell: Option<Count>,
    /// How the shape is cut into the domains of points.
    #[serde(default, skip_serializing_if = "TilingInput::is_by_cells")]
    pub tiling: TilingInput,
    /// In space, a turn of the body out of the place of its shape; it then needs `tiling: Shape`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turned: Option<TurnedInput<D>>,
    /// Against volumetric locking, where the material or its flow is all but incompressible: points take the
    /// volume change of their cell in place of their own; left alone if left out.
    #[serde(default)]
    pub mean_dilatation: Option<MeanDilatationInput>,
    /// The stress in which it begins; none if left out.
    #[serde(default)]
    pub initial: Option<InitialInput>,
}

/// The stress in which a body begins, effective where its law has a pore fluid; positions and displacements begin as if
/// it had none. A point whose law does not bear it is refused.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum InitialInput {
    /// That of level ground at rest under its own weight: σ_v = -∫ γ' - `surcharge`, σ_h = K₀ σ_v in all horizontal
    /// directions. Loads that balance it have to act fully from the start, with `ramp: [(0, 1)]`.
    Geostatic {
        /// Height of the ground surface: y in the plane, z in space `[L]`.
        surface: Finite,
        /// γ', the submerged weight per volume under water; a number, `Linear` or `Layers` `[F/L³]`.
        unit_weight: Quantity<Positive>,
        /// K₀ = σ_h/σ_v `[-]`.
        k0: Quantity<Positive>,
        /// Pressure on the surface `[F/L²]`.
        #[serde(default)]
        surcharge: Finite,
        /// Largest vertical stress of the past over the present one, at least 1, for `CamClay`: its yield surface goes
        /// through that state, at the law's own K₀ of first compression. Left out, `preconsolidation` holds `[-]`.
        #[serde(default)]
        over_consolidation: Option<Quantity<Positive>>,
    },
    /// The same stress in all points, tension positive `[F/L²]`.
    Stress {
        /// σ_xx.
        xx: Finite,
        /// σ_yy.
        yy: Finite,
        /// σ_zz, which acts in the plane, too.
        zz: Finite,
        /// σ_xy.
        #[serde(default)]
        xy: Finite,
        /// σ_yz, in space only.
        #[serde(default)]
        yz: Finite,
        /// σ_zx, in space only.
        #[serde(default)]
        zx: Finite,
    },
    /// From a table with the columns x, y (and z in space), sxx, syy, szz, sxy (and syz, szx in space), from CSV or HDF5; a
    /// point takes the nearest row. A column `preconsolidation` gives the p_c of `CamClay`.
    Table {
        /// The file, as seen from the scene's folder.
        file: String,
    },
}

/// A turn of a body at rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TurnedInput<const D: usize> {
    /// Direction of the axis, of any length.
    pub axis: Coordinates<D>,
    /// A point of the axis `[L]`.
    #[serde(default)]
    pub about: Coordinates<D>,
    /// Angle, right-handed about the axis `[degrees]`.
    pub angle: Finite,
}

/// How a shape is cut into the domains of points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum TilingInput {
    /// By the cells of the mesh; a `Ring` in a box mesh by straight pieces with the volume of the ring in all.
    #[default]
    Cells,
    /// Along the shape, in box meshes, by pieces about as large as the mesh's cells with `points_per_cell` in each direction: a
    /// `Ring` or a `Tube` along `Z` by pieces between circles and radii whose corners lie on the circles, a `Cylinder` along `Z` by
    /// a square and four fans round it, a `Box` along its edges, and in the plane a convex `Polygon` of four corners between
    /// points that part opposite edges equally. Points have the volumes of these pieces.
    Shape,
}

impl TilingInput {
    /// Whether it is by cells.
    pub(crate) fn is_by_cells(&self) -> bool {
        *self == Self::Cells
    }
}

/// What the volume change of a cell is. Points take it in each load step from the cell that holds them at its
/// start. `VolumeRatio` and `Volume` are then those of the cells, and domains that follow F follow them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum MeanDilatationInput {
    /// The mean over the points in the cell: for bodies whose surface moves through cells.
    Points,
    /// That of the cell itself, wherever its points stand: the more accurate one in cells that stay full of
    /// material; cells filled in part may turn unstable.
    Cell,
}

/// What a body fills at rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum ShapeInput<const D: usize> {
    /// A box along the axes. Along a direction in which both its ends lie on mesh lines, points are
    /// spaced evenly in each cell; along any other, evenly over the whole box and at least as densely.
    Box {
        /// Corner with the lowest coordinates `[L]`.
        from: Coordinates<D>,
        /// Corner with the highest coordinates `[L]`.
        to: Coordinates<D>,
        /// Names of bodies before this one, of the shapes `Cylinder`, `Tube`, `Sphere`, `Polygon` or `Surface`, that are cut out of the
        /// box, as far as they reach into it. The box then has its ends on mesh lines, and all have equally many
        /// points per cell. Also names of tools: the first of a tool's parts that is a `Cylinder`, a `Disc` or a `Surface` is
        /// cut out like a body, and points that stand inside any of its parts are left out.
        #[serde(default)]
        without: Vec<String>,
        /// Shapes that are cut out of the box, as far as they reach into it, and are no bodies: `Box`, `Cylinder`, `Tube`,
        /// `Sphere`, `Polygon` or `Surface`. The box then has its ends on mesh lines.
        #[serde(default)]
        cutouts: Vec<ShapeInput<D>>,
        /// Angle by which the box is turned about its corner `from`, in space about the line along z through it, anticlockwise;
        /// it then needs `tiling: Shape` `[degrees]`.
        #[serde(default = "zero")]
        turned: Finite,
    },
    /// A ring. In a ring mesh: all cells between two of its rings of nodes, exactly the polygon's volume. In a box
    /// mesh: a polygon of its own, cut into pieces about as large as the mesh's cells.
    Ring {
        /// Centre (x, y) `[L]`.
        #[serde(default)]
        centre: PlanePoint,
        /// Inner radius, above 0 `[L]`.
        inner: Finite,
        /// Outer radius `[L]`.
        outer: Finite,
        /// Names of tools; points that stand inside them are left out.
        #[serde(default)]
        without: Vec<String>,
    },
    /// A cylinder along an axis; in plane strain, a disc; as a body of revolution a `Box`. Box meshes only. Cells that are filled in part have points
    /// whose volume, centre and extent are those of what fills them.
    Cylinder {
        /// Direction of its axis; `Z` if left out.
        #[serde(default = "Direction::z")]
        axis: Direction,
        /// Where the axis passes, by the coordinates across it: (x, y) of `Z`, (y, z) of `X`, (x, z) of `Y` `[L]`.
        #[serde(default)]
        centre: PlanePoint,
        /// Radius `[L]`.
        radius: Positive,
        /// First and last coordinate along the axis; in three dimensions only, and there all of the mesh if left
        /// out `[L]`.
        #[serde(default)]
        extent: Option<(Finite, Finite)>,
    },
    /// A tube; in the plane, an annulus. In a box mesh as `Cylinder`, in a ring mesh along `Z` all cells between two
    /// of its rings of nodes.
    Tube {
        /// Direction of its axis; `Z` if left out.
        #[serde(default = "Direction::z")]
        axis: Direction,
        /// Where the axis passes, as for `Cylinder` `[L]`.
        #[serde(default)]
        centre: PlanePoint,
        /// Inner radius `[L]`.
        inner: Positive,
        /// Outer radius `[L]`.
        outer: Positive,
        /// First and last coordinate along the axis; in three dimensions only, and there all of the mesh if left
        /// out `[L]`.
        #[serde(default)]
        extent: Option<(Finite, Finite)>,
        /// Names of tools; points that stand inside them are left out.
        #[serde(default)]
        without: Vec<String>,
    },
    /// A polygon, with holes; in three dimensions drawn out along an axis; in the plane and as a section of a body of
    /// revolution as it is. Box meshes only. Filled as a `Cylinder` is.
    Polygon {
        /// Its corners in order, either way round, by the coordinates across the axis: (x, y) of `Z`, (y, z) of `X`, (x, z) of
        /// `Y`; edges may not cross or touch `[L]`.
        vertices: Vec<PlanePoint>,
        /// Corners of its holes `[L]`.
        #[serde(default)]
        holes: Vec<Vec<PlanePoint>>,
        /// Direction of its axis; `Z` if left out.
        #[serde(default = "Direction::z")]
        axis: Direction,
        /// First and last coordinate along the axis; in three dimensions only, and there all of the mesh if left
        /// out `[L]`.
        #[serde(default)]
        extent: Option<(Finite, Finite)>,
    },
    /// A sphere; box meshes only, in three dimensions or, with its centre on the axis, as a body of revolution (in plane
    /// strain a disc is a `Cylinder`). Filled as a `Cylinder` is.
    Sphere {
        /// Its centre `[L]`.
        centre: Coordinates<D>,
        /// Its radius `[L]`.
        radius: Positive,
    },
    /// What a closed surface encloses; three dimensions and box meshes only. Cells that are filled in part have
    /// points whose volume, centre and extent are those of what fills them, so that the body's volume is the
    /// surface's. A surface that is open, crosses itself, or whose facets face different ways is refused.
    Surface {
        /// An STL file, binary or text, beside the scene.
        file: String,
        /// How many times as large the body is as the file says, about the origin.
        #[serde(default = "one")]
        scale: Positive,
        /// How far it is then moved; not at all if left out `[L]`.
        #[serde(default)]
        shift: Coordinates<D>,
    },
    /// Material points that are given, one row each. A CSV file has a line of names first: `x`, `y`, in three
    /// dimensions `z`, `volume`, and, if points have domains, `r1x`, `r1y`, … `r3z`: vectors from the point to the middles of
    /// its domain's sides, right-handed. Names may be in capitals and have a unit in brackets, as `X [mm]`, which is not
    /// converted; columns are parted by commas, semicolons, tabs or blanks; a column `id` or `index` is not read. An HDF5 file has datasets `position` (rows by dimensions), `volume` and, if
    /// points have domains, `domain` (rows by dimensions by dimensions, one vector after the other). Without
    /// domains they are cubes of the points' volumes. Points are kept in the order of the file, unless most of them stand
    /// far from the one before: then in the order of the cells that hold them, row by row.
    Points {
        /// The file, beside the scene: HDF5 if it ends in `.h5` or `.hdf5`, else CSV.
        file: String,
    },
}

impl<const D: usize> ShapeInput<D> {
    /// Shapes that are cut out of it and are no bodies.
    pub fn cutouts(&self) -> &[Self] {
        match self {
            Self::Box { cutouts, .. } => cutouts,
            _ => &[],
        }
    }

    /// Names of the bodies and tools that are cut out of it.
    pub fn without(&self) -> &[String] {
        match self {
            Self::Box { without, .. } | Self::Ring { without, .. } | Self::Tube { without, .. } => without,
            _ => &[],
        }
    }
}

//! The input language: what a scene file may say.
//!
//! A scene is a RON file that opens with the space it lives in, `PlaneStrain( … )` or `Solid( … )`.
//! Units are any consistent set; the documentation of each field gives its dimension in length `[L]`,
//! force `[F]`, mass `[M]` and time `[T]`. Numbers are checked as they are read, so that a wrong one is
//! reported with its line; what only the whole scene can tell (a region without nodes, say) is
//! checked when the scene is compiled.

mod edit;
mod number;
mod position;
mod read;

pub use edit::{EditError, Edited, set_value};
pub use number::{Coordinates, Count, Finite, Fraction, Poisson, Positive};
pub use position::{Position, position_of};
pub use read::ReadError;

use crate::model::{Schedule, Tolerance};
use crate::observe::Field;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A whole scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub enum Scene {
    /// The plane: nothing moves or varies in the third direction; forces and volumes are per unit thickness.
    PlaneStrain(SceneIn<2, PlaneBasis>),
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
    /// Material points that the history follows.
    #[serde(default)]
    pub probes: Vec<ProbeInput<D>>,
    /// How the load fraction goes from 0 to 1.
    pub schedule: ScheduleInput,
    /// When a load step counts as solved.
    #[serde(default)]
    pub tolerance: ToleranceInput,
    /// How linear systems are solved.
    #[serde(default)]
    pub solver: SolverInput,
    /// What the results file holds.
    #[serde(default)]
    pub output: OutputInput,
}

/// Bases of the plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum PlaneBasis {
    /// Standard MPM: the cell's own shape functions at the point.
    Smpm,
    /// Generalised interpolation: the mean over a box along the axes. Box meshes that stay rectilinear only.
    Gimp,
    /// A parallelogram that deforms with the point's deformation gradient.
    Cpdi1,
    /// A quadrilateral whose corners move with the mesh.
    Cpdi2q,
    /// Triangles whose corners move with the mesh.
    Cpdi2t,
}

/// Bases of three-dimensional space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum SolidBasis {
    /// Standard MPM: the cell's own shape functions at the point.
    Smpm,
    /// Generalised interpolation: the mean over a box along the axes. Box meshes that stay rectilinear only.
    Gimp,
    /// A parallelepiped that deforms with the point's deformation gradient.
    Cpdi1,
    /// A hexahedron whose corners move with the mesh.
    Cpdi2Hexahedron,
    /// Tetrahedra whose corners move with the mesh, six to a hexahedron.
    Cpdi2Tetrahedron,
}

/// How the points' domains are made and how they deform. An option that the scene's basis does not have is an
/// error.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DomainsInput {
    /// `Gimp`: what a half length follows; `Stretch` if left out.
    pub gimp_update: Option<GimpUpdateInput>,
    /// `Cpdi2t`: how a body's pieces are cut into triangles; `Cross` if left out.
    pub triangles: Option<TrianglesInput>,
    /// `Cpdi2q`: weights of the corners; `Current` if left out.
    pub corner_weights: Option<CornerWeightsInput>,
    /// Bases with convected corners: a point whose domain's distortion passes this, or whose domain turns inside
    /// out, goes on with the `Cpdi1` domain of its own deformation gradient; never if left out `[-]`.
    pub fallback_beyond: Option<Positive>,
    /// Bases with domains: what is done, after every load step, about domains that have outgrown their cells
    /// (needles, after large shear); nothing if left out.
    pub control: Option<ControlInput>,
}

/// What is done about domains that have outgrown their cells. The size of a domain is that of its longest
/// principal semi-axis in half cells: 1 where it is as long as the cell around its point, 1/n at rest with n
/// points per cell and direction. A limit of 0.7, the default, leaves domains at rest alone from two points per
/// cell and direction on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum ControlInput {
    /// They are shortened along their long axes. Only where the mesh is sampled changes, not the point's state,
    /// volume or mass; counted as `/history/domains_capped`.
    Cap {
        /// Largest size `[-]`.
        #[serde(default = "default_cells")]
        cells: Positive,
    },
    /// As `Cap`, and they are thickened so that their volume stays, as far as they reach no limit that way; those of
    /// `Cpdi1` are laid along the edges of their cells. The torque or force of a shear band then still swings by
    /// pressure alone, unless its body has `mean_dilatation`.
    Reshape {
        /// Largest size `[-]`.
        #[serde(default = "default_cells")]
        cells: Positive,
    },
    /// Their points are split, into halves of halves, until none is too large. Volume, mass, their centre, and
    /// loads are kept; counted as `/history/domains_split`.
    Split {
        /// Largest size `[-]`.
        #[serde(default = "default_cells")]
        cells: Positive,
        /// The run ends where there would be more than so many times the points of the start `[-]`.
        #[serde(default = "default_growth")]
        growth: Positive,
    },
}

/// What is done about cells that bodies barely reach into: their nodes carry next to no stiffness, and the
/// tangent becomes singular.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum StabilisationInput {
    /// Jumps of the displacement gradient (of the load step) across the faces of boundary cells are penalised:
    /// the cells with an empty neighbour follow those inside. Counted as `/history/ghost_faces`.
    Ghost {
        /// The penalty over Young's modulus; 1/30 if left out `[-]`.
        #[serde(default = "default_ghost")]
        factor: Positive,
    },
}

fn default_ghost() -> Positive {
    Positive(1.0 / 30.0)
}

fn default_cells() -> Positive {
    Positive(0.7)
}

fn default_growth() -> Positive {
    Positive(16.0)
}

/// What a half length of a `Gimp` domain follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum GimpUpdateInput {
    /// The diagonal of the stretch, `U_ii` with `U = √(FᵀF)`.
    Stretch,
    /// The diagonal of the deformation gradient, `F_ii`; fails where a body turns by a right angle.
    Diagonal,
    /// The volume, `(det F)^(1/D)`.
    Volume,
    /// Nothing: the domain keeps its size.
    None,
}

/// How pieces of a body are cut into triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum TrianglesInput {
    /// Each of the n² pieces of a cell from its lower left to its upper right corner.
    Slash,
    /// Each of the n² pieces of a cell from its upper left to its lower right corner.
    Backslash,
    /// Each of (n/2)² pieces of a cell by both diagonals; n must be even.
    Cross,
}

/// Weights of the corners of a `Cpdi2q` domain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum CornerWeightsInput {
    /// Those of the present quadrilateral; they can turn negative.
    Current,
    /// Those of the quadrilateral at rest.
    Frozen,
}

/// The background mesh at rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum MeshInput {
    /// A box of quadrilaterals or hexahedra.
    Box {
        /// One axis per direction: x, y and, in three dimensions, z.
        axes: Vec<AxisInput>,
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
    },
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

/// A direction of space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
pub enum Direction {
    /// The first direction.
    X,
    /// The second direction.
    Y,
    /// The third direction; three dimensions only.
    Z,
}

impl Direction {
    fn z() -> Self {
        Direction::Z
    }

    /// 0, 1 or 2.
    pub fn index(self) -> usize {
        match self {
            Direction::X => 0,
            Direction::Y => 1,
            Direction::Z => 2,
        }
    }
}

/// How the mesh moves; a pure function of the load fraction.
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
    },
}

/// What a twist of the mesh does with angles larger than a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum ReindexingInput {
    /// Each ring's angle is reduced by whole cells, which leaves the ring's polygon as it is: the mesh
    /// is never sheared by more than a cell.
    #[default]
    WholeCells,
    /// Rings keep their angle; the run ends when a cell folds.
    Off,
}

fn zero() -> Finite {
    Finite(0.0)
}

fn one() -> Positive {
    Positive(1.0)
}

/// A point (x, y) of the plane `[L]`; the origin if left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct PlanePoint(pub (Finite, Finite));

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

/// A piecewise linear function of the load fraction, as knots (load fraction, factor), held constant
/// before the first and after the last. Left out, it rises linearly from 0 to 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct RampInput(pub Vec<(Fraction, Finite)>);

impl Default for RampInput {
    fn default() -> Self {
        Self(vec![(Fraction(0.0), Finite(0.0)), (Fraction(1.0), Finite(1.0))])
    }
}

/// A law. Stress is work-conjugate to elastic logarithmic strain: `τ = λ tr(ε_e) I + 2G ε_e`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum MaterialInput {
    /// Hencky elasticity.
    Hencky {
        /// Young's modulus E `[F/L²]`.
        young: Positive,
        /// Poisson's ratio ν, -1 < ν < 0.5 `[-]`.
        poisson: Poisson,
        /// Mass per reference volume; needed where a body force acts `[M/L³]`.
        #[serde(default)]
        density: Option<Positive>,
    },
    /// Hencky elasticity with von Mises perfect plasticity.
    VonMises {
        /// Young's modulus E `[F/L²]`.
        young: Positive,
        /// Poisson's ratio ν, -1 < ν < 0.5 `[-]`.
        poisson: Poisson,
        /// ρ_y = √(2 J₂) of the Kirchhoff stress at yield, √(2/3) times the uniaxial yield stress `[F/L²]`.
        yield_radius: Positive,
        /// Mass per reference volume; needed where a body force acts `[M/L³]`.
        #[serde(default)]
        density: Option<Positive>,
    },
}

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
    /// Material points per cell and direction, evenly spaced; needed by every shape but `Points`, which has its own.
    #[serde(default)]
    pub points_per_cell: Option<Count>,
    /// Against volumetric locking, where the material or its flow is all but incompressible: points take the
    /// volume change of their cell in place of their own; left alone if left out.
    #[serde(default)]
    pub mean_dilatation: Option<MeanDilatationInput>,
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
        /// Names of bodies before this one, of the shapes `Cylinder`, `Tube` or `Surface`, that are cut out of the
        /// box, as far as they reach into it. The box then has its ends on mesh lines, and all have equally many
        /// points per cell.
        #[serde(default)]
        without: Vec<String>,
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
    },
    /// A cylinder along an axis; in the plane, a disc. Box meshes only. Cells that are filled in part have points
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
    /// its domain's sides, right-handed. An HDF5 file has datasets `position` (rows by dimensions), `volume` and, if
    /// points have domains, `domain` (rows by dimensions by dimensions, one vector after the other). Without
    /// domains they are cubes of the points' volumes. Points are kept in the order of the file, unless most of them stand
    /// far from the one before: then in the order of the cells that hold them, row by row.
    Points {
        /// The file, beside the scene: HDF5 if it ends in `.h5` or `.hdf5`, else CSV.
        file: String,
    },
}

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
    /// Point (x, y) about which the moment of the reaction is recorded, as `/history/reaction_moment/<name>`;
    /// not recorded if left out `[L]`.
    #[serde(default)]
    pub moment_about: Option<PlanePoint>,
}

/// Prescribed displacement of one component.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DisplaceInput {
    /// The component.
    pub axis: Direction,
    /// Displacement in all `[L]`.
    pub by: Finite,
    /// Part of it against the load fraction; linear if left out.
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
    },
    /// The body force of the generalised vortex (Brannon, Kamojjala & Sadeghirad 2011), a manufactured solution for a
    /// ring of radii 0.75 and 1.25 around the origin in `Hencky` elasticity, in the plane: every circle of radius R
    /// turns by the angle times 1 - 32 (R - 1)² + 256 (R - 1)⁴.
    Vortex {
        /// Name of the body.
        body: String,
        /// Angle by which the middle circle turns in all `[degrees]`.
        angle: Finite,
        /// Part of the angle against the load fraction; linear if left out.
        #[serde(default)]
        ramp: RampInput,
    },
    /// A force shared equally by the material points nearest to a position at rest.
    PointForce {
        /// Name of the body.
        body: String,
        /// The position `[L]`.
        near: Coordinates<D>,
        /// How many points share the force; points at equal distance count in their order.
        #[serde(default = "Count::one")]
        points: Count,
        /// The whole force (in the plane: per unit thickness) `[F]`.
        force: Coordinates<D>,
        /// Part of it against the load fraction; linear if left out.
        #[serde(default)]
        ramp: RampInput,
    },
    /// A dead traction on the part of a body's boundary that lies on a plane across an axis at rest,
    /// carried by the material points next to it in proportion to their share of the boundary.
    Traction {
        /// Name of the body.
        body: String,
        /// The axis that the plane cuts.
        axis: Direction,
        /// Coordinate of the plane at rest `[L]`.
        at: Finite,
        /// Bounds of the loaded part of the plane; all of it if left out.
        #[serde(default)]
        within: Option<BoundsInput<D>>,
        /// The whole force (in the plane: per unit thickness) `[F]`.
        resultant: Coordinates<D>,
        /// Part of it against the load fraction; linear if left out.
        #[serde(default)]
        ramp: RampInput,
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

/// Load steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScheduleInput {
    /// Number of equal load steps.
    pub steps: Count,
    /// How often a step that does not converge may be halved before the run ends; steps grow again
    /// by doubling, and every one of the equal steps ends where it would have.
    #[serde(default = "default_cuts", deserialize_with = "number::halvings")]
    #[schemars(range(min = 0, max = Schedule::MOST_CUTS))]
    pub cuts: u8,
    /// Where the iteration of a load step begins.
    #[serde(default)]
    pub predictor: PredictorInput,
    /// What sets the load fraction of a load step.
    #[serde(default)]
    pub control: StepControlInput,
}

/// Where the iteration of a load step begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum PredictorInput {
    /// At the displacement of the step before, in proportion to the change of the load fraction, and on to a
    /// hundredth of the tolerance. Where that does not converge at once, the step begins again at rest.
    #[default]
    LastStep,
    /// At rest, as other codes do. Path control has a guess of its own.
    Rest,
}

/// What sets the load fraction of a load step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum StepControlInput {
    /// It is given: `steps` equal steps.
    #[default]
    Load,
    /// It is found: each step has a given length along the path of equilibria, so that a run passes points
    /// where the load fraction has to decrease (snap-through, snap-back). `steps` is then the largest
    /// number of load steps; the run ends when the load fraction reaches 1. `cuts` limits how often in a
    /// row a step that cannot be solved is halved.
    Path {
        /// Change of the load fraction in the first step.
        first: Positive,
        /// Largest change of the load fraction in a step; as `first` if left out.
        #[serde(default)]
        longest: Option<Positive>,
        /// Newton iterations that a step should need: with fewer the next is longer, with more shorter.
        #[serde(default = "default_path_iterations")]
        iterations: Count,
        /// What the length of a step is.
        #[serde(default)]
        measure: PathMeasureInput,
    },
}

/// What the length of a step along the path is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum PathMeasureInput {
    /// Energy dissipated by yielding; load steps while nothing yields. For limit points caused by
    /// yielding and localisation: it cannot turn back, because a body that unloads dissipates nothing.
    Dissipation {
        /// Longest step `[F L]` (in the plane: per unit thickness); if left out, as the iterations allow.
        #[serde(default)]
        most: Option<Positive>,
    },
    /// Root mean square of the free displacements, each node weighted by its share of the stiffness. For
    /// limit points of elastic bodies (arches, shells).
    ArcLength {
        /// Longest step `[L]`; if left out, as the iterations allow.
        #[serde(default)]
        most: Option<Positive>,
    },
}

impl Default for PathMeasureInput {
    fn default() -> Self {
        Self::Dissipation { most: None }
    }
}

fn default_path_iterations() -> Count {
    Count(6)
}

fn default_cuts() -> u8 {
    Schedule::equal(1).cuts
}

/// How linear systems are solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum SolverInput {
    /// By the solver that is predicted to be quicker: up to some ten thousand equations the direct one, beyond
    /// the iterative one, which leaves to the other what takes it more iterations than a factorisation is worth.
    /// `mpm check` tells both costs.
    #[default]
    Auto,
    /// By sparse factorisation.
    Direct,
    /// By conjugate gradients with geometric multigrid, as accurately as each Newton iteration needs it; what
    /// they cannot solve is factorised.
    Iterative,
}

/// When a load step counts as solved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ToleranceInput {
    /// Out-of-balance force over external plus reaction force `[-]`.
    pub residual: Positive,
    /// Newton iterations per load step before it is cut.
    pub iterations: Count,
    /// A factorised tangent is kept for further iterations while each of them leaves at most this part of the
    /// out-of-balance force, below 1; if left out every iteration has its own. Iterations become more and cheaper:
    /// worth it where factorising takes most of the time and the response is nearly linear `[-]`.
    pub keep_factor_below: Option<Positive>,
}

impl Default for ToleranceInput {
    fn default() -> Self {
        let Tolerance { residual, iterations, keep_factor_below } = Tolerance::default();
        Self {
            residual: Positive(residual),
            iterations: Count(iterations),
            keep_factor_below: keep_factor_below.map(Positive),
        }
    }
}

/// What the results file holds besides the history.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct OutputInput {
    /// Fields of the material points.
    pub fields: Vec<Field>,
    /// Points are recorded every so many load steps, and always at the start and the end.
    pub every: Count,
    /// Whether the health of the points' domains is worked out after every load step, as columns
    /// `/history/domain_…`.
    pub domain_history: bool,
    /// Whether energies are recorded `[F L]`: `/history/energy/elastic`, `…/dissipated` by yielding,
    /// `…/external_work` of loads and supports, and `…/unbalanced`, what is left of the work. That vanishes with the
    /// square of the load step, but for forces that a reset mesh lets go of, and for `stabilisation`, whose penalty
    /// is in none of them. Costs a pass over the points per load step.
    pub energies: bool,
    /// Whether the condition number of every load step's last tangent is estimated (`/history/condition`), by ten
    /// linear solutions more: 10 to 30 % more time in the plane, up to 80 % in space with the direct solver. Without it
    /// the summary has a lower bound, from the pivots, which is free.
    pub condition: bool,
    /// Checkpoints, from which an interrupted run goes on by `mpm resume`; none if left out.
    pub checkpoint: Option<CheckpointInput>,
}

/// When the state of the run is kept in a file beside the results; at least one of the two is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CheckpointInput {
    /// After every so many load steps.
    #[serde(default)]
    pub every: Option<Count>,
    /// After the first load step that ends so long after the last checkpoint `[s]`.
    #[serde(default)]
    pub seconds: Option<Positive>,
}

impl Default for OutputInput {
    fn default() -> Self {
        Self {
            fields: vec![Field::CauchyStress, Field::Displacement],
            every: Count(1),
            domain_history: false,
            energies: false,
            condition: false,
            checkpoint: None,
        }
    }
}

impl<const D: usize, B> SceneIn<D, B> {
    fn files(&self) -> impl Iterator<Item = &str> {
        self.bodies.iter().filter_map(|body| match &body.shape {
            ShapeInput::Surface { file, .. } | ShapeInput::Points { file } => Some(file.as_str()),
            _ => None,
        })
    }
}

impl Scene {
    /// Files that it names.
    pub fn files(&self) -> Vec<&str> {
        match self {
            Scene::PlaneStrain(scene) => scene.files().collect(),
            Scene::Solid(scene) => scene.files().collect(),
        }
    }

    /// What the scene wants recorded.
    pub fn output(&self) -> &OutputInput {
        match self {
            Scene::PlaneStrain(scene) => &scene.output,
            Scene::Solid(scene) => &scene.output,
        }
    }

    /// What the scene shows.
    pub fn title(&self) -> &str {
        match self {
            Scene::PlaneStrain(scene) => &scene.title,
            Scene::Solid(scene) => &scene.title,
        }
    }
}

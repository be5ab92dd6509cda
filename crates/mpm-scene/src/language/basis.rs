//! Bases, their domains, and what is done about cells that bodies barely reach into.

use super::any_case::{self, AnyCase};
use super::number::{self, Positive};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

/// Bases of the plane. Their names may be written in capitals and small letters of any kind: `CPDI1`, `sMPM`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
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

/// Bases of three-dimensional space. Their names may be written in capitals and small letters of any kind: `CPDI1`, `sMPM`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
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

impl AnyCase for PlaneBasis {
    const NAME: &'static str = "PlaneBasis";
    const NAMES: &'static [&'static str] = &["Smpm", "Gimp", "Cpdi1", "Cpdi2q", "Cpdi2t"];
    const VALUES: &'static [Self] = &[Self::Smpm, Self::Gimp, Self::Cpdi1, Self::Cpdi2q, Self::Cpdi2t];
}

impl AnyCase for SolidBasis {
    const NAME: &'static str = "SolidBasis";
    const NAMES: &'static [&'static str] = &["Smpm", "Gimp", "Cpdi1", "Cpdi2Hexahedron", "Cpdi2Tetrahedron"];
    const VALUES: &'static [Self] =
        &[Self::Smpm, Self::Gimp, Self::Cpdi1, Self::Cpdi2Hexahedron, Self::Cpdi2Tetrahedron];
}

impl<'de> Deserialize<'de> for PlaneBasis {
    fn deserialize<De: Deserializer<'de>>(deserializer: De) -> Result<Self, De::Error> {
        any_case::read(deserializer)
    }
}

impl<'de> Deserialize<'de> for SolidBasis {
    fn deserialize<De: Deserializer<'de>>(deserializer: De) -> Result<Self, De::Error> {
        any_case::read(deserializer)
    }
}

/// How the points' domains are made and how they deform. An option that the scene's basis does not have is an
/// error.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DomainsInput {
    /// `Gimp`: what a half length follows; `Stretch` if left out.
    #[serde(deserialize_with = "number::chosen")]
    pub gimp_update: Option<GimpUpdateInput>,
    /// `Cpdi2t`: how a body's pieces are cut into triangles; `Cross` if left out.
    #[serde(deserialize_with = "number::chosen")]
    pub triangles: Option<TrianglesInput>,
    /// `Cpdi2q`: weights of the corners; `Current` if left out.
    #[serde(deserialize_with = "number::chosen")]
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
    /// Jumps of the displacement gradient (of the load step) across the faces of boundary cells are penalised, with splines
    /// of degree p those of its p-th derivative: the cells with an empty neighbour follow those inside. Counted as
    /// `/history/ghost_faces`.
    Ghost {
        /// The penalty over Young's modulus; if left out 1/30, with splines of degree 2 and 3 1e-3 and 1e-4 `[-]`.
        #[serde(default)]
        factor: Option<Positive>,
    },
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
    Fixed,
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

#[cfg(test)]
mod tests {
    use super::*;

    /// `None` would be read as "left out", which chooses the default.
    #[test]
    fn none_is_no_choice_where_there_is_a_default() {
        for (field, choice) in [("gimp_update", "Fixed"), ("triangles", "Slash"), ("corner_weights", "Current")]
        {
            let read = |value: &str| ron::from_str::<DomainsInput>(&format!("({field}: {value})"));
            assert!(read(choice).is_ok(), "{field}: {:?}", read(choice));
            assert!(read("None").is_err(), "{field}");
        }
        assert_eq!(ron::from_str::<DomainsInput>("()").unwrap(), DomainsInput::default());
    }
}

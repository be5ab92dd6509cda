#![doc = include_str!("../README.md")]
//!
//! # In more detail
//!
//! How a material point influences the nodes of a background grid.
//!
//! A [`Basis`] turns a point, with the domain it carries, into influences `S_vp` and `∇S_vp` on
//! nodes. [`Stencils`], [`ActiveNodes`] and [`Links`] hold these as data, from which everything else
//! (active equations, sparsity pattern, order of sums) is derived.
//!
//! | basis | domain of a point | D | source |
//! |---|---|---|---|
//! | [`Smpm`] | none | any | Sulsky, Chen & Schreyer 1994 |
//! | [`Gimp`] | a box along the axes; rectilinear meshes only | any | Bardenhagen & Kober 2004; updates: Charlton, Coombs & Augarde 2017, Coombs et al. 2020 |
//! | [`Cpdi1`] | a parallelogram or parallelepiped that deforms with F | any | Sadeghirad, Brannon & Burghardt 2011 |
//! | [`Cpdi2q`] | a quadrilateral with convected corners | 2 | Sadeghirad, Brannon & Guilkey 2013 |
//! | [`Cpdi2Hexahedron`] | a hexahedron with convected corners | 3 | Sadeghirad, Brannon & Guilkey 2013 |
//! | [`Cpdi2t`] | a triangle with convected corners | 2 | Nguyen et al. 2017; Wang et al. 2019 |
//! | [`Cpdi2Tetrahedron`] | a tetrahedron with convected corners | 3 | Leavy et al. 2019 |
//! | [`Fallback`] | another basis' domain, CPDI1's where that has degenerated | as that | here |
//!
//! Wang et al. 2019, *On the use of domain-based material point methods for problems involving large
//! distortion* (Computer Methods in Applied Mechanics and Engineering), compare them under rotation
//! and distortion. All reproduce linear fields on every mesh they suit: `Σ S = 1`, `Σ ∇S = 0`,
//! `Σ x_v ⊗ ∇S = I`, and `Σ S x_v` is the point's position. Parts of a domain up to half a cell outside
//! the mesh see the boundary cell's functions continued.

mod active;
mod cells;
mod completeness;
mod connectivity;
pub mod control;
mod cpdi1;
mod cpdi2_hexahedron;
mod cpdi2_tetrahedron;
mod cpdi2q;
mod cpdi2t;
mod fallback;
mod gimp;
mod influence;
mod links;
mod sampled;
mod simplex;
mod smpm;
mod stored;
mod tensor;

pub use active::ActiveNodes;
pub use cells::{CellPart, Cells};
pub use completeness::Completeness;
pub use connectivity::{Stencils, UnconnectedPoint};
/// See [`control`].
pub use control::{DomainControl, Part};
pub use cpdi1::{Cpdi1, Parallelepiped};
pub use cpdi2_hexahedron::{Cpdi2Hexahedron, Hexahedron};
pub use cpdi2_tetrahedron::Cpdi2Tetrahedron;
pub use cpdi2q::{CornerWeights, Cpdi2q, Quadrilateral};
pub use cpdi2t::{Cpdi2t, TriangleSplit};
pub use fallback::{Fallback, FallbackDomain};
pub use gimp::{Gimp, GimpUpdate, HalfLengths};
pub use influence::{Influence, Stencil};
pub use links::{Group, Links};
/// A part of a cell at rest, from which a basis seeds points.
pub use mpm_grid::LinearCell as Piece;
pub use simplex::Simplex;
pub use smpm::Smpm;
pub use stored::StoredDomain;

use mpm_grid::{Block, Mesh, NodeId, NodeKind, OutsideMesh, Vector};

/// A basis says how a point's domain spreads its influence, and how that domain deforms.
pub trait Basis<const D: usize>: Send + Sync {
    /// Geometry a point carries for this basis; `()` for standard MPM.
    type Domain: Clone + Send + Sync + StoredDomain;

    /// Its name in one word, as people write it.
    fn name(&self) -> &'static str;

    /// The nodes that it influences. All bodies of a model share one kind.
    fn node_kind(&self) -> NodeKind {
        NodeKind::Vertices
    }

    /// Pieces per direction that a cell is cut into for `points_per_cell` points per direction, or
    /// what the number must be instead.
    ///
    /// # Errors
    /// A sentence that says which numbers the basis can use.
    fn pieces_per_cell(&self, points_per_cell: u32) -> Result<u32, &'static str> {
        Ok(points_per_cell)
    }

    /// Whether the basis exists on this mesh.
    ///
    /// # Errors
    /// A sentence that says which meshes the basis needs.
    fn suits(&self, _mesh: &Mesh<D>) -> Result<(), &'static str> {
        Ok(())
    }

    /// Places the points that stand for one piece of the body at rest.
    fn seed(&self, piece: &Piece<D>, place: &mut dyn FnMut(Seed<D, Self::Domain>));

    /// `S_vp` and its gradient with respect to start-of-step positions.
    ///
    /// # Errors
    /// The position (of the point or of a part of its domain) that lies outside the mesh.
    fn influences(
        &self,
        mesh: &Mesh<D>,
        x: &Vector<D>,
        domain: &Self::Domain,
        stencil: &mut Stencil<D>,
    ) -> Result<(), OutsideMesh<D>>;

    /// Carries the point and its domain through a converged load step.
    ///
    /// # Errors
    /// What makes the convected domain unusable.
    fn convect(
        &self,
        domain: &mut Self::Domain,
        position: &mut Vector<D>,
        step: &Convection<'_, D>,
    ) -> Result<(), ConvectionError>;

    /// How far the shape of a domain is from one that this basis can be trusted with `[-]`: the basis'
    /// own objective measure, 0 where the domain cannot go bad. [`Fallback`] acts on it.
    fn distortion(&self, _domain: &Self::Domain) -> f64 {
        0.0
    }

    /// Second moment of the domain, `3/V ∫ (x - x̄) ⊗ (x - x̄) dV` (of a box, squares of the half lengths),
    /// which [`control`] takes for its size; `None` where there is no domain `[L²]`.
    fn spread(&self, _domain: &Self::Domain) -> Option<Block<D>> {
        None
    }

    /// Maps the domain about its point `x` by `map` `[-]`, symmetric with a positive determinant:
    /// `x_c → x + A (x_c - x)`. It goes on deforming from there.
    fn scale(&self, _domain: &mut Self::Domain, _x: &Vector<D>, _map: &Block<D>) {}

    /// Gives the domain other sides with the same second moment: the first along the direction in which it is
    /// thinnest in cells no longer than it must be, and so on, so that its corners reach as little into other
    /// rows of cells as may be. `to_cells` takes half the edges of a cell to length 1. Nothing where the
    /// shape is more than its second moment.
    fn align(&self, _domain: &mut Self::Domain, _to_cells: &Block<D>) {}

    /// Cuts the domain of the point at `x` in two, across the side that `to_cells` (which takes half
    /// the edges of a cell to length 1) makes longest; `None` where it has none or cannot be cut.
    fn halve(
        &self,
        _domain: &Self::Domain,
        _x: &Vector<D>,
        _to_cells: &Block<D>,
    ) -> Option<[Part<D, Self::Domain>; 2]> {
        None
    }

    /// The health of a point's domain in this mesh.
    ///
    /// # Errors
    /// As [`Self::influences`].
    fn diagnose(
        &self,
        _mesh: &Mesh<D>,
        _x: &Vector<D>,
        _domain: &Self::Domain,
    ) -> Result<DomainReport, OutsideMesh<D>> {
        Ok(DomainReport::default())
    }

    /// Corners of the domain `[L]` for drawing: round the outline in the plane, a list in space
    /// (lexicographic for boxes and hexahedra); none where there is no domain.
    fn outline(&self, _x: &Vector<D>, _domain: &Self::Domain) -> Vec<Vector<D>> {
        Vec::new()
    }
}

/// The health of a point's domain; the default is that of a point without one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DomainReport {
    /// Signed volume of the domain over that at rest `[-]`; not above zero once inside out.
    pub measure: f64,
    /// [`Basis::distortion`] `[-]`.
    pub distortion: f64,
    /// The smallest `w_c` `[-]`.
    pub smallest_weight: f64,
    /// Number of nodes that receive the point through a single corner of its domain.
    pub single_corner_nodes: usize,
    /// Number of corners outside the mesh.
    pub corners_outside: usize,
    /// Whether [`Fallback`] has replaced the domain.
    pub fallen_back: bool,
}

impl Default for DomainReport {
    fn default() -> Self {
        Self {
            measure: 1.0,
            distortion: 0.0,
            smallest_weight: 1.0,
            single_corner_nodes: 0,
            corners_outside: 0,
            fallen_back: false,
        }
    }
}

/// A new point of a body at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Seed<const D: usize, Domain> {
    /// `x_p` `[L]`.
    pub position: Vector<D>,
    /// `V⁰_p` `[L^D]`.
    pub volume: f64,
    /// Geometry for the basis.
    pub domain: Domain,
}

/// What a domain may know of a converged load step.
#[derive(Clone, Copy, Debug)]
pub struct Convection<'a, const D: usize> {
    /// `Σ_v S_vp Δu_v` of the point `[L]`.
    pub displacement: Vector<D>,
    /// F of the point at the end of the step `[-]`.
    pub deformation_gradient: Block<D>,
    /// Mesh of the step, at its start.
    pub mesh: &'a Mesh<D>,
    /// Nodes of the step.
    pub active: &'a ActiveNodes<D>,
    /// `Δu_v` of every active node `[L]`.
    pub increment: &'a [Vector<D>],
}

impl<const D: usize> Convection<'_, D> {
    /// `Δu_v`; zero where the node carries no material `[L]`.
    #[inline]
    pub fn at_node(&self, node: NodeId) -> Vector<D> {
        self.active.number(node).map_or_else(Vector::zeros, |v| self.increment[v])
    }
}

/// A domain that cannot be carried on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ConvectionError {
    /// The domain turned inside out or lost its volume.
    #[error("its domain inverted (volume {volume:e})")]
    Inverted {
        /// Volume of the domain, negative once inside out `[L^D]`.
        volume: f64,
    },
    /// A box along the axes lost its extent in one direction.
    #[error("its domain has half length {half_length:e} along axis {axis}")]
    HalfLength {
        /// Direction, from 0.
        axis: usize,
        /// The half length `[L]`.
        half_length: f64,
    },
    /// A part of the domain left the mesh.
    #[error("its domain left the mesh: {0}")]
    Outside(String),
}

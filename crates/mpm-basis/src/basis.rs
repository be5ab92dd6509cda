//! What a basis is: how a point, with its domain, influences nodes.

use crate::active::ActiveNodes;
use crate::corner::{Corner, CornerPoint};
use crate::domain::Domain;
use crate::influence::Stencil;
use mpm_grid::{Block, LinearCell, Mesh, NodeId, NodeKind, OutsideMesh, Vector};

/// A basis says how a point's domain spreads its influence over nodes, and how that domain moves.
pub trait Basis<const D: usize>: Send + Sync {
    /// Geometry a point carries for this basis; `()` for standard MPM.
    type Domain: Domain<D>;

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

    /// Places the points that stand for one piece of a body at rest.
    fn seed(&self, piece: &LinearCell<D>, place: &mut dyn FnMut(Seed<D, Self::Domain>));

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

    /// As [`Self::influences`], of a ring in the half plane (r, z), D = 2: `S_vp` is the same, its gradient the mean
    /// weighted by r. A basis whose gradients are those of the point itself has nothing to weigh.
    ///
    /// With `V_p = 2π r_p A` these gradients, and `S_vp / r_p` along the hoop, leave no force of a uniform stress on
    /// nodes within a body whose domains tile it (Nairn & Guilkey 2015).
    ///
    /// # Errors
    /// As [`Self::influences`].
    fn ring_influences(
        &self,
        mesh: &Mesh<D>,
        x: &Vector<D>,
        domain: &Self::Domain,
        stencil: &mut Stencil<D>,
    ) -> Result<(), OutsideMesh<D>> {
        self.influences(mesh, x, domain, stencil)
    }

    /// Adds the parts of a ring's mass that nodes receive, the means of N_v weighted by r, as values; gradients do not
    /// count. Nodes are among those of [`Self::ring_influences`].
    ///
    /// # Errors
    /// As [`Self::influences`].
    fn ring_masses(
        &self,
        mesh: &Mesh<D>,
        x: &Vector<D>,
        domain: &Self::Domain,
        stencil: &mut Stencil<D>,
    ) -> Result<(), OutsideMesh<D>> {
        self.influences(mesh, x, domain, stencil)
    }

    /// Adds the parts that nodes carry of a force on a side of a ring's domain; by the displacement of the point and its
    /// gradient, where the basis knows no better.
    ///
    /// # Errors
    /// As [`Self::influences`].
    fn ring_side(
        &self,
        mesh: &Mesh<D>,
        x: &Vector<D>,
        domain: &Self::Domain,
        side: &RingSide<D>,
        stencil: &mut Stencil<D>,
    ) -> Result<(), OutsideMesh<D>> {
        let mut own = Stencil::new();
        self.influences(mesh, x, domain, &mut own)?;
        let arm = side.ends[0] * side.parts[0] + side.ends[1] * side.parts[1] - x;
        for it in own.entries() {
            stencil.add(it.node, it.value + arm.dot(&it.gradient), Vector::zeros());
        }
        Ok(())
    }

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

    /// Corners of a point's domain, at most; none where the basis has no corners that a tool could touch.
    fn n_corners(&self) -> usize {
        0
    }

    /// Adds the corners of a point's domain, always in the same order. Their nodes are among those that the point
    /// [influences](Self::influences). Areas of a [ring](CornerPoint::is_ring) are those of the whole ring.
    ///
    /// # Errors
    /// As [`Self::influences`].
    fn corners(
        &self,
        _mesh: &Mesh<D>,
        _point: &CornerPoint<D>,
        _domain: &Self::Domain,
        _to: &mut Vec<Corner<D>>,
    ) -> Result<(), OutsideMesh<D>> {
        Ok(())
    }

    /// Cuts the domain of the point at `x` in two, across the side that `to_cells` (which takes half
    /// the edges of a cell to length 1) makes longest; `None` where it has none or cannot be cut.
    fn halve(
        &self,
        _domain: &Self::Domain,
        _x: &Vector<D>,
        _to_cells: &Block<D>,
    ) -> Option<[DomainPart<D, Self::Domain>; 2]> {
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
}

/// The health of a point's domain; the default is that of a point without one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DomainReport {
    /// Signed volume of the domain over that at rest `[-]`; not above zero once inside out.
    pub measure: f64,
    /// [`Domain::distortion`] `[-]`.
    pub distortion: f64,
    /// The smallest `w_c` `[-]`.
    pub smallest_weight: f64,
    /// Number of nodes that receive the point through a single corner of its domain.
    pub single_corner_nodes: usize,
    /// Number of corners outside the mesh.
    pub corners_outside: usize,
    /// Whether [`crate::Fallback`] has replaced the domain.
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

/// Where a force acts that is spread linearly over a straight side of a ring's section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RingSide<const D: usize> {
    /// Ends of the side `[L]`.
    pub ends: [Vector<D>; 2],
    /// Parts of the force that belong to the ends, whose sum is 1: of a uniform traction r/3 of the end's own radius and
    /// r/6 of the other's, over half their sum `[-]`.
    pub parts: [f64; 2],
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

/// One of the points that a point is split into.
#[derive(Clone, Debug, PartialEq)]
pub struct DomainPart<const D: usize, Domain> {
    /// Centre of its domain `[L]`.
    pub position: Vector<D>,
    /// Its domain.
    pub domain: Domain,
    /// Its part of the point's mass and volume `[-]`; the parts' sum is 1, and the mean of their
    /// positions weighed with it is the point's.
    pub share: f64,
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

/// What directions are called, where nobody says otherwise.
const AXES: [&str; 3] = ["x", "y", "z"];

impl ConvectionError {
    /// The sentence with other names of the directions.
    pub fn told(&self, axes: [&str; 3]) -> String {
        match self {
            Self::HalfLength { axis, half_length } => {
                format!("its domain has half length {half_length:e} along {}", axes[*axis])
            }
            _ => self.to_string(),
        }
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
    #[error("its domain has half length {half_length:e} along {}", AXES[*axis])]
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

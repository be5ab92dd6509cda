//! What the solver asks of a body.

use super::occupied::OccupiedCell;
use crate::body::advance::{AdvanceError, Converged};
use crate::body::assembly_plan::AssemblyPlan;
use crate::body::dilatation::{Dilatation, MeanDilatation};
use crate::body::domain_control::{Controlled, TooManyPoints};
use crate::body::law_of_body::LawOfBody;
use crate::body::point_view::PointView;
use crate::body::regularised::FieldPoint;
use crate::body::scatter::{PassInput, Sums};
use crate::body::space::Space;
use crate::body::start::{PointStart, RefusedStart};
use crate::body::stored::{ForeignPoints, StoredPoints};
use crate::body::trial::InadmissiblePoint;
use mpm_basis::parallel::each_point;
use mpm_basis::{ActiveNodes, Connectivity, Corner, DomainControl, DomainReport, Stencils, UnconnectedPoint};
use mpm_grid::{Mesh, NodeKind, OutsideMesh, Vector};
use mpm_linear::Symmetry;
use mpm_material::{FieldInfo, Regularisation, SymmetricTensor};

/// A set of material points under one basis and one law.
pub trait Body<const D: usize>: Send + Sync {
    /// The same body of revolution, of points that may turn about the axis, see [`Space::Axisymmetric`]; none of other
    /// bodies.
    fn with_twist(self: Box<Self>) -> Option<Box<dyn Body<3>>>;

    /// The space that it lives in; all bodies of a model share one.
    fn space(&self) -> Space;

    /// Number of material points.
    fn n_points(&self) -> usize;

    /// Name of the basis, see [`Basis::name`](mpm_basis::Basis::name).
    fn basis(&self) -> &'static str;

    /// The nodes that its points influence, see [`Basis::node_kind`](mpm_basis::Basis::node_kind).
    fn node_kind(&self, mesh: &Mesh<D>) -> NodeKind;

    /// How volume changes are averaged over cells, which needs vertices; none where they are not.
    fn mean_dilatation(&self) -> Option<MeanDilatation>;

    /// The nodal field that regularises its law, if one does.
    fn regularisation(&self) -> Option<Regularisation>;

    /// About the width of shear bands that the field allows, if one regularises the law and bands can form `[L]`.
    fn band_width(&self) -> Option<f64>;

    /// What that field sees of a point.
    fn field_point(&self, point: usize) -> FieldPoint<D>;

    /// Whether its law can yield.
    fn can_yield(&self) -> bool;

    /// Whether its points have masses, which body forces need.
    fn has_masses(&self) -> bool;

    /// Gives the points another law, before the first load step: they begin as `starts` say, one for each point, or free
    /// of stress if there are none.
    ///
    /// # Errors
    /// The first point that has no elastic state under its stress.
    ///
    /// # Panics
    /// If there are starts, and not one for each point, or if the law is compiled for another space.
    fn set_law(&mut self, law: LawOfBody<D>, starts: &[PointStart]) -> Result<(), RefusedStart>;

    /// Whether its tangent is symmetric; the [`SparsityPattern`](crate::SparsityPattern) takes the worst of all bodies.
    fn symmetry(&self) -> Symmetry;

    /// What its law remembers of a point and shows in results.
    fn history_fields(&self) -> Vec<FieldInfo>;

    /// Appends the components of all [history fields](Self::history_fields) of one point.
    fn history(&self, point: usize, to: &mut Vec<f64>);

    /// Points that yield at the apex of their law or at the tip of its cut-off, where they have no stiffness; none where
    /// its law has no apex.
    fn points_at_apex(&self) -> Option<usize>;

    /// Young's modulus of its law, of small strains around no stress `[F/L²]`.
    fn young(&self) -> f64;

    /// Undrained shear strength that a point has left, see [`mpm_material::Material::undrained_strength`] `[F/L²]`; none
    /// where its law has none.
    fn undrained_strength(&self, point: usize) -> Option<f64>;

    /// Where a point and its domain are.
    fn extent(&self, point: usize) -> PointExtent<D>;

    /// Corners of a point's domain, at most, see [`Basis::n_corners`](mpm_basis::Basis::n_corners).
    fn n_corners(&self) -> usize;

    /// Adds the corners of a point's domain, see [`Basis::corners`](mpm_basis::Basis::corners).
    ///
    /// # Errors
    /// The point, or a corner of its domain, lies outside the mesh.
    fn corners(&self, mesh: &Mesh<D>, point: usize, to: &mut Vec<Corner<D>>) -> Result<(), OutsideMesh<D>>;

    /// Whether its points have domains.
    fn has_domains(&self) -> bool;

    /// Influences of all points on the nodes of `mesh`.
    ///
    /// # Errors
    /// The first point that the mesh does not cover.
    fn stencils(&self, mesh: &Mesh<D>) -> Result<Stencils<D>, UnconnectedPoint<D>>;

    /// The nodes of [`Self::stencils`] without the influences, see [`Stencils::of_nodes`].
    ///
    /// # Errors
    /// As [`Self::stencils`].
    fn nodes(&self, mesh: &Mesh<D>) -> Result<Stencils<D>, UnconnectedPoint<D>>;

    /// Cells over which volume changes are averaged, where they are; `connectivity` are the body's in this step.
    ///
    /// # Errors
    /// The first point that the mesh does not cover.
    fn dilatation(
        &self,
        connectivity: &Connectivity<D>,
        mesh: &Mesh<D>,
        active: &ActiveNodes<D>,
    ) -> Result<Option<Dilatation<D>>, UnconnectedPoint<D>>;

    /// Adds internal force and tangent, see `pass.rs`; where a nodal field regularises the body also those of the field, see
    /// `regularised/pass.rs`.
    ///
    /// # Errors
    /// The first point that has no admissible state under the trial displacement.
    fn assemble(
        &self,
        plan: &AssemblyPlan<D>,
        input: PassInput<'_, D>,
        sums: Sums<'_, D>,
    ) -> Result<f64, InadmissiblePoint>;

    /// Energy that a trial displacement, with the unknowns that belong to no node's displacement, dissipates `[F L]`, see
    /// `dissipation.rs`.
    ///
    /// # Errors
    /// The first point that has no admissible state under the trial displacement.
    fn dissipation(
        &self,
        plan: &AssemblyPlan<D>,
        trial: (&[Vector<D>], &[f64]),
        gradient: &mut [Vector<D>],
    ) -> Result<f64, InadmissiblePoint>;

    /// Adds the external force of `loads` to `external`, one entry per active node `[F]`.
    fn external_force(
        &self,
        connectivity: &Connectivity<D>,
        loads: &BodyLoads<'_, D>,
        external: &mut [Vector<D>],
    );

    /// Adds to `scale` the forces that a strain of one in every point would cause,
    /// `Σ_p V⁰_p M |∇S_vp|` with the law's P-wave modulus M: a scale for round-off `[F]`.
    fn stiffness_force(&self, connectivity: &Connectivity<D>, scale: &mut [f64]);

    /// Adds to `scale` the same forces for the strains of which each point's stress is computed,
    /// `Σ_p V⁰_p M |∇S_vp| (|b_e − I|_p + Σ_w |∇S_wp| |Δu_w|)`: each node's own scale for round-off under the increment
    /// `Δu` `[F]`.
    fn strain_force(&self, connectivity: &Connectivity<D>, increment: &[Vector<D>], scale: &mut [f64]);

    /// Adds the cells that the body occupies, see [`OccupiedCell`]; they may occur more than once.
    ///
    /// # Errors
    /// The first part of a domain that the mesh does not cover.
    fn occupied_cells(
        &self,
        connectivity: &Connectivity<D>,
        mesh: &Mesh<D>,
        active: &ActiveNodes<D>,
        out: &mut Vec<OccupiedCell>,
    ) -> Result<(), OutsideMesh<D>>;

    /// Works out the points after a converged step, without touching the present ones.
    ///
    /// # Errors
    /// The first point that cannot be carried on.
    fn prepare(&mut self, plan: &AssemblyPlan<D>, step: Converged<'_, D>) -> Result<(), AdvanceError>;

    /// The largest |ln λ| among the points that yield in the step prepared last, λ the principal stretches of its ΔF `[-]`.
    fn largest_step_strain(&self) -> f64;

    /// Makes the prepared points the present ones.
    fn commit(&mut self);

    /// Makes the present positions those at rest, where the body keeps these: displacements count from here on.
    fn reset_displacements(&mut self);

    /// Shortens or splits the domains of the present points that are too long in `mesh`.
    ///
    /// # Errors
    /// The body would have more than `most` points; nothing has changed.
    fn control(
        &mut self,
        mesh: &Mesh<D>,
        control: DomainControl,
        most: usize,
    ) -> Result<Controlled, TooManyPoints>;

    /// One point as the outside may see it.
    fn point(&self, point: usize) -> PointView<D>;

    /// Kirchhoff stress τ of a point `[F/L²]`; not a number where the law finds none for the committed state.
    fn kirchhoff(&self, point: usize) -> SymmetricTensor;

    /// Elastic energy of a point per reference volume `[F/L²]`.
    fn stored_energy(&self, point: usize) -> f64;

    /// The health of every point's domain in `mesh`; a domain too far outside the mesh is reported with
    /// all its corners outside.
    fn diagnose(&self, mesh: &Mesh<D>) -> Vec<DomainReport>;

    /// Corners of a point's domain, see [`Domain::outline`](mpm_basis::Domain::outline) `[L]`.
    fn outline(&self, point: usize) -> Vec<Vector<D>>;

    /// Name and bytes of every column of the points; a column that the scene does not need has none.
    fn columns(&self) -> Vec<(&'static str, usize)>;

    /// Name and numbers per point of every column that [`Self::store`] gives.
    fn stored_columns(&self) -> Vec<(&'static str, usize)>;

    /// The present points as plain numbers.
    fn store(&self) -> StoredPoints;

    /// Makes stored points the present ones; no more is taken over than [`Self::store`] gave.
    ///
    /// # Errors
    /// What cannot be points of this body; nothing has changed.
    fn restore(&mut self, stored: &StoredPoints) -> Result<(), ForeignPoints>;
}

/// Where a point is, and how large.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointExtent<const D: usize> {
    /// `x_p` `[L]`.
    pub position: Vector<D>,
    /// Width of a cube of the point's volume at rest, `(V_p⁰)^(1/D)`; of a body of revolution that of a square of its
    /// cross section `[L]`.
    pub width: f64,
    /// No corner of its domain is farther away `[L]`.
    pub radius: f64,
}

/// Loads on one body at one moment.
#[derive(Clone, Debug, Default)]
pub struct BodyLoads<'a, const D: usize> {
    /// Body force per mass `[L/T²]`; `None` where none acts.
    pub acceleration: Option<Vector<D>>,
    /// Forces on single points, ascending in point `[F]`.
    pub point_forces: &'a [PointForce<D>],
    /// Forces on sides of rings, with the mesh and its nodes in which these are; none of other bodies.
    pub side_forces: Option<SideForces<'a, D>>,
}

/// Forces on sides of the domains of a body of revolution.
#[derive(Clone, Copy, Debug)]
pub struct SideForces<'a, const D: usize> {
    /// Mesh of the step.
    pub mesh: &'a Mesh<D>,
    /// Nodes of the step.
    pub active: &'a ActiveNodes<D>,
    /// The forces.
    pub forces: &'a [SideForce<D>],
}

/// A force that is spread linearly over a straight side which a point of a body of revolution carries with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SideForce<const D: usize> {
    /// The point.
    pub point: usize,
    /// f, of the whole ring `[F]`.
    pub force: Vector<D>,
    /// From the point to the ends of the side, at rest `[L]`.
    pub arms: [Vector<D>; 2],
    /// Parts of the force that belong to the ends, see [`mpm_basis::RingSide`] `[-]`.
    pub parts: [f64; 2],
}

/// A force at a place that a point carries with it.
///
/// Its nodal forces are `(S_vp + a·∇S_vp) f` with the arm `a = F_p a⁰`: their sum is f and their moment that of f at
/// `x_p + a`, for every basis, for `Σ S = 1`, `Σ ∇S = 0`, `Σ S x_v = x_p` and `Σ x_v ⊗ ∇S = I`. In parallelograms,
/// triangles and tetrahedra with the arm to the middle of a side they are those of equal parts at its corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointForce<const D: usize> {
    /// The point.
    pub point: usize,
    /// f `[F]`.
    pub force: Vector<D>,
    /// From the point to where the force acts, at rest: `a⁰` `[L]`.
    pub arm: Vector<D>,
}

/// All points of a body in order, see [`of_points`].
pub fn views<const D: usize>(body: &dyn Body<D>) -> impl Iterator<Item = PointView<D>> {
    of_points(body, |point| body.point(point))
}

/// Something of every point of a body in order, worked out in parallel, a block at a time: that of all points together would
/// need as much memory as the points themselves.
pub fn of_points<const D: usize, T: Send>(
    body: &dyn Body<D>,
    of: impl Fn(usize) -> T + Sync,
) -> impl Iterator<Item = T> {
    const BLOCK: usize = 8192;
    let n = body.n_points();
    (0..n).step_by(BLOCK).flat_map(move |first| {
        let block = first..n.min(first + BLOCK);
        each_point(block.len(), &|k| of(block.start + k))
    })
}

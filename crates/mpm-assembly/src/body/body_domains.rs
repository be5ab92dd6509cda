//! The basis of a body and the domains of its points, behind an interface that does not name the basis.

use crate::body::advance::{AdvanceError, Converged, PreparedDomains};
use crate::body::domain_control::{self, Controlled, TooManyPoints};
use crate::body::space::Space;
use crate::body::stored::ForeignPoints;
use mpm_basis::parallel::each_point;
use mpm_basis::{
    Basis, Connectivity, Corner, CornerPoint, Domain, DomainControl, DomainReport, RingSide, Stencil, Stencils,
    UnconnectedPoint,
};
use mpm_grid::{Block, Mesh, NodeKind, OutsideMesh, Vector};

/// What is compiled for each basis. `position` are those of the points `[L]`.
pub(crate) trait BodyDomains<const D: usize>: Send + Sync {
    fn basis(&self) -> &'static str;

    fn node_kind(&self, mesh: &Mesh<D>) -> NodeKind;

    /// See [`Basis::sampled_cells`].
    fn sampled_cells(
        &self,
        mesh: &Mesh<D>,
        point: (usize, &Vector<D>),
        take: &mut dyn FnMut([u32; D]),
    ) -> Result<(), OutsideMesh<D>>;

    /// Bytes of a domain; none for standard MPM.
    fn domain_bytes(&self) -> usize;

    /// Of points in a space, with parts of their masses where these are wanted.
    fn stencils(
        &self,
        mesh: &Mesh<D>,
        position: &[Vector<D>],
        of: (Space, bool),
    ) -> Result<Stencils<D>, UnconnectedPoint<D>>;

    /// Their nodes alone.
    fn nodes(
        &self,
        mesh: &Mesh<D>,
        position: &[Vector<D>],
        space: Space,
    ) -> Result<Stencils<D>, UnconnectedPoint<D>>;

    /// Works out positions and domains after a load step, see [`PreparedDomains::advance`].
    fn advance(
        &mut self,
        of: (&[Vector<D>], Space),
        deformation_gradient: &[Block<D>],
        connectivity: &Connectivity<D>,
        step: Converged<'_, D>,
    ) -> Result<(), AdvanceError>;

    /// Makes what was worked out the present positions and domains.
    fn commit(&mut self, position: &mut Vec<Vector<D>>);

    /// As [`Body::control`](crate::Body::control); where points were split, with the positions of all points.
    fn control(
        &mut self,
        position: &[Vector<D>],
        mesh: &Mesh<D>,
        control: DomainControl,
        most: (usize, Space),
    ) -> Result<(Controlled, Vec<Vector<D>>), TooManyPoints>;

    fn diagnose(&self, position: &[Vector<D>], mesh: &Mesh<D>) -> Vec<DomainReport>;

    /// No corner of a point's domain is farther away from the point `[L]`; `None` where there is no domain.
    fn radius(&self, point: usize) -> Option<f64>;

    /// See [`Basis::n_corners`].
    fn n_corners(&self) -> usize;

    /// See [`Basis::corners`].
    fn corners(
        &self,
        mesh: &Mesh<D>,
        point: usize,
        of: &CornerPoint<D>,
        to: &mut Vec<Corner<D>>,
    ) -> Result<(), OutsideMesh<D>>;

    /// See [`Basis::ring_side`].
    fn ring_side(
        &self,
        mesh: &Mesh<D>,
        point: (usize, &Vector<D>),
        side: &RingSide<D>,
        stencil: &mut Stencil<D>,
    ) -> Result<(), OutsideMesh<D>>;

    /// Corners of the domain of a point that stands at `x`.
    fn outline(&self, point: usize, x: &Vector<D>) -> Vec<Vector<D>>;

    /// Numbers of a stored domain.
    fn domain_numbers(&self) -> usize;

    /// Appends the numbers of all domains.
    fn store_domains(&self, to: &mut Vec<f64>);

    /// Makes the stored domains of `n` points the present ones; on an error nothing has changed.
    fn restore_domains(&mut self, values: &[f64], n: usize) -> Result<(), ForeignPoints>;
}

/// The domains of a body's points under a basis.
pub struct DomainsOfBody<const D: usize>(pub(super) Box<dyn BodyDomains<D>>);

impl<const D: usize> DomainsOfBody<D> {
    /// One domain for each point.
    pub fn new<B: Basis<D> + 'static>(basis: B, domains: Vec<B::Domain>) -> Self {
        Self(Box::new(DomainsOf { basis, domains, prepared: PreparedDomains::default() }))
    }
}

/// A basis and the domain of every point; zero bytes for standard MPM.
struct DomainsOf<const D: usize, B: Basis<D>> {
    basis: B,
    domains: Vec<B::Domain>,
    /// Of the next step, kept for its memory.
    prepared: PreparedDomains<D, B::Domain>,
}

impl<const D: usize, B: Basis<D>> BodyDomains<D> for DomainsOf<D, B> {
    fn basis(&self) -> &'static str {
        self.basis.name()
    }

    fn node_kind(&self, mesh: &Mesh<D>) -> NodeKind {
        self.basis.node_kind(mesh)
    }

    fn sampled_cells(
        &self,
        mesh: &Mesh<D>,
        (point, x): (usize, &Vector<D>),
        take: &mut dyn FnMut([u32; D]),
    ) -> Result<(), OutsideMesh<D>> {
        self.basis.sampled_cells(mesh, x, &self.domains[point], take)
    }

    fn domain_bytes(&self) -> usize {
        size_of::<B::Domain>()
    }

    fn stencils(
        &self,
        mesh: &Mesh<D>,
        position: &[Vector<D>],
        (space, with_masses): (Space, bool),
    ) -> Result<Stencils<D>, UnconnectedPoint<D>> {
        if space.is_axisymmetric() {
            return Stencils::of_rings(&self.basis, mesh, (position, &self.domains), with_masses);
        }
        Stencils::of(&self.basis, mesh, position, &self.domains)
    }

    fn nodes(
        &self,
        mesh: &Mesh<D>,
        position: &[Vector<D>],
        space: Space,
    ) -> Result<Stencils<D>, UnconnectedPoint<D>> {
        Stencils::of_nodes(&self.basis, mesh, (position, &self.domains), space.is_axisymmetric())
    }

    fn advance(
        &mut self,
        (position, space): (&[Vector<D>], Space),
        deformation_gradient: &[Block<D>],
        connectivity: &Connectivity<D>,
        step: Converged<'_, D>,
    ) -> Result<(), AdvanceError> {
        let columns = (position, &self.domains[..], space);
        self.prepared.advance(&self.basis, columns, deformation_gradient, connectivity, step)
    }

    fn commit(&mut self, position: &mut Vec<Vector<D>>) {
        self.prepared.swap(position, &mut self.domains);
    }

    fn control(
        &mut self,
        position: &[Vector<D>],
        mesh: &Mesh<D>,
        control: DomainControl,
        most: (usize, Space),
    ) -> Result<(Controlled, Vec<Vector<D>>), TooManyPoints> {
        domain_control::control(&self.basis, position, &mut self.domains, mesh, control, most)
    }

    fn diagnose(&self, position: &[Vector<D>], mesh: &Mesh<D>) -> Vec<DomainReport> {
        each_point(position.len(), &|p| {
            let report = self.basis.diagnose(mesh, &position[p], &self.domains[p]);
            report.unwrap_or_else(|_| DomainReport {
                corners_outside: self.outline(p, &position[p]).len(),
                ..DomainReport::default()
            })
        })
    }

    fn radius(&self, point: usize) -> Option<f64> {
        // Of the shapes that domains have, tetrahedra reach the farthest for their second moment: √(20/3) of its root.
        let spread = self.domains[point].spread()?;
        Some((20.0 / 3.0 * spread.trace()).sqrt())
    }

    fn n_corners(&self) -> usize {
        self.basis.n_corners()
    }

    fn corners(
        &self,
        mesh: &Mesh<D>,
        point: usize,
        of: &CornerPoint<D>,
        to: &mut Vec<Corner<D>>,
    ) -> Result<(), OutsideMesh<D>> {
        self.basis.corners(mesh, of, &self.domains[point], to)
    }

    fn ring_side(
        &self,
        mesh: &Mesh<D>,
        (point, x): (usize, &Vector<D>),
        side: &RingSide<D>,
        stencil: &mut Stencil<D>,
    ) -> Result<(), OutsideMesh<D>> {
        self.basis.ring_side(mesh, x, &self.domains[point], side, stencil)
    }

    fn outline(&self, point: usize, x: &Vector<D>) -> Vec<Vector<D>> {
        self.domains[point].outline(x)
    }

    fn domain_numbers(&self) -> usize {
        B::Domain::NUMBERS
    }

    fn store_domains(&self, to: &mut Vec<f64>) {
        self.domains.iter().for_each(|domain| domain.store(to));
    }

    fn restore_domains(&mut self, values: &[f64], n: usize) -> Result<(), ForeignPoints> {
        let width = B::Domain::NUMBERS;
        let restore = |p: usize| {
            B::Domain::restore(&values[p * width..(p + 1) * width])
                .map_err(|reason| ForeignPoints { column: "domain", reason: format!("point {p}: {reason}") })
        };
        self.domains = (0..n).map(restore).collect::<Result<_, _>>()?;
        Ok(())
    }
}

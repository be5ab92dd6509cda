//! The domains of a body of revolution that turns: those of its section.

use crate::body::advance::{AdvanceError, Converged};
use crate::body::body_domains::BodyDomains;
use crate::body::domain_control::{Controlled, TooManyPoints};
use crate::body::space::Space;
use crate::body::stored::ForeignPoints;
use mpm_basis::{
    Connectivity, Corner, CornerPoint, DomainControl, DomainReport, RingSide, Stencil, Stencils,
    UnconnectedPoint, outside_of_layer,
};
use mpm_grid::{Block, Mesh, NodeKind, OutsideMesh, Vector, flattened, flattened_block, raised};

/// The domains of the section.
pub(crate) struct LayerDomains(pub Box<dyn BodyDomains<2>>);

fn section(position: &[Vector<3>]) -> Vec<Vector<2>> {
    position.iter().map(flattened).collect()
}

impl BodyDomains<3> for LayerDomains {
    fn basis(&self) -> &'static str {
        self.0.basis()
    }

    fn node_kind(&self, mesh: &Mesh<3>) -> NodeKind {
        self.0.node_kind(&mesh.section())
    }

    fn sampled_cells(
        &self,
        mesh: &Mesh<3>,
        (point, x): (usize, &Vector<3>),
        take: &mut dyn FnMut([u32; 3]),
    ) -> Result<(), OutsideMesh<3>> {
        let mut in_layer = |[i, j]: [u32; 2]| take([i, j, 0]);
        let found = self.0.sampled_cells(&mesh.section(), (point, &flattened(x)), &mut in_layer);
        found.map_err(|it| outside_of_layer(&it))
    }

    fn domain_bytes(&self) -> usize {
        self.0.domain_bytes()
    }

    fn stencils(
        &self,
        mesh: &Mesh<3>,
        position: &[Vector<3>],
        of: (Space, bool),
    ) -> Result<Stencils<3>, UnconnectedPoint<3>> {
        let stencils = self.0.stencils(&mesh.section(), &section(position), of);
        stencils.map(Stencils::in_layer).map_err(|it| it.in_layer())
    }

    fn nodes(
        &self,
        mesh: &Mesh<3>,
        position: &[Vector<3>],
        space: Space,
    ) -> Result<Stencils<3>, UnconnectedPoint<3>> {
        let nodes = self.0.nodes(&mesh.section(), &section(position), space);
        nodes.map(Stencils::in_layer).map_err(|it| it.in_layer())
    }

    fn advance(
        &mut self,
        (position, space): (&[Vector<3>], Space),
        deformation_gradient: &[Block<3>],
        connectivity: &Connectivity<3>,
        step: Converged<'_, 3>,
    ) -> Result<(), AdvanceError> {
        let mesh = step.mesh.section();
        let nodes =
            step.active.space().section(&mesh).expect("the section of a layer has the nodes of the layer");
        let (active, increment) = (step.active.section(nodes), section(step.increment));
        let deformation_gradient: Vec<Block<2>> = deformation_gradient.iter().map(flattened_block).collect();
        let in_plane = Converged { mesh: &mesh, active: &active, increment: &increment, own: step.own };
        let of = (&section(position)[..], space);
        self.0.advance(of, &deformation_gradient, &connectivity.section(), in_plane)
    }

    fn commit(&mut self, position: &mut Vec<Vector<3>>) {
        let mut of_section = section(position);
        self.0.commit(&mut of_section);
        position.clear();
        position.extend(of_section.iter().map(raised));
    }

    fn control(
        &mut self,
        position: &[Vector<3>],
        mesh: &Mesh<3>,
        control: DomainControl,
        most: (usize, Space),
    ) -> Result<(Controlled, Vec<Vector<3>>), TooManyPoints> {
        let (done, of_section) = self.0.control(&section(position), &mesh.section(), control, most)?;
        Ok((done, of_section.iter().map(raised).collect()))
    }

    fn diagnose(&self, position: &[Vector<3>], mesh: &Mesh<3>) -> Vec<DomainReport> {
        self.0.diagnose(&section(position), &mesh.section())
    }

    fn radius(&self, point: usize) -> Option<f64> {
        self.0.radius(point)
    }

    fn n_corners(&self) -> usize {
        self.0.n_corners()
    }

    fn corners(
        &self,
        mesh: &Mesh<3>,
        point: usize,
        of: &CornerPoint<3>,
        to: &mut Vec<Corner<3>>,
    ) -> Result<(), OutsideMesh<3>> {
        let mut corners = Vec::new();
        let found = self.0.corners(&mesh.section(), point, &of.section(), &mut corners);
        found.map_err(|it| outside_of_layer(&it))?;
        to.extend(corners.iter().map(Corner::in_layer));
        Ok(())
    }

    fn ring_side(
        &self,
        mesh: &Mesh<3>,
        (point, x): (usize, &Vector<3>),
        side: &RingSide<3>,
        stencil: &mut Stencil<3>,
    ) -> Result<(), OutsideMesh<3>> {
        let mut in_plane = Stencil::new();
        let side = RingSide { ends: side.ends.map(|end| flattened(&end)), parts: side.parts };
        let found = self.0.ring_side(&mesh.section(), (point, &flattened(x)), &side, &mut in_plane);
        found.map_err(|it| outside_of_layer(&it))?;
        in_plane.add_to_layer(stencil);
        Ok(())
    }

    fn outline(&self, point: usize, x: &Vector<3>) -> Vec<Vector<3>> {
        self.0.outline(point, &flattened(x)).iter().map(raised).collect()
    }

    fn domain_numbers(&self) -> usize {
        self.0.domain_numbers()
    }

    fn store_domains(&self, to: &mut Vec<f64>) {
        self.0.store_domains(to);
    }

    fn restore_domains(&mut self, values: &[f64], n: usize) -> Result<(), ForeignPoints> {
        self.0.restore_domains(values, n)
    }
}

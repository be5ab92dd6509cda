//! Points of one law under one basis.

use super::occupied::{OccupiedCell, occupied, sampled_cells};
use crate::body::advance::{AdvanceError, Converged, PreparedState};
use crate::body::assembly_plan::AssemblyPlan;
use crate::body::body_domains::{BodyDomains, DomainsOfBody};
use crate::body::body_law::BodyLaw;
use crate::body::dilatation::{Dilatation, MeanDilatation};
use crate::body::domain_control::{Controlled, TooManyPoints};
use crate::body::interface::{Body, BodyLoads, PointExtent, PointForce};
use crate::body::law_of_body::LawOfBody;
use crate::body::nodal_sums::add_by_node;
use crate::body::point_view::PointView;
use crate::body::points::Points;
use crate::body::regularised::FieldPoint;
use crate::body::scatter::{PassInput, Sums};
use crate::body::space::Space;
use crate::body::start::{PointStart, RefusedStart};
use crate::body::stored::{ForeignPoints, StoredPoints, Widths};
use crate::body::trial::InadmissiblePoint;
use mpm_basis::{
    ActiveNodes, Basis, Connectivity, Corner, CornerPoint, DomainControl, DomainReport, Seed, Stencils,
    UnconnectedPoint,
};
use mpm_grid::{Mesh, NodeKind, OutsideMesh, Vector};
use mpm_linear::Symmetry;
use mpm_material::{FieldInfo, Material, Regularisation, SymmetricTensor};
use std::any::Any;

/// The one kind of [`Body`] there is.
///
/// What a law does is compiled once for each law, what a basis does once for each: a pass reads points and links only.
pub struct MaterialBody<const D: usize> {
    pub(super) points: Points<D>,
    pub(super) law: Box<dyn BodyLaw<D>>,
    pub(super) domains: Box<dyn BodyDomains<D>>,
    /// The next step's columns, kept for their memory.
    prepared: PreparedState<D>,
    is_prepared: bool,
    pub(super) mean_dilatation: Option<MeanDilatation>,
}

impl<const D: usize> MaterialBody<D> {
    /// A body of points that rest, free of stress, where their seeds are.
    pub fn new<B: Basis<D> + 'static, M: Material + 'static>(
        basis: B,
        law: M,
        seeds: impl IntoIterator<Item = Seed<D, B::Domain>>,
    ) -> Self {
        let (places, domains): (Vec<_>, Vec<_>) =
            seeds.into_iter().map(|seed| ((seed.position, seed.volume), seed.domain)).unzip();
        Self::of(LawOfBody::new(law), DomainsOfBody::new(basis, domains), places)
    }

    /// As [`Self::new`], of a law and domains that may have been compiled elsewhere, in the law's space; `places` has
    /// position `[L]` and volume `[L^D]` (of a body of revolution: area of the cross section `[L²]`) of every point.
    ///
    /// # Panics
    /// A point of a body of revolution does not stand beside the axis, r > 0.
    pub fn of(
        law: LawOfBody<D>,
        DomainsOfBody(domains): DomainsOfBody<D>,
        places: impl IntoIterator<Item = (Vector<D>, f64)>,
    ) -> Self {
        let places: Vec<(Vector<D>, f64)> = places.into_iter().collect();
        let mut points = Points::at_rest(law.space(), &places, law.0.can_yield());
        drop(places);
        let mut law = law.0;
        law.begin(&mut points, &[]).expect("a point that begins free of stress is refused by no law");
        Self::of_columns(points, law, domains)
    }

    /// A body of points that have begun.
    pub(super) fn of_columns(
        points: Points<D>,
        law: Box<dyn BodyLaw<D>>,
        domains: Box<dyn BodyDomains<D>>,
    ) -> Self {
        let prepared = PreparedState::default();
        Self { law, domains, points, prepared, is_prepared: false, mean_dilatation: None }
    }

    /// The same, with the mass `density · V⁰` `[M]` in every point. A run with body forces refuses bodies without it.
    pub fn with_density(mut self, density: f64) -> Self {
        self.points.mass = self.points.reference_volume.iter().map(|volume| density * volume).collect();
        self
    }

    /// The same, with the mass `density · V⁰` `[M]` of densities that differ from point to point, one for each in order.
    pub fn with_densities(mut self, densities: &[f64]) -> Self {
        assert_eq!(densities.len(), self.points.len(), "every point has a density");
        let masses =
            self.points.reference_volume.iter().zip(densities).map(|(volume, density)| density * volume);
        self.points.mass = masses.collect();
        self
    }

    /// The same, with positions at rest, which displacements are reported from.
    pub fn with_reference_positions(mut self) -> Self {
        self.points.reference_position = self.points.position.clone();
        self
    }

    /// The same, with points that begin as `starts` say, one for each in order.
    ///
    /// # Errors
    /// The first point that has no elastic state under its stress.
    pub fn with_starts(mut self, starts: &[PointStart]) -> Result<Self, RefusedStart> {
        assert_eq!(starts.len(), self.points.len(), "every point has a start");
        self.law.begin(&mut self.points, starts)?;
        Ok(self)
    }

    /// The same, with volume changes averaged over cells where `mean` says how.
    pub fn with_mean_dilatation(self, mean: Option<MeanDilatation>) -> Self {
        Self { mean_dilatation: mean, ..self }
    }

    fn widths(&self) -> Widths {
        Widths {
            domain: self.domains.domain_numbers(),
            history: self.law.history_numbers(),
            plastic: usize::from(self.law.can_yield()),
        }
    }
}

impl<const D: usize> Body<D> for MaterialBody<D> {
    fn with_twist(self: Box<Self>) -> Option<Box<dyn Body<3>>> {
        let body = (self as Box<dyn Any>).downcast::<MaterialBody<2>>().ok()?;
        let turning =
            |body: MaterialBody<2>| -> Box<dyn Body<3>> { Box::new(MaterialBody::<2>::with_twist(body)) };
        body.points.space.is_axisymmetric().then(|| turning(*body))
    }

    fn space(&self) -> Space {
        self.points.space
    }

    fn n_points(&self) -> usize {
        self.points.len()
    }

    fn basis(&self) -> &'static str {
        self.domains.basis()
    }

    fn node_kind(&self, mesh: &Mesh<D>) -> NodeKind {
        self.domains.node_kind(mesh)
    }

    fn mean_dilatation(&self) -> Option<MeanDilatation> {
        self.mean_dilatation
    }

    fn regularisation(&self) -> Option<Regularisation> {
        self.law.regularisation()
    }

    fn band_width(&self) -> Option<f64> {
        self.law.band_width()
    }

    fn field_point(&self, point: usize) -> FieldPoint<D> {
        self.law.field_point(&self.points, point)
    }

    fn can_yield(&self) -> bool {
        self.law.can_yield()
    }

    fn symmetry(&self) -> Symmetry {
        self.law.symmetry()
    }

    fn history_fields(&self) -> Vec<FieldInfo> {
        self.law.history_fields()
    }

    fn history(&self, point: usize, to: &mut Vec<f64>) {
        self.law.show_history(point, to);
    }

    fn points_at_apex(&self) -> Option<usize> {
        self.law.has_apex().then(|| self.law.points_at_apex(&self.points))
    }

    fn young(&self) -> f64 {
        self.law.elasticity().young()
    }

    fn undrained_strength(&self, point: usize) -> Option<f64> {
        self.law.undrained_strength(point)
    }

    fn extent(&self, point: usize) -> PointExtent<D> {
        let (width, radius) = self.points.extent(point, self.domains.radius(point));
        PointExtent { position: self.points.position[point], width, radius }
    }

    fn n_corners(&self) -> usize {
        self.domains.n_corners()
    }

    fn corners(&self, mesh: &Mesh<D>, point: usize, to: &mut Vec<Corner<D>>) -> Result<(), OutsideMesh<D>> {
        let (position, deformation_gradient) =
            (self.points.position[point], self.points.deformation_gradient[point]);
        let volume = self.points.volume_ratio(point) * self.points.reference_volume[point];
        let reference_size = self.points.reference_size(point);
        let is_ring = self.points.space.is_axisymmetric();
        let of = CornerPoint { position, reference_size, volume, is_ring, deformation_gradient };
        let first = to.len();
        self.domains.corners(mesh, point, &of, to)?;
        self.turn_corners(point, &mut to[first..]);
        Ok(())
    }

    fn has_masses(&self) -> bool {
        self.points.mass.len() == self.points.len()
    }

    fn set_law(&mut self, law: LawOfBody<D>, starts: &[PointStart]) -> Result<(), RefusedStart> {
        assert!(starts.is_empty() || starts.len() == self.points.len(), "every point has a start");
        assert_eq!(law.space(), self.points.space, "the law is compiled for the space of the body");
        self.law = law.0;
        self.points.plastic = if self.law.can_yield() { vec![false; self.points.len()] } else { Vec::new() };
        self.law.begin(&mut self.points, starts)
    }

    fn has_domains(&self) -> bool {
        self.domains.domain_bytes() > 0
    }

    fn stencils(&self, mesh: &Mesh<D>) -> Result<Stencils<D>, UnconnectedPoint<D>> {
        self.domains.stencils(mesh, &self.points.position, (self.points.space, self.has_masses()))
    }

    fn nodes(&self, mesh: &Mesh<D>) -> Result<Stencils<D>, UnconnectedPoint<D>> {
        self.domains.nodes(mesh, &self.points.position, self.points.space)
    }

    fn dilatation(
        &self,
        connectivity: &Connectivity<D>,
        mesh: &Mesh<D>,
        active: &ActiveNodes<D>,
    ) -> Result<Option<Dilatation<D>>, UnconnectedPoint<D>> {
        let space = self.points.space;
        let of = |mean| Dilatation::of((mean, space), &self.points.position, connectivity, mesh, active);
        self.mean_dilatation.map(of).transpose()
    }

    fn assemble(
        &self,
        plan: &AssemblyPlan<D>,
        input: PassInput<'_, D>,
        sums: Sums<'_, D>,
    ) -> Result<f64, InadmissiblePoint> {
        self.law.assemble(&self.points, plan, input, sums)
    }

    fn dissipation(
        &self,
        plan: &AssemblyPlan<D>,
        trial: (&[Vector<D>], &[f64]),
        gradient: &mut [Vector<D>],
    ) -> Result<f64, InadmissiblePoint> {
        self.law.dissipation(&self.points, plan, trial, gradient)
    }

    fn external_force(
        &self,
        connectivity: &Connectivity<D>,
        loads: &BodyLoads<'_, D>,
        external: &mut [Vector<D>],
    ) {
        if let Some(acceleration) = loads.acceleration {
            assert!(self.has_masses(), "a body force needs the masses");
            add_by_node(connectivity, (external, Vector::zeros()), &|group, external| {
                for (k, masses) in group.masses.chunks_exact(group.nodes.len()).enumerate() {
                    let force = acceleration * self.points.mass[group.first_point + k];
                    for (&node, &part) in group.nodes.iter().zip(masses) {
                        *external.of(node as usize) += force * part;
                    }
                }
            });
        }
        if let Some(sides) = &loads.side_forces {
            self.add_side_forces(sides, external);
        }
        let mut group = 0;
        for &PointForce { point, force, arm } in loads.point_forces {
            while connectivity.group_points(group).end <= point {
                group += 1;
            }
            let view = connectivity.group(group);
            let (values, gradients) = view.point(point - view.first_point);
            let arm = self.points.deformation_gradient[point] * arm;
            for ((&node, &value), gradient) in view.nodes.iter().zip(values).zip(gradients) {
                external[node as usize] += force * (value + arm.dot(gradient));
            }
        }
    }

    fn stiffness_force(&self, connectivity: &Connectivity<D>, scale: &mut [f64]) {
        let modulus = self.law.elasticity().p_wave();
        add_by_node(connectivity, (scale, 0.0), &|group, scale| {
            for k in 0..group.points {
                let weight = modulus * self.points.reference_volume[group.first_point + k];
                self.for_strains(group, k, |node, size| *scale.of(node) += weight * size);
            }
        });
    }

    fn strain_force(&self, connectivity: &Connectivity<D>, increment: &[Vector<D>], scale: &mut [f64]) {
        let modulus = self.law.elasticity().p_wave();
        add_by_node(connectivity, (scale, 0.0), &|group, scale| {
            for k in 0..group.points {
                let p = group.first_point + k;
                let mut step = 0.0;
                self.for_strains(group, k, |node, size| step += size * increment[node].norm());
                let strain = self.points.elastic_excess[p].norm() + step;
                let weight = modulus * self.points.reference_volume[p] * strain;
                self.for_strains(group, k, |node, size| *scale.of(node) += weight * size);
            }
        });
    }

    fn occupied_cells(
        &self,
        connectivity: &Connectivity<D>,
        mesh: &Mesh<D>,
        active: &ActiveNodes<D>,
        out: &mut Vec<OccupiedCell>,
    ) -> Result<(), OutsideMesh<D>> {
        let (volume, young) = (&self.points.reference_volume[..], self.young());
        if mesh.functions() == NodeKind::Vertices {
            let points = (volume, self.points.space.coordinates::<D>());
            occupied(connectivity, mesh.lattice(), active, points, young, out);
            return Ok(());
        }
        let sampled = |point: usize, take: &mut dyn FnMut([u32; D])| {
            self.domains.sampled_cells(mesh, (point, &self.points.position[point]), take)
        };
        sampled_cells(mesh.lattice(), sampled, volume, young, out)
    }

    fn prepare(&mut self, plan: &AssemblyPlan<D>, step: Converged<'_, D>) -> Result<(), AdvanceError> {
        self.is_prepared = false;
        self.law.advance(&self.points, plan, (step.increment, step.own), &mut self.prepared)?;
        let of = (&self.points.position[..], self.points.space);
        self.domains.advance(of, self.prepared.deformation_gradient(), plan.connectivity(), step)?;
        self.is_prepared = true;
        Ok(())
    }

    fn largest_step_strain(&self) -> f64 {
        self.prepared.largest_strain()
    }

    fn commit(&mut self) {
        if std::mem::take(&mut self.is_prepared) {
            self.prepared.swap(&mut self.points);
            self.law.commit();
            self.domains.commit(&mut self.points.position);
        }
    }

    fn reset_displacements(&mut self) {
        if !self.points.reference_position.is_empty() {
            self.points.reference_position.clone_from(&self.points.position);
        }
    }

    fn control(
        &mut self,
        mesh: &Mesh<D>,
        control: DomainControl,
        most: usize,
    ) -> Result<Controlled, TooManyPoints> {
        let (mut done, position) =
            self.domains.control(&self.points.position, mesh, control, (most, self.points.space))?;
        self.by_ring(&mut done.parts, &position);
        if !done.parts.is_empty() {
            self.points = self.points.divided(&done.parts, &position);
            self.law.divide(&done.parts);
        }
        Ok(done)
    }

    fn point(&self, point: usize) -> PointView<D> {
        let points = &self.points;
        PointView {
            position: points.position[point],
            reference_position: points.reference_position.get(point).copied(),
            reference_volume: points.reference_volume[point],
            reference_size: points.reference_size(point),
            deformation_gradient: points.deformation_gradient[point],
            hoop_stretch: points.hoop_stretch.get(point).copied(),
            angle: points.angle.get(point).copied(),
            volume_ratio: points.volume_ratio(point),
            elastic_excess: points.elastic_excess[point],
            plastic: points.plastic.get(point).copied().unwrap_or(false),
        }
    }

    fn kirchhoff(&self, point: usize) -> SymmetricTensor {
        self.law.kirchhoff(&self.points, point)
    }

    fn stored_energy(&self, point: usize) -> f64 {
        self.law.stored_energy(&self.points, point)
    }

    fn diagnose(&self, mesh: &Mesh<D>) -> Vec<DomainReport> {
        self.domains.diagnose(&self.points.position, mesh)
    }

    fn outline(&self, point: usize) -> Vec<Vector<D>> {
        self.domains.outline(point, &self.points.position[point])
    }

    fn columns(&self) -> Vec<(&'static str, usize)> {
        self.points.columns(self.domains.domain_bytes(), self.law.history_bytes())
    }

    fn stored_columns(&self) -> Vec<(&'static str, usize)> {
        self.points.stored_columns(self.widths())
    }

    fn store(&self) -> StoredPoints {
        self.points.store(self.widths(), &|name, values| match name {
            "domain" => self.domains.store_domains(values),
            _ => self.law.store_history(values),
        })
    }

    fn restore(&mut self, stored: &StoredPoints) -> Result<(), ForeignPoints> {
        let points = self.points.restore(stored, self.widths())?;
        self.is_prepared = false;
        self.law.restore_history(stored.values("history"), stored.points)?;
        self.domains.restore_domains(stored.values("domain"), stored.points)?;
        self.law.commit();
        self.points = points;
        Ok(())
    }
}

//! Points of one law under one basis.

use super::occupied::{OccupiedCell, occupied};
use crate::body::advance::{AdvanceError, Converged, PreparedDomains, PreparedState};
use crate::body::assembly_plan::AssemblyPlan;
use crate::body::dilatation::{Dilatation, MeanDilatation};
use crate::body::domain_control::{self, Controlled, TooManyPoints};
use crate::body::interface::{Body, BodyLoads, PointForce};
use crate::body::kinematics::determinant;
use crate::body::point_view::PointView;
use crate::body::points::Points;
use crate::body::scatter::{PassInput, Sums};
use crate::body::stored::{self, ForeignPoints, StoredPoints};
use crate::body::trial::InadmissiblePoint;
use crate::body::{dissipation, pass};
use mpm_basis::{
    ActiveNodes, Basis, Connectivity, Domain, DomainControl, DomainReport, Seed, Stencils, UnconnectedPoint,
};
use mpm_grid::{Lattice, Mesh, NodeKind, Vector};
use mpm_linear::Symmetry;
use mpm_material::{FieldInfo, History, Material, SymmetricTensor, respond};
use nalgebra::Matrix3;
use rayon::prelude::*;

/// The one kind of [`Body`] there is: basis `B`, law `M`.
///
/// A pass is compiled for the law, not for the basis, because it reads points and links only. What the basis decides
/// are stencils, the convection of domains, and domain control.
pub struct MaterialBody<const D: usize, B: Basis<D>, M: Material> {
    basis: B,
    law: M,
    points: Points<D, M>,
    /// Domain of every point; zero bytes for standard MPM.
    domains: Vec<B::Domain>,
    /// The next step's columns, kept for their memory.
    prepared: (PreparedState<D, M>, PreparedDomains<D, B::Domain>),
    is_prepared: bool,
    mean_dilatation: Option<MeanDilatation>,
}

impl<const D: usize, B: Basis<D>, M: Material> MaterialBody<D, B, M> {
    /// A body of points that rest, free of stress, where their seeds are.
    pub fn new(basis: B, law: M, seeds: impl IntoIterator<Item = Seed<D, B::Domain>>) -> Self {
        let (mut points, mut domains) = (Points::default(), Vec::new());
        for seed in seeds {
            points.push(&law, seed.position, seed.volume);
            domains.push(seed.domain);
        }
        let prepared = (PreparedState::default(), PreparedDomains::default());
        Self { basis, law, points, domains, prepared, is_prepared: false, mean_dilatation: None }
    }

    /// The same, with the mass `density · V⁰` `[M]` in every point, which body forces need.
    pub fn with_density(mut self, density: f64) -> Self {
        self.points.mass = self.points.reference_volume.iter().map(|volume| density * volume).collect();
        self
    }

    /// The same, with positions at rest, which displacements are reported from.
    pub fn with_reference_positions(mut self) -> Self {
        self.points.reference_position = self.points.position.clone();
        self
    }

    /// The same, with volume changes averaged over cells where `mean` says how.
    pub fn with_mean_dilatation(self, mean: Option<MeanDilatation>) -> Self {
        Self { mean_dilatation: mean, ..self }
    }
}

impl<const D: usize, B: Basis<D>, M: Material> Body<D> for MaterialBody<D, B, M> {
    fn n_points(&self) -> usize {
        self.points.len()
    }

    fn basis(&self) -> &'static str {
        self.basis.name()
    }

    fn node_kind(&self) -> NodeKind {
        self.basis.node_kind()
    }

    fn averages_volume_changes(&self) -> bool {
        self.mean_dilatation.is_some()
    }

    fn can_yield(&self) -> bool {
        M::PLASTIC
    }

    fn symmetry(&self) -> Symmetry {
        if self.law.has_symmetric_tangent() { Symmetry::Symmetric } else { Symmetry::Unsymmetric }
    }

    fn history_fields(&self) -> &'static [FieldInfo] {
        M::History::FIELDS
    }

    fn history(&self, point: usize, to: &mut Vec<f64>) {
        self.points.history[point].show(to);
    }

    fn has_domains(&self) -> bool {
        size_of::<B::Domain>() > 0
    }

    fn stencils(&self, mesh: &Mesh<D>) -> Result<Stencils<D>, UnconnectedPoint<D>> {
        Stencils::of(&self.basis, mesh, &self.points.position, &self.domains)
    }

    fn dilatation(
        &self,
        connectivity: &Connectivity<D>,
        mesh: &Mesh<D>,
        active: &ActiveNodes<D>,
    ) -> Result<Option<Dilatation<D>>, UnconnectedPoint<D>> {
        let of = |mean| Dilatation::of(mean, &self.points.position, connectivity, mesh, active);
        self.mean_dilatation.map(of).transpose()
    }

    fn assemble(
        &self,
        plan: &AssemblyPlan<D>,
        input: PassInput<'_, D>,
        sums: Sums<'_, D>,
    ) -> Result<f64, InadmissiblePoint> {
        pass::assemble(&self.law, &self.points, plan, input, sums)
    }

    fn dissipation(
        &self,
        plan: &AssemblyPlan<D>,
        increment: &[Vector<D>],
        gradient: &mut [Vector<D>],
    ) -> Result<f64, InadmissiblePoint> {
        dissipation::dissipation(&self.law, &self.points, plan, increment, gradient)
    }

    fn external_force(
        &self,
        connectivity: &Connectivity<D>,
        loads: &BodyLoads<'_, D>,
        external: &mut [Vector<D>],
    ) {
        if let Some(acceleration) = loads.acceleration {
            assert_eq!(self.points.mass.len(), self.points.len(), "a body force needs the masses");
            for group in (0..connectivity.n_groups()).map(|group| connectivity.group(group)) {
                for k in 0..group.points {
                    let force = acceleration * self.points.mass[group.first_point + k];
                    for (&node, &value) in group.nodes.iter().zip(group.point(k).0) {
                        external[node as usize] += force * value;
                    }
                }
            }
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
        for group in (0..connectivity.n_groups()).map(|group| connectivity.group(group)) {
            for k in 0..group.points {
                let weight = modulus * self.points.reference_volume[group.first_point + k];
                for (&node, gradient) in group.nodes.iter().zip(group.point(k).1) {
                    scale[node as usize] += weight * gradient.norm();
                }
            }
        }
    }

    fn strain_force(&self, connectivity: &Connectivity<D>, increment: &[Vector<D>], scale: &mut [f64]) {
        let modulus = self.law.elasticity().p_wave();
        for group in (0..connectivity.n_groups()).map(|group| connectivity.group(group)) {
            for k in 0..group.points {
                let (p, gradients) = (group.first_point + k, group.point(k).1);
                let nodes = || group.nodes.iter().zip(gradients);
                let step: f64 = nodes().map(|(&node, it)| it.norm() * increment[node as usize].norm()).sum();
                let strain = self.points.elastic_excess[p].norm() + step;
                let weight = modulus * self.points.reference_volume[p] * strain;
                for (&node, gradient) in nodes() {
                    scale[node as usize] += weight * gradient.norm();
                }
            }
        }
    }

    fn occupied_cells(
        &self,
        connectivity: &Connectivity<D>,
        lattice: &Lattice<D>,
        active: &ActiveNodes<D>,
        out: &mut Vec<OccupiedCell>,
    ) {
        let young = self.law.elasticity().young();
        occupied(connectivity, lattice, active, &self.points.reference_volume, young, out);
    }

    fn prepare(&mut self, plan: &AssemblyPlan<D>, step: Converged<'_, D>) -> Result<(), AdvanceError> {
        self.is_prepared = false;
        let (state, domains) = &mut self.prepared;
        state.advance(&self.law, &self.points, plan, step.increment)?;
        let columns = (&self.points.position[..], &self.domains[..]);
        domains.advance(&self.basis, columns, state.deformation_gradient(), plan.connectivity(), step)?;
        self.is_prepared = true;
        Ok(())
    }

    fn commit(&mut self) {
        if std::mem::take(&mut self.is_prepared) {
            let (state, domains) = &mut self.prepared;
            state.swap(&mut self.points);
            domains.swap(&mut self.points.position, &mut self.domains);
        }
    }

    fn control(
        &mut self,
        mesh: &Mesh<D>,
        control: DomainControl,
        most: usize,
    ) -> Result<Controlled, TooManyPoints> {
        domain_control::control(&self.basis, &mut self.points, &mut self.domains, mesh, control, most)
    }

    fn point(&self, point: usize) -> PointView<D> {
        let points = &self.points;
        let elastic_excess = points.elastic_excess[point];
        PointView {
            position: points.position[point],
            reference_position: points.reference_position.get(point).copied(),
            reference_volume: points.reference_volume[point],
            deformation_gradient: points.deformation_gradient[point],
            volume_ratio: determinant(&points.deformation_gradient[point]),
            elastic_excess,
            // The committed elastic state is admissible, so the law answers elastically.
            kirchhoff: respond(&self.law, &elastic_excess, &points.history[point])
                .map_or(SymmetricTensor::from_matrix(&Matrix3::repeat(f64::NAN)), |it| it.kirchhoff),
            plastic: points.plastic.get(point).copied().unwrap_or(false),
        }
    }

    fn diagnose(&self, mesh: &Mesh<D>) -> Vec<DomainReport> {
        let points = &self.points;
        (0..points.len())
            .into_par_iter()
            .map(|p| {
                let report = self.basis.diagnose(mesh, &points.position[p], &self.domains[p]);
                report.unwrap_or_else(|_| DomainReport {
                    corners_outside: self.outline(p).len(),
                    ..DomainReport::default()
                })
            })
            .collect()
    }

    fn outline(&self, point: usize) -> Vec<Vector<D>> {
        self.domains[point].outline(&self.points.position[point])
    }

    fn columns(&self) -> [(&'static str, usize); 9] {
        let points = &self.points;
        [
            ("position", size_of_val(&points.position[..])),
            ("position at rest", size_of_val(&points.reference_position[..])),
            ("volume at rest", size_of_val(&points.reference_volume[..])),
            ("mass", size_of_val(&points.mass[..])),
            ("domain", size_of_val(&self.domains[..])),
            ("deformation gradient", size_of_val(&points.deformation_gradient[..])),
            ("elastic state", size_of_val(&points.elastic_excess[..])),
            ("history of the law", size_of_val(&points.history[..])),
            ("plastic state", size_of_val(&points.plastic[..])),
        ]
    }

    fn stored_columns(&self) -> Vec<(&'static str, usize)> {
        self.points.stored_columns(B::Domain::NUMBERS)
    }

    fn store(&self) -> StoredPoints {
        self.points.store(&self.domains)
    }

    fn restore(&mut self, stored: &StoredPoints) -> Result<(), ForeignPoints> {
        let points = self.points.restore(stored, B::Domain::NUMBERS)?;
        self.domains = stored::restore_domains(stored)?;
        self.points = points;
        Ok(())
    }
}

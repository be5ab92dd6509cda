//! What bodies of revolution have besides.

use crate::body::body_domains::DomainsOfBody;
use crate::body::interface::{SideForce, SideForces};
use crate::body::kinematics::inverse_and_determinant;
use crate::body::law_of_body::LawOfBody;
use crate::body::layer_domains::LayerDomains;
use crate::body::material_body::MaterialBody;
use crate::body::space::Space;
use mpm_basis::{Basis, Corner, Group, RingSide, Seed, Stencil};
use mpm_grid::Vector;
use mpm_material::Material;

impl MaterialBody<2> {
    /// As [`Self::new`], of a body of revolution: positions are (r, z), and volumes of seeds the areas of their cross
    /// section `[L²]`.
    ///
    /// # Panics
    /// A point does not stand beside the axis, r > 0.
    pub fn axisymmetric<B: Basis<2> + 'static, M: Material + 'static>(
        basis: B,
        law: M,
        seeds: impl IntoIterator<Item = Seed<2, B::Domain>>,
    ) -> Self {
        let (places, domains): (Vec<_>, Vec<_>) =
            seeds.into_iter().map(|seed| ((seed.position, seed.volume), seed.domain)).unzip();
        Self::of(LawOfBody::axisymmetric(law), DomainsOfBody::new(basis, domains), places)
    }

    /// The same body of revolution, of points that may turn about the axis: see [`Space::Axisymmetric`].
    ///
    /// # Panics
    /// It is no body of revolution.
    pub fn with_twist(self) -> MaterialBody<3> {
        assert!(self.points.space.is_axisymmetric(), "only bodies of revolution turn about their axis");
        let domains = Box::new(LayerDomains(self.domains));
        let body = MaterialBody::of_columns(self.points.with_twist(), self.law.with_twist(), domains);
        body.with_mean_dilatation(self.mean_dilatation)
    }
}

impl<const D: usize> MaterialBody<D> {
    /// Gives the corners of a point that turns about the axis their angles, as third coordinates: with the gradient of the
    /// angle `F_θJ / r` with respect to positions at rest.
    pub(super) fn turn_corners(&self, point: usize, corners: &mut [Corner<D>]) {
        let Some(&angle) = self.points.angle.get(point) else { return };
        let (x, f) = (&self.points.position[point], &self.points.deformation_gradient[point]);
        let row = inverse_and_determinant(f).0.row(D - 1).transpose();
        let by_place = row * (-f[(D - 1, D - 1)] / x[0]);
        for corner in corners {
            corner.position[D - 1] = angle + by_place.dot(&(corner.position - x));
        }
    }

    /// The same cut of shares of an area as one of shares of the volume of a ring, where the body is one: a part has
    /// its area times its radius.
    pub(super) fn by_ring(&self, parts: &mut [(usize, f64)], position: &[Vector<D>]) {
        if self.points.space.is_axisymmetric() {
            for ((point, share), x) in parts.iter_mut().zip(position) {
                *share *= x[0] / self.points.position[*point][0];
            }
        }
    }

    /// Hands out the strain by which a displacement of one of each node can change the `k`-th point of a group, `|∇S_vp|`,
    /// and that of the hoop where there is one.
    pub(super) fn for_strains(&self, group: &Group<'_, D>, k: usize, mut take: impl FnMut(usize, f64)) {
        let (values, gradients) = group.point(k);
        let per_radius = match self.points.space {
            Space::Cartesian => 0.0,
            Space::Axisymmetric => 1.0 / self.points.position[group.first_point + k][0],
        };
        for ((&node, gradient), value) in group.nodes.iter().zip(gradients).zip(values) {
            let hoop = if per_radius == 0.0 { 0.0 } else { value.abs() * per_radius };
            take(node as usize, gradient.norm() + hoop);
        }
    }

    /// Adds forces on sides of rings to `external`.
    pub(super) fn add_side_forces(&self, on: &SideForces<'_, D>, external: &mut [Vector<D>]) {
        let mut stencil = Stencil::new();
        for SideForce { point, force, arms, parts } in on.forces {
            let x = &self.points.position[*point];
            let ends = arms.map(|arm| x + self.points.deformation_gradient[*point] * arm);
            stencil.clear();
            self.domains
                .ring_side(on.mesh, (*point, x), &RingSide { ends, parts: *parts }, &mut stencil)
                .expect("the stencils of the step have found these corners in the mesh");
            for it in stencil.entries() {
                // A node that is not active carries next to nothing.
                if let Some(node) = on.active.number(it.node) {
                    external[node] += force * it.value;
                }
            }
        }
    }
}

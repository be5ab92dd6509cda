//! The check that every basis must pass: constant and linear fields are reproduced.

use crate::basis::Basis;
use crate::influence::Stencil;
use mpm_grid::{Block, Mesh, NodeSpace, OutsideMesh, Vector};
use std::fmt;

/// How far the influences of a point are from reproducing constant and linear fields, each error over the
/// magnitude of the terms that cancel in it `[-]`: a few units of rounding for a complete basis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Completeness {
    /// `|Σ S_vp - 1|`.
    pub unity: f64,
    /// `|Σ ∇S_vp|`.
    pub gradient_sum: f64,
    /// `|Σ S_vp x_v - x_p|`.
    pub position: f64,
    /// `|Σ x_v ⊗ ∇S_vp - I|`.
    pub linear_gradient: f64,
}

impl Completeness {
    /// The errors of the point at `x` `[L]` with `domain`.
    ///
    /// # Errors
    /// The point, or a part of its domain, lies outside the mesh.
    ///
    /// # Panics
    /// The mesh has no nodes of the basis' kind.
    pub fn of<const D: usize, B: Basis<D>>(
        basis: &B,
        mesh: &Mesh<D>,
        x: &Vector<D>,
        domain: &B::Domain,
    ) -> Result<Self, OutsideMesh<D>> {
        let nodes = NodeSpace::of(basis.node_kind(mesh), mesh).expect("the mesh has nodes of the basis' kind");
        let mut stencil = Stencil::new();
        basis.influences(mesh, x, domain, &mut stencil)?;
        stencil.finish();
        let (mut one, mut here) = (0.0, Vector::<D>::zeros());
        let (mut zero, mut identity) = (Vector::<D>::zeros(), Block::<D>::zeros());
        let (mut values, mut gradients, mut moments, mut far) = (0.0, 0.0, 0.0, 0.0_f64);
        for entry in stencil.entries() {
            let (s, g, x_v) = (entry.value, entry.gradient, nodes.position(mesh, entry.node));
            one += s;
            here += x_v * s;
            zero += g;
            identity += x_v * g.transpose();
            values += s.abs();
            gradients += g.norm();
            moments += x_v.norm() * g.norm();
            far = far.max(x_v.norm());
        }
        Ok(Self {
            unity: (one - 1.0).abs() / values,
            gradient_sum: zero.norm() / gradients,
            position: (here - x).norm() / (values * far),
            linear_gradient: (identity - Block::identity()).norm() / moments,
        })
    }

    /// Whether every error is below a limit `[-]`; never where one is not a number.
    pub fn is_within(&self, limit: f64) -> bool {
        [self.unity, self.gradient_sum, self.position, self.linear_gradient].iter().all(|it| *it < limit)
    }
}

impl fmt::Display for Completeness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { unity, gradient_sum, position, linear_gradient } = self;
        write!(f, "relative errors of Σ S = 1: {unity:e}, Σ ∇S = 0: {gradient_sum:e}, ")?;
        write!(f, "Σ S x = x_p: {position:e}, Σ x ⊗ ∇S = I: {linear_gradient:e}")
    }
}

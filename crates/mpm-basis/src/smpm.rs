//! Standard MPM: the point influences the nodes of its cell by the cell's own shape functions.
//!
//! `S_vp = N_v(x_p)`, `∇S_vp = ∇N_v(x_p)` (Sulsky, Chen & Schreyer 1994).

use crate::basis::{Basis, Convection, ConvectionError, Seed};
use crate::corner::{Carriers, Corner, CornerPoint};
use crate::influence::Stencil;
use crate::ring;
use crate::tensor::{inverse_transpose, signs};
use mpm_grid::{LinearCell, Mesh, NodeId, NodeKind, OutsideMesh, Vector};
use std::array::from_fn;

/// Standard MPM; a point has no domain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Smpm;

impl<const D: usize> Basis<D> for Smpm {
    type Domain = ();

    fn name(&self) -> &'static str {
        "sMPM"
    }

    fn seed(&self, piece: &LinearCell<D>, place: &mut dyn FnMut(Seed<D, ()>)) {
        place(Seed { position: piece.position(&Vector::zeros()), volume: piece.volume(), domain: () });
    }

    #[inline]
    fn influences(
        &self,
        mesh: &Mesh<D>,
        x: &Vector<D>,
        _domain: &(),
        stencil: &mut Stencil<D>,
    ) -> Result<(), OutsideMesh<D>> {
        let place = mesh.locate(x, 0.0)?;
        mesh.values_and_gradients(&place, |node, value, gradient| stencil.add(node, value, gradient));
        Ok(())
    }

    fn convect(
        &self,
        _domain: &mut (),
        position: &mut Vector<D>,
        step: &Convection<'_, D>,
    ) -> Result<(), ConvectionError> {
        *position += step.displacement;
        Ok(())
    }

    fn n_corners(&self) -> usize {
        1 << D
    }

    fn corners(
        &self,
        mesh: &Mesh<D>,
        point: &CornerPoint<D>,
        _domain: &(),
        to: &mut Vec<Corner<D>>,
    ) -> Result<(), OutsideMesh<D>> {
        corners(mesh, point, to)
    }
}

/// The corners of a point without a domain: those of the parallelepiped `½ (V_p⁰)^(1/D) F` (of a ring with the area of its
/// cross section for the volume), which are carried by the point's own cell, `W_cv = S_vp + ∇S_vp · (x_c - x_p)`. On splines
/// it has none: a point alone says nothing of what is around it there.
///
/// # Errors
/// The point lies outside the mesh.
fn corners<const D: usize>(
    mesh: &Mesh<D>,
    point: &CornerPoint<D>,
    to: &mut Vec<Corner<D>>,
) -> Result<(), OutsideMesh<D>> {
    if mesh.functions() != NodeKind::Vertices {
        return Ok(());
    }
    let CornerPoint { position, reference_size, volume, deformation_gradient, is_ring } = point;
    let sides = deformation_gradient * (0.5 * reference_size.powf(1.0 / D as f64));
    let weight = 1.0 / f64::from(1 << D);
    let push = inverse_transpose(&sides) * (volume * weight);
    let ring = is_ring.then(|| ring::quadrilateral(from_fn(|c| (position + sides * signs(c), weight))));
    let place = mesh.locate(position, 0.0)?;
    for c in 0..1 << D {
        let s = signs::<D>(c);
        let arm = sides * s;
        let mut nodes = [(NodeId::from_index(0).expect("0 is a number"), 0.0); 8];
        let mut at = 0;
        mesh.values_and_gradients(&place, |node, value, gradient| {
            nodes[at] = (node, value + gradient.dot(&arm));
            at += 1;
        });
        let (area, share) = match &ring {
            None => (push * s, weight),
            Some(ring) => (ring::area(point, &ring[c].sample), ring[c].mass),
        };
        to.push(Corner { position: position + arm, area, share, carriers: Carriers::Vertices(nodes) });
    }
    Ok(())
}

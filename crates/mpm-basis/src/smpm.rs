//! Standard MPM: the point influences the nodes of its cell by the cell's own shape functions.
//!
//! `S_vp = N_v(x_p)`, `∇S_vp = ∇N_v(x_p)` (Sulsky, Chen & Schreyer 1994).

use crate::basis::{Basis, Convection, ConvectionError, Seed};
use crate::corner::{self, Corner, CornerPoint};
use crate::influence::Stencil;
use mpm_grid::{LinearCell, Mesh, OutsideMesh, Vector};

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
        corner::of_point(mesh, point, to)
    }
}

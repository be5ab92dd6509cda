//! CPDI2 in space with tetrahedra whose corners move with the displacement field; the formulas are in
//! [`crate::Simplex`].

use crate::basis::{Basis, Convection, ConvectionError, DomainPart, DomainReport, Seed};
use crate::corner::{Corner, CornerPoint};
use crate::influence::Stencil;
use crate::simplex::Simplex;
use mpm_grid::{Block, LinearCell, Mesh, OutsideMesh, Vector};

/// Second-order convected particle domain interpolation with tetrahedra, D = 3 (Leavy et al. 2019).
///
/// Every piece is cut into six tetrahedra around its diagonal from the lowest to the highest corner
/// (Kuhn 1960). Every face is so cut from its lowest to its highest corner in the order of the
/// lattice, the same from both sides: the tetrahedra of a body share their faces. Their volumes add
/// up to the body's exactly where its outer faces are plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cpdi2Tetrahedron;

/// The two corners between the lowest and the highest, in an order that keeps the hand of the piece.
const PATHS: [[usize; 2]; 6] = [[1, 3], [2, 6], [4, 5], [3, 2], [6, 4], [5, 1]];

impl Basis<3> for Cpdi2Tetrahedron {
    type Domain = Simplex<3>;

    fn name(&self) -> &'static str {
        "CPDI2-tetrahedron"
    }

    fn seed(&self, piece: &LinearCell<3>, place: &mut dyn FnMut(Seed<3, Simplex<3>>)) {
        let x = piece.corners();
        for [a, b] in PATHS {
            place(Simplex::at_rest(x[0], [x[a], x[b], x[7]]).into_seed());
        }
    }

    fn influences(
        &self,
        mesh: &Mesh<3>,
        _x: &Vector<3>,
        domain: &Simplex<3>,
        stencil: &mut Stencil<3>,
    ) -> Result<(), OutsideMesh<3>> {
        domain.influences(mesh, stencil)
    }

    fn convect(
        &self,
        domain: &mut Simplex<3>,
        position: &mut Vector<3>,
        step: &Convection<'_, 3>,
    ) -> Result<(), ConvectionError> {
        domain.convect(position, step)
    }

    fn halve(
        &self,
        domain: &Simplex<3>,
        _x: &Vector<3>,
        to_cells: &Block<3>,
    ) -> Option<[DomainPart<3, Simplex<3>>; 2]> {
        domain.halve(to_cells)
    }

    fn sampled_cells(
        &self,
        mesh: &Mesh<3>,
        x: &Vector<3>,
        domain: &Self::Domain,
        take: &mut dyn FnMut([u32; 3]),
    ) -> Result<(), OutsideMesh<3>> {
        domain.sampled_cells(mesh, x, take)
    }

    fn n_corners(&self) -> usize {
        4
    }

    fn corners(
        &self,
        mesh: &Mesh<3>,
        point: &CornerPoint<3>,
        domain: &Simplex<3>,
        to: &mut Vec<Corner<3>>,
    ) -> Result<(), OutsideMesh<3>> {
        domain.domain_corners(mesh, point, to)
    }

    fn diagnose(
        &self,
        mesh: &Mesh<3>,
        _x: &Vector<3>,
        domain: &Simplex<3>,
    ) -> Result<DomainReport, OutsideMesh<3>> {
        domain.diagnose(mesh)
    }
}

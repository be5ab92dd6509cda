//! CPDI2t: triangles whose corners move with the displacement field; the formulas are in
//! [`crate::Simplex`].
//!
//! Where a node has a single corner c of a triangle among its nodes, `∇S_vp = N_v(x_c) g_c`: its
//! direction is the normal of the far edge wherever the node lies, and its size grows without bound
//! as the triangle turns into a sliver (Wang et al. 2019). [`crate::DomainReport`] counts such nodes,
//! [`crate::Fallback`] replaces slivers.

use crate::basis::{Basis, Convection, ConvectionError, DomainPart, DomainReport, RingSide, Seed};
use crate::corner::{Corner, CornerPoint};
use crate::domain::Domain;
use crate::influence::Stencil;
use crate::ring;
use crate::simplex::Simplex;
use mpm_grid::{Block, LinearCell, Mesh, OutsideMesh, Vector};

/// Second-order convected particle domain interpolation with triangles, D = 2.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cpdi2t {
    /// How a cell is cut into triangles.
    pub split: TriangleSplit,
}

/// How a cell of n × n points is cut into triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TriangleSplit {
    /// n² sub-quadrilaterals, each cut from its lower left to its upper right corner in the order of
    /// the lattice ("/"): 2 n² triangles.
    Slash,
    /// n² sub-quadrilaterals, each cut from its lower right to its upper left corner ("\"): 2 n²
    /// triangles.
    Backslash,
    /// (n/2)² sub-quadrilaterals, each cut by both diagonals through its local centre: n² triangles;
    /// n is even.
    #[default]
    Cross,
}

impl Basis<2> for Cpdi2t {
    type Domain = Simplex<2>;

    fn name(&self) -> &'static str {
        "CPDI2t"
    }

    fn pieces_per_cell(&self, points_per_cell: u32) -> Result<u32, &'static str> {
        match self.split {
            TriangleSplit::Slash | TriangleSplit::Backslash => Ok(points_per_cell),
            TriangleSplit::Cross if points_per_cell.is_multiple_of(2) => Ok(points_per_cell / 2),
            TriangleSplit::Cross => Err("CPDI2t with crossed diagonals cuts every sub-square of 2 x 2 points \
                                         into four triangles: the number of points per direction must be even"),
        }
    }

    fn seed(&self, piece: &LinearCell<2>, place: &mut dyn FnMut(Seed<2, Simplex<2>>)) {
        let [a, b, c, d, ..] = *piece.corners();
        let mut triangle = |first, others| place(Simplex::at_rest(first, others).into_seed());
        match self.split {
            TriangleSplit::Slash => {
                triangle(a, [b, d]);
                triangle(a, [d, c]);
            }
            TriangleSplit::Backslash => {
                triangle(a, [b, c]);
                triangle(b, [d, c]);
            }
            TriangleSplit::Cross => {
                let apex = piece.position(&Vector::zeros());
                for side in [[a, b], [b, d], [d, c], [c, a]] {
                    triangle(apex, side);
                }
            }
        }
    }

    fn influences(
        &self,
        mesh: &Mesh<2>,
        _x: &Vector<2>,
        domain: &Simplex<2>,
        stencil: &mut Stencil<2>,
    ) -> Result<(), OutsideMesh<2>> {
        domain.influences(mesh, stencil)
    }

    fn ring_influences(
        &self,
        mesh: &Mesh<2>,
        _x: &Vector<2>,
        domain: &Simplex<2>,
        stencil: &mut Stencil<2>,
    ) -> Result<(), OutsideMesh<2>> {
        ring::influences(mesh, &domain.ring(), stencil)
    }

    fn ring_masses(
        &self,
        mesh: &Mesh<2>,
        _x: &Vector<2>,
        domain: &Simplex<2>,
        stencil: &mut Stencil<2>,
    ) -> Result<(), OutsideMesh<2>> {
        ring::masses(mesh, &domain.ring(), stencil)
    }

    fn ring_side(
        &self,
        mesh: &Mesh<2>,
        x: &Vector<2>,
        domain: &Simplex<2>,
        side: &RingSide<2>,
        stencil: &mut Stencil<2>,
    ) -> Result<(), OutsideMesh<2>> {
        ring::side(mesh, &domain.outline(x), side, stencil)
    }

    fn convect(
        &self,
        domain: &mut Simplex<2>,
        position: &mut Vector<2>,
        step: &Convection<'_, 2>,
    ) -> Result<(), ConvectionError> {
        domain.convect(position, step)
    }

    fn halve(
        &self,
        domain: &Simplex<2>,
        _x: &Vector<2>,
        to_cells: &Block<2>,
    ) -> Option<[DomainPart<2, Simplex<2>>; 2]> {
        domain.halve(to_cells)
    }

    fn sampled_cells(
        &self,
        mesh: &Mesh<2>,
        x: &Vector<2>,
        domain: &Self::Domain,
        take: &mut dyn FnMut([u32; 2]),
    ) -> Result<(), OutsideMesh<2>> {
        domain.sampled_cells(mesh, x, take)
    }

    fn n_corners(&self) -> usize {
        3
    }

    fn corners(
        &self,
        mesh: &Mesh<2>,
        point: &CornerPoint<2>,
        domain: &Simplex<2>,
        to: &mut Vec<Corner<2>>,
    ) -> Result<(), OutsideMesh<2>> {
        if point.is_ring {
            return ring::corners(mesh, point, &domain.ring(), to);
        }
        domain.domain_corners(mesh, point, to)
    }

    fn diagnose(
        &self,
        mesh: &Mesh<2>,
        _x: &Vector<2>,
        domain: &Simplex<2>,
    ) -> Result<DomainReport, OutsideMesh<2>> {
        domain.diagnose(mesh)
    }
}

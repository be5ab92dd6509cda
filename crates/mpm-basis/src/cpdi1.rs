//! CPDI1: a parallelogram or parallelepiped that deforms with the point's F.
//!
//! Half-vectors `r_d = F r⁰_d`, corners `x_p ± r_1 ± r_2 (± r_3)`, `S_vp = 2⁻ᴰ Σ_c N_v(x_c)` and
//! `g_c = 2⁻ᴰ R⁻ᵀ s_c` with `R = (r_1 … r_D)` and the signs `s_c` of the corner (Sadeghirad, Brannon &
//! Burghardt 2011; in the plane the polygon formula). Lattices of either hand give the same.

use crate::basis::{Basis, Convection, ConvectionError, DomainPart, DomainReport, RingSide, Seed};
use crate::corner::{Corner, CornerPoint};
use crate::domain::{Domain, block};
use crate::domain_control::longest;
use crate::influence::Stencil;
use crate::ring::{self, RingSample};
use crate::sampled::{self, Sample};
use crate::tensor::{determinant, inverse_transpose, outline, signs};
use mpm_grid::{Block, LinearCell, Mesh, OutsideMesh, Vector};
use std::array::from_fn;

/// Convected particle domain interpolation with parallelograms (D = 2) or parallelepipeds (D = 3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cpdi1;

/// Half-vectors of a parallelepiped centred at the point, one a column `[L]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parallelepiped<const D: usize> {
    /// At rest, `r⁰_d`.
    pub initial: Block<D>,
    /// Now, `r_d`.
    pub current: Block<D>,
}

impl<const D: usize> Parallelepiped<D> {
    /// A domain at rest; the columns of `half_vectors` are `r⁰_d` `[L]`.
    pub fn at_rest(half_vectors: Block<D>) -> Self {
        Self { initial: half_vectors, current: half_vectors }
    }

    /// `r_d = F r⁰_d`.
    ///
    /// # Errors
    /// The volume, where it is not positive (relative to the hand at rest).
    pub(crate) fn deform(&mut self, f: &Block<D>) -> Result<(), ConvectionError> {
        let current = f * self.initial;
        let volume = |r: &Block<D>| determinant(r) * f64::from(1 << D);
        sampled::sound(volume(&current), volume(&self.initial))?;
        self.current = current;
        Ok(())
    }

    /// The first 2^D entries are the corners, lexicographic.
    #[inline]
    fn samples(&self, x: &Vector<D>) -> [Sample<D>; 8] {
        let weight = 1.0 / f64::from(1 << D);
        let push = inverse_transpose(&self.current) * weight;
        from_fn(|c| {
            let s = if c < 1 << D { signs(c) } else { Vector::zeros() };
            Sample { position: x + self.current * s, weight, gradient: push * s }
        })
    }

    /// The corners of a ring, D = 2.
    fn ring(&self, x: &Vector<D>) -> [RingSample<D>; 4] {
        ring::quadrilateral(from_fn(|c| (x + self.current * signs(c), 0.25)))
    }
}

impl<const D: usize> Domain<D> for Parallelepiped<D> {
    const NUMBERS: usize = 2 * D * D;

    fn store(&self, to: &mut Vec<f64>) {
        to.extend(self.initial.iter().chain(self.current.iter()));
    }

    fn restore(from: &[f64]) -> Result<Self, String> {
        Ok(Self { initial: block(from), current: block(&from[D * D..]) })
    }

    fn spread(&self) -> Option<Block<D>> {
        Some(self.current * self.current.transpose())
    }

    /// `r_d` becomes `A r_d`, and `r⁰_d` what F takes there, `F⁻¹ A F r⁰_d`.
    fn scale(&mut self, _x: &Vector<D>, map: &Block<D>) {
        let scaled = map * self.current;
        let back = inverse_transpose(&self.current).transpose();
        *self = Parallelepiped { initial: self.initial * (back * scaled), current: scaled };
    }

    /// The half-vectors become Cholesky's factor of the second moment in cells, thin directions first.
    fn align(&mut self, to_cells: &Block<D>) {
        let in_cells = to_cells * self.current;
        let spread = in_cells * in_cells.transpose();
        let mut order: [usize; D] = from_fn(|d| d);
        order.sort_by(|&a, &b| spread[(a, a)].total_cmp(&spread[(b, b)]));
        let mut sides = Block::<D>::zeros();
        for (k, &row) in order.iter().enumerate() {
            for (l, &column) in order[..=k].iter().enumerate() {
                let known: f64 = (0..l).map(|m| sides[(row, m)] * sides[(column, m)]).sum();
                let rest = spread[(row, column)] - known;
                sides[(row, l)] = if l == k { rest.sqrt() } else { rest / sides[(column, l)] };
            }
        }
        // The hand stays.
        if determinant(&sides) * determinant(&in_cells) < 0.0 {
            sides.column_mut(D - 1).neg_mut();
        }
        let current = inverse_transpose(to_cells).transpose() * sides;
        let back = inverse_transpose(&self.current).transpose();
        *self = Parallelepiped { initial: self.initial * (back * current), current };
    }

    fn outline(&self, x: &Vector<D>) -> Vec<Vector<D>> {
        outline(&(0..1 << D).map(|c| x + self.current * signs(c)).collect::<Vec<_>>())
    }
}

impl<const D: usize> Basis<D> for Cpdi1 {
    type Domain = Parallelepiped<D>;

    fn name(&self) -> &'static str {
        "CPDI1"
    }

    fn seed(&self, piece: &LinearCell<D>, place: &mut dyn FnMut(Seed<D, Parallelepiped<D>>)) {
        let centre = Vector::zeros();
        place(Seed {
            position: piece.position(&centre),
            volume: piece.volume(),
            domain: Parallelepiped::at_rest(piece.jacobian(&centre)),
        });
    }

    fn influences(
        &self,
        mesh: &Mesh<D>,
        x: &Vector<D>,
        domain: &Parallelepiped<D>,
        stencil: &mut Stencil<D>,
    ) -> Result<(), OutsideMesh<D>> {
        sampled::influences(mesh, &domain.samples(x)[..1 << D], stencil)
    }

    fn ring_influences(
        &self,
        mesh: &Mesh<D>,
        x: &Vector<D>,
        domain: &Parallelepiped<D>,
        stencil: &mut Stencil<D>,
    ) -> Result<(), OutsideMesh<D>> {
        ring::influences(mesh, &domain.ring(x), stencil)
    }

    fn ring_masses(
        &self,
        mesh: &Mesh<D>,
        x: &Vector<D>,
        domain: &Parallelepiped<D>,
        stencil: &mut Stencil<D>,
    ) -> Result<(), OutsideMesh<D>> {
        ring::masses(mesh, &domain.ring(x), stencil)
    }

    fn ring_side(
        &self,
        mesh: &Mesh<D>,
        x: &Vector<D>,
        domain: &Parallelepiped<D>,
        side: &RingSide<D>,
        stencil: &mut Stencil<D>,
    ) -> Result<(), OutsideMesh<D>> {
        ring::side(mesh, &domain.outline(x), side, stencil)
    }

    fn convect(
        &self,
        domain: &mut Parallelepiped<D>,
        position: &mut Vector<D>,
        step: &Convection<'_, D>,
    ) -> Result<(), ConvectionError> {
        domain.deform(&step.deformation_gradient)?;
        *position += step.displacement;
        Ok(())
    }

    fn halve(
        &self,
        domain: &Parallelepiped<D>,
        x: &Vector<D>,
        to_cells: &Block<D>,
    ) -> Option<[DomainPart<D, Parallelepiped<D>>; 2]> {
        let d = longest(domain.current.column_iter().map(|r| r.into_owned()), to_cells);
        let mut half = *domain;
        half.current.column_mut(d).scale_mut(0.5);
        half.initial.column_mut(d).scale_mut(0.5);
        let r = half.current.column(d).into_owned();
        Some([x - r, x + r].map(|position| DomainPart { position, domain: half, share: 0.5 }))
    }

    fn sampled_cells(
        &self,
        mesh: &Mesh<D>,
        x: &Vector<D>,
        domain: &Self::Domain,
        take: &mut dyn FnMut([u32; D]),
    ) -> Result<(), OutsideMesh<D>> {
        sampled::cells(mesh, x, &domain.samples(x)[..1 << D], take)
    }

    fn n_corners(&self) -> usize {
        1 << D
    }

    fn corners(
        &self,
        mesh: &Mesh<D>,
        point: &CornerPoint<D>,
        domain: &Parallelepiped<D>,
        to: &mut Vec<Corner<D>>,
    ) -> Result<(), OutsideMesh<D>> {
        if point.is_ring {
            return ring::corners(mesh, point, &domain.ring(&point.position), to);
        }
        sampled::corners(mesh, point, &domain.samples(&point.position)[..1 << D], to)
    }

    fn diagnose(
        &self,
        mesh: &Mesh<D>,
        x: &Vector<D>,
        domain: &Parallelepiped<D>,
    ) -> Result<DomainReport, OutsideMesh<D>> {
        let measure = determinant(&domain.current) / determinant(&domain.initial);
        sampled::report(mesh, &domain.samples(x)[..1 << D], measure, 0.0)
    }
}

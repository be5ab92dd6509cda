//! The triangle or tetrahedron whose corners move with the displacement field: what CPDI2t and its
//! relative in space share.
//!
//! `w_c = 1/(D+1)`; `g_c` is the gradient of corner c's barycentric coordinate: with the edges
//! `E = (x_1 - x_0 … x_D - x_0)`, `g_1 … g_D` are the columns of `E⁻ᵀ` and `g_0 = -Σ g_c`; in the plane
//! the polygon formula. The convected corners are the affine image by the point's own
//! `ΔF = I + Σ_v Δu_v ⊗ ∇S_vp`, exactly, so that the domain's volume follows `det F`.

use crate::basis::{Convection, ConvectionError, DomainPart, DomainReport, Seed};
use crate::corner::{Corner, CornerPoint};
use crate::domain::{Domain, extent, vector};
use crate::domain_control::{longest, scale_corners};
use crate::influence::Stencil;
use crate::ring::{self, RingSample};
use crate::sampled::{self, Sample};
use crate::tensor::{determinant, inverse_transpose};
use mpm_grid::{Block, Mesh, OutsideMesh, Vector};
use std::array::from_fn;

/// Corners of a point's triangle (D = 2) or tetrahedron (D = 3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Simplex<const D: usize> {
    /// The first corner `[L]`.
    pub first: Vector<D>,
    /// The other D corners `[L]`.
    pub others: [Vector<D>; D],
    /// Signed volume at rest `[L^D]`; negative in left-handed lattices.
    pub initial_volume: f64,
}

impl<const D: usize> Simplex<D> {
    /// A domain at rest with these corners `[L]`.
    pub fn at_rest(first: Vector<D>, others: [Vector<D>; D]) -> Self {
        let mut domain = Self { first, others, initial_volume: 0.0 };
        domain.initial_volume = domain.volume();
        domain
    }

    /// Signed volume `[L^D]`.
    pub fn volume(&self) -> f64 {
        determinant(&self.edges()) / factorial::<D>()
    }

    #[inline]
    fn edges(&self) -> Block<D> {
        Block::from_columns(&self.others.map(|x| x - self.first))
    }

    fn corners(&self) -> Vec<Vector<D>> {
        std::iter::once(self.first).chain(self.others).collect()
    }

    fn centroid(&self) -> Vector<D> {
        (self.first + self.others.iter().sum::<Vector<D>>()) / (D + 1) as f64
    }

    /// A point with this domain at rest.
    pub(crate) fn into_seed(self) -> Seed<D, Self> {
        Seed { position: self.centroid(), volume: self.initial_volume.abs(), domain: self }
    }

    /// The first D + 1 entries are the corners.
    #[inline]
    fn samples(&self) -> [Sample<D>; 4] {
        let weight = 1.0 / (D + 1) as f64;
        let push = inverse_transpose(&self.edges());
        from_fn(|c| match c {
            0 => Sample { position: self.first, weight, gradient: -push.column_sum() },
            c if c <= D => {
                Sample { position: self.others[c - 1], weight, gradient: push.column(c - 1).into_owned() }
            }
            _ => Sample { position: Vector::zeros(), weight: 0.0, gradient: Vector::zeros() },
        })
    }

    /// See [`crate::Basis::influences`].
    #[inline]
    pub(crate) fn influences(&self, mesh: &Mesh<D>, stencil: &mut Stencil<D>) -> Result<(), OutsideMesh<D>> {
        sampled::influences(mesh, &self.samples()[..=D], stencil)
    }

    /// See [`crate::Basis::convect`].
    pub(crate) fn convect(
        &mut self,
        position: &mut Vector<D>,
        step: &Convection<'_, D>,
    ) -> Result<(), ConvectionError> {
        sampled::convect(std::iter::once(&mut self.first).chain(&mut self.others), step)?;
        sampled::sound(self.volume(), self.initial_volume)?;
        *position = self.centroid();
        Ok(())
    }

    /// Through the middle of the longest edge, see [`crate::Basis::halve`].
    pub(crate) fn halve(&self, to_cells: &Block<D>) -> Option<[DomainPart<D, Self>; 2]> {
        let corners = self.corners();
        let edges: Vec<[usize; 2]> = (1..=D).flat_map(|b| (0..b).map(move |a| [a, b])).collect();
        let ends = edges[longest(edges.iter().map(|&[a, b]| corners[b] - corners[a]), to_cells)];
        let middle = (corners[ends[0]] + corners[ends[1]]) * 0.5;
        Some([ends[1], ends[0]].map(|replaced| {
            let mut half = *self;
            half.initial_volume *= 0.5;
            match replaced {
                0 => half.first = middle,
                c => half.others[c - 1] = middle,
            }
            DomainPart { position: half.centroid(), domain: half, share: 0.5 }
        }))
    }

    /// Hands out the cells of its corners.
    ///
    /// # Errors
    /// As [`sampled::cells`].
    pub(crate) fn sampled_cells(
        &self,
        mesh: &Mesh<D>,
        x: &Vector<D>,
        take: &mut dyn FnMut([u32; D]),
    ) -> Result<(), OutsideMesh<D>> {
        sampled::cells(mesh, x, &self.samples()[..=D], take)
    }

    /// See [`crate::Basis::corners`].
    pub(crate) fn domain_corners(
        &self,
        mesh: &Mesh<D>,
        point: &CornerPoint<D>,
        to: &mut Vec<Corner<D>>,
    ) -> Result<(), OutsideMesh<D>> {
        sampled::corners(mesh, point, &self.samples()[..=D], to)
    }

    /// See [`crate::Basis::diagnose`].
    pub(crate) fn diagnose(&self, mesh: &Mesh<D>) -> Result<DomainReport, OutsideMesh<D>> {
        let measure = self.volume() / self.initial_volume;
        sampled::report(mesh, &self.samples()[..=D], measure, self.distortion())
    }
}

impl Simplex<2> {
    /// The corners of a ring.
    pub(crate) fn ring(&self) -> [RingSample<2>; 3] {
        let [first, second, third, _] = self.samples();
        ring::triangle([first, second, third])
    }
}

impl<const D: usize> Domain<D> for Simplex<D> {
    const NUMBERS: usize = D * (D + 1) + 1;

    fn store(&self, to: &mut Vec<f64>) {
        to.extend(self.first.iter().chain(self.others.iter().flat_map(|corner| corner.iter())));
        to.push(self.initial_volume);
    }

    fn restore(from: &[f64]) -> Result<Self, String> {
        let others = from_fn(|c| vector(&from[D * (c + 1)..]));
        Ok(Self { first: vector(from), others, initial_volume: extent(from[D * (D + 1)])? })
    }

    /// Slenderness: the length of size, `(D! V)^(1/D)`, over the smallest height `1/max|g_c|`. 1.07 for an equilateral
    /// triangle, 1.41 for half a square or a sixth of a cube, growing without bound for slivers.
    fn distortion(&self) -> f64 {
        let size = determinant(&self.edges()).abs().powf(1.0 / D as f64);
        size * self.samples()[..=D].iter().map(|it| it.gradient.norm()).fold(0.0, f64::max)
    }

    fn spread(&self) -> Option<Block<D>> {
        let centre = self.centroid();
        let corners = self.corners().into_iter().map(|x| (x - centre) * (x - centre).transpose());
        Some(corners.sum::<Block<D>>() * (3.0 / ((D + 1) * (D + 2)) as f64))
    }

    fn scale(&mut self, x: &Vector<D>, map: &Block<D>) {
        scale_corners(std::iter::once(&mut self.first).chain(&mut self.others), x, map);
        self.initial_volume *= determinant(map);
    }

    fn outline(&self, _x: &Vector<D>) -> Vec<Vector<D>> {
        self.corners()
    }
}

/// D!
fn factorial<const D: usize>() -> f64 {
    (1..=D).product::<usize>() as f64
}

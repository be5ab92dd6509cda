//! CPDI2 in space: a hexahedron whose corners move with the displacement field.
//!
//! `w_c = (1/V) ∫ M_c dV` and `g_c = (1/V) ∫ ∇M_c dV` with the trilinear corner functions M_c of the
//! hexahedron with bilinear faces (Sadeghirad, Brannon & Guilkey 2013). In local coordinates the
//! integrands `M_c det J` and `cof(J) ∂M_c/∂ξ` are polynomials of degree 3 and 2 in each direction, so
//! 2×2×2 Gauss points are exact.

use crate::basis::{Basis, Convection, ConvectionError, DomainPart, DomainReport, Seed};
use crate::corner::{Corner, CornerPoint};
use crate::domain::{Domain, extent, vector};
use crate::domain_control::{longest, scale_corners, spread_of_corners};
use crate::influence::Stencil;
use crate::sampled::{self, Sample};
use crate::tensor::{determinant, signs};
use mpm_grid::{Block, LinearCell, Mesh, OutsideMesh, Vector};
use std::array::from_fn;

/// Second-order convected particle domain interpolation with hexahedra, D = 3.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cpdi2Hexahedron;

/// Corners of a point's hexahedron.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hexahedron {
    /// Positions `[L]`, lexicographic as those of a cell.
    pub corners: [Vector<3>; 8],
    /// Signed volume at rest `[L³]`; negative in left-handed lattices.
    pub initial_volume: f64,
}

impl Hexahedron {
    /// A domain at rest with these corners `[L]`, lexicographic.
    pub fn at_rest(corners: [Vector<3>; 8]) -> Self {
        Self { corners, initial_volume: moments(&corners).volume }
    }

    /// Signed volume `[L³]`.
    pub fn volume(&self) -> f64 {
        moments(&self.corners).volume
    }
}

/// Integrals over a hexahedron.
struct Moments {
    /// `∫ dV`, signed `[L³]`.
    volume: f64,
    /// `∫ M_c dV` `[L³]`.
    value: [f64; 8],
    /// `∫ ∇M_c dV` `[L²]`.
    gradient: [Vector<3>; 8],
}

impl Moments {
    fn position(&self, corners: &[Vector<3>; 8]) -> Vector<3> {
        (0..8).map(|c| corners[c] * (self.value[c] / self.volume)).sum()
    }
}

fn moments(corners: &[Vector<3>; 8]) -> Moments {
    let cell = LinearCell::new(*corners);
    let mut moments = Moments { volume: 0.0, value: [0.0; 8], gradient: [Vector::zeros(); 8] };
    for gauss in 0..8 {
        let xi = signs::<3>(gauss) / 3.0_f64.sqrt();
        let j = cell.jacobian(&xi);
        let (a, b, c) = (j.column(0), j.column(1), j.column(2));
        // Columns of the cofactors of J; no division, so that folded domains are served too.
        let (bc, ca, ab) = (b.cross(&c), c.cross(&a), a.cross(&b));
        let determinant = a.dot(&bc);
        moments.volume += determinant;
        let (m, dm) = (LinearCell::values(&xi), LinearCell::<3>::local_gradients(&xi));
        for c in 0..8 {
            moments.value[c] += m[c] * determinant;
            moments.gradient[c] += bc * dm[c].x + ca * dm[c].y + ab * dm[c].z;
        }
    }
    moments
}

fn samples(domain: &Hexahedron) -> [Sample<3>; 8] {
    let m = moments(&domain.corners);
    from_fn(|c| Sample {
        position: domain.corners[c],
        weight: m.value[c] / m.volume,
        gradient: m.gradient[c] / m.volume,
    })
}

impl Domain<3> for Hexahedron {
    const NUMBERS: usize = 25;

    fn store(&self, to: &mut Vec<f64>) {
        to.extend(self.corners.iter().flat_map(|corner| corner.iter()));
        to.push(self.initial_volume);
    }

    fn restore(from: &[f64]) -> Result<Self, String> {
        Ok(Self { corners: from_fn(|c| vector(&from[3 * c..])), initial_volume: extent(from[24])? })
    }

    /// `1 - min_c det J(c) / (V/8)` over the corners c: 0 for parallelepipeds, 1 where a corner folds.
    fn distortion(&self) -> f64 {
        let cell = LinearCell::new(self.corners);
        let mean = self.volume() / 8.0;
        let at = |c| determinant(&cell.jacobian(&signs(c))) / mean;
        1.0 - (0..8).map(at).fold(f64::INFINITY, f64::min)
    }

    fn spread(&self) -> Option<Block<3>> {
        Some(spread_of_corners(&self.corners))
    }

    fn scale(&mut self, x: &Vector<3>, map: &Block<3>) {
        scale_corners(&mut self.corners, x, map);
        self.initial_volume *= determinant(map);
    }

    fn outline(&self, _x: &Vector<3>) -> Vec<Vector<3>> {
        self.corners.to_vec()
    }
}

impl Basis<3> for Cpdi2Hexahedron {
    type Domain = Hexahedron;

    fn name(&self) -> &'static str {
        "CPDI2-hexahedron"
    }

    fn seed(&self, piece: &LinearCell<3>, place: &mut dyn FnMut(Seed<3, Hexahedron>)) {
        let corners = *piece.corners();
        let m = moments(&corners);
        place(Seed {
            position: m.position(&corners),
            volume: m.volume.abs(),
            domain: Hexahedron { corners, initial_volume: m.volume },
        });
    }

    fn influences(
        &self,
        mesh: &Mesh<3>,
        _x: &Vector<3>,
        domain: &Hexahedron,
        stencil: &mut Stencil<3>,
    ) -> Result<(), OutsideMesh<3>> {
        sampled::influences(mesh, &samples(domain), stencil)
    }

    fn convect(
        &self,
        domain: &mut Hexahedron,
        position: &mut Vector<3>,
        step: &Convection<'_, 3>,
    ) -> Result<(), ConvectionError> {
        sampled::convect(&mut domain.corners, step)?;
        let m = moments(&domain.corners);
        sampled::sound(m.volume, domain.initial_volume)?;
        *position = m.position(&domain.corners);
        Ok(())
    }

    /// Between the middles of two opposite faces; not where a corner has folded.
    fn halve(
        &self,
        domain: &Hexahedron,
        _x: &Vector<3>,
        to_cells: &Block<3>,
    ) -> Option<[DomainPart<3, Hexahedron>; 2]> {
        let sound = domain.distortion() < 1.0;
        if !sound {
            return None;
        }
        let x = &domain.corners;
        let sides: [Vector<3>; 3] = from_fn(|d| (0..8).map(|c| x[c] * signs::<3>(c)[d]).sum());
        let d = longest(sides, to_cells);
        let volume = domain.volume();
        Some([0, 1].map(|side| {
            let corners = from_fn(|c| if c >> d & 1 == side { x[c] } else { (x[c] + x[c ^ (1 << d)]) * 0.5 });
            let m = moments(&corners);
            let share = m.volume / volume;
            let half = Hexahedron { corners, initial_volume: domain.initial_volume * share };
            DomainPart { position: m.position(&corners), domain: half, share }
        }))
    }

    fn sampled_cells(
        &self,
        mesh: &Mesh<3>,
        x: &Vector<3>,
        domain: &Self::Domain,
        take: &mut dyn FnMut([u32; 3]),
    ) -> Result<(), OutsideMesh<3>> {
        sampled::cells(mesh, x, &samples(domain), take)
    }

    fn n_corners(&self) -> usize {
        8
    }

    fn corners(
        &self,
        mesh: &Mesh<3>,
        point: &CornerPoint<3>,
        domain: &Hexahedron,
        to: &mut Vec<Corner<3>>,
    ) -> Result<(), OutsideMesh<3>> {
        sampled::corners(mesh, point, &samples(domain), to)
    }

    fn diagnose(
        &self,
        mesh: &Mesh<3>,
        _x: &Vector<3>,
        domain: &Hexahedron,
    ) -> Result<DomainReport, OutsideMesh<3>> {
        let measure = domain.volume() / domain.initial_volume;
        sampled::report(mesh, &samples(domain), measure, domain.distortion())
    }
}

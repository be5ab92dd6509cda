//! CPDI2q: a quadrilateral whose corners move with the displacement field.
//!
//! `w_c = (1/A) ∫ M_c dA` with the bilinear corner functions M_c, and
//! `g_c = (1/2A) (y_{c+1} - y_{c-1}, x_{c-1} - x_{c+1})` with the corners taken round the polygon
//! (Sadeghirad, Brannon & Guilkey 2013).
//!
//! With `x = x̄ + r_1 ξ + r_2 η + h ξη` and the hourglass vector `h = κ_1 r_1 + κ_2 r_2`,
//! `det ∂x/∂ξ = (A/4) (1 + κ_2 ξ + κ_1 η)`, hence `w_c = ¼ (1 + (s_1 κ_2 + s_2 κ_1)/3)` for the corner with
//! the signs s. The domain is convex while `|κ_1| + |κ_2| < 1`. The mean gradient does not feel κ, so
//! nothing resists its growth; past 3 a weight is negative.

use crate::basis::{Basis, Convection, ConvectionError, DomainPart, DomainReport, RingSide, Seed};
use crate::corner::{Corner, CornerPoint};
use crate::domain::{Domain, extent, vector};
use crate::domain_control::{longest, scale_corners, spread_of_corners};
use crate::influence::Stencil;
use crate::ring::{self, RingSample};
use crate::sampled::{self, Sample};
use crate::tensor::{determinant, outline, signs};
use mpm_grid::{Block, LinearCell, Mesh, OutsideMesh, Vector};
use std::array::from_fn;

/// Second-order convected particle domain interpolation with quadrilaterals, D = 2.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cpdi2q {
    /// Which shape of the domain weighs its corners.
    pub weights: CornerWeights,
}

/// Which shape of the domain weighs its corners.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CornerWeights {
    /// The current one, as published: the point sits at the area centroid.
    #[default]
    Current,
    /// The one at rest, a remedy: weights stay positive whatever the distortion, S remains linearly
    /// complete, and the point sits at `Σ_c w⁰_c x_c`, which is no longer the centroid.
    ///
    /// Weights enter S alone, that is body forces, loads on points and the points' positions. The
    /// gradient is as published: without such loads the nodal solution is the same as with current
    /// weights, and a domain that loses its area still ends in [`ConvectionError::Inverted`].
    Frozen,
}

/// Corners of a point's quadrilateral.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quadrilateral {
    /// Positions `[L]`, lexicographic as those of a cell.
    pub corners: [Vector<2>; 4],
    /// Signed area at rest `[L²]`; negative in left-handed lattices.
    pub initial_area: f64,
    /// `κ` at rest `[-]`.
    pub initial_hourglass: Vector<2>,
}

/// What the formulas need of a quadrilateral.
struct Shape {
    /// Signed area `[L²]`.
    area: f64,
    /// `κ` `[-]`; not finite where the area is zero.
    hourglass: Vector<2>,
}

impl Shape {
    #[inline]
    fn of([a, b, c, d]: &[Vector<2>; 4]) -> Self {
        let r = Block::from_columns(&[(b - a + d - c) * 0.25, (c - a + d - b) * 0.25]);
        let h = (a - b - c + d) * 0.25;
        let quarter = determinant(&r);
        let cross = |a: &Vector<2>, b: &Vector<2>| a.x * b.y - a.y * b.x;
        let (r1, r2) = (r.column(0).into_owned(), r.column(1).into_owned());
        Self { area: 4.0 * quarter, hourglass: Vector::<2>::new(cross(&h, &r2), cross(&r1, &h)) / quarter }
    }
}

/// `w_c` of the corner with signs s.
#[inline]
fn weight(corner: usize, hourglass: &Vector<2>) -> f64 {
    let s = signs::<2>(corner);
    0.25 * (1.0 + (s.x * hourglass.y + s.y * hourglass.x) / 3.0)
}

impl Quadrilateral {
    /// A domain at rest with these corners `[L]`, lexicographic.
    pub fn at_rest(corners: [Vector<2>; 4]) -> Self {
        let shape = Shape::of(&corners);
        Self { corners, initial_area: shape.area, initial_hourglass: shape.hourglass }
    }

    /// Signed area `[L²]`.
    pub fn area(&self) -> f64 {
        Shape::of(&self.corners).area
    }
}

impl Cpdi2q {
    #[inline]
    fn weights(self, domain: &Quadrilateral, shape: &Shape) -> [f64; 4] {
        match self.weights {
            CornerWeights::Current => from_fn(|c| weight(c, &shape.hourglass)),
            CornerWeights::Frozen => from_fn(|c| weight(c, &domain.initial_hourglass)),
        }
    }

    fn position(weights: &[f64; 4], corners: &[Vector<2>; 4]) -> Vector<2> {
        (0..4).map(|c| corners[c] * weights[c]).sum()
    }

    #[inline]
    fn samples(self, domain: &Quadrilateral) -> [Sample<2>; 4] {
        let shape = Shape::of(&domain.corners);
        let weights = self.weights(domain, &shape);
        // The corners after and before corner c are those across its edges.
        let neighbours = [(1, 2), (3, 0), (0, 3), (2, 1)];
        let scale = 0.5 / shape.area;
        from_fn(|c| {
            let (next, previous) = neighbours[c];
            let along = domain.corners[next] - domain.corners[previous];
            Sample {
                position: domain.corners[c],
                weight: weights[c],
                gradient: Vector::<2>::new(along.y, -along.x) * scale,
            }
        })
    }
}

impl Cpdi2q {
    /// The corners of a ring.
    fn ring(self, domain: &Quadrilateral) -> [RingSample<2>; 4] {
        let weights = self.weights(domain, &Shape::of(&domain.corners));
        ring::quadrilateral(from_fn(|c| (domain.corners[c], weights[c])))
    }
}

impl Domain<2> for Quadrilateral {
    const NUMBERS: usize = 11;

    fn store(&self, to: &mut Vec<f64>) {
        to.extend(self.corners.iter().flat_map(|corner| corner.iter()));
        to.push(self.initial_area);
        to.extend(self.initial_hourglass.iter());
    }

    fn restore(from: &[f64]) -> Result<Self, String> {
        let corners = from_fn(|c| vector(&from[2 * c..]));
        Ok(Self { corners, initial_area: extent(from[8])?, initial_hourglass: vector(&from[9..]) })
    }

    /// `|κ_1| + |κ_2|`: the same after any affine map, 0 for parallelograms, 1 where the domain is no
    /// longer convex.
    fn distortion(&self) -> f64 {
        Shape::of(&self.corners).hourglass.lp_norm(1)
    }

    fn spread(&self) -> Option<Block<2>> {
        Some(spread_of_corners(&self.corners))
    }

    fn scale(&mut self, x: &Vector<2>, map: &Block<2>) {
        scale_corners(&mut self.corners, x, map);
        self.initial_area *= determinant(map);
    }

    fn outline(&self, _x: &Vector<2>) -> Vec<Vector<2>> {
        outline(&self.corners)
    }
}

impl Basis<2> for Cpdi2q {
    type Domain = Quadrilateral;

    fn name(&self) -> &'static str {
        "CPDI2q"
    }

    fn seed(&self, piece: &LinearCell<2>, place: &mut dyn FnMut(Seed<2, Quadrilateral>)) {
        let corners = from_fn(|c| piece.corners()[c]);
        let domain = Quadrilateral::at_rest(corners);
        let weights = from_fn(|c| weight(c, &domain.initial_hourglass));
        place(Seed { position: Self::position(&weights, &corners), volume: piece.volume(), domain });
    }

    fn influences(
        &self,
        mesh: &Mesh<2>,
        _x: &Vector<2>,
        domain: &Quadrilateral,
        stencil: &mut Stencil<2>,
    ) -> Result<(), OutsideMesh<2>> {
        sampled::influences(mesh, &self.samples(domain), stencil)
    }

    fn ring_influences(
        &self,
        mesh: &Mesh<2>,
        _x: &Vector<2>,
        domain: &Quadrilateral,
        stencil: &mut Stencil<2>,
    ) -> Result<(), OutsideMesh<2>> {
        ring::influences(mesh, &self.ring(domain), stencil)
    }

    fn ring_masses(
        &self,
        mesh: &Mesh<2>,
        _x: &Vector<2>,
        domain: &Quadrilateral,
        stencil: &mut Stencil<2>,
    ) -> Result<(), OutsideMesh<2>> {
        ring::masses(mesh, &self.ring(domain), stencil)
    }

    fn ring_side(
        &self,
        mesh: &Mesh<2>,
        x: &Vector<2>,
        domain: &Quadrilateral,
        side: &RingSide<2>,
        stencil: &mut Stencil<2>,
    ) -> Result<(), OutsideMesh<2>> {
        ring::side(mesh, &domain.outline(x), side, stencil)
    }

    fn convect(
        &self,
        domain: &mut Quadrilateral,
        position: &mut Vector<2>,
        step: &Convection<'_, 2>,
    ) -> Result<(), ConvectionError> {
        sampled::convect(&mut domain.corners, step)?;
        let shape = Shape::of(&domain.corners);
        sampled::sound(shape.area, domain.initial_area)?;
        *position = Self::position(&self.weights(domain, &shape), &domain.corners);
        Ok(())
    }

    /// Between the middles of two opposite sides; not where the domain is no longer convex. Shares are
    /// those of the area by which corners are weighed.
    fn halve(
        &self,
        domain: &Quadrilateral,
        _x: &Vector<2>,
        to_cells: &Block<2>,
    ) -> Option<[DomainPart<2, Quadrilateral>; 2]> {
        let shape = Shape::of(&domain.corners);
        let [a, b, c, d] = domain.corners;
        if shape.hourglass.lp_norm(1).is_nan() || shape.hourglass.lp_norm(1) >= 1.0 {
            return None;
        }
        let (across, corners) = match longest([b - a + d - c, c - a + d - b], to_cells) {
            0 => (1, [[a, (a + b) * 0.5, c, (c + d) * 0.5], [(a + b) * 0.5, b, (c + d) * 0.5, d]]),
            _ => (0, [[a, b, (a + c) * 0.5, (b + d) * 0.5], [(a + c) * 0.5, (b + d) * 0.5, c, d]]),
        };
        let rest = domain.initial_hourglass;
        Some(from_fn(|k| {
            let side = if k == 0 { -0.5 } else { 0.5 };
            // The half of κ at rest: x̄ ± ½ r_1, ½ r_1, r_2 ± ½ h, ½ h where the cut is across r_1.
            let rest_share = 0.5 * (1.0 + side * rest[across]);
            let mut initial_hourglass = Vector::zeros();
            initial_hourglass[across] = 0.25 * rest[across] / rest_share;
            initial_hourglass[1 - across] = rest[1 - across] * (1.0 - 2.0 * side * initial_hourglass[across]);
            let share = match self.weights {
                CornerWeights::Current => 0.5 * (1.0 + side * shape.hourglass[across]),
                CornerWeights::Frozen => rest_share,
            };
            let initial_area = share * domain.initial_area;
            let half = Quadrilateral { corners: corners[k], initial_area, initial_hourglass };
            let position = Self::position(&self.weights(&half, &Shape::of(&half.corners)), &half.corners);
            DomainPart { position, domain: half, share }
        }))
    }

    fn sampled_cells(
        &self,
        mesh: &Mesh<2>,
        x: &Vector<2>,
        domain: &Self::Domain,
        take: &mut dyn FnMut([u32; 2]),
    ) -> Result<(), OutsideMesh<2>> {
        sampled::cells(mesh, x, &self.samples(domain), take)
    }

    fn n_corners(&self) -> usize {
        4
    }

    fn corners(
        &self,
        mesh: &Mesh<2>,
        point: &CornerPoint<2>,
        domain: &Quadrilateral,
        to: &mut Vec<Corner<2>>,
    ) -> Result<(), OutsideMesh<2>> {
        if point.is_ring {
            return ring::corners(mesh, point, &self.ring(domain), to);
        }
        sampled::corners(mesh, point, &self.samples(domain), to)
    }

    fn diagnose(
        &self,
        mesh: &Mesh<2>,
        _x: &Vector<2>,
        domain: &Quadrilateral,
    ) -> Result<DomainReport, OutsideMesh<2>> {
        let measure = domain.area() / domain.initial_area;
        sampled::report(mesh, &self.samples(domain), measure, domain.distortion())
    }
}

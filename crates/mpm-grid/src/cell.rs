//! The linear cell: segment, quadrilateral or hexahedron with straight edges.
//!
//! x(ξ) = Σ_c N_c(ξ) x_c with N_c = Π_d ½(1 ± ξ_d), ξ in [-1, 1]^D (isoparametric element;
//! Hughes, *The Finite Element Method*, 1987, chapter 3). Corner c lies on the upper side in
//! direction d where bit d of c is set: lexicographic, first direction fastest.

use std::array::from_fn;

use crate::{Block, Vector};

/// A D-linear cell given by its corners.
///
/// Volumes and maps serve cells of either hand: those of a ring, with directions (θ, r), have a
/// negative Jacobian determinant throughout.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearCell<const D: usize> {
    corners: [Vector<D>; 8],
}

impl<const D: usize> LinearCell<D> {
    /// The cell with the given corners; the first 2^D entries count.
    #[inline]
    pub fn new(corners: [Vector<D>; 8]) -> Self {
        const { assert!(1 <= D && D <= 3, "space has one, two or three dimensions") };
        Self { corners }
    }

    /// Corner positions `[L]`; the first 2^D entries count.
    #[inline]
    pub fn corners(&self) -> &[Vector<D>; 8] {
        &self.corners
    }

    /// Shape functions N_c at local coordinates, the first 2^D entries.
    #[inline]
    pub fn values(local: &Vector<D>) -> [f64; 8] {
        let half = halves(local);
        from_fn(|c| if c < 1 << D { product(&half, c, D) } else { 0.0 })
    }

    /// ∂N_c/∂ξ at local coordinates, the first 2^D entries.
    #[inline]
    pub fn local_gradients(local: &Vector<D>) -> [Vector<D>; 8] {
        let half = halves(local);
        from_fn(|c| if c < 1 << D { local_gradient(&half, c) } else { Vector::zeros() })
    }

    /// ∂N_c/∂x `[1/L]` at local coordinates, the first 2^D entries; not finite where the Jacobian
    /// is singular.
    #[inline]
    pub fn gradients(&self, local: &Vector<D>) -> [Vector<D>; 8] {
        let inverse = inverse(&self.jacobian(local)).transpose();
        let mut gradients = Self::local_gradients(local);
        for g in gradients.iter_mut().take(1 << D) {
            *g = inverse * *g;
        }
        gradients
    }

    /// Position `[L]` at local coordinates.
    #[inline]
    pub fn position(&self, local: &Vector<D>) -> Vector<D> {
        let mut x = Vector::zeros();
        for (corner, n) in self.corners.iter().zip(Self::values(local)).take(1 << D) {
            x += corner * n;
        }
        x
    }

    /// ∂x/∂ξ `[L]` at local coordinates; column d is ∂x/∂ξ_d.
    #[inline]
    pub fn jacobian(&self, local: &Vector<D>) -> Block<D> {
        let gradients = Self::local_gradients(local);
        let mut j = Block::zeros();
        for (corner, g) in self.corners.iter().zip(gradients).take(1 << D) {
            j += corner * g.transpose();
        }
        j
    }

    /// det ∂x/∂ξ `[L^D]` at local coordinates; negative in a left-handed cell.
    #[inline]
    pub fn determinant(&self, local: &Vector<D>) -> f64 {
        determinant(&self.jacobian(local))
    }

    /// Length, area or volume `[L^D]`, exact and positive for a valid cell of either hand.
    pub fn volume(&self) -> f64 {
        let x = &self.corners;
        match D {
            1 => (x[1][0] - x[0][0]).abs(),
            2 => 0.5 * cross(&(x[3] - x[0]), &(x[2] - x[1])).abs(),
            _ => self.hexahedron_volume().abs(),
        }
    }

    /// With x = Σ_S a_S Π_{d in S} ξ_d, S the sets of directions, det ∂x/∂ξ has even monomials in four triple products only:
    /// its integral is 8 ([a₁ a₂ a₃] + ([a₁ a₁₂ a₁₃] + [a₁₂ a₂ a₂₃] + [a₁₃ a₂₃ a₃]) / 3).
    fn hexahedron_volume(&self) -> f64 {
        let x = &self.corners;
        // Eight times a_S; bit d of `set` says whether d is in S.
        let a = |set: usize| {
            (0..8).fold(Vector::<D>::zeros(), |sum, c| {
                if (set & !c).count_ones().is_multiple_of(2) { sum + x[c] } else { sum - x[c] }
            })
        };
        let [a1, a2, a3, a12, a13, a23] = [1, 2, 4, 3, 5, 6].map(a);
        let triple = |u: &Vector<D>, v: &Vector<D>, w: &Vector<D>| {
            u[0] * (v[1] * w[2] - v[2] * w[1])
                + u[1] * (v[2] * w[0] - v[0] * w[2])
                + u[2] * (v[0] * w[1] - v[1] * w[0])
        };
        let bent = triple(&a1, &a12, &a13) + triple(&a12, &a2, &a23) + triple(&a13, &a23, &a3);
        (triple(&a1, &a2, &a3) + bent / 3.0) / 64.0
    }

    /// The part of this cell between two local positions: again a linear cell, exactly.
    pub fn piece(&self, from_local: &Vector<D>, to_local: &Vector<D>) -> Self {
        Self::new(from_fn(|c| {
            let pick = |d: usize| {
                if c >> d & 1 == 0 { from_local[d] } else { to_local[d] }
            };
            if c < 1 << D { self.position(&Vector::from_fn(|d, _| pick(d))) } else { Vector::zeros() }
        }))
    }

    /// Whether det ∂x/∂ξ has the sign `hand` (±1) at every corner and at the centre, and is neither too small
    /// nor too large for a number; for D <= 2, where it is linear in ξ, that means everywhere.
    pub fn is_valid(&self, hand: f64) -> bool {
        let is_right = |determinant: f64| (f64::MIN_POSITIVE..=f64::MAX).contains(&(hand * determinant));
        let at = |c: usize| Vector::from_fn(|d, _| if c >> d & 1 == 0 { -1.0 } else { 1.0 });
        let corners = (0..1 << D).all(|c| is_right(self.determinant(&at(c))));
        corners && is_right(self.determinant(&Vector::zeros()))
    }

    /// Local coordinates of `x`, also outside the cell as far as its map can be inverted there.
    ///
    /// D = 2 in closed form, on the branch where the Jacobian has the sign it has at the centre,
    /// with two Newton corrections; D = 3 by Newton's method with step halving.
    pub fn local(&self, x: &Vector<D>) -> Option<Vector<D>> {
        let start = match D {
            2 => self.bilinear_local(x)?,
            _ => self.estimate(x),
        };
        let local = if D == 3 { self.newton(x, start)? } else { self.correct(x, start, 2) };
        local.iter().all(|c| c.is_finite()).then_some(local)
    }

    /// Local coordinates of `x` in the parallelepiped tangent to this cell at its centre.
    pub(crate) fn estimate(&self, x: &Vector<D>) -> Vector<D> {
        let centre = Vector::zeros();
        inverse(&self.jacobian(&centre)) * (x - self.position(&centre))
    }

    /// Root of the bilinear map. With x - x_0 = p = aξ + bη + cξη, the cross product with b + cξ
    /// leaves (a×c) ξ² + (a×b - p×c) ξ - p×b = 0, whose derivative at the root is det ∂x/∂ξ.
    fn bilinear_local(&self, x: &Vector<D>) -> Option<Vector<D>> {
        let [x0, x1, x2, x3] = [0, 1, 2, 3].map(|c| self.corners[c]);
        let p = x - 0.25 * (x0 + x1 + x2 + x3);
        let a = 0.25 * ((x1 - x0) + (x3 - x2));
        let b = 0.25 * ((x2 - x0) + (x3 - x1));
        let c = 0.25 * ((x3 - x2) - (x1 - x0));
        let area = cross(&a, &b);
        let (quadratic, linear, constant) = (cross(&a, &c), area - cross(&p, &c), -cross(&p, &b));
        let discriminant = linear * linear - 4.0 * quadratic * constant;
        if discriminant.is_nan() || discriminant < 0.0 {
            return None;
        }
        let slope = discriminant.sqrt().copysign(area);
        // The form without cancellation of two; the first holds for parallelograms too.
        let xi = if linear * slope >= 0.0 {
            -2.0 * constant / (linear + slope)
        } else {
            (slope - linear) / (2.0 * quadratic)
        };
        let (along, rest) = (b + c * xi, p - a * xi);
        let eta = rest.dot(&along) / along.norm_squared();
        Some(Vector::from_fn(|d, _| if d == 0 { xi } else { eta }))
    }

    /// Newton corrections of a nearly exact `local`; those that are not finite are dropped.
    fn correct(&self, x: &Vector<D>, mut local: Vector<D>, times: usize) -> Vector<D> {
        for _ in 0..times {
            let step = inverse(&self.jacobian(&local)) * (x - self.position(&local));
            if step.iter().all(|s| s.is_finite()) {
                local += step;
            }
        }
        local
    }

    fn newton(&self, x: &Vector<D>, start: Vector<D>) -> Option<Vector<D>> {
        let clamped = start.map(|c| c.clamp(-2.0, 2.0));
        // A parallelepiped is solved by `start` itself; elsewhere a far start may lie beyond a fold.
        self.newton_from(x, clamped).or_else(|| self.newton_from(x, Vector::zeros()))
    }

    fn newton_from(&self, x: &Vector<D>, mut local: Vector<D>) -> Option<Vector<D>> {
        let hand = self.determinant(&Vector::zeros()).signum();
        let mut residual = x - self.position(&local);
        for _ in 0..50 {
            let j = self.jacobian(&local);
            if determinant(&j) * hand <= 0.0 {
                return None;
            }
            let step = inverse(&j) * residual;
            if !step.iter().all(|s| s.is_finite()) {
                return None;
            }
            if step.amax() < 1e-12 * (1.0 + local.amax()) {
                return Some(local + step);
            }
            let mut share = 1.0;
            loop {
                let next = local + step * share;
                let left = x - self.position(&next);
                if left.norm_squared() < residual.norm_squared() {
                    (local, residual) = (next, left);
                    break;
                }
                // Only the rounding of positions keeps so small a step from improving.
                if step.amax() < 1e-8 {
                    return Some(local);
                }
                if share < 1e-6 {
                    return None;
                }
                share *= 0.5;
            }
        }
        None
    }
}

/// ½(1 - ξ_d) and ½(1 + ξ_d) per direction.
#[inline]
pub(crate) fn halves<const D: usize>(local: &Vector<D>) -> [[f64; 2]; D] {
    from_fn(|d| [0.5 * (1.0 - local[d]), 0.5 * (1.0 + local[d])])
}

/// ∂N_c/∂ξ.
#[inline]
pub(crate) fn local_gradient<const D: usize>(half: &[[f64; 2]; D], c: usize) -> Vector<D> {
    Vector::from_fn(|d, _| {
        let slope = if c >> d & 1 == 0 { -0.5 } else { 0.5 };
        slope * product(half, c, d)
    })
}

/// Π over directions except `skip` of the factor of corner `c`.
#[inline]
pub(crate) fn product<const D: usize>(half: &[[f64; 2]; D], c: usize, skip: usize) -> f64 {
    let mut value = 1.0;
    for d in 0..D {
        if d != skip {
            value *= half[d][c >> d & 1];
        }
    }
    value
}

fn cross<const D: usize>(a: &Vector<D>, b: &Vector<D>) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

#[inline]
pub(crate) fn determinant<const D: usize>(m: &Block<D>) -> f64 {
    match D {
        1 => m[(0, 0)],
        2 => m[(0, 0)] * m[(1, 1)] - m[(0, 1)] * m[(1, 0)],
        _ => (0..3).map(|j| m[(0, j)] * cofactor(m, 0, j)).sum(),
    }
}

/// Cofactor of a 3×3 block, by cyclic indices (no signs needed).
#[inline]
fn cofactor<const D: usize>(m: &Block<D>, i: usize, j: usize) -> f64 {
    let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
    let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
    m[(i1, j1)] * m[(i2, j2)] - m[(i1, j2)] * m[(i2, j1)]
}

/// The inverse; not finite where the block is singular.
#[inline]
pub fn inverse<const D: usize>(m: &Block<D>) -> Block<D> {
    let per_det = 1.0 / determinant(m);
    match D {
        1 => Block::from_element(per_det),
        2 => Block::from_fn(|i, j| {
            let adjugate = if i == j { m[(1 - i, 1 - j)] } else { -m[(i, j)] };
            adjugate * per_det
        }),
        _ => Block::from_fn(|i, j| cofactor(m, j, i) * per_det),
    }
}

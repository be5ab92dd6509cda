//! The generalised vortex: a manufactured solution with large rotation and shear, regular everywhere.
//!
//! A ring of radii 0.75 and 1.25 around the origin; every circle of radius R turns by
//! `α(R) = A g(R)`, `g = 1 − 32 (R − 1)² + 256 (R − 1)⁴`, which vanishes with its slope at both edges
//! (Brannon, Kamojjala & Sadeghirad 2011; Kamojjala et al. 2015). In polar coordinates that is a
//! simple shear `γ = R α'(R)` turned by α, so J = 1 and, for the Hencky law with `h = asinh(γ/2)`,
//! `s = √(1 + γ²/4)`:
//!
//! ```text
//! τ_rr = −G h γ / s,   τ_θθ = +G h γ / s,   τ_rθ = 2 G h / s
//! ```
//!
//! For the neo-Hookean law τ = G (b − I) where J = 1, with b_rr = 1, b_rθ = γ, b_θθ = 1 + γ²:
//!
//! ```text
//! τ_rr = 0,   τ_θθ = G γ²,   τ_rθ = G γ
//! ```
//!
//! Static equilibrium in the turned frame gives the body force per volume
//! `b_r = −dτ_rr/dR − (τ_rr − τ_θθ)/R`, `b_θ = −dτ_rθ/dR − 2 τ_rθ/R`.

use mpm_grid::{LoadFraction, Ramp, Vector};
use mpm_solver::BodyForce;

/// The vortex of one body.
#[derive(Clone, Debug, PartialEq)]
pub struct Vortex {
    shear: f64,
    angle: Ramp,
    is_rubber: bool,
}

/// State of the exact solution on one circle.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Circle {
    /// `α`, `γ` and `dγ/dR`.
    angle: f64,
    gamma: f64,
    slope: f64,
}

impl Vortex {
    /// In a Hencky material of shear modulus G `[F/L²]`, turning by `angle` `[rad]` in the middle.
    pub fn new(shear: f64, angle: Ramp) -> Self {
        Self { shear, angle, is_rubber: false }
    }

    /// The same in a neo-Hookean material.
    pub fn of_rubber(shear: f64, angle: Ramp) -> Self {
        Self { is_rubber: true, ..Self::new(shear, angle) }
    }

    /// τ_rr, τ_θθ and τ_rθ over G.
    fn stresses(&self, gamma: f64) -> [f64; 3] {
        if self.is_rubber {
            return [0.0, gamma * gamma, gamma];
        }
        let (h, s) = ((0.5 * gamma).asinh(), (1.0 + 0.25 * gamma * gamma).sqrt());
        [-h * gamma / s, h * gamma / s, 2.0 * h / s]
    }

    /// b_r and b_θ `[F/L³]`.
    fn polar_force(&self, circle: Circle, radius: f64) -> [f64; 2] {
        let Circle { gamma, slope, .. } = circle;
        if self.is_rubber {
            return [self.shear * gamma * gamma / radius, -self.shear * (slope + 2.0 * gamma / radius)];
        }
        let (h, s) = ((0.5 * gamma).asinh(), (1.0 + 0.25 * gamma * gamma).sqrt());
        // d(h/s)/dγ with dh/dγ = 1/(2s) and ds/dγ = γ/(4s).
        let quotient = 0.5 / (s * s) - 0.25 * h * gamma / s.powi(3);
        let radial = self.shear * (slope * (h / s + gamma * quotient) + 2.0 * h * gamma / (s * radius));
        let hoop = -2.0 * self.shear * (slope * quotient + 2.0 * h / (s * radius));
        [radial, hoop]
    }

    fn circle(&self, radius: f64, at: LoadFraction) -> Circle {
        let amplitude = self.angle.value(at);
        let x = radius - 1.0;
        let g = 1.0 - 32.0 * x * x + 256.0 * x.powi(4);
        let first = -64.0 * x + 1024.0 * x.powi(3);
        let second = -64.0 + 3072.0 * x * x;
        Circle {
            angle: amplitude * g,
            gamma: amplitude * radius * first,
            slope: amplitude * (first + radius * second),
        }
    }

    /// Where the exact motion takes the point at `rest` `[L]`.
    pub fn position<const D: usize>(&self, rest: &Vector<D>, at: LoadFraction) -> Vector<D> {
        let Circle { angle, .. } = self.circle(rest[0].hypot(rest[1]), at);
        let (sin, cos) = angle.sin_cos();
        let mut x = *rest;
        (x[0], x[1]) = (cos * rest[0] - sin * rest[1], sin * rest[0] + cos * rest[1]);
        x
    }

    /// Exact stress, Kirchhoff and Cauchy alike: xx, yy, xy of the point that was at `rest` `[F/L²]`.
    pub fn stress<const D: usize>(&self, rest: &Vector<D>, at: LoadFraction) -> [f64; 3] {
        let radius = rest[0].hypot(rest[1]);
        let Circle { gamma, .. } = self.circle(radius, at);
        let [radial, hoop, shear] = self.stresses(gamma).map(|stress| self.shear * stress);
        let x = self.position(rest, at);
        let (cos, sin) = (x[0] / radius, x[1] / radius);
        // [e_r e_θ] [[radial, shear], [shear, hoop]] [e_r e_θ]ᵀ
        let xx = radial * cos * cos + hoop * sin * sin - 2.0 * shear * sin * cos;
        let yy = radial * sin * sin + hoop * cos * cos + 2.0 * shear * sin * cos;
        let xy = (radial - hoop) * sin * cos + shear * (cos * cos - sin * sin);
        [xx, yy, xy]
    }
}

impl<const D: usize> BodyForce<D> for Vortex {
    fn ramps(&self) -> Vec<&Ramp> {
        vec![&self.angle]
    }

    fn force(&self, rest: &Vector<D>, at: LoadFraction) -> Vector<D> {
        let radius = rest[0].hypot(rest[1]);
        let [radial, hoop] = self.polar_force(self.circle(radius, at), radius);
        let x = self.position(rest, at);
        let (cos, sin) = (x[0] / radius, x[1] / radius);
        let mut force = Vector::zeros();
        (force[0], force[1]) = (radial * cos - hoop * sin, radial * sin + hoop * cos);
        force
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mpm_material::{Elasticity, Hencky, Material, NeoHooke, SymmetricTensor, respond};
    use nalgebra::{Matrix2, Matrix3};

    const E: f64 = 1e3;
    const NU: f64 = 0.3;

    const G: f64 = E / (2.0 * (1.0 + NU));

    fn vortices() -> [Vortex; 2] {
        [Vortex::new(G, Ramp::linear(1.0)), Vortex::of_rubber(G, Ramp::linear(1.0))]
    }

    /// Of both laws: the motion is the same.
    fn vortex() -> Vortex {
        Vortex::new(G, Ramp::linear(1.0))
    }

    /// F of the exact motion by central differences.
    fn gradient(rest: &Vector<2>, at: LoadFraction) -> Matrix2<f64> {
        let step = 1e-6;
        let mut f = Matrix2::zeros();
        for j in 0..2 {
            let mut d = Vector::<2>::zeros();
            d[j] = step;
            let column =
                (vortex().position(&(rest + d), at) - vortex().position(&(rest - d), at)) / (2.0 * step);
            f.set_column(j, &column);
        }
        f
    }

    /// Kirchhoff stress of a law on the exact motion.
    fn of_law<M: Material<History = ()>>(law: &M, f: &Matrix2<f64>) -> [f64; 3] {
        let mut excess = Matrix3::zeros();
        excess.fixed_view_mut::<2, 2>(0, 0).copy_from(&(f * f.transpose() - Matrix2::identity()));
        let tau = respond(law, &SymmetricTensor::from_matrix(&excess), &()).unwrap().kirchhoff;
        [tau.xx, tau.yy, tau.xy]
    }

    #[test]
    fn the_stress_is_that_of_the_law_on_the_exact_motion() {
        let at = LoadFraction::new(0.7).unwrap();
        let elasticity = Elasticity::from_young_poisson(E, NU).unwrap();
        let (hencky, rubber) = (Hencky(elasticity), NeoHooke::new(elasticity).unwrap());
        for rest in [Vector::<2>::new(0.8, 0.1), Vector::<2>::new(-0.5, 0.9), Vector::<2>::new(0.3, -1.15)] {
            let f = gradient(&rest, at);
            let of_laws = [of_law(&hencky, &f), of_law(&rubber, &f)];
            for (vortex, of_law) in vortices().iter().zip(of_laws) {
                for (found, expected) in vortex.stress(&rest, at).into_iter().zip(of_law) {
                    assert!((found - expected).abs() < 1e-6 * E, "{found} {expected}");
                }
            }
        }
    }

    #[test]
    fn the_body_force_balances_the_divergence_of_the_stress() {
        // b = -div σ in current coordinates: the exact motion is undone to find the stress at x.
        let at = LoadFraction::new(0.9).unwrap();
        for vortex in vortices() {
            let stress_at = |x: &Vector<2>| {
                let Circle { angle, .. } = vortex.circle(x.norm(), at);
                let (sin, cos) = (-angle).sin_cos();
                vortex.stress(&Vector::<2>::new(cos * x[0] - sin * x[1], sin * x[0] + cos * x[1]), at)
            };
            for rest in [Vector::<2>::new(0.85, 0.2), Vector::<2>::new(-0.6, 0.8), Vector::<2>::new(0.1, -1.2)]
            {
                let x = vortex.position(&rest, at);
                let step = 1e-5;
                let d = |j: usize, k: usize| {
                    let mut dx = Vector::<2>::zeros();
                    dx[j] = step;
                    (stress_at(&(x + dx))[k] - stress_at(&(x - dx))[k]) / (2.0 * step)
                };
                let expected = Vector::<2>::new(-(d(0, 0) + d(1, 2)), -(d(0, 2) + d(1, 1)));
                let found = vortex.force(&rest, at);
                assert!((found - expected).norm() < 1e-5 * expected.norm(), "{found} {expected}");
            }
        }
    }
}

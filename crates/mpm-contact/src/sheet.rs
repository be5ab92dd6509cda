//! Pieces of helicoids: distances to them by the roots of one function of the angle.

use mpm_grid::Block;
use nalgebra::Vector3;
use std::f64::consts::{PI, TAU};

/// A piece of a helicoid about the third axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sheet {
    pub radii: [f64; 2],
    /// c: rise per angle `[L]`, negative where it is left-handed.
    pub rise: f64,
    /// Θ `[rad]`.
    pub end: f64,
}

/// A place of the sheet where the distance is least nearby.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Foot {
    pub radius: f64,
    pub angle: f64,
}

impl Sheet {
    pub(crate) fn position(&self, radius: f64, angle: f64) -> Vector3<f64> {
        Vector3::new(radius * angle.cos(), radius * angle.sin(), self.rise * angle)
    }

    /// The unit normal that points along the axis.
    pub(crate) fn normal(&self, radius: f64, angle: f64) -> Vector3<f64> {
        let (sine, cosine) = angle.sin_cos();
        Vector3::new(self.rise * sine, -self.rise * cosine, radius) / radius.hypot(self.rise)
    }

    /// The nearest radius at the angle ψ from `x`.
    pub(crate) fn radius(&self, rho: f64, psi: f64) -> f64 {
        (rho * psi.cos()).clamp(self.radii[0], self.radii[1])
    }

    /// Half the derivative by ψ of the squared distance to the nearest point of the ray at ψ.
    fn slope(&self, rho: f64, zeta: f64, psi: f64) -> f64 {
        rho * self.radius(rho, psi) * psi.sin() + self.rise * (self.rise * psi - zeta)
    }

    /// Angles within a turn, from -π to π, between which the slope rises or falls throughout.
    fn monotone(&self, rho: f64) -> Vec<f64> {
        let mut angles = vec![-PI, PI];
        let mut add = |angle: f64| angles.extend([angle, -angle]);
        let c2 = self.rise * self.rise;
        for r in self.radii {
            // Where the radius is held at r from here on, and where that branch turns.
            if rho > 0.0 && r <= rho {
                add((r / rho).acos());
            }
            if rho * r > 0.0 && c2 <= rho * r {
                add((-c2 / (rho * r)).acos());
            }
        }
        if rho > 0.0 && c2 <= rho * rho {
            let angle = 0.5 * (-c2 / (rho * rho)).acos();
            add(angle);
            add(PI - angle);
        }
        angles.sort_by(f64::total_cmp);
        angles
    }

    /// All angles in [0, Θ] at which the distance from the place (ρ, α, z) is least nearby, if it may be below `reach`.
    pub(crate) fn minima(&self, rho: f64, alpha: f64, z: f64, reach: f64) -> Vec<f64> {
        // The distance is at least |z - c θ|.
        let span = reach / self.rise.abs();
        let middle = z / self.rise;
        let (low, high) = ((middle - span).max(0.0), (middle + span).min(self.end));
        let mut found = Vec::new();
        if low > high {
            return found;
        }
        let zeta = z - self.rise * alpha;
        let slope = |theta: f64| self.slope(rho, zeta, theta - alpha);
        // At the ends of the sheet, where the distance grows inwards.
        if low == 0.0 && slope(0.0) >= 0.0 {
            found.push(0.0);
        }
        let breaks = self.monotone(rho);
        let first_turn = ((low - alpha + PI) / TAU).floor();
        let mut turn = first_turn;
        while TAU * turn - PI <= high - alpha {
            for pair in breaks.windows(2) {
                let at = |psi: f64| (alpha + psi + TAU * turn).clamp(low, high);
                let (a, b) = (at(pair[0]), at(pair[1]));
                if a < b && slope(a) < 0.0 && slope(b) >= 0.0 {
                    found.push(root(&slope, a, b, |theta| self.curvature(rho, theta - alpha)));
                }
            }
            turn += 1.0;
        }
        if high == self.end && slope(self.end) <= 0.0 {
            found.push(self.end);
        }
        found
    }

    /// The slope's derivative.
    fn curvature(&self, rho: f64, psi: f64) -> f64 {
        let c2 = self.rise * self.rise;
        let free = rho * psi.cos();
        if self.radii[0] < free && free < self.radii[1] {
            rho * rho * (2.0 * psi).cos() + c2
        } else {
            rho * self.radius(rho, psi) * psi.cos() + c2
        }
    }

    /// `H = (I - n⊗n - J A⁻¹ Jᵀ)/d` with the derivatives J of the foot by what is free to move, radius and angle, and
    /// `A = JᵀJ - (x - foot)·∂²foot`.
    pub(crate) fn hessian(
        &self,
        foot: &Foot,
        free: [bool; 2],
        from_foot: &Vector3<f64>,
        distance: f64,
    ) -> Block<3> {
        let (sine, cosine) = foot.angle.sin_cos();
        let by_radius = Vector3::new(cosine, sine, 0.0);
        let by_angle = Vector3::new(-foot.radius * sine, foot.radius * cosine, self.rise);
        let mixed = Vector3::new(-sine, cosine, 0.0);
        let bent = Vector3::new(-foot.radius * cosine, -foot.radius * sine, 0.0);
        let a_rr = 1.0;
        let a_rt = by_radius.dot(&by_angle) - from_foot.dot(&mixed);
        let a_tt = by_angle.norm_squared() - from_foot.dot(&bent);
        let normal = from_foot / distance;
        let mut block = Block::<3>::identity() - normal * normal.transpose();
        match free {
            [true, true] => {
                let det = a_rr * a_tt - a_rt * a_rt;
                let mix = by_radius * by_angle.transpose();
                block -= (by_radius * by_radius.transpose() * a_tt + by_angle * by_angle.transpose() * a_rr
                    - (mix + mix.transpose()) * a_rt)
                    / det;
            }
            [true, false] => block -= by_radius * by_radius.transpose() / a_rr,
            [false, true] => block -= by_angle * by_angle.transpose() / a_tt,
            [false, false] => {}
        }
        block / distance
    }
}

/// The root of a function that rises from below 0 at `a` to at least 0 at `b`, by Newton's method kept between bounds.
fn root(value: &impl Fn(f64) -> f64, a: f64, b: f64, derivative: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (a, b);
    let mut at = 0.5 * (a + b);
    for _ in 0..100 {
        let f = value(at);
        if f < 0.0 {
            low = at;
        } else {
            high = at;
        }
        let newton = at - f / derivative(at);
        let next = if low < newton && newton < high { newton } else { 0.5 * (low + high) };
        if (next - at).abs() <= 4.0 * f64::EPSILON * at.abs().max(1e-3) {
            return next;
        }
        at = next;
    }
    at
}

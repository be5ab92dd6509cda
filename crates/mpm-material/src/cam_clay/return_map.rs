//! The return to the yield ellipse: Newton's method on two equations.

use super::elastic::Skeleton;
use super::parameters::CamClayParameters;
use crate::NoReturn;
use crate::elementary::{exp, ln};

/// A return.
#[derive(Clone, Copy, Debug)]
pub(super) struct Returned {
    /// p and q [F/L²].
    pub stress: (f64, f64),
    /// G₀ + g p [F/L²].
    pub shear_modulus: f64,
    /// Elastic ε_v.
    pub volumetric: f64,
    /// β: what is left of ε_s.
    pub beta: f64,
    /// p_c [F/L²].
    pub preconsolidation: f64,
    /// ∂(p, q)/∂(ε_v, ε_s) of the trial.
    pub derivative: [[f64; 2]; 2],
}

/// What stays the same in a return.
pub(super) struct Equations {
    pub skeleton: Skeleton,
    /// M.
    pub critical_ratio: f64,
    /// ε_v and ε_s of the trial.
    pub trial: (f64, f64),
    /// p_c,n [F/L²].
    pub before: f64,
    /// ln(p_c,n/p_r).
    logarithm: f64,
    /// G₀/p_r.
    shear: f64,
    /// M².
    m2: f64,
    /// 1/M².
    per_m2: f64,
    /// 1/κ.
    per_swelling: f64,
    /// λ − κ.
    pub hardening: f64,
    /// 1/(λ − κ).
    per_hardening: f64,
}

/// The equations in P = ln(p/p_r) and v = ε_s,tr/ε_s − 1 = 6 m p Δγ/M²:
///
/// ```text
/// R = ε_v − ε_v,tr − v M² (1 − y)/(6m),   F = ln(1 + y) − ln(p_c/p),
/// m = G₀/p + g,   ε_s = ε_s,tr/(1 + v),   y = η²/M²,   η = q/p = 3mε_s,
/// ε_v = −κ P + (3/2) g ε_s²,   ln(p_c/p) = ln(p_c,n/p_r) + (ε_v − ε_v,tr)/(λ − κ) − P.
/// ```
///
/// R is the flow rule ε_v − ε_v,tr = p Δγ (2 − p_c/p) on the yield surface, where p_c/p = 1 + y. On the isotropic axis
/// F is linear, so that steps of any length need no iteration there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    /// P and v.
    unknowns: [f64; 2],
    /// ε_v − ε_v,tr and ε_s.
    strains: (f64, f64),
    /// G₀/p and m.
    moduli: (f64, f64),
    /// 1/(1 + v).
    beta: f64,
    /// η.
    ratio: f64,
    /// y.
    yielding: f64,
    /// M²/(6m).
    flow: f64,
}

/// Derivatives at a point.
struct Slopes {
    /// ∂(R, F)/∂(P, v).
    jacobian: [[f64; 2]; 2],
    /// ∂η/∂(P, v).
    ratio: [f64; 2],
    /// ∂y/∂η.
    yielding: f64,
    /// 1/(1 + y).
    per_relative: f64,
}

impl Equations {
    /// Of a trial state with ε_v and ε_s, p_c being `before` [F/L²].
    #[inline]
    pub fn new(skeleton: Skeleton, parameters: &CamClayParameters, trial: (f64, f64), before: f64) -> Self {
        let CamClayParameters { critical_ratio, compression, swelling, .. } = *parameters;
        let hardening = compression - swelling;
        let m2 = critical_ratio * critical_ratio;
        Self {
            skeleton,
            critical_ratio,
            trial,
            before,
            logarithm: ln(before / skeleton.reference_pressure),
            shear: skeleton.shear / skeleton.reference_pressure,
            m2,
            per_m2: 1.0 / m2,
            per_swelling: 1.0 / swelling,
            hardening,
            per_hardening: 1.0 / hardening,
        }
    }

    /// Newton's method from the trial state with the pressure `p` [F/L²]; where it does not arrive, from the first
    /// zero of f along Δγ, which always exists and is bracketed.
    ///
    /// # Errors
    /// Numbers overflowed.
    #[inline(never)]
    pub fn solve(&self, p: f64) -> Result<Returned, NoReturn> {
        if p.is_finite() && p > 0.0 {
            let start = self.skeleton.exponent(self.trial.0, self.trial.1);
            // The trial's pressure is known: no power of e has to be taken.
            if let Some((returned, _)) = self.newton(self.with_modulus([start, 0.0], self.skeleton.shear / p)) {
                return Ok(returned);
            }
        }
        self.bracketed()
    }

    /// The state of ln(p/p_r) = `logarithm` [-] and Δγ = `multiplier` [L²/F], p being known too [F/L²].
    pub(super) fn flowing(&self, logarithm: f64, p: f64, multiplier: f64) -> Point {
        let constant = self.skeleton.shear / p;
        let modulus = constant + self.skeleton.shear_ratio;
        self.with_modulus([logarithm, 6.0 * self.per_m2 * modulus * p * multiplier], constant)
    }

    #[inline]
    fn at(&self, unknowns: [f64; 2]) -> Point {
        // Without a constant part of the modulus no pressure is needed.
        let constant = if self.shear > 0.0 { self.shear * exp(-unknowns[0]) } else { 0.0 };
        self.with_modulus(unknowns, constant)
    }

    /// G₀/p being `constant`.
    #[inline]
    fn with_modulus(&self, unknowns: [f64; 2], constant: f64) -> Point {
        let skeleton = &self.skeleton;
        let [logarithm, excess] = unknowns;
        let modulus = constant + skeleton.shear_ratio;
        let beta = 1.0 / (1.0 + excess);
        let shear = beta * self.trial.1;
        let ratio = 3.0 * modulus * shear;
        let volumetric = 1.5 * skeleton.shear_ratio * shear * shear - skeleton.swelling * logarithm;
        Point {
            unknowns,
            strains: (volumetric - self.trial.0, shear),
            moduli: (constant, modulus),
            beta,
            ratio,
            yielding: self.per_m2 * ratio * ratio,
            flow: self.m2 / (6.0 * modulus),
        }
    }

    /// R and F, and the larger of R/κ and F.
    #[inline]
    fn residual(&self, point: &Point) -> ([f64; 2], f64) {
        let [logarithm, excess] = point.unknowns;
        let change = point.strains.0;
        let relative = self.logarithm + change * self.per_hardening - logarithm;
        // F is of the size of 1: ln(1 + y) to the last digit of a small y would be of no use.
        let residual =
            [change - excess * point.flow * (1.0 - point.yielding), ln(1.0 + point.yielding) - relative];
        (residual, (residual[0] * self.per_swelling).abs().max(residual[1].abs()))
    }

    #[inline]
    fn slopes(&self, point: &Point) -> Slopes {
        let skeleton = &self.skeleton;
        let (shear, (constant, modulus)) = (point.strains.1, point.moduli);
        let excess = point.unknowns[1];
        let ratio = [-3.0 * constant * shear, -point.ratio * point.beta];
        let yielding = 2.0 * self.per_m2 * point.ratio;
        let per_relative = 1.0 / (1.0 + point.yielding);
        let volumetric_by = [-skeleton.swelling, -3.0 * skeleton.shear_ratio * shear * shear * point.beta];
        let against = excess * point.flow * yielding;
        let below = point.flow * (1.0 - point.yielding);
        // ∂(1/m)/∂P = (G₀/p)/m².
        let jacobian = [
            [
                volumetric_by[0] + against * ratio[0] - excess * below * (constant / modulus),
                volumetric_by[1] + against * ratio[1] - below,
            ],
            [
                per_relative * yielding * ratio[0] - volumetric_by[0] * self.per_hardening + 1.0,
                per_relative * yielding * ratio[1] - volumetric_by[1] * self.per_hardening,
            ],
        ];
        Slopes { jacobian, ratio, yielding, per_relative }
    }

    /// Newton's method from a point; a step is halved until the error falls. Answers with Δγ too. `None` where
    /// it gets stuck, or arrives at a negative multiplier.
    #[inline]
    pub(super) fn newton(&self, start: Point) -> Option<(Returned, f64)> {
        const STEPS: usize = 30;
        const HALVINGS: usize = 10;
        /// Convergence is quadratic: from here one step goes to round-off.
        const LAST: f64 = 1e-7;

        let mut now = start;
        let (mut residual, mut error) = self.residual(&now);
        for _ in 0..STEPS {
            let step = solve(&self.slopes(&now).jacobian, &residual);
            let moved =
                |part: f64| self.at([now.unknowns[0] - part * step[0], now.unknowns[1] - part * step[1]]);
            if error < LAST {
                let last = moved(1.0);
                return (last.unknowns[1] > 0.0).then(|| self.returned(&last));
            }
            let mut part = 1.0;
            let mut next = None;
            for _ in 0..HALVINGS {
                let tried = moved(part);
                let (tried_residual, tried_error) = self.residual(&tried);
                if tried_error < error {
                    next = Some((tried, tried_residual, tried_error));
                    break;
                }
                part *= 0.5;
            }
            (now, residual, error) = next?;
        }
        None
    }

    /// The answer, with the tangent of these equations: ∂(R, F)/∂(P, v) d(P, v) = −∂(R, F)/∂(ε_v, ε_s)_trial.
    #[inline]
    fn returned(&self, point: &Point) -> (Returned, f64) {
        let skeleton = &self.skeleton;
        let ((change, shear), (constant, modulus)) = (point.strains, point.moduli);
        let p = if self.shear > 0.0 {
            skeleton.shear / constant
        } else {
            skeleton.reference_pressure * exp(point.unknowns[0])
        };
        let Slopes { jacobian, ratio, yielding, per_relative } = self.slopes(point);

        let by_volume = solve(&jacobian, &[1.0, -self.per_hardening]);
        let volumetric_by = 3.0 * skeleton.shear_ratio * shear * point.beta;
        let ratio_by = 3.0 * modulus * point.beta;
        let excess = point.unknowns[1];
        let by_shear = solve(
            &jacobian,
            &[
                -volumetric_by - excess * point.flow * yielding * ratio_by,
                volumetric_by * self.per_hardening - per_relative * yielding * ratio_by,
            ],
        );
        let q_by =
            |d: [f64; 2], direct: f64| p * (direct + ratio[0] * d[0] + ratio[1] * d[1] + point.ratio * d[0]);
        let derivative =
            [[p * by_volume[0], p * by_shear[0]], [q_by(by_volume, 0.0), q_by(by_shear, ratio_by)]];
        let returned = Returned {
            stress: (p, p * point.ratio),
            shear_modulus: p * modulus,
            volumetric: self.trial.0 + change,
            beta: point.beta,
            preconsolidation: p * (1.0 + point.yielding),
            derivative,
        };
        (returned, excess * point.flow / p)
    }
}

/// Two linear equations.
#[inline]
fn solve([[a, b], [c, d]]: &[[f64; 2]; 2], [x, y]: &[f64; 2]) -> [f64; 2] {
    let inverse = 1.0 / (a * d - b * c);
    [inverse * (d * x - b * y), inverse * (a * y - c * x)]
}

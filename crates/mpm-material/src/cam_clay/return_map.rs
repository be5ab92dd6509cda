//! The return to the yield ellipse: Newton's method on two equations.

use super::elastic::Skeleton;
use super::parameters::CamClayParameters;
use crate::NoReturn;

/// Error that counts as solved: what rounding of strains of 3 leaves of a pressure that they decide, at κ = 0.005,
/// is some 1e-12.
const SOLVED: f64 = 1e-11;

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
    /// 1/M².
    per_m2: f64,
    /// λ − κ.
    pub hardening: f64,
}

/// The equations in P = ln(p/p_r) and ζ = p Δγ, which are of moderate size for pressures of any size:
///
/// ```text
/// R = ε_v − ε_v,tr − ζ (2 − p_c/p),   F = ln(1 + η²/M²) − ln(p_c/p),
/// m = G₀/p + g,   ε_s = β ε_s,tr,   β = 1/(1 + 6mζ/M²),   η = q/p = 3mε_s,
/// ε_v = −κ P + (3/2) g ε_s²,   ln(p_c/p) = ln(p_c,n/p_r) + (ε_v − ε_v,tr)/(λ − κ) − P.
/// ```
///
/// On the isotropic axis F is linear, so that steps of any length need no iteration there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    /// P and ζ.
    unknowns: [f64; 2],
    /// ε_v and ε_s.
    strains: (f64, f64),
    /// G₀/p and m.
    moduli: (f64, f64),
    beta: f64,
    /// η.
    ratio: f64,
    /// p_c/p.
    relative: f64,
    /// R and F.
    residual: [f64; 2],
    /// Of R/κ and F, the larger.
    error: f64,
}

/// Derivatives at a point.
struct Slopes {
    /// ∂(R, F)/∂(P, ζ).
    jacobian: [[f64; 2]; 2],
    /// ∂η/∂(P, ζ).
    ratio: [f64; 2],
    /// 2η/(M² + η²) = ∂ ln(1 + η²/M²)/∂η.
    yielding: f64,
}

impl Equations {
    /// Of a trial state with ε_v and ε_s, p_c being `before` [F/L²].
    #[inline]
    pub fn new(skeleton: Skeleton, parameters: &CamClayParameters, trial: (f64, f64), before: f64) -> Self {
        let CamClayParameters { critical_ratio, compression, swelling, .. } = *parameters;
        Self {
            skeleton,
            critical_ratio,
            trial,
            before,
            logarithm: (before / skeleton.reference_pressure).ln(),
            per_m2: 1.0 / (critical_ratio * critical_ratio),
            hardening: compression - swelling,
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
            if let Some((returned, _)) = self.newton(self.unreturned(start, p)) {
                return Ok(returned);
            }
        }
        self.bracketed()
    }

    /// The trial state, of which P and the pressure `p` are known: no power of e has to be taken.
    #[inline]
    fn unreturned(&self, logarithm: f64, p: f64) -> Point {
        let constant = self.skeleton.shear / p;
        let modulus = constant + self.skeleton.shear_ratio;
        let relative = self.logarithm - logarithm;
        let ratio = 3.0 * modulus * self.trial.1;
        let residual = [0.0, (self.per_m2 * ratio * ratio).ln_1p() - relative];
        Point {
            unknowns: [logarithm, 0.0],
            strains: self.trial,
            moduli: (constant, modulus),
            beta: 1.0,
            ratio,
            relative: self.before / p,
            residual,
            error: residual[1].abs(),
        }
    }

    #[inline]
    pub(super) fn at(&self, unknowns: [f64; 2]) -> Point {
        let skeleton = &self.skeleton;
        let [logarithm, zeta] = unknowns;
        // Without a constant part of the modulus no pressure is needed.
        let constant = if skeleton.shear > 0.0 {
            skeleton.shear / skeleton.reference_pressure * (-logarithm).exp()
        } else {
            0.0
        };
        let modulus = constant + skeleton.shear_ratio;
        let beta = 1.0 / (1.0 + 6.0 * self.per_m2 * modulus * zeta);
        let shear = beta * self.trial.1;
        let ratio = 3.0 * modulus * shear;
        let volumetric = 1.5 * skeleton.shear_ratio * shear * shear - skeleton.swelling * logarithm;
        let change = volumetric - self.trial.0;
        let relative = self.logarithm + change / self.hardening - logarithm;
        let quotient = relative.exp();
        let residual = [change - zeta * (2.0 - quotient), (self.per_m2 * ratio * ratio).ln_1p() - relative];
        let error = (residual[0] / skeleton.swelling).abs().max(residual[1].abs());
        Point {
            unknowns,
            strains: (volumetric, shear),
            moduli: (constant, modulus),
            beta,
            ratio,
            relative: quotient,
            residual,
            error,
        }
    }

    #[inline]
    fn slopes(&self, point: &Point) -> Slopes {
        let skeleton = &self.skeleton;
        let ((_, shear), (constant, modulus)) = (point.strains, point.moduli);
        let zeta = point.unknowns[1];
        let rate = 6.0 * self.per_m2 * point.beta * shear;
        let shear_by = [rate * constant * zeta, -rate * modulus];
        let ratio = [3.0 * (modulus * shear_by[0] - constant * shear), 3.0 * modulus * shear_by[1]];
        let coupling = 3.0 * skeleton.shear_ratio * shear;
        let volumetric_by = [coupling * shear_by[0] - skeleton.swelling, coupling * shear_by[1]];
        let relative_by = [volumetric_by[0] / self.hardening - 1.0, volumetric_by[1] / self.hardening];
        let yielding = 2.0 * self.per_m2 * point.ratio / (1.0 + self.per_m2 * point.ratio * point.ratio);
        let hardened = zeta * point.relative;
        let jacobian = [
            [
                volumetric_by[0] + hardened * relative_by[0],
                volumetric_by[1] + hardened * relative_by[1] - (2.0 - point.relative),
            ],
            [yielding * ratio[0] - relative_by[0], yielding * ratio[1] - relative_by[1]],
        ];
        Slopes { jacobian, ratio, yielding }
    }

    /// Newton's method from a point; a step is halved until the error falls. Answers with Δγ too. `None` where
    /// it gets stuck, or arrives at a negative multiplier.
    #[inline]
    pub(super) fn newton(&self, start: Point) -> Option<(Returned, f64)> {
        const STEPS: usize = 30;
        const HALVINGS: usize = 10;

        let mut now = start;
        for _ in 0..STEPS {
            let slopes = self.slopes(&now);
            let step = solve(&slopes.jacobian, &now.residual);
            let mut part = 1.0;
            let mut next = None;
            for _ in 0..HALVINGS {
                let tried = self.at([now.unknowns[0] - part * step[0], now.unknowns[1] - part * step[1]]);
                if tried.error < now.error {
                    next = Some(tried);
                    break;
                }
                if now.error < SOLVED {
                    break;
                }
                part *= 0.5;
            }
            // Convergence is quadratic: from 1e-8 one step goes to round-off.
            let (best, is_last) = match next {
                Some(better) => (better, now.error < 1e-8 && better.error < SOLVED),
                None if now.error < SOLVED => (now, true),
                None => return None,
            };
            now = best;
            if is_last {
                return (now.unknowns[1] > 0.0).then(|| self.returned(&now));
            }
        }
        None
    }

    /// The answer, with the tangent of these equations: ∂(R, F)/∂(P, ζ) d(P, ζ) = −∂(R, F)/∂(ε_v, ε_s)_trial.
    #[inline]
    fn returned(&self, point: &Point) -> (Returned, f64) {
        let skeleton = &self.skeleton;
        let ((volumetric, shear), (_, modulus)) = (point.strains, point.moduli);
        let p = skeleton.reference_pressure * point.unknowns[0].exp();
        let Slopes { jacobian, ratio, yielding } = self.slopes(point);
        let hardened = point.unknowns[1] * point.relative;

        let by_volume = solve(&jacobian, &[1.0 + hardened / self.hardening, -1.0 / self.hardening]);
        let volumetric_by = 3.0 * skeleton.shear_ratio * shear * point.beta;
        let ratio_by = 3.0 * modulus * point.beta;
        let by_shear = solve(
            &jacobian,
            &[
                -volumetric_by * (1.0 + hardened / self.hardening),
                volumetric_by / self.hardening - yielding * ratio_by,
            ],
        );
        let q_by =
            |d: [f64; 2], direct: f64| p * (direct + ratio[0] * d[0] + ratio[1] * d[1] + point.ratio * d[0]);
        let derivative =
            [[p * by_volume[0], p * by_shear[0]], [q_by(by_volume, 0.0), q_by(by_shear, ratio_by)]];
        let returned = Returned {
            stress: (p, p * point.ratio),
            shear_modulus: p * modulus,
            volumetric,
            beta: point.beta,
            preconsolidation: p * point.relative,
            derivative,
        };
        (returned, point.unknowns[1] / p)
    }
}

/// Two linear equations.
#[inline]
fn solve([[a, b], [c, d]]: &[[f64; 2]; 2], [x, y]: &[f64; 2]) -> [f64; 2] {
    let inverse = 1.0 / (a * d - b * c);
    [inverse * (d * x - b * y), inverse * (a * y - c * x)]
}

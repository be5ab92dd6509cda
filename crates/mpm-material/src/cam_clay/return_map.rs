//! The return to the yield ellipse: Newton's method on two equations, for one point or for four.

use super::elastic::Skeleton;
use super::parameters::Constants;
use crate::NoReturn;
use crate::elementary::{exp, ln};
use crate::lanes::Number;

/// A return.
#[derive(Clone, Copy, Debug)]
pub(super) struct Returned<T = f64> {
    /// p and q [F/L²].
    pub stress: (T, T),
    /// G₀ + g p [F/L²].
    pub shear_modulus: T,
    /// Elastic ε_v.
    pub volumetric: T,
    /// β: what is left of ε_s.
    pub beta: T,
    /// p_c [F/L²].
    pub preconsolidation: T,
    /// ∂(p, q)/∂(ε_v, ε_s) of the trial.
    pub derivative: [[T; 2]; 2],
}

/// What stays the same in a return.
pub(super) struct Equations<T = f64> {
    pub skeleton: Skeleton<T>,
    /// M.
    pub critical_ratio: T,
    /// ε_v and ε_s of the trial.
    pub trial: (T, T),
    /// p_c,n [F/L²].
    pub before: T,
    /// ln(p_c,n/p_r).
    logarithm: T,
    /// G₀/p_r.
    shear: T,
    /// M².
    m2: T,
    /// 1/M².
    per_m2: T,
    /// 1/κ.
    per_swelling: T,
    /// λ − κ.
    pub hardening: T,
    /// 1/(λ − κ).
    per_hardening: T,
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
pub(super) struct Point<T = f64> {
    /// P and v.
    unknowns: [T; 2],
    /// ε_v − ε_v,tr and ε_s.
    strains: (T, T),
    /// G₀/p and m.
    moduli: (T, T),
    /// 1/(1 + v).
    beta: T,
    /// η.
    ratio: T,
    /// y.
    yielding: T,
    /// M²/(6m).
    flow: T,
}

/// Derivatives at a point.
struct Slopes<T> {
    /// ∂(R, F)/∂(P, v).
    jacobian: [[T; 2]; 2],
    /// ∂η/∂(P, v).
    ratio: [T; 2],
    /// ∂y/∂η.
    yielding: T,
    /// 1/(1 + y).
    per_relative: T,
}

/// A point with R and F there, and their size.
struct Tried<T> {
    point: Point<T>,
    residual: [T; 2],
    /// The larger of R/κ and F.
    error: T,
}

impl Equations {
    /// Newton's method from the trial state with the pressure `p` [F/L²]; where it does not arrive, from the first
    /// zero of f along Δγ, which always exists and is bracketed.
    ///
    /// # Errors
    /// Numbers overflowed.
    #[inline(never)]
    pub fn solve(&self, p: f64) -> Result<Returned, NoReturn> {
        let (returned, arrives) = self.starting_at_trial(p, true);
        if arrives { Ok(returned) } else { self.bracketed() }
    }

    /// The state of ln(p/p_r) = `logarithm` [-] and Δγ = `multiplier` [L²/F], p being known too [F/L²].
    pub(super) fn flowing(&self, logarithm: f64, p: f64, multiplier: f64) -> Point {
        let constant = self.skeleton.shear / p;
        let modulus = constant + self.skeleton.shear_ratio;
        self.with_modulus([logarithm, 6.0 * self.per_m2 * modulus * p * multiplier], constant)
    }

    /// Newton's method from a point. Answers with Δγ too.
    pub(super) fn starting_at(&self, start: Point) -> Option<(Returned, f64)> {
        let (point, arrives) = self.newton(start, true);
        arrives.then(|| self.returned(&point))
    }
}

impl<T: Number> Equations<T> {
    /// Of a trial state with ε_v and ε_s, p_c being `before` [F/L²].
    #[inline(always)]
    pub fn new(constants: &Constants<T>, trial: (T, T), before: T) -> Self {
        let Constants { skeleton, critical_ratio, compression } = *constants;
        let one = T::of(1.0);
        let hardening = compression - skeleton.swelling;
        let m2 = critical_ratio * critical_ratio;
        Self {
            skeleton,
            critical_ratio,
            trial,
            before,
            logarithm: ln(before / skeleton.reference_pressure),
            shear: skeleton.shear / skeleton.reference_pressure,
            m2,
            per_m2: one / m2,
            per_swelling: one / skeleton.swelling,
            hardening,
            per_hardening: one / hardening,
        }
    }

    /// Newton's method from the trial states with the pressure `p` [F/L²], of those that are `asked`. Answers which of them
    /// arrive, too.
    #[inline(always)]
    pub fn starting_at_trial(&self, p: T, asked: T::Mask) -> (Returned<T>, T::Mask) {
        let asked = asked & p.above(T::ZERO) & p.below(T::of(f64::INFINITY));
        let start = self.skeleton.exponent(self.trial.0, self.trial.1);
        // The trial's pressure is known: no power of e has to be taken.
        let start = self.with_modulus([start, T::ZERO], self.skeleton.shear / p);
        let (point, arrives) = self.newton(start, asked);
        (self.returned(&point).0, arrives)
    }

    #[inline(always)]
    fn at(&self, unknowns: [T; 2]) -> Point<T> {
        let has_constant = self.shear.above(T::ZERO);
        // Without a constant part of the modulus no pressure is needed.
        let constant = if T::any(has_constant) {
            T::pick(has_constant, self.shear * exp(-unknowns[0]), T::ZERO)
        } else {
            T::ZERO
        };
        self.with_modulus(unknowns, constant)
    }

    /// G₀/p being `constant`.
    #[inline(always)]
    fn with_modulus(&self, unknowns: [T; 2], constant: T) -> Point<T> {
        let skeleton = &self.skeleton;
        let [logarithm, excess] = unknowns;
        let modulus = constant + skeleton.shear_ratio;
        let beta = T::of(1.0) / (T::of(1.0) + excess);
        let shear = beta * self.trial.1;
        let ratio = T::of(3.0) * modulus * shear;
        let volumetric = T::of(1.5) * skeleton.shear_ratio * shear * shear - skeleton.swelling * logarithm;
        Point {
            unknowns,
            strains: (volumetric - self.trial.0, shear),
            moduli: (constant, modulus),
            beta,
            ratio,
            yielding: self.per_m2 * ratio * ratio,
            flow: self.m2 / (T::of(6.0) * modulus),
        }
    }

    #[inline(always)]
    fn tried(&self, point: Point<T>) -> Tried<T> {
        let one = T::of(1.0);
        let [logarithm, excess] = point.unknowns;
        let change = point.strains.0;
        let relative = self.logarithm + change * self.per_hardening - logarithm;
        // F is of the size of 1: ln(1 + y) to the last digit of a small y would be of no use.
        let residual =
            [change - excess * point.flow * (one - point.yielding), ln(one + point.yielding) - relative];
        let error = (residual[0] * self.per_swelling).absolute().zip(residual[1].absolute(), f64::max);
        Tried { point, residual, error }
    }

    #[inline(always)]
    fn slopes(&self, point: &Point<T>) -> Slopes<T> {
        let skeleton = &self.skeleton;
        let (shear, (constant, modulus)) = (point.strains.1, point.moduli);
        let excess = point.unknowns[1];
        let (one, three) = (T::of(1.0), T::of(3.0));
        let ratio = [-three * constant * shear, -point.ratio * point.beta];
        let yielding = T::of(2.0) * self.per_m2 * point.ratio;
        let per_relative = one / (one + point.yielding);
        let volumetric_by = [-skeleton.swelling, -three * skeleton.shear_ratio * shear * shear * point.beta];
        let against = excess * point.flow * yielding;
        let below = point.flow * (one - point.yielding);
        // ∂(1/m)/∂P = (G₀/p)/m².
        let jacobian = [
            [
                volumetric_by[0] + against * ratio[0] - excess * below * (constant / modulus),
                volumetric_by[1] + against * ratio[1] - below,
            ],
            [
                per_relative * yielding * ratio[0] - volumetric_by[0] * self.per_hardening + one,
                per_relative * yielding * ratio[1] - volumetric_by[1] * self.per_hardening,
            ],
        ];
        Slopes { jacobian, ratio, yielding, per_relative }
    }

    /// Newton's method from points, of those that are `asked`; a step is halved until the error falls. Answers which of them
    /// arrive: not those that get stuck, nor those with a negative multiplier.
    ///
    /// A point that has arrived stays where it is while others go on, so that it has the bits that it has alone.
    #[inline(always)]
    fn newton(&self, start: Point<T>, asked: T::Mask) -> (Point<T>, T::Mask) {
        const STEPS: usize = 30;
        /// Convergence is quadratic: from here one step goes to round-off.
        const LAST: f64 = 1e-7;

        let mut now = self.tried(start);
        let (mut arrives, mut goes_on) = (asked, asked);
        for _ in 0..STEPS {
            let [x, y] = solve(&self.slopes(&now.point).jacobian, &now.residual);
            let step = [T::pick(goes_on, x, T::ZERO), T::pick(goes_on, y, T::ZERO)];
            let goes_further = goes_on & !now.error.below(T::of(LAST));
            if !T::any(goes_further) {
                now.point = self.moved(&now.point, step, T::of(1.0));
                goes_on = goes_further;
                break;
            }
            let is_stuck;
            (now, is_stuck) = self.downhill(&now, step, goes_further);
            arrives = arrives & !is_stuck;
            goes_on = goes_further & !is_stuck;
        }
        let point = now.point;
        (point, arrives & !goes_on & point.unknowns[1].above(T::ZERO))
    }

    /// The point after this part of a step.
    #[inline(always)]
    fn moved(&self, from: &Point<T>, step: [T; 2], part: T) -> Point<T> {
        self.at([from.unknowns[0] - part * step[0], from.unknowns[1] - part * step[1]])
    }

    /// A step, halved where the error has to fall and does not. Answers where it never does, too.
    #[inline(always)]
    fn downhill(&self, from: &Tried<T>, step: [T; 2], has_to_fall: T::Mask) -> (Tried<T>, T::Mask) {
        const HALVINGS: usize = 10;

        let (mut part, mut halvings) = (T::of(1.0), 0);
        loop {
            let tried = self.tried(self.moved(&from.point, step, part));
            let is_stuck = has_to_fall & !tried.error.below(from.error);
            halvings += 1;
            if halvings == HALVINGS || !T::any(is_stuck) {
                return (tried, is_stuck);
            }
            part = T::pick(is_stuck, T::of(0.5) * part, part);
        }
    }

    /// The answer, with the tangent of these equations: ∂(R, F)/∂(P, v) d(P, v) = −∂(R, F)/∂(ε_v, ε_s)_trial. And Δγ.
    #[inline(always)]
    fn returned(&self, point: &Point<T>) -> (Returned<T>, T) {
        let skeleton = &self.skeleton;
        let ((change, shear), (constant, modulus)) = (point.strains, point.moduli);
        let has_constant = self.shear.above(T::ZERO);
        let p = if T::all(has_constant) {
            skeleton.shear / constant
        } else {
            let other = skeleton.reference_pressure * exp(point.unknowns[0]);
            T::pick(has_constant, skeleton.shear / constant, other)
        };
        let Slopes { jacobian, ratio, yielding, per_relative } = self.slopes(point);

        let by_volume = solve(&jacobian, &[T::of(1.0), -self.per_hardening]);
        let volumetric_by = T::of(3.0) * skeleton.shear_ratio * shear * point.beta;
        let ratio_by = T::of(3.0) * modulus * point.beta;
        let excess = point.unknowns[1];
        let by_shear = solve(
            &jacobian,
            &[
                -volumetric_by - excess * point.flow * yielding * ratio_by,
                volumetric_by * self.per_hardening - per_relative * yielding * ratio_by,
            ],
        );
        let [c, d] = by_volume;
        let q_by_volume = p * (ratio[0] * c + ratio[1] * d + point.ratio * c);
        let [c, d] = by_shear;
        let q_by_shear = p * (ratio_by + ratio[0] * c + ratio[1] * d + point.ratio * c);
        let returned = Returned {
            stress: (p, p * point.ratio),
            shear_modulus: p * modulus,
            volumetric: self.trial.0 + change,
            beta: point.beta,
            preconsolidation: p * (T::of(1.0) + point.yielding),
            derivative: [[p * by_volume[0], p * by_shear[0]], [q_by_volume, q_by_shear]],
        };
        (returned, excess * point.flow / p)
    }
}

/// Two linear equations.
#[inline(always)]
fn solve<T: Number>([[a, b], [c, d]]: &[[T; 2]; 2], [x, y]: &[T; 2]) -> [T; 2] {
    let inverse = T::of(1.0) / (*a * *d - *b * *c);
    [inverse * (*d * *x - *b * *y), inverse * (*a * *y - *c * *x)]
}

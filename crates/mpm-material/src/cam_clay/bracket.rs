//! The first zero of the yield function along the plastic multiplier, where Newton's method does not arrive.

use super::return_map::{Equations, Returned};
use crate::NoReturn;
use crate::elementary::exp;

const NO_ZERO: NoReturn =
    NoReturn { reason: "the yield function of Cam-Clay has no zero along the plastic multiplier" };
const NO_FLOW: NoReturn =
    NoReturn { reason: "the flow rule of Cam-Clay has no solution within the range of numbers" };

/// A solution of the flow rule for a given Δγ.
#[derive(Clone, Copy)]
struct Flowed {
    /// ε_v and ε_s.
    strains: (f64, f64),
    /// p [F/L²].
    p: f64,
    /// f/p_c,n².
    overshoot: f64,
    /// Gradient of [`Equations::flowed`]'s function.
    gradient: [f64; 2],
    hessian: [[f64; 2]; 2],
    /// That function's value.
    value: f64,
}

impl Equations {
    /// Brackets the zero by doubling Δγ, then halves, and tries Newton's method from there now and then.
    ///
    /// # Errors
    /// No zero up to multipliers of 1e50/p_c: the trial pressure is below all measure.
    #[inline(never)]
    pub(super) fn bracketed(&self) -> Result<Returned, NoReturn> {
        const DOUBLINGS: usize = 200;
        const HALVINGS: usize = 60;
        /// Newton's method is tried anew after so many halvings.
        const TRIES: usize = 3;

        let mut upper = 1e-6 * self.skeleton.swelling / self.before;
        let mut lower = 0.0;
        let mut at_upper = self.flowed(self.start(), upper)?;
        let mut doublings = 0;
        while at_upper.overshoot > 0.0 {
            if doublings == DOUBLINGS {
                return Err(NO_ZERO);
            }
            doublings += 1;
            lower = upper;
            upper *= 2.0;
            at_upper = self.flowed(at_upper.strains, upper)?;
        }
        for halving in 0..HALVINGS {
            if halving % TRIES == 0 {
                let (volumetric, shear) = at_upper.strains;
                let logarithm = self.skeleton.exponent(volumetric, shear);
                if let Some((returned, multiplier)) = self.starting_at(self.flowing(logarithm, at_upper.p, upper))
                    // The first zero, and no other.
                    && multiplier >= lower * (1.0 - 1e-9)
                    && multiplier <= upper * (1.0 + 1e-9)
                {
                    return Ok(returned);
                }
            }
            let middle = 0.5 * (lower + upper);
            let at_middle = self.flowed(at_upper.strains, middle)?;
            if at_middle.overshoot > 0.0 {
                lower = middle;
            } else {
                (upper, at_upper) = (middle, at_middle);
            }
        }
        Err(NO_ZERO)
    }

    /// The trial strains, or, where their pressure is out of all proportion, some of less pressure: each
    /// of Newton's steps would take only a factor e off it.
    fn start(&self) -> (f64, f64) {
        const LARGEST: f64 = 50.0;

        let (volumetric, shear) = self.trial;
        if self.skeleton.exponent(volumetric, shear) < LARGEST {
            (volumetric, shear)
        } else {
            (volumetric.max(-LARGEST * self.skeleton.swelling), 0.0)
        }
    }

    /// For a given Δγ the flow rule says that the gradient of a strictly convex function of the elastic strains
    /// vanishes,
    ///
    /// ¼ (ε_v − ε_v,tr)² + ¼M² (ε_s − ε_s,tr)² + Δγ [ψ + ½ (λ − κ) p_c],
    ///
    /// so it has exactly one solution, and f there goes from positive to negative as Δγ grows. Newton's
    /// method, its steps halved where they do not lead down, finds it from any `start`.
    fn flowed(&self, start: (f64, f64), multiplier: f64) -> Result<Flowed, NoReturn> {
        const STEPS: usize = 200;
        const HALVINGS: usize = 60;

        let mut now = self.convex(start, multiplier);
        let size = |point: &Flowed| point.gradient[0].abs().max(point.gradient[1].abs());
        for _ in 0..STEPS {
            let [[a, b], [_, d]] = now.hessian;
            let determinant = a * d - b * b;
            let [x, y] = now.gradient;
            let step = ((d * x - b * y) / determinant, (a * y - b * x) / determinant);
            if !(step.0.is_finite() && step.1.is_finite()) {
                return Err(NO_FLOW);
            }
            let mut part = 1.0;
            let mut next = None;
            for _ in 0..HALVINGS {
                let strains = (now.strains.0 - part * step.0, now.strains.1 - part * step.1);
                let tried = self.convex(strains, multiplier);
                // Near the minimum the gradient has digits left where the value has none.
                let rounding = 1e-14 * now.value.abs();
                let is_flat = tried.value <= now.value + rounding;
                if tried.value < now.value - rounding || is_flat && size(&tried) < size(&now) {
                    next = Some(tried);
                    break;
                }
                part *= 0.5;
            }
            let Some(better) = next else { break };
            now = better;
        }
        if now.overshoot.is_finite() { Ok(now) } else { Err(NO_FLOW) }
    }

    /// That function, with its first and second derivatives.
    fn convex(&self, strains: (f64, f64), multiplier: f64) -> Flowed {
        let (volumetric, shear) = strains;
        let m = self.critical_ratio;
        let m2 = m * m;
        let state = self.skeleton.at(volumetric, shear);
        let [[p_v, p_s], [_, q_s]] = state.derivative;
        let (dv, ds) = (volumetric - self.trial.0, shear - self.trial.1);
        let preconsolidation = self.before * exp(dv / self.hardening);
        let stored = self.skeleton.energy(volumetric, shear) + 0.5 * self.hardening * preconsolidation;
        let mixed = -multiplier * p_s;
        let hardening = 0.5 * preconsolidation / self.hardening;
        let along = state.q / m;
        let overshoot = (along * along + state.p * (state.p - preconsolidation)) / (self.before * self.before);
        Flowed {
            strains,
            p: state.p,
            overshoot,
            gradient: [
                0.5 * dv + multiplier * (0.5 * preconsolidation - state.p),
                0.5 * m2 * ds + multiplier * state.q,
            ],
            hessian: [[0.5 + multiplier * (hardening - p_v), mixed], [mixed, 0.5 * m2 + multiplier * q_s]],
            value: 0.25 * dv * dv + 0.25 * m2 * ds * ds + multiplier * stored,
        }
    }
}

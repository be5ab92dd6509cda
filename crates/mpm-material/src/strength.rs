//! Undrained shear strength, perfect or softening, and the equation of a return with it.

use crate::elementary::exp;
use crate::{FieldInfo, History, ParameterError};

/// Undrained shear strength s_u(ξ) [F/L²] as a function of the accumulated plastic shear ξ [-], which is
/// work conjugate to it: dW_p = s_u dξ. In pure plastic shear by the angle γ, ξ = γ.
///
/// Softening localises: what a scene answers then depends on the size of its cells. State the width of a
/// shear band, or scale ξ₉₅ with the cells.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct UndrainedStrength {
    intact: f64,
    softening: Softening,
}

/// s_u(ξ)/s_u(0).
#[derive(Clone, Copy, PartialEq, Debug)]
enum Softening {
    /// 1
    None,
    /// max(1 + `slope` ξ, `residual`)
    Linear { slope: f64, residual: f64 },
    /// δ + (1 − δ) exp(−`rate` ξ), δ = `remoulded`
    Remoulding { remoulded: f64, rate: f64 },
}

/// A return in one scalar equation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shear {
    /// Increment Δ of ξ.
    pub increment: f64,
    /// s_u(ξ + Δ).
    pub strength: f64,
    /// s_u'(ξ + Δ).
    pub slope: f64,
}

impl UndrainedStrength {
    /// A strength that stays.
    ///
    /// # Errors
    /// `strength` is not positive and finite.
    pub fn perfect(strength: f64) -> Result<Self, ParameterError> {
        let intact = ParameterError::unless_positive("undrained_strength", strength)?;
        Ok(Self { intact, softening: Softening::None })
    }

    /// s_u = max(s_u0 + H ξ, s_res), with s_u0 = `intact`, H = `modulus` (negative for softening) and
    /// s_res = `residual`, all [F/L²].
    ///
    /// # Errors
    /// `intact` is not positive, `modulus` not finite, `residual` not between 0 and `intact`; 0 only where
    /// nothing softens, because a material without any strength has no stiffness either.
    pub fn linear(intact: f64, modulus: f64, residual: f64) -> Result<Self, ParameterError> {
        ParameterError::unless_positive("undrained_strength", intact)?;
        ParameterError::unless(modulus.is_finite(), "modulus", modulus, "a finite number")?;
        let range = residual >= 0.0 && residual <= intact;
        ParameterError::unless(range, "residual", residual, "a number between 0 and the undrained strength")?;
        if modulus < 0.0 {
            ParameterError::unless_positive("residual", residual)?;
        }
        let softening = Softening::Linear { slope: modulus / intact, residual: residual / intact };
        Ok(Self { intact, softening })
    }

    /// Remoulding, s_u = s_u0 [δ + (1 − δ) exp(−3 ξ/ξ₉₅)], with s_u0 = `intact` [F/L²], δ = `remoulded`
    /// (1/sensitivity), and the plastic shear ξ₉₅ = `shear_95` at which 95 % of what is to be lost is
    /// lost: 10 to 50 in cycles of a T-bar, less in brittle clay (Einav and Randolph 2005).
    ///
    /// # Errors
    /// `intact` or `shear_95` is not positive, `remoulded` not in (0, 1].
    pub fn remoulding(intact: f64, remoulded: f64, shear_95: f64) -> Result<Self, ParameterError> {
        ParameterError::unless_positive("undrained_strength", intact)?;
        let range = remoulded > 0.0 && remoulded <= 1.0;
        ParameterError::unless(range, "remoulded", remoulded, "a number above 0 and at most 1")?;
        let rate = 3.0 / ParameterError::unless_positive("shear_95", shear_95)?;
        Ok(Self { intact, softening: Softening::Remoulding { remoulded, rate } })
    }

    /// The same softening from another strength `intact` > 0 [F/L²]: H, s_res and δ stay.
    #[inline]
    pub(crate) fn with_intact(&self, intact: f64) -> Self {
        let softening = match self.softening {
            Softening::Linear { slope, residual } => {
                let part = self.intact / intact;
                Softening::Linear { slope: slope * part, residual: residual * part }
            }
            other => other,
        };
        Self { intact, softening }
    }

    /// s_u(0) [F/L²].
    #[inline]
    pub fn intact(&self) -> f64 {
        self.intact
    }

    /// Whether the strength never changes.
    #[inline]
    pub fn is_perfect(&self) -> bool {
        matches!(self.softening, Softening::None)
    }

    /// s_u(ξ) [F/L²].
    #[inline]
    pub fn at(&self, shear: f64) -> f64 {
        match self.softening {
            Softening::None => self.intact,
            Softening::Linear { slope, residual } => self.intact * (1.0 + slope * shear).max(residual),
            Softening::Remoulding { remoulded, rate } => {
                self.intact * (remoulded + (1.0 - remoulded) * exp(-rate * shear))
            }
        }
    }

    /// The largest −s_u'(ξ) [F/L²]; negative where it hardens.
    pub(crate) fn fastest_softening(&self) -> f64 {
        let fastest = match self.softening {
            Softening::None => 0.0,
            Softening::Linear { slope, .. } => -slope,
            Softening::Remoulding { remoulded, rate } => rate * (1.0 - remoulded),
        };
        self.intact * fastest
    }

    /// Refuses what softens faster than a point unloads, −s_u' ≥ `stiffness` [F/L²] somewhere: the return
    /// then has no solution near the last state (the point snaps back).
    pub(crate) fn check(&self, stiffness: f64, expected: &'static str) -> Result<(), ParameterError> {
        let rate = self.fastest_softening();
        ParameterError::unless(rate < stiffness, "fastest softening", rate, expected).map(|_| ())
    }

    /// Solves s_u(ξ + Δ) + c Δ = t for Δ ≥ 0, with ξ = `shear`, c = `stiffness` and t = `reach` ≥ s_u(ξ),
    /// all [F/L²]; strengths that pass [`Self::check`] make the left side increase.
    #[inline]
    pub(crate) fn solve(&self, shear: f64, stiffness: f64, reach: f64) -> Shear {
        match self.softening {
            Softening::None => {
                Shear { increment: (reach - self.intact) / stiffness, strength: self.intact, slope: 0.0 }
            }
            Softening::Linear { slope, residual } => {
                let (slope, floor) = (self.intact * slope, self.intact * residual);
                let increment = (reach - self.intact - slope * shear) / (stiffness + slope);
                let strength = self.intact + slope * (shear + increment);
                if strength > floor {
                    Shear { increment, strength, slope }
                } else {
                    Shear { increment: (reach - floor) / stiffness, strength: floor, slope: 0.0 }
                }
            }
            Softening::Remoulding { remoulded, rate } => {
                self.solve_remoulding(shear, stiffness, reach, (remoulded, rate))
            }
        }
    }

    /// The left side is convex, so the first Newton step from Δ = 0 lands beyond the root, and the following
    /// ones fall towards it: no step has to be damped.
    #[inline(never)]
    fn solve_remoulding(&self, shear: f64, stiffness: f64, reach: f64, (remoulded, rate): (f64, f64)) -> Shear {
        // Convergence is quadratic; the bound makes the end certain where the slope all but vanishes.
        const STEPS: usize = 64;

        let floor = self.intact * remoulded;
        let lost = (self.intact - floor) * exp(-rate * shear);
        let at = |increment: f64| {
            let rest = lost * exp(-rate * increment);
            Shear { increment, strength: floor + rest, slope: -rate * rest }
        };
        let next = |now: &Shear| {
            let excess = reach - now.strength - stiffness * now.increment;
            now.increment + excess / (stiffness + now.slope)
        };
        let mut now = at(next(&at(0.0)).clamp(0.0, reach / stiffness));
        for _ in 0..STEPS {
            let better = next(&now);
            let falls = better < now.increment && better >= 0.0;
            // Also where it is not a number.
            if !falls {
                break;
            }
            now = at(better);
        }
        now
    }
}

/// Accumulated plastic shear ξ [-], work conjugate to the undrained strength.
#[derive(Clone, Copy, PartialEq, PartialOrd, Debug, Default)]
pub struct PlasticShear(
    /// The sum.
    pub f64,
);

impl History for PlasticShear {
    const NUMBERS: usize = 1;
    const FIELDS: &'static [FieldInfo] = &[FieldInfo { name: "plastic_shear", components: 1, unit: "-" }];

    fn store(&self, to: &mut Vec<f64>) {
        to.push(self.0);
    }

    fn restore(from: &[f64]) -> Result<Self, String> {
        let error = |error: ParameterError| error.to_string();
        ParameterError::unless_not_negative("plastic_shear", from[0]).map(Self).map_err(error)
    }
}

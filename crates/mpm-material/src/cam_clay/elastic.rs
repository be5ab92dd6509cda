//! The elastic skeleton: pressure and shear stress from an energy.

use crate::elementary::{exp, ln};
use crate::lanes::Number;

/// Constants of the energy ψ of [`super::CamClay`], for one point or for four.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Skeleton<T = f64> {
    /// κ.
    pub swelling: T,
    /// G₀.
    pub shear: T,
    /// g.
    pub shear_ratio: T,
    /// p_r.
    pub reference_pressure: T,
}

/// Stresses of elastic strains ε_v and ε_s.
#[derive(Clone, Copy, Debug)]
pub(super) struct Elastic<T> {
    pub p: T,
    pub q: T,
    /// G₀ + g p.
    pub shear_modulus: T,
    /// ∂(p, q)/∂(ε_v, ε_s).
    pub derivative: [[T; 2]; 2],
}

impl Skeleton {
    /// ψ [F/L²].
    pub fn energy(&self, volumetric: f64, shear: f64) -> f64 {
        let p = self.reference_pressure * exp(self.exponent(volumetric, shear));
        self.swelling * p + 1.5 * self.shear * shear * shear
    }

    /// ε_v and ε_s of stresses, p > 0.
    pub fn strains(&self, p: f64, q: f64) -> (f64, f64) {
        let shear = q / (3.0 * (self.shear + self.shear_ratio * p));
        let logarithm = ln(p / self.reference_pressure);
        (1.5 * self.shear_ratio * shear * shear - self.swelling * logarithm, shear)
    }
}

impl<T: Number> Skeleton<T> {
    /// −p = ∂ψ/∂ε_v, q = ∂ψ/∂ε_s.
    #[inline(always)]
    pub fn at(&self, volumetric: T, shear: T) -> Elastic<T> {
        let Self { swelling, shear_ratio, .. } = *self;
        let three = T::of(3.0);
        let p = self.reference_pressure * exp(self.exponent(volumetric, shear));
        let shear_modulus = self.shear + shear_ratio * p;
        // ∂p/∂ε_s = −∂q/∂ε_v.
        let mixed = three * shear_ratio * p * shear / swelling;
        let q_s = three * shear_modulus + three * shear_ratio * shear * mixed;
        let derivative = [[-p / swelling, mixed], [-mixed, q_s]];
        Elastic { p, q: three * shear_modulus * shear, shear_modulus, derivative }
    }

    /// ω = ln(p/p_r).
    #[inline(always)]
    pub fn exponent(&self, volumetric: T, shear: T) -> T {
        (T::of(1.5) * self.shear_ratio * shear * shear - volumetric) / self.swelling
    }
}

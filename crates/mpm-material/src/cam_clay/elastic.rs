//! The elastic skeleton: pressure and shear stress from an energy.

use crate::elementary::{exp, ln};

/// Constants of the energy ψ of [`super::CamClay`].
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Skeleton {
    /// κ.
    pub swelling: f64,
    /// G₀.
    pub shear: f64,
    /// g.
    pub shear_ratio: f64,
    /// p_r.
    pub reference_pressure: f64,
}

/// Stresses of elastic strains ε_v and ε_s.
#[derive(Clone, Copy, Debug)]
pub(super) struct Elastic {
    pub p: f64,
    pub q: f64,
    /// G₀ + g p.
    pub shear_modulus: f64,
    /// ∂(p, q)/∂(ε_v, ε_s).
    pub derivative: [[f64; 2]; 2],
}

impl Skeleton {
    /// −p = ∂ψ/∂ε_v, q = ∂ψ/∂ε_s.
    #[inline]
    pub fn at(&self, volumetric: f64, shear: f64) -> Elastic {
        let Self { swelling, shear_ratio, .. } = *self;
        let p = self.reference_pressure * exp(self.exponent(volumetric, shear));
        let shear_modulus = self.shear + shear_ratio * p;
        // ∂p/∂ε_s = −∂q/∂ε_v.
        let mixed = 3.0 * shear_ratio * p * shear / swelling;
        let q_s = 3.0 * shear_modulus + 3.0 * shear_ratio * shear * mixed;
        let derivative = [[-p / swelling, mixed], [-mixed, q_s]];
        Elastic { p, q: 3.0 * shear_modulus * shear, shear_modulus, derivative }
    }

    /// ω = ln(p/p_r).
    #[inline]
    pub fn exponent(&self, volumetric: f64, shear: f64) -> f64 {
        (1.5 * self.shear_ratio * shear * shear - volumetric) / self.swelling
    }

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

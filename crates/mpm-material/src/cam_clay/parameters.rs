//! Parameters of modified Cam-Clay.

use super::elastic::Skeleton;
use crate::ParameterError;
use crate::lanes::Number;

/// What [`crate::CamClay`] is made of.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct CamClayParameters {
    /// M [-]: q/p at the critical state.
    pub critical_ratio: f64,
    /// λ [-]: slope of ln J against ln p, Kirchhoff's p, in first compression. With λ* of Cauchy's p,
    /// λ = λ*/(1 − λ*).
    pub compression: f64,
    /// κ [-]: the same in unloading.
    pub swelling: f64,
    /// G₀ [F/L²]: the part of the shear modulus G₀ + g p that is constant.
    pub shear: f64,
    /// g [-]: the part of it that grows with p. Alone, ν = (3 − 2gκ)/(6 + 2gκ).
    pub shear_ratio: f64,
    /// p_r [F/L²]: pressure at zero elastic strain.
    pub reference_pressure: f64,
    /// p_c [F/L²] where a point is not given one of its own: twice the pressure at the tip of the yield ellipse.
    pub preconsolidation: f64,
}

/// Those that a trial state meets, of one point or of four, which may have their own.
#[derive(Clone, Copy, Debug)]
pub(super) struct Constants<T> {
    /// κ, G₀, g, and p_r.
    pub skeleton: Skeleton<T>,
    /// M.
    pub critical_ratio: T,
    /// λ.
    pub compression: T,
}

impl CamClayParameters {
    /// # Errors
    /// A parameter is out of range: M, κ, p_r, p_c positive; λ > κ; G₀, g not negative, and not both zero.
    pub(super) fn check(&self) -> Result<(), ParameterError> {
        let CamClayParameters {
            critical_ratio,
            compression,
            swelling,
            shear,
            shear_ratio,
            reference_pressure,
            preconsolidation,
        } = *self;
        ParameterError::unless_positive("critical_ratio", critical_ratio)?;
        ParameterError::unless_positive("swelling", swelling)?;
        let range = compression > swelling && compression.is_finite();
        ParameterError::unless(range, "compression", compression, "a finite number above swelling")?;
        ParameterError::unless_not_negative("shear", shear)?;
        ParameterError::unless_not_negative("shear_ratio", shear_ratio)?;
        let is_stiff = shear > 0.0 || shear_ratio > 0.0;
        ParameterError::unless(is_stiff, "shear", shear, "a positive number where shear_ratio is zero")?;
        ParameterError::unless_positive("reference_pressure", reference_pressure)?;
        ParameterError::unless_positive("preconsolidation", preconsolidation)?;
        Ok(())
    }
}

impl<T: Number> Constants<T> {
    /// Of G₀ [F/L²], M, λ, κ, and g; and p_r [F/L²].
    #[inline(always)]
    pub fn of(
        [shear, critical_ratio, compression, swelling, shear_ratio]: [T; 5],
        reference_pressure: f64,
    ) -> Self {
        let skeleton = Skeleton { swelling, shear, shear_ratio, reference_pressure: T::of(reference_pressure) };
        Self { skeleton, critical_ratio, compression }
    }
}

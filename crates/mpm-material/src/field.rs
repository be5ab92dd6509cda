//! Laws that a nodal field regularises: the field k follows a driver d of the law, and pulls it back.
//!
//! Energy per reference volume besides that of the law (micromorphic models: S. Forest, J. Eng. Mech. 135, 2009):
//!
//! ```text
//! W = ½ h (d − k)² + ½ h l² |Grad k|²
//! ```
//!
//! With the driver κ, the accumulated plastic strain, the yield radius is ρ_y = ρ_loc(κ) + h (κ − k). Written in
//! s_u = ρ_y/√2 and ξ = √2 κ that is s_u(ξ) + ½h (ξ − √2 k), for every law with such a strength.

use std::f64::consts::{PI, SQRT_2};

use nalgebra::Vector3;

use crate::response::PrincipalTrial;
use crate::spectral::Spectrum;
use crate::strength::Shear;
use crate::{Material, NoReturn, ParameterError, Response, SymmetricTensor, UndrainedStrength, Update};

/// What a nodal field follows.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum FieldDriver {
    /// κ, the accumulated plastic strain: against softening of the material.
    PlasticStrain,
    /// m(F), a measure of the total shear: against softening by large elastic strains. It stiffens elasticity, too.
    Strain,
}

/// A nodal field and how it is tied to its driver.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Regularisation {
    driver: FieldDriver,
    modulus: f64,
    length: f64,
}

impl Regularisation {
    /// A field with the modulus h `[F/L²]` and the length l `[L]`.
    ///
    /// # Errors
    /// h or l is not positive and finite.
    pub fn new(driver: FieldDriver, modulus: f64, length: f64) -> Result<Self, ParameterError> {
        ParameterError::unless_positive("modulus", modulus)?;
        ParameterError::unless_positive("length", length)?;
        Ok(Self { driver, modulus, length })
    }

    /// What the field follows.
    pub fn driver(&self) -> FieldDriver {
        self.driver
    }

    /// h `[F/L²]`.
    #[inline]
    pub fn modulus(&self) -> f64 {
        self.modulus
    }

    /// l `[L]`.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Half a wave of a strain that softening by `softening`, −∂ρ/∂κ, lets grow: about the width of a shear band,
    /// π √(A/softening) `[L]`.
    pub fn band_width(&self, softening: f64) -> f64 {
        PI * (self.gradient_modulus() / softening).sqrt()
    }

    /// A = h l², the modulus of the gradient of the field `[F]`.
    #[inline]
    pub fn gradient_modulus(&self) -> f64 {
        self.modulus * self.length * self.length
    }
}

/// The nodal field at a point.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct FieldCoupling {
    /// h `[F/L²]`.
    pub modulus: f64,
    /// k `[-]`.
    pub value: f64,
}

/// An update under a nodal field.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct FieldUpdate<H> {
    /// Stress, tangent and history under the field.
    pub update: Update<H>,
    /// ∂τ_a/∂k `[F/L²]`, which is −h ∂d/∂ε_aᵗʳ.
    pub by_field: Vector3<f64>,
    /// d after the update `[-]`.
    pub driver: f64,
    /// ∂d/∂k `[-]`.
    pub driver_by_field: f64,
}

/// A law whose plastic strain can drive a nodal field.
pub trait Regularisable: Material {
    /// κ = Σ|Δε_p| (Frobenius norm, for laws with one yield radius; else ξ/√2) `[-]`.
    fn plastic_strain(&self, history: &Self::History) -> f64;

    /// The largest −∂ρ_loc/∂κ `[F/L²]`; 0 or less where nothing softens.
    fn fastest_softening(&self) -> f64;

    /// As [`Material::update`], with the yield radius ρ_loc(κ) + h (κ − k).
    ///
    /// # Errors
    /// As of [`Material::update`], and where the field leaves the point no strength.
    fn update_with_field(
        &self,
        trial: &Vector3<f64>,
        history: &Self::History,
        field: FieldCoupling,
    ) -> Result<FieldUpdate<Self::History>, NoReturn>;
}

/// The field is so far above the plastic strain that no strength is left.
pub(crate) const NO_STRENGTH: NoReturn = NoReturn { reason: "the regularising field leaves it no strength" };

impl<H> FieldUpdate<H> {
    /// An update whose driver the field does not change.
    #[inline]
    pub fn uncoupled(update: Update<H>, driver: f64) -> Self {
        Self { update, by_field: Vector3::zeros(), driver, driver_by_field: 0.0 }
    }
}

impl FieldCoupling {
    /// ½h (ξ − √2 k), what the field adds to an undrained strength `[F/L²]`; ξ is `shear`.
    #[inline]
    pub(crate) fn added_strength(&self, shear: f64) -> f64 {
        0.5 * self.modulus * (shear - SQRT_2 * self.value)
    }

    /// As `strength.solve`, with what the field adds to strength and slope.
    #[inline]
    pub(crate) fn solve(&self, strength: &UndrainedStrength, shear: f64, stiffness: f64, reach: f64) -> Shear {
        let half = 0.5 * self.modulus;
        let added = self.added_strength(shear);
        let local = strength.solve(shear, stiffness + half, reach - added);
        Shear {
            increment: local.increment,
            strength: local.strength + added + half * local.increment,
            slope: local.slope + half,
        }
    }
}

/// Answer of a point under a nodal field.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct FieldResponse<H> {
    /// As of [`crate::respond`].
    pub response: Response<H>,
    /// ∂τ/∂k `[F/L²]`; a displacement gradient l of the end of the step changes d by −(∂τ/∂k : l)/h.
    pub by_field: SymmetricTensor,
    /// d after the update `[-]`.
    pub driver: f64,
    /// ∂d/∂k `[-]`.
    pub driver_by_field: f64,
}

/// As [`crate::respond`], of an `answer` in principal axes that knows the field at the point.
///
/// # Errors
/// What `answer` says.
#[inline]
pub fn respond_with_field<H>(
    answer: impl FnOnce(&Vector3<f64>) -> Result<FieldUpdate<H>, NoReturn>,
    trial_excess: &SymmetricTensor,
) -> Result<FieldResponse<H>, NoReturn> {
    let trial = PrincipalTrial::of(Spectrum::of(trial_excess));
    let FieldUpdate { update, by_field, driver, driver_by_field } = answer(&trial.strain.into())?;
    let by_field = trial.frame.compose(&by_field.into());
    Ok(FieldResponse { response: trial.response(update, trial_excess), by_field, driver, driver_by_field })
}

//! Isotropic elastic constants.

use nalgebra::Vector3;

use crate::ParameterError;
use crate::deviator::Deviator;

/// Elastic constants of an isotropic material, both positive.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Elasticity {
    bulk: f64,
    shear: f64,
}

impl Elasticity {
    /// From Young's modulus E [F/L²] and Poisson's ratio ν [-]:
    /// K = E / 3(1 − 2ν), G = E / 2(1 + ν).
    pub fn from_young_poisson(young: f64, poisson: f64) -> Result<Self, ParameterError> {
        ParameterError::unless_positive("young", young)?;
        if !(poisson > -1.0 && poisson < 0.5) {
            let expected = "a number between -1 and 0.5, both excluded";
            return Err(ParameterError { name: "poisson", value: poisson, expected });
        }
        Ok(Self { bulk: young / (3.0 * (1.0 - 2.0 * poisson)), shear: young / (2.0 * (1.0 + poisson)) })
    }

    /// From the bulk modulus K and the shear modulus G [F/L²].
    ///
    /// # Errors
    /// One of them is not positive and finite.
    pub fn from_bulk_shear(bulk: f64, shear: f64) -> Result<Self, ParameterError> {
        let bulk = ParameterError::unless_positive("bulk", bulk)?;
        Ok(Self { bulk, shear: ParameterError::unless_positive("shear", shear)? })
    }

    /// The same shear modulus with a bulk modulus that is larger by `bulk` ≥ 0 [F/L²].
    #[inline]
    pub(crate) fn stiffened(&self, bulk: f64) -> Self {
        Self { bulk: self.bulk + bulk, ..*self }
    }

    /// As [`Self::from_bulk_shear`], of moduli that are known to be positive [F/L²].
    #[inline]
    pub(crate) fn of_moduli(bulk: f64, shear: f64) -> Self {
        Self { bulk, shear }
    }

    /// Bulk modulus K [F/L²].
    #[inline]
    pub fn bulk(&self) -> f64 {
        self.bulk
    }

    /// Shear modulus G [F/L²].
    #[inline]
    pub fn shear(&self) -> f64 {
        self.shear
    }

    /// First Lamé constant λ = K − ⅔ G [F/L²].
    #[inline]
    pub fn lame(&self) -> f64 {
        self.bulk - 2.0 / 3.0 * self.shear
    }

    /// P-wave modulus λ + 2G [F/L²]: stiffness against stretch without lateral strain.
    #[inline]
    pub fn p_wave(&self) -> f64 {
        self.bulk + 4.0 / 3.0 * self.shear
    }

    /// The same Poisson's ratio with Young's modulus `young` > 0 [F/L²].
    #[inline]
    pub(crate) fn with_young(&self, young: f64) -> Self {
        let factor = young / self.young();
        Self { bulk: self.bulk * factor, shear: self.shear * factor }
    }

    /// Energy ½ K (tr ε)² + G |dev ε|² per reference volume [F/L²] of principal strains, where stress is linear in
    /// logarithmic strain.
    pub fn energy(&self, strain: &Vector3<f64>) -> f64 {
        let split = Deviator::<f64>::of(&(*strain).into());
        0.5 * self.bulk * split.volumetric * split.volumetric + self.shear * split.norm * split.norm
    }

    /// Principal strains that carry principal stresses, where stress is linear in logarithmic strain.
    pub fn strain(&self, stress: &Vector3<f64>) -> Vector3<f64> {
        let split = Deviator::<f64>::of(&(*stress).into());
        (Vector3::from(split.strain) / (2.0 * self.shear)).add_scalar(split.volumetric / (9.0 * self.bulk))
    }

    /// Young's modulus E = 9KG / (3K + G) [F/L²].
    #[inline]
    pub fn young(&self) -> f64 {
        9.0 * self.bulk * self.shear / (3.0 * self.bulk + self.shear)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_agree_with_the_textbook() {
        let (young, poisson) = (210.0, 0.3);
        let elasticity = Elasticity::from_young_poisson(young, poisson).expect("in range");
        let lame = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
        let (k, g) = (elasticity.bulk(), elasticity.shear());
        assert!((elasticity.lame() - lame).abs() < 1e-12 * lame);
        assert!((elasticity.p_wave() - (lame + 2.0 * g)).abs() < 1e-12 * lame);
        assert!((elasticity.young() - young).abs() < 1e-12 * young);
        assert!((k - young / (3.0 * (1.0 - 2.0 * poisson))).abs() < 1e-12 * k);
        assert!((g - young / (2.0 * (1.0 + poisson))).abs() < 1e-12 * g);
    }

    #[test]
    fn parameters_out_of_range_are_named() {
        for young in [0.0, -1.0, f64::INFINITY] {
            let error = Elasticity::from_young_poisson(young, 0.3).expect_err("out of range");
            assert_eq!((error.name, error.value), ("young", young));
        }
        for poisson in [-1.0, 0.5, 2.0, f64::NEG_INFINITY] {
            let error = Elasticity::from_young_poisson(1.0, poisson).expect_err("out of range");
            assert_eq!((error.name, error.value), ("poisson", poisson));
        }
        assert!(Elasticity::from_young_poisson(f64::NAN, 0.3).is_err());
        assert!(Elasticity::from_young_poisson(1.0, f64::NAN).is_err());
        assert!(Elasticity::from_young_poisson(1.0, -0.99).is_ok());
    }
}

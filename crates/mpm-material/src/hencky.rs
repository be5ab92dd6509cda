//! Hencky elasticity: linear in the logarithmic strain.

use nalgebra::{Matrix3, Vector3};

use crate::{Elasticity, Material, NoReturn, PointParameters, Update};

/// Hencky's law τ = λ tr(ε) I + 2G ε, hyperelastic with the energy ½λ (tr ε)² + G ε : ε
/// (Hencky 1928).
///
/// Linear elasticity at small strain, and plausible up to stretches of about 1.3; it stays
/// defined for all of them.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Hencky(
    /// Elastic constants.
    pub Elasticity,
);

impl Hencky {
    /// Kirchhoff stresses τ_a = λ Σ ε_b + 2G ε_a [F/L²] of principal strains.
    #[inline]
    pub(crate) fn stress(&self, strain: &Vector3<f64>) -> Vector3<f64> {
        let (lambda, two_g) = (self.0.lame(), 2.0 * self.0.shear());
        strain.map(|eps| two_g * eps).add_scalar(lambda * strain.sum())
    }

    /// What [`Material::update`] answers, which never fails.
    #[inline]
    pub(crate) fn answer(&self, trial: &Vector3<f64>) -> Update<()> {
        let (lambda, two_g) = (self.0.lame(), 2.0 * self.0.shear());
        Update {
            elastic_strain: *trial,
            kirchhoff: self.stress(trial),
            tangent: Matrix3::from_diagonal_element(two_g).add_scalar(lambda),
            secant: Vector3::repeat(two_g),
            plastic: false,
            history: (),
        }
    }
}

impl Material for Hencky {
    type History = ();
    const PLASTIC: bool = false;

    #[inline]
    fn has_symmetric_tangent(&self) -> bool {
        true
    }

    fn initial(&self, _point: &PointParameters) {}

    #[inline]
    fn update(&self, trial: &Vector3<f64>, _history: &()) -> Result<Update<()>, NoReturn> {
        Ok(self.answer(trial))
    }

    fn stored_energy(&self, elastic_strain: &Vector3<f64>, _history: &()) -> f64 {
        self.0.energy(elastic_strain)
    }

    #[inline]
    fn elasticity(&self) -> Elasticity {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn principal_stress_is_linear_in_strain() {
        let elasticity = Elasticity::from_young_poisson(1000.0, 0.25).expect("in range");
        let strain = Vector3::new(0.3, -0.1, 0.05);
        let update = Hencky(elasticity).update(&strain, &()).expect("elastic");
        // E = 1000, nu = 1/4: lambda = G = 400.
        let expected = Vector3::new(340.0, 20.0, 140.0);
        assert!((update.kirchhoff - expected).norm() < 1e-10);
        assert!((update.tangent * strain - expected).norm() < 1e-10);
        assert!((update.secant[2] - (140.0 - 340.0) / (0.05 - 0.3)).abs() < 1e-10);
    }
}

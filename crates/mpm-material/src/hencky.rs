//! Hencky elasticity: linear in the logarithmic strain.

use nalgebra::Vector3;

use crate::lanes::{LANES, Lanes, Mask, Number, each};
use crate::{Elasticity, LaneUpdate, Material, NoReturn, PointParameters, PrincipalUpdate, Update};

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
        self.principal::<f64>(&(*strain).into()).kirchhoff.into()
    }

    /// What [`Material::update`] answers, which never fails.
    #[inline]
    pub(crate) fn answer(&self, trial: &Vector3<f64>) -> Update<()> {
        self.principal::<f64>(&(*trial).into()).with(false, ())
    }

    /// The same of one point or of four.
    #[inline(always)]
    pub(crate) fn principal<T: Number>(&self, trial: &[T; 3]) -> PrincipalUpdate<T> {
        let (lambda, two_g) = (T::of(self.0.lame()), T::of(2.0 * self.0.shear()));
        let mean = lambda * (trial[0] + trial[1] + trial[2]);
        let mut tangent = [[lambda; 3]; 3];
        for (a, row) in tangent.iter_mut().enumerate() {
            row[a] = two_g + lambda;
        }
        PrincipalUpdate {
            elastic_strain: *trial,
            kirchhoff: each(|a| two_g * trial[a] + mean),
            tangent,
            secant: [two_g; 3],
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

    #[inline(always)]
    fn update_lanes(&self, trial: &[Lanes; 3], _history: [&(); LANES]) -> Result<LaneUpdate<()>, NoReturn> {
        Ok(LaneUpdate { principal: self.principal(trial), plastic: Mask::NONE, history: [(); LANES] })
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

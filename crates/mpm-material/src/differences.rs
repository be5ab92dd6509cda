//! A law's answer against differences of its stress: for the tests of a new law.

use nalgebra::{Matrix3, Vector3};

use crate::{Material, NoReturn};

/// By how much a strain is varied on either side [-].
const STEP: f64 = 1e-6;

/// How far a law's derivatives at one trial state are from differences of its stress, as parts of its P-wave modulus.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct DerivativeError {
    /// Largest entry of `∂τ_a/∂ε_b` less central differences over strains of 1e-6.
    pub tangent: f64,
    /// Largest error of a secant, as the stress difference that it makes: `S (ε_a − ε_b) − (τ_a − τ_b)`.
    pub secant: f64,
    /// Largest entry of the tangent less its transpose.
    pub asymmetry: f64,
}

/// Compares tangent and secants of `law` at the principal trial strains `trial` [-] with differences of its stress.
///
/// Strains of order 0.01 and a smooth law give errors of about 1e-9; a wrong entry gives one of its own size. At a trial
/// state nearer than 1e-6 to a border of regions (first yield, an edge, an apex) differences mean nothing.
///
/// ```
/// use mpm_material::{Elasticity, Material, PointParameters, VonMises, derivative_error};
/// use nalgebra::Vector3;
/// let law = VonMises::new(Elasticity::from_young_poisson(1000.0, 0.3)?, 15.0)?;
/// let history = law.initial(&PointParameters::at(Vector3::zeros()));
/// let error = derivative_error(&law, &Vector3::new(0.03, -0.02, 0.01), &history)?;
/// assert!(error.tangent < 1e-8 && error.secant < 1e-12 && error.asymmetry < 1e-12, "{error:?}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// What the law's [`Material::update`] says at `trial` or beside it.
pub fn derivative_error<M: Material>(
    law: &M,
    trial: &Vector3<f64>,
    history: &M::History,
) -> Result<DerivativeError, NoReturn> {
    let update = law.update(trial, history)?;
    let mut differences = Matrix3::zeros();
    for b in 0..3 {
        let beside = |by: f64| {
            let mut strain = *trial;
            strain[b] += by;
            law.update(&strain, history).map(|it| it.kirchhoff)
        };
        differences.set_column(b, &((beside(STEP)? - beside(-STEP)?) / (2.0 * STEP)));
    }
    let size = law.elasticity().p_wave();
    let secant = [(0, 1), (1, 2), (2, 0)].into_iter().zip(&update.secant).map(|((a, b), secant)| {
        (secant * (trial[a] - trial[b]) - (update.kirchhoff[a] - update.kirchhoff[b])).abs()
    });
    Ok(DerivativeError {
        tangent: largest((update.tangent - differences).iter().map(|it| it.abs())) / size,
        secant: largest(secant) / size,
        asymmetry: largest((update.tangent - update.tangent.transpose()).iter().map(|it| it.abs())) / size,
    })
}

/// The largest of non-negative numbers; NaN if there is one, which `f64::max` would pass over.
fn largest(numbers: impl Iterator<Item = f64>) -> f64 {
    numbers.fold(0.0, |most: f64, it| if it > most || it.is_nan() { it } else { most })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Elasticity, Hencky, PointParameters, Update};

    /// Hencky's law with one wrong number.
    struct Wrong(Hencky, fn(&mut Update<()>));

    impl Material for Wrong {
        type History = ();
        const PLASTIC: bool = false;

        fn has_symmetric_tangent(&self) -> bool {
            true
        }

        fn initial(&self, _point: &PointParameters) {}

        fn stored_energy(&self, elastic_strain: &Vector3<f64>, history: &()) -> f64 {
            self.0.stored_energy(elastic_strain, history)
        }

        fn update(&self, trial: &Vector3<f64>, history: &()) -> Result<Update<()>, NoReturn> {
            let mut update = self.0.update(trial, history)?;
            self.1(&mut update);
            Ok(update)
        }

        fn elasticity(&self) -> Elasticity {
            self.0.elasticity()
        }
    }

    #[test]
    fn a_wrong_number_is_found() -> Result<(), Box<dyn std::error::Error>> {
        let hencky = Hencky(Elasticity::from_young_poisson(1000.0, 0.3)?);
        let error = |mend: fn(&mut Update<()>)| {
            derivative_error(&Wrong(hencky, mend), &Vector3::new(0.02, -0.01, 0.03), &())
        };
        let right = error(|_| ())?;
        assert!(right.tangent < 1e-8 && right.secant < 1e-14 && right.asymmetry == 0.0, "{right:?}");
        assert!(error(|it| it.tangent[(0, 1)] *= 1.001)?.tangent > 1e-5);
        assert!(error(|it| it.tangent[(0, 1)] *= 1.001)?.asymmetry > 1e-5);
        assert!(error(|it| it.secant[2] *= 1.001)?.secant > 1e-6);
        assert!(error(|it| it.tangent[(2, 2)] = f64::NAN)?.tangent.is_nan());
        Ok(())
    }
}

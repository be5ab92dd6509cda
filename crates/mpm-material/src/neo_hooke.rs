//! Compressible neo-Hooke elasticity.

use nalgebra::Vector3;

use crate::elementary::{exp_m1, ln_1p};
use crate::lanes::{LANES, Lanes, Mask, Number, each};
use crate::{
    Elasticity, LaneUpdate, Material, NoReturn, ParameterError, PointParameters, PrincipalUpdate, Update,
};

/// Compressible neo-Hookean elasticity with the energy, per reference volume,
///
/// ψ = ½ G (λ₁² + λ₂² + λ₃² − 3 − 2 ln J) + ½ λ (ln J)²,   λ = K − ⅔ G,
///
/// λ_a the principal stretches (Bonet and Wood 2008, section 6.4.3), so that
///
/// τ_a = G (λ_a² − 1) + λ ln J = G expm1(2ε_a) + λ Σ ε_b.
///
/// Unlike Hencky's law it stays elliptic in shear of any size, so that rubber can be turned far: it is
/// polyconvex up to ln J = 1 + G/λ.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct NeoHooke(Elasticity);

impl NeoHooke {
    /// Elastic constants of small strains.
    ///
    /// # Errors
    /// Poisson's ratio is negative: then λ < 0, and the energy falls without bound as a body is crushed.
    pub fn new(elasticity: Elasticity) -> Result<Self, ParameterError> {
        let (k, g) = (elasticity.bulk(), elasticity.shear());
        // At ν = 0 rounding may leave a λ below zero.
        let poisson = (3.0 * k - 2.0 * g) / (2.0 * (3.0 * k + g));
        let range = poisson > -1e-15;
        ParameterError::unless(range, "poisson", poisson, "a number of at least 0 and below 0.5")?;
        Ok(Self(elasticity))
    }

    /// The same law with Young's modulus `young` > 0 [F/L²].
    #[inline]
    pub(crate) fn with_young(&self, young: f64) -> Self {
        Self(self.0.with_young(young))
    }

    /// What the law answers to one trial state or four. Secants are G (λ_a² − λ_b²)/δ = 2G λ_a λ_b (sinh δ)/δ, δ = ε_a − ε_b.
    #[inline(always)]
    fn principal<T: Number>(&self, trial: &[T; 3]) -> PrincipalUpdate<T> {
        let (g, lambda) = (T::of(self.0.shear()), T::of(self.0.lame()));
        let (one, two_g) = (T::of(1.0), T::of(2.0 * self.0.shear()));
        let excess: [T; 3] = each(|a| exp_m1(T::of(2.0) * trial[a]));
        let secant = |a: usize, b: usize| {
            let (difference, gap) = (excess[a] - excess[b], trial[a] - trial[b]);
            let both = ((one + excess[a]) * (one + excess[b])).root();
            let series = two_g * both * (one + sinh_ratio_m1(gap * gap));
            T::pick((gap * gap).below(T::of(0.01)), series, g * difference / gap)
        };
        let mean = lambda * (trial[0] + trial[1] + trial[2]);
        let mut tangent = [[lambda; 3]; 3];
        for (a, row) in tangent.iter_mut().enumerate() {
            row[a] = (excess[a] + one) * two_g + lambda;
        }
        PrincipalUpdate {
            elastic_strain: *trial,
            kirchhoff: each(|a| excess[a] * g + mean),
            tangent,
            secant: [secant(0, 1), secant(1, 2), secant(2, 0)],
        }
    }

    /// Energy ψ per reference volume [F/L²] of principal logarithmic strains.
    pub fn energy(&self, strain: &Vector3<f64>) -> f64 {
        let volumetric = strain.sum();
        // λ_a² − 1 − 2 ln λ_a, summed.
        let shape: f64 = strain.iter().map(|&eps| exp_m1(2.0 * eps) - 2.0 * eps).sum();
        0.5 * self.0.shear() * shape + 0.5 * self.0.lame() * volumetric * volumetric
    }
}

/// (sinh x)/x − 1 for x² = `square` < 0.01, by its series Σ x²ᵐ/(2m+1)!; the first term left out is 3e-18.
#[inline(always)]
fn sinh_ratio_m1<T: Number>(square: T) -> T {
    let (one, part) = (T::of(1.0), |by: f64| square / T::of(by));
    part(6.0) * (one + part(20.0) * (one + part(42.0) * (one + part(72.0))))
}

impl Material for NeoHooke {
    type History = ();
    const PLASTIC: bool = false;

    #[inline]
    fn has_symmetric_tangent(&self) -> bool {
        true
    }

    fn initial(&self, _point: &PointParameters) {}

    #[inline]
    fn update(&self, trial: &Vector3<f64>, _history: &()) -> Result<Update<()>, NoReturn> {
        Ok(self.principal::<f64>(&(*trial).into()).with(false, ()))
    }

    #[inline(always)]
    fn update_lanes(&self, trial: &[Lanes; 3], _history: [&(); LANES]) -> Result<LaneUpdate<()>, NoReturn> {
        Ok(LaneUpdate { principal: self.principal(trial), plastic: Mask::NONE, history: [(); LANES] })
    }

    fn stored_energy(&self, elastic_strain: &Vector3<f64>, _history: &()) -> f64 {
        self.energy(elastic_strain)
    }

    /// λ_a² = 1 + (τ_a − λ v)/G, where v = ln J solves v = ½ Σ ln λ_a²: the right side falls as v grows, so there is
    /// one solution. Newton's method from the volume change of small strains.
    fn elastic_strain(&self, kirchhoff: &Vector3<f64>, _history: &()) -> Result<Vector3<f64>, NoReturn> {
        const STEPS: usize = 100;

        // At ν = 0 rounding may leave a λ below zero.
        let (g, lambda) = (self.0.shear(), self.0.lame().max(0.0));
        let strain = |volume: f64| kirchhoff.map(|tau| 0.5 * ln_1p((tau - lambda * volume) / g));
        // Where no square is positive, the volume has to shrink.
        let largest = (kirchhoff.min() + g) / lambda;
        let mut volume = (kirchhoff.sum() / (3.0 * self.0.bulk())).min(largest - 1e-3 * (1.0 + largest.abs()));
        for _ in 0..STEPS {
            let residual = strain(volume).sum() - volume;
            let slope: f64 = kirchhoff.iter().map(|tau| -0.5 * lambda / (g + tau - lambda * volume)).sum();
            let next = volume - residual / (slope - 1.0);
            let better = if next < largest { next } else { 0.5 * (volume + largest) };
            if (better - volume).abs() <= 1e-16 * volume.abs() || better == volume {
                break;
            }
            volume = better;
        }
        Ok(strain(volume))
    }

    #[inline]
    fn elasticity(&self) -> Elasticity {
        self.0
    }
}

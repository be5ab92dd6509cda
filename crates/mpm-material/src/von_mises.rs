//! Von Mises plasticity, associated, perfect or with a strength that changes: the radial return.

use std::f64::consts::SQRT_2;

use nalgebra::Vector3;

use crate::field::NO_STRENGTH;
use crate::lanes::{LANES, Lanes, Mask, Number, each, four};
use crate::law::{YIELD_TOLERANCE, strain_of};
use crate::{
    Elasticity, FieldCoupling, FieldInfo, FieldUpdate, Hencky, History, LaneUpdate, Material, NoReturn,
    ParameterError, PointParameters, PrincipalUpdate, Regularisable, UndrainedStrength, Update,
};

/// Von Mises plasticity with Hencky elasticity: |dev τ| ≤ ρ_y = √2 s_u(ξ), ξ = √2 Σ|Δε_p|.
///
/// With the exponential map the return keeps its small-strain form in logarithmic strains
/// (Simo 1992). The flow preserves volume. With ρ_y = √2 s_u a plane problem has the limit load of a material
/// with the shear strength s_u; in triaxial compression the law bears q = √3 s_u.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct VonMises {
    elasticity: Elasticity,
    yield_radius: f64,
    /// Read only where it is not perfect.
    strength: UndrainedStrength,
}

/// Accumulated plastic strain Σ|Δε_p| [-], Frobenius norm, over the load steps of a point.
#[derive(Clone, Copy, PartialEq, PartialOrd, Debug, Default)]
pub struct PlasticStrain(
    /// The sum.
    pub f64,
);

impl History for PlasticStrain {
    const NUMBERS: usize = 1;
    const FIELDS: &'static [FieldInfo] = &[FieldInfo { name: "plastic_strain", components: 1, unit: "-" }];

    fn store(&self, to: &mut Vec<f64>) {
        to.push(self.0);
    }

    fn restore(from: &[f64]) -> Result<Self, String> {
        if from[0] < 0.0 {
            return Err(format!("the accumulated plastic strain is {}, expected 0 or more", from[0]));
        }
        Ok(Self(from[0]))
    }
}

impl VonMises {
    /// `yield_radius` is ρ_y = |dev τ| = √(2 J₂) at yield [F/L²]. The uniaxial yield stress is
    /// √(3/2) ρ_y, the shear strength ρ_y/√2.
    pub fn new(elasticity: Elasticity, yield_radius: f64) -> Result<Self, ParameterError> {
        let yield_radius = ParameterError::unless_positive("yield_radius", yield_radius)?;
        let strength = UndrainedStrength::perfect(yield_radius / SQRT_2)?;
        Ok(Self { elasticity, yield_radius, strength })
    }

    /// ρ_y = √2 s_u(ξ).
    ///
    /// # Errors
    /// A strength that softens as fast as the shear modulus, or faster: the point would snap back.
    pub fn with_strength(elasticity: Elasticity, strength: UndrainedStrength) -> Result<Self, ParameterError> {
        let law = Self { elasticity, yield_radius: SQRT_2 * strength.intact(), strength };
        strength.check(elasticity.shear(), "below the shear modulus, or a point snaps back").map(|()| law)
    }

    /// The same law with other E and ρ_y, both positive [F/L²].
    #[inline]
    pub(crate) fn with_values(&self, young: f64, yield_radius: f64) -> Self {
        let strength = self.strength.with_intact(yield_radius / SQRT_2);
        Self { elasticity: self.elasticity.with_young(young), yield_radius, strength }
    }

    /// Yield radius ρ_y before any plastic strain [F/L²].
    #[inline]
    pub fn yield_radius(&self) -> f64 {
        self.yield_radius
    }
}

impl Material for VonMises {
    type History = PlasticStrain;
    const PLASTIC: bool = true;

    #[inline]
    fn has_symmetric_tangent(&self) -> bool {
        true
    }

    fn initial(&self, _point: &PointParameters) -> PlasticStrain {
        PlasticStrain::default()
    }

    /// With the deviator e of the trial strain, s = 2G e, ρ = |s| and n = s/ρ, a plastic point
    /// keeps the fraction β = ρ_y/ρ of e:
    ///
    /// τ = K tr(ε) 1 + β s, ε_e = ⅓ tr(ε) 1 + β e,
    /// ∂τ/∂ε = K 1⊗1 + 2Gβ (I − ⅓ 1⊗1 − n⊗n) + 2G h/(h + G) n⊗n, h = s_u'(ξ).
    ///
    /// Where the strength changes, s_u(ξ + Δ) + G Δ = ρ/√2 is solved before.
    #[inline]
    fn update(&self, trial: &Vector3<f64>, history: &PlasticStrain) -> Result<Update<PlasticStrain>, NoReturn> {
        let is_perfect = self.strength.is_perfect();
        let shear = SQRT_2 * history.0;
        let rho_y = if is_perfect { self.yield_radius } else { SQRT_2 * self.strength.at(shear) };

        let reached = Return::of(&self.elasticity, &(*trial).into());
        let Return { rho, two_g, .. } = reached;
        if rho > rho_y * (1.0 + YIELD_TOLERANCE) {
            let (rho_y, hardening) = if is_perfect {
                (rho_y, 0.0)
            } else {
                let g = self.elasticity.shear();
                let solution = self.strength.solve(shear, g, rho / SQRT_2);
                (SQRT_2 * solution.strength, two_g * solution.slope / (solution.slope + g))
            };
            let flow = reached.flow(rho_y);
            Ok(reached.answer(rho_y, hardening).with(true, PlasticStrain(history.0 + flow)))
        } else {
            Ok(Hencky(self.elasticity).answer(trial).with_history(*history))
        }
    }

    /// Four points at once where the strength stays.
    #[inline(always)]
    fn update_lanes(
        &self,
        trial: &[Lanes; 3],
        history: [&PlasticStrain; LANES],
    ) -> Result<LaneUpdate<PlasticStrain>, NoReturn> {
        if !self.strength.is_perfect() {
            let of = |k: usize| self.update(&strain_of(trial, k), history[k]);
            return Ok(LaneUpdate::of([of(0)?, of(1)?, of(2)?, of(3)?]));
        }
        let elastic = Hencky(self.elasticity).principal(trial);
        let reached = Return::of(&self.elasticity, trial);
        let plastic = reached.rho.above(Lanes::of(self.yield_radius * (1.0 + YIELD_TOLERANCE)));
        if !Lanes::any(plastic) {
            return Ok(LaneUpdate { principal: elastic, plastic, history: four(|k| *history[k]) });
        }
        let radius = Lanes::of(self.yield_radius);
        let returned = reached.answer(radius, Lanes::ZERO);
        Ok(LaneUpdate::returned(plastic, (&returned, reached.flow(radius)), &elastic, history))
    }

    fn stored_energy(&self, elastic_strain: &Vector3<f64>, _history: &PlasticStrain) -> f64 {
        self.elasticity.energy(elastic_strain)
    }

    fn undrained_strength(&self, history: &PlasticStrain) -> Option<f64> {
        Some(self.strength.at(SQRT_2 * history.0))
    }

    #[inline]
    fn elasticity(&self) -> Elasticity {
        self.elasticity
    }
}

impl LaneUpdate<PlasticStrain> {
    /// Answers of four points: those that yield are returned and flow by so much, the others are elastic.
    #[inline(always)]
    pub(crate) fn returned(
        plastic: Mask,
        (returned, flow): (&PrincipalUpdate<Lanes>, Lanes),
        elastic: &PrincipalUpdate<Lanes>,
        history: [&PlasticStrain; LANES],
    ) -> Self {
        let before = Lanes(four(|k| history[k].0));
        let after = Lanes::pick(plastic, before + flow, before);
        let principal = PrincipalUpdate::pick(plastic, returned, elastic);
        Self { principal, plastic, history: four(|k| PlasticStrain(after.0[k])) }
    }
}

/// A trial state, or four, seen from the yield surface.
struct Return<T> {
    /// tr ε.
    volumetric: T,
    /// Deviator of the trial strain.
    e: [T; 3],
    /// 2G |e| [F/L²].
    rho: T,
    two_g: T,
    /// Bulk modulus [F/L²].
    k: T,
}

impl<T: Number> Return<T> {
    #[inline(always)]
    fn of(elasticity: &Elasticity, trial: &[T; 3]) -> Self {
        let (k, two_g) = (T::of(elasticity.bulk()), T::of(2.0 * elasticity.shear()));
        let volumetric = trial[0] + trial[1] + trial[2];
        let mean = volumetric / T::of(3.0);
        let e = each(|a| trial[a] - mean);
        let rho = two_g * (e[0] * e[0] + e[1] * e[1] + e[2] * e[2]).root();
        Self { volumetric, e, rho, two_g, k }
    }

    /// |Δε_p| of the return to the radius `rho_y` [-].
    #[inline(always)]
    fn flow(&self, rho_y: T) -> T {
        (self.rho - rho_y) / self.two_g
    }

    /// The state that is returned to the radius `rho_y`; `hardening` is the modulus along n.
    #[inline(always)]
    fn answer(&self, rho_y: T, hardening: T) -> PrincipalUpdate<T> {
        let Self { volumetric, e, rho, two_g, k } = *self;
        let beta = rho_y / rho;
        let to_n = two_g / rho;
        let n: [T; 3] = each(|a| e[a] * to_n);
        let modulus = two_g * beta;
        let (third, mean, pressure) = (k - modulus / T::of(3.0), volumetric / T::of(3.0), k * volumetric);
        let along = modulus - hardening;
        let tangent = |a: usize, b: usize| {
            let isotropic = if a == b { modulus + third } else { third };
            isotropic - n[a] * n[b] * along
        };
        PrincipalUpdate {
            elastic_strain: each(|a| e[a] * beta + mean),
            kirchhoff: each(|a| e[a] * modulus + pressure),
            tangent: [each(|b| tangent(0, b)), each(|b| tangent(1, b)), each(|b| tangent(2, b))],
            secant: [modulus; 3],
        }
    }
}

impl Regularisable for VonMises {
    fn plastic_strain(&self, history: &PlasticStrain) -> f64 {
        history.0
    }

    fn fastest_softening(&self) -> f64 {
        2.0 * self.strength.fastest_softening()
    }

    /// With s_u(ξ) + ½h (ξ − √2 k) in the place of s_u(ξ) the return is that of [`Material::update`], and
    /// ∂τ/∂k = −(2G h/D) n, ∂κ/∂k = h/D, D = 2G + ρ_loc' + h = 2 (s_u' + ½h + G).
    fn update_with_field(
        &self,
        trial: &Vector3<f64>,
        history: &PlasticStrain,
        field: FieldCoupling,
    ) -> Result<FieldUpdate<PlasticStrain>, NoReturn> {
        let g = self.elasticity.shear();
        let shear = SQRT_2 * history.0;
        let reached = Return::of(&self.elasticity, &(*trial).into());
        let Return { e, rho, two_g, .. } = reached;
        let local = self.strength.at(shear);
        let strength = local + field.added_strength(shear);
        if rho > SQRT_2 * (strength + YIELD_TOLERANCE * local) {
            let solution = field.solve(&self.strength, shear, g, rho / SQRT_2);
            if solution.strength <= 0.0 {
                return Err(NO_STRENGTH);
            }
            let hardening = two_g * solution.slope / (solution.slope + g);
            let radius = SQRT_2 * solution.strength;
            let after = PlasticStrain(history.0 + reached.flow(radius));
            let update = reached.answer(radius, hardening).with(true, after);
            let driver_by_field = 0.5 * field.modulus / (solution.slope + g);
            let by_field = Vector3::from(e) * (-two_g * two_g * driver_by_field / rho);
            return Ok(FieldUpdate { by_field, driver: update.history.0, driver_by_field, update });
        }
        let update = Hencky(self.elasticity).answer(trial).with_history(*history);
        Ok(FieldUpdate::uncoupled(update, history.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law(yield_radius: f64) -> VonMises {
        let elasticity = Elasticity::from_young_poisson(1000.0, 0.3).expect("in range");
        VonMises::new(elasticity, yield_radius).expect("positive")
    }

    fn deviator(tensor: &Vector3<f64>) -> Vector3<f64> {
        tensor.add_scalar(-tensor.sum() / 3.0)
    }

    #[test]
    fn yield_radius_must_be_positive_and_finite() {
        for radius in [0.0, -1.0, f64::INFINITY] {
            let error = VonMises::new(law(1.0).elasticity(), radius).expect_err("out of range");
            assert_eq!((error.name, error.value), ("yield_radius", radius));
        }
        assert!(VonMises::new(law(1.0).elasticity(), f64::NAN).is_err());
    }

    #[test]
    fn history_returns_as_it_was() {
        let mut numbers = Vec::new();
        PlasticStrain(0.1).store(&mut numbers);
        assert_eq!((numbers.len(), PlasticStrain::restore(&numbers)), (1, Ok(PlasticStrain(0.1))));
        assert!(PlasticStrain::restore(&[-0.1]).is_err());
    }

    #[test]
    fn below_yield_it_is_hencky() {
        let law = law(1e6);
        let strain = Vector3::new(0.2, -0.3, 0.05);
        let elastic = Hencky(law.elasticity()).update(&strain, &()).expect("it returns");
        let update = law.update(&strain, &PlasticStrain(0.7)).expect("it returns");
        assert!(!update.plastic);
        assert_eq!(update.elastic_strain, strain);
        assert_eq!(update.history, PlasticStrain(0.7));
        assert!((update.kirchhoff - elastic.kirchhoff).norm() < 1e-12 * 1000.0);
        assert!((update.tangent - elastic.tangent).norm() < 1e-12 * 1000.0);
        assert_eq!(update.secant, elastic.secant);
    }

    #[test]
    fn returns_to_the_yield_surface_along_the_trial_deviator() {
        let law = law(15.0);
        let strain = Vector3::new(0.2, -0.3, 0.05);
        let update = law.update(&strain, &PlasticStrain(0.25)).expect("it returns");
        let s = deviator(&update.kirchhoff);
        assert!(update.plastic);
        assert!((s.norm() - 15.0).abs() <= 15.0 * 1e-12);
        assert!((s.normalize() - deviator(&strain).normalize()).norm() < 1e-14);
        // Volume is kept by the flow, and the stress is that of the elastic strain left.
        assert!((update.elastic_strain.sum() - strain.sum()).abs() < 1e-16);
        let elastic = Hencky(law.elasticity()).update(&update.elastic_strain, &()).expect("it returns");
        assert!((update.kirchhoff - elastic.kirchhoff).norm() < 1e-12 * update.kirchhoff.norm());
        let flow = (strain - update.elastic_strain).norm();
        assert!((update.history.0 - 0.25 - flow).abs() < 1e-15);
        let secant = (update.kirchhoff[0] - update.kirchhoff[1]) / (strain[0] - strain[1]);
        assert!((update.secant[0] - secant).abs() < 1e-12 * secant);
    }

    #[test]
    fn a_returned_point_is_not_plastic_again() {
        let law = law(15.0);
        for i in 0..200 {
            let angle = 0.1 * f64::from(i);
            let strain = Vector3::new(angle.cos(), (1.7 * angle).sin(), 0.3 * angle.sin());
            let first = law.update(&strain, &PlasticStrain(0.0)).expect("it returns");
            let second = law.update(&first.elastic_strain, &first.history).expect("it returns");
            assert!(first.plastic && !second.plastic, "strain {strain:?}");
        }
    }

    #[test]
    fn tangent_is_the_derivative_of_the_stress() {
        let law = law(15.0);
        let strain = Vector3::new(0.2, -0.3, 0.05);
        let tangent = law.update(&strain, &PlasticStrain(0.0)).expect("it returns").tangent;
        let h = 1e-6;
        for b in 0..3 {
            let stress = |sign: f64| {
                let mut moved = strain;
                moved[b] += sign * h;
                law.update(&moved, &PlasticStrain(0.0)).expect("it returns").kirchhoff
            };
            let difference = (stress(1.0) - stress(-1.0)) / (2.0 * h);
            assert!((tangent.column(b) - difference).norm() < 1e-9 * law.elasticity().p_wave());
        }
    }
}

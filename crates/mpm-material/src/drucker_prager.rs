//! Drucker–Prager plasticity with a dilatancy of its own and a tension cut-off: exact returns to all regions.

use nalgebra::Vector3;

use crate::deviator::Deviator;
use crate::lanes::{LANES, Lanes, Number, each, four};
use crate::law::YIELD_TOLERANCE;
use crate::mohr_coulomb::{check_angles, check_apex_stiffness};
use crate::{
    Apex, Elasticity, Hencky, LaneUpdate, Material, NoReturn, ParameterError, PlasticStrain, PointParameters,
    PrincipalUpdate, Update,
};

/// Perfect Drucker–Prager plasticity with Hencky elasticity. With p = −⅓ tr τ and q = √(3/2) |dev τ|:
///
/// f = q − η p − k ≤ 0, flow from q − η̄ p, η̄ ≤ η; p ≥ −p_t with associated flow.
///
/// Without a cut-off p_t = k/η, so that the apex of the cone is the corner where both meet. k and p_t are
/// Kirchhoff's: Cauchy stresses meet k/J. The tangent is symmetric where η̄ = η only.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct DruckerPrager {
    elasticity: Elasticity,
    /// η [-].
    friction: f64,
    /// η̄ [-].
    dilation: f64,
    /// k [F/L²].
    strength: f64,
    /// p_t [F/L²]; infinite where there is neither friction nor cut-off.
    tension: f64,
    /// q_t = k − η p_t [F/L²], where the cone meets the cut-off; exactly 0 at the apex.
    corner: f64,
    /// Part of the elastic moduli that the tangent has where the law has none.
    apex_stiffness: f64,
}

/// Where the cone meets a Mohr–Coulomb surface of cohesion c and friction φ.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ConeMatch {
    /// Triaxial compression: η = 6 sin φ/(3 − sin φ), k = 6c cos φ/(3 − sin φ). Overrates plane strain
    /// and extension; with φ > 36.9° triaxial extension ends in tension even without cohesion.
    Compression,
    /// Triaxial extension: the same with 3 + sin φ.
    Extension,
    /// Collapse in plane strain with associated flow: η = 3 tan φ/√(3 + 4 tan² φ), k = 3c/√(3 + 4 tan² φ).
    PlaneStrain,
    /// Collapse in plane strain with flow that keeps volume: η = √3 sin φ, k = √3 c cos φ.
    IsochoricPlaneStrain,
}

impl ConeMatch {
    /// η and k/c for an angle [rad].
    fn cone(self, angle: f64) -> (f64, f64) {
        let (sin, cos) = angle.sin_cos();
        let triaxial = |root: f64| (6.0 * sin / root, 6.0 * cos / root);
        match self {
            Self::Compression => triaxial(3.0 - sin),
            Self::Extension => triaxial(3.0 + sin),
            Self::PlaneStrain => {
                let tan = angle.tan();
                let root = (3.0 + 4.0 * tan * tan).sqrt();
                (3.0 * tan / root, 3.0 / root)
            }
            Self::IsochoricPlaneStrain => (3.0_f64.sqrt() * sin, 3.0_f64.sqrt() * cos),
        }
    }
}

impl DruckerPrager {
    /// η = `friction`, η̄ = `dilation` [-] and k = `strength` [F/L²].
    ///
    /// # Errors
    /// `friction` is not in [0, 3) (at 3 the cone holds every compression), `dilation` not in [0, η],
    /// `strength` negative, or zero without friction.
    pub fn new(
        elasticity: Elasticity,
        friction: f64,
        dilation: f64,
        strength: f64,
    ) -> Result<Self, ParameterError> {
        let range = (0.0..3.0).contains(&friction);
        ParameterError::unless(range, "slope", friction, "a number of at least 0 and below 3")?;
        let range = (0.0..=friction).contains(&dilation);
        let expected = "a number of at least 0 and at most the slope of the cone";
        ParameterError::unless(range, "flow_slope", dilation, expected)?;
        ParameterError::unless_not_negative("strength", strength)?;
        let has_strength = strength > 0.0 || friction > 0.0;
        ParameterError::unless(
            has_strength,
            "strength",
            strength,
            "a positive number where there is no friction",
        )?;
        let (tension, corner, apex_stiffness) = (strength / friction, 0.0, 0.0);
        Ok(Self { elasticity, friction, dilation, strength, tension, corner, apex_stiffness })
    }

    /// The same law whose tangent has this `part` of the elastic moduli where p and q are both given: at the apex, and in
    /// the corner of a cut-off. Stresses are unchanged, and Newton's method converges linearly there.
    ///
    /// # Errors
    /// `part` is not in [0, 1].
    pub fn with_apex_stiffness(self, part: f64) -> Result<Self, ParameterError> {
        Ok(Self { apex_stiffness: check_apex_stiffness(part)?, ..self })
    }

    /// The cone that meets Mohr–Coulomb's surface of cohesion c [F/L²] and friction φ `[degrees]` where
    /// `at` says; η̄ follows from ψ as η does from φ.
    ///
    /// # Errors
    /// An angle is not in [0°, 90°), ψ > φ, or what [`Self::new`] refuses.
    pub fn matched(
        elasticity: Elasticity,
        at: ConeMatch,
        cohesion: f64,
        friction: f64,
        dilation: f64,
    ) -> Result<Self, ParameterError> {
        check_angles(friction, dilation)?;
        ParameterError::unless_not_negative("cohesion", cohesion)?;
        let (eta, strength) = at.cone(friction.to_radians());
        let (eta_flow, _) = at.cone(dilation.to_radians());
        Self::new(elasticity, eta, eta_flow, cohesion * strength)
    }

    /// The same law with the cut-off p ≥ −p_t, p_t = `tension` [F/L²].
    ///
    /// # Errors
    /// `tension` is negative, or beyond the apex k/η, where no cut-off would ever act.
    pub fn with_cut_off(self, tension: f64) -> Result<Self, ParameterError> {
        ParameterError::unless_not_negative("tension", tension)?;
        let apex = self.strength / self.friction;
        let expected = "at most the mean tension at the apex, strength / slope";
        ParameterError::unless(tension <= apex, "tension", tension, expected)?;
        let corner = if tension < apex { self.strength - self.friction * tension } else { 0.0 };
        Ok(Self { tension, corner, ..self })
    }

    /// E, k, and p_t [F/L²], η and η̄.
    pub(crate) fn values(&self) -> [f64; 5] {
        // Without friction and cut-off p_t is infinite; what is stored is finite.
        [self.elasticity.young(), self.strength, self.tension.min(f64::MAX), self.friction, self.dilation]
    }

    /// The same law with other values.
    #[inline]
    pub(crate) fn with_values(&self, &[young, strength, tension, friction, dilation]: &[f64; 5]) -> Self {
        let elasticity = self.elasticity.with_young(young);
        let apex = strength / friction;
        let is_cut = tension < apex.min(f64::MAX);
        let corner = if is_cut { strength - friction * tension } else { 0.0 };
        let tension = if is_cut { tension } else { apex };
        Self { elasticity, strength, tension, friction, dilation, corner, ..*self }
    }

    /// Slope η of the cone [-].
    #[inline]
    pub fn friction(&self) -> f64 {
        self.friction
    }

    /// Strength k of the cone [F/L²].
    #[inline]
    pub fn strength(&self) -> f64 {
        self.strength
    }

    /// Regions, exact and exhaustive, where the trial state violates something. With
    /// Δγ = f/(3G + K η η̄), q_t = k − η p_t:
    ///
    /// * cone, where f > 0 and p + K η̄ Δγ ≥ −p_t: p + K η̄ Δγ, q − 3G Δγ (positive by itself);
    /// * cut-off, else, where q ≤ q_t: −p_t, q;
    /// * corner, else (the apex if q_t = 0): −p_t, q_t.
    #[inline(always)]
    fn returned<T: Number>(&self, trial: &Trial<T>) -> (PrincipalUpdate<T>, T) {
        let of = T::of;
        let (k, three_g) = (self.elasticity.bulk(), 3.0 * self.elasticity.shear());
        let (eta, eta_flow) = (self.friction, self.dilation);
        let Trial { split, p: p_trial, q: q_trial, overshoot, .. } = trial;
        let m = three_g + k * eta * eta_flow;
        let delta = *overshoot / of(m);
        let p_cone = *p_trial + of(k * eta_flow) * delta;
        let on_cone = overshoot.above(T::ZERO) & p_cone.compare(of(-self.tension), |p, least| p >= least);
        let on_cut_off = q_trial.compare(of(self.corner), |q, corner| q <= corner);
        let pick = |on_cone_: T, on_cut_off_: T, else_: T| {
            T::pick(on_cone, on_cone_, T::pick(on_cut_off, on_cut_off_, else_))
        };
        let p = T::pick(on_cone, p_cone, of(-self.tension));
        let q = pick(*q_trial - of(three_g) * delta, *q_trial, of(self.corner));
        let part = self.apex_stiffness;
        let a = [
            [
                pick(of(-k + k * k * eta * eta_flow / m), T::ZERO, of(-part * k)),
                pick(of(three_g * k * eta_flow / m), T::ZERO, T::ZERO),
            ],
            [
                pick(of(-three_g * k * eta / m), T::ZERO, T::ZERO),
                pick(of(three_g - three_g * three_g / m), of(three_g), of(part * three_g)),
            ],
        ];
        let added = pick(T::ZERO, T::ZERO, of(part));
        // β = |e_e|/|e|. On the cut-off q may be 0, and β is 1.
        let beta = T::pick(q.compare(*q_trial, |q, trial| q == trial), of(1.0), q / *q_trial);
        let secant = of(2.0 / 3.0 * three_g) * (beta + added);
        let volume = (split.volumetric + p / of(k)) / of(3.0);
        let flow: [T; 3] = each(|i| volume + split.strain[i] * (of(1.0) - beta));
        let principal = PrincipalUpdate {
            elastic_strain: split.strains(-p / of(k), beta),
            kirchhoff: split.stresses(p, q),
            tangent: split.tangent(&a, secant),
            secant: [secant; 3],
        };
        (principal, (flow[0] * flow[0] + flow[1] * flow[1] + flow[2] * flow[2]).root())
    }

    #[inline(always)]
    fn trial<T: Number>(&self, strain: &[T; 3]) -> Trial<T> {
        let split = Deviator::of(strain);
        let p = T::of(-self.elasticity.bulk()) * split.volumetric;
        let q = T::of(3.0 * self.elasticity.shear()) * split.shear();
        let larger = |a: T, b: T| T::pick(a.above(b), a, b);
        let strength = T::of(self.strength);
        let overshoot = q - T::of(self.friction) * p - strength;
        let beyond = larger(overshoot, -p - T::of(self.tension));
        // The size of the stresses, from above.
        let size = larger(p.absolute() + q, strength);
        let yields = beyond.above(T::ZERO) & beyond.above(T::of(YIELD_TOLERANCE) * size);
        Trial { split, p, q, overshoot, yields }
    }
}

/// A trial state, or four, seen from the cone.
struct Trial<T: Number> {
    split: Deviator<T>,
    p: T,
    q: T,
    /// f of the cone.
    overshoot: T,
    yields: T::Mask,
}

impl Material for DruckerPrager {
    type History = PlasticStrain;
    const PLASTIC: bool = true;

    #[inline]
    fn has_symmetric_tangent(&self) -> bool {
        self.dilation == self.friction
    }

    fn initial(&self, _point: &PointParameters) -> PlasticStrain {
        PlasticStrain::default()
    }

    fn apex(&self, _history: &PlasticStrain) -> Option<Apex> {
        let volumetric = self.tension / self.elasticity.bulk();
        let has_apex = volumetric.is_finite() && self.corner == 0.0;
        has_apex.then_some(Apex { volumetric, stiffness: self.apex_stiffness })
    }

    #[inline]
    fn update(&self, trial: &Vector3<f64>, history: &PlasticStrain) -> Result<Update<PlasticStrain>, NoReturn> {
        let reached = self.trial::<f64>(&(*trial).into());
        if reached.yields {
            let (principal, flow) = self.returned(&reached);
            return Ok(principal.with(true, PlasticStrain(history.0 + flow)));
        }
        Ok(Hencky(self.elasticity).answer(trial).with_history(*history))
    }

    /// Four points at once.
    #[inline(always)]
    fn update_lanes(
        &self,
        trial: &[Lanes; 3],
        history: [&PlasticStrain; LANES],
    ) -> Result<LaneUpdate<PlasticStrain>, NoReturn> {
        let principal = Hencky(self.elasticity).principal(trial);
        let reached = self.trial(trial);
        let plastic = reached.yields;
        if !Lanes::any(plastic) {
            return Ok(LaneUpdate { principal, plastic, history: four(|k| *history[k]) });
        }
        let (returned, flow) = self.returned(&reached);
        Ok(LaneUpdate::returned(plastic, (&returned, flow), &principal, history))
    }

    fn stored_energy(&self, elastic_strain: &Vector3<f64>, _history: &PlasticStrain) -> f64 {
        self.elasticity.energy(elastic_strain)
    }

    #[inline]
    fn elasticity(&self) -> Elasticity {
        self.elasticity
    }
}

//! Drucker–Prager plasticity with a dilatancy of its own and a tension cut-off: exact returns to all regions.

use nalgebra::Vector3;

use crate::deviator::Deviator;
use crate::lanes::{LANES, Lanes, Mask, Number, each};
use crate::law::{SURELY_ELASTIC, YIELD_TOLERANCE, strain_of};
use crate::mohr_coulomb::{check_angles, check_apex_stiffness};
use crate::{
    Apex, Elasticity, Hencky, LaneUpdate, Material, NoReturn, ParameterError, PlasticStrain, PointParameters,
    Update,
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
    #[inline]
    fn yielded(&self, split: &Deviator, trial: (f64, f64), history: &PlasticStrain) -> Update<PlasticStrain> {
        let (k, three_g) = (self.elasticity.bulk(), 3.0 * self.elasticity.shear());
        let (eta, eta_flow) = (self.friction, self.dilation);
        let (p, q) = trial;
        let m = three_g + k * eta * eta_flow;
        let overshoot = q - eta * p - self.strength;
        let delta = overshoot / m;
        let mut added = 0.0;
        let (p, q, a) = if overshoot > 0.0 && p + k * eta_flow * delta >= -self.tension {
            let a = [
                [-k + k * k * eta * eta_flow / m, three_g * k * eta_flow / m],
                [-three_g * k * eta / m, three_g - three_g * three_g / m],
            ];
            (p + k * eta_flow * delta, q - three_g * delta, a)
        } else if q <= self.corner {
            (-self.tension, q, [[0.0; 2], [0.0, three_g]])
        } else {
            added = self.apex_stiffness;
            (-self.tension, self.corner, [[-added * k, 0.0], [0.0, added * three_g]])
        };
        // β = |e_e|/|e|. On the cut-off q may be 0, and β is 1.
        let beta = if q == trial.1 { 1.0 } else { q / trial.1 };
        let elastic_strain = split.strains(-p / k, beta);
        let secant = 2.0 / 3.0 * three_g * (beta + added);
        let flow = Vector3::repeat((split.volumetric + p / k) / 3.0) + split.strain * (1.0 - beta);
        Update {
            elastic_strain,
            kirchhoff: split.stresses(p, q),
            tangent: split.tangent(&a, secant),
            secant: Vector3::repeat(secant),
            plastic: true,
            history: PlasticStrain(history.0 + flow.norm()),
        }
    }
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
        let split = Deviator::of(trial);
        let p = -self.elasticity.bulk() * split.volumetric;
        let q = 3.0 * self.elasticity.shear() * split.shear();
        let overshoot = (q - self.friction * p - self.strength).max(-p - self.tension);
        // The size of the stresses, from above.
        if overshoot > 0.0 && overshoot > YIELD_TOLERANCE * (p.abs() + q).max(self.strength) {
            return Ok(self.yielded(&split, (p, q), history));
        }
        Ok(Hencky(self.elasticity).answer(trial).with_history(*history))
    }

    /// Four points at once where they do not yield.
    #[inline(always)]
    fn update_lanes(
        &self,
        trial: &[Lanes; 3],
        history: [&PlasticStrain; LANES],
    ) -> Result<LaneUpdate<PlasticStrain>, NoReturn> {
        let of = Lanes::of;
        let volumetric = trial[0] + trial[1] + trial[2];
        let mean = volumetric / of(3.0);
        let e: [Lanes; 3] = each(|a| trial[a] - mean);
        let norm = (e[0] * e[0] + e[1] * e[1] + e[2] * e[2]).root();
        let p = of(-self.elasticity.bulk()) * volumetric;
        let q = of(3.0 * self.elasticity.shear() * (2.0_f64 / 3.0).sqrt()) * norm;
        let strength = of(self.strength);
        let room = of(SURELY_ELASTIC) * (p.absolute() + q + strength);
        let is_below =
            (q - of(self.friction) * p - strength).below(-room) & (-p - of(self.tension)).below(-room);
        let elastic = Hencky(self.elasticity).principal(trial);
        let alone = |k: usize| self.update(&strain_of(trial, k), history[k]);
        LaneUpdate::elastic_but(elastic, Mask(is_below.0.map(|is_below| !is_below)), history, alone)
    }

    fn stored_energy(&self, elastic_strain: &Vector3<f64>, _history: &PlasticStrain) -> f64 {
        self.elasticity.energy(elastic_strain)
    }

    #[inline]
    fn elasticity(&self) -> Elasticity {
        self.elasticity
    }
}

//! Mohr–Coulomb plasticity with a dilatancy of its own: exact returns to face, edges, and apex.

mod cut_off;

use nalgebra::{Matrix3, Vector3};

use crate::lanes::{LANES, Lanes, Number};
use crate::law::{SURELY_ELASTIC, YIELD_TOLERANCE, strain_of};
use crate::ordered::{Loss, Ordered, extremes, extremes_of_four};
use crate::{
    Apex, Elasticity, Hencky, LaneUpdate, Material, NoReturn, ParameterError, PlasticStrain, PointParameters,
    Update,
};

/// Perfect Mohr–Coulomb plasticity with Hencky elasticity. With τ₁ ≥ τ₂ ≥ τ₃, s = sin φ and t = sin ψ:
///
/// f = τ₁ (1 + s) − τ₃ (1 − s) − 2c cos φ ≤ 0, flow along (1 + t, 0, −1 + t), t ≤ s,
///
/// and where there is a tension cut-off t_c, τ₁ ≤ t_c with associated flow (Rankine). The strength c
/// is Kirchhoff's: Cauchy stresses meet c/J. The tangent is symmetric where ψ = φ only.
///
/// Regions and their order are those of Clausen, Damkilde and Andersen (2007) and de Souza Neto, Perić and
/// Owen (2008, section 8.2). What is left at the apex flows there whatever ψ is.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct MohrCoulomb {
    elasticity: Elasticity,
    /// c [F/L²].
    cohesion: f64,
    /// sin φ and cos φ.
    friction: (f64, f64),
    /// sin ψ.
    dilation: f64,
    /// φ and ψ [degrees].
    angles: (f64, f64),
    /// t_c [F/L²]; infinite where there is none, or where the apex comes first.
    cut_off: f64,
    /// Part of the elastic moduli that the tangent has where the law has none.
    apex_stiffness: f64,
}

/// A return to the cone, in descending order.
struct Returned {
    elastic: [f64; 3],
    loss: Option<Loss>,
    /// As parts of 2G.
    secants: [f64; 3],
}

/// Refuses parts of the elastic moduli at the apex outside [0, 1].
pub(crate) fn check_apex_stiffness(part: f64) -> Result<f64, ParameterError> {
    ParameterError::unless((0.0..=1.0).contains(&part), "apex_stiffness", part, "a part from 0 to 1")
}

/// Refuses angles [degrees] of friction outside [0°, 90°) and of dilation outside [0°, φ].
pub(crate) fn check_angles(friction: f64, dilation: f64) -> Result<(), ParameterError> {
    let range = (0.0..90.0).contains(&friction);
    ParameterError::unless(range, "friction", friction, "an angle of at least 0 and below 90 degrees")?;
    let range = (0.0..=friction).contains(&dilation);
    let expected = "an angle of at least 0 and at most that of friction";
    ParameterError::unless(range, "dilation", dilation, expected).map(|_| ())
}

impl MohrCoulomb {
    /// Cohesion c [F/L²], angles of friction φ and of dilation ψ `[degrees]`.
    ///
    /// # Errors
    /// `cohesion` is negative, `friction` not in [0°, 90°), `dilation` not in [0°, φ]; or there is neither
    /// friction nor cohesion.
    pub fn new(
        elasticity: Elasticity,
        cohesion: f64,
        friction: f64,
        dilation: f64,
    ) -> Result<Self, ParameterError> {
        ParameterError::unless_not_negative("cohesion", cohesion)?;
        check_angles(friction, dilation)?;
        let has_strength = cohesion > 0.0 || friction > 0.0;
        ParameterError::unless(
            has_strength,
            "cohesion",
            cohesion,
            "a positive number where there is no friction",
        )?;
        let angles = (friction, dilation);
        let friction = friction.to_radians().sin_cos();
        let dilation = dilation.to_radians().sin();
        let (cut_off, apex_stiffness) = (f64::INFINITY, 0.0);
        Ok(Self { elasticity, cohesion, friction, dilation, angles, cut_off, apex_stiffness })
    }

    /// The same law whose tangent has this `part` of the elastic moduli where the law has no stiffness: at the apex, and
    /// where three planes meet. Stresses are unchanged, and Newton's method converges linearly there.
    ///
    /// # Errors
    /// `part` is not in [0, 1].
    pub fn with_apex_stiffness(self, part: f64) -> Result<Self, ParameterError> {
        Ok(Self { apex_stiffness: check_apex_stiffness(part)?, ..self })
    }

    /// The same law with the tension cut-off τ_a ≤ t_c, t_c = `strength` [F/L²]: 0 for clay and sand.
    ///
    /// # Errors
    /// `strength` is negative, or beyond the apex c cot φ, where no cut-off would ever act.
    pub fn with_cut_off(self, strength: f64) -> Result<Self, ParameterError> {
        ParameterError::unless_not_negative("tensile_strength", strength)?;
        let apex = self.apex();
        let expected = "at most the tension at the apex, cohesion / tan(friction)";
        ParameterError::unless(strength <= apex, "tensile_strength", strength, expected)?;
        Ok(Self { cut_off: if strength < apex { strength } else { f64::INFINITY }, ..self })
    }

    /// E, c, and t_c, or where none acts the tension at the apex [F/L²]; φ and ψ [degrees].
    pub(crate) fn values(&self) -> [f64; 5] {
        // Without friction there is no apex; what is stored is finite.
        let tension = self.tip().min(f64::MAX);
        [self.elasticity.young(), self.cohesion, tension, self.angles.0, self.angles.1]
    }

    /// The same law with other values.
    #[inline]
    pub(crate) fn with_values(&self, &[young, cohesion, tension, friction, dilation]: &[f64; 5]) -> Self {
        let elasticity = self.elasticity.with_young(young);
        let mut law = Self { elasticity, cohesion, ..*self };
        if (friction, dilation) != self.angles {
            law.angles = (friction, dilation);
            law.friction = friction.to_radians().sin_cos();
            law.dilation = dilation.to_radians().sin();
        }
        law.cut_off = if tension < law.apex().min(f64::MAX) { tension } else { f64::INFINITY };
        law
    }

    /// Tension that all three stresses can reach [F/L²]; infinite where there is no bound.
    #[inline]
    fn tip(&self) -> f64 {
        if self.cut_off.is_finite() { self.cut_off } else { self.apex() }
    }

    /// The tangent where the law has none.
    #[inline]
    fn at_apex(&self) -> Matrix3<f64> {
        let part = self.apex_stiffness;
        let (lambda, two_g) = (self.elasticity.lame(), 2.0 * self.elasticity.shear());
        Matrix3::from_diagonal_element(part * two_g).add_scalar(part * lambda)
    }

    /// Tension that all three stresses bear, c cot φ; infinite without friction.
    #[inline]
    fn apex(&self) -> f64 {
        let (sin, cos) = self.friction;
        // Without friction the quotient is infinite; c and sin φ do not vanish together.
        self.cohesion * cos / sin
    }

    /// f of the plane that belongs to a larger and a smaller stress.
    #[inline]
    fn overshoot(&self, larger: f64, smaller: f64) -> f64 {
        let (sin, cos) = self.friction;
        larger * (1.0 + sin) - smaller * (1.0 - sin) - 2.0 * self.cohesion * cos
    }

    /// Elastic stresses of a strain or of a direction of flow.
    #[inline]
    fn stresses(&self, strain: &[f64; 3]) -> [f64; 3] {
        let (two_g, mean) =
            (2.0 * self.elasticity.shear(), self.elasticity.lame() * strain.iter().sum::<f64>());
        strain.map(|eps| two_g * eps + mean)
    }

    /// Return to the cone alone. On the face a = f/α along the flow,
    ///
    /// α = 4 [G + (K + G/3) s t], D = D_e − (D_e N_g)⊗(D_e N_f)/α,
    ///
    /// right where it leaves the strains in order. Else the gap that it would close first is closed:
    /// on the edge of that gap the sum m of both multipliers is (f₁ + f₂)/(α + β), their difference follows from
    /// the gap. The apex is left where the edge's return passes it.
    #[inline]
    fn on_cone(&self, trial: &Ordered) -> Returned {
        let (k, g) = (self.elasticity.bulk(), self.elasticity.shear());
        let ((s, _), t) = (self.friction, self.dilation);
        let [e1, e2, e3] = trial.strain;
        let (upper, lower) = trial.gaps();
        let tau = self.stresses(&trial.strain);
        let alpha = 4.0 * (g + (k + g / 3.0) * s * t);

        let a = self.overshoot(tau[0], tau[2]) / alpha;
        if upper >= a * (1.0 + t) && lower >= a * (1.0 - t) {
            let elastic = [e1 - a * (1.0 + t), e2, e3 + a * (1.0 - t)];
            let u = self.stresses(&[1.0 + t, 0.0, -1.0 + t]).map(|stress| stress / alpha);
            let loss = Loss { dyad: (u, self.stresses(&[1.0 + s, 0.0, -1.0 + s])), equal: None };
            let secants = [1.0 - a * (1.0 + t) / upper, 1.0 - a * (1.0 - t) / lower, 1.0 - 2.0 * a / (e1 - e3)];
            return Returned { elastic, loss: Some(loss), secants };
        }
        let is_compression = upper * (1.0 - t) < lower * (1.0 + t);
        let edge = if is_compression {
            self.on_edge(trial, &tau, alpha, true)
        } else {
            self.on_edge(trial, &tau, alpha, false)
        };
        if edge.elastic[0] < edge.elastic[2] {
            let strain = self.apex() / (3.0 * k);
            return Returned { elastic: [strain; 3], loss: None, secants: [0.0; 3] };
        }
        edge
    }

    /// On the edge τ₁ = τ₂ (triaxial compression) the planes (1, 3) and (2, 3) are active,
    /// β = 4λ s t + 2G (1 − s)(1 − t); on τ₂ = τ₃ (extension) (1, 3) and (1, 2), β = 4λ s t + 2G (1 + s)(1 + t).
    #[inline]
    fn on_edge(&self, trial: &Ordered, tau: &[f64; 3], alpha: f64, is_compression: bool) -> Returned {
        let (lambda, two_g) = (self.elasticity.lame(), 2.0 * self.elasticity.shear());
        let ((s, _), t) = (self.friction, self.dilation);
        let [e1, e2, e3] = trial.strain;
        let (upper, lower) = trial.gaps();
        let outer = self.overshoot(tau[0], tau[2]);
        if is_compression {
            let beta = 4.0 * lambda * s * t + two_g * (1.0 - s) * (1.0 - t);
            let m = (outer + self.overshoot(tau[1], tau[2])) / (alpha + beta);
            let pair = 0.5 * (e1 + e2) - 0.5 * m * (1.0 + t);
            let elastic = [pair, pair, e3 + m * (1.0 - t)];
            let difference = elastic[0] - elastic[2];
            let u = self.stresses(&[1.0 + t, 1.0 + t, -2.0 * (1.0 - t)]);
            let v = self.stresses(&[1.0 + s, 1.0 + s, -2.0 * (1.0 - s)]);
            let dyad = (u.map(|stress| stress / (2.0 * (alpha + beta))), v);
            let loss = Loss { dyad, equal: Some((0, 1)) };
            Returned { elastic, loss: Some(loss), secants: [0.0, difference / lower, difference / (e1 - e3)] }
        } else {
            let beta = 4.0 * lambda * s * t + two_g * (1.0 + s) * (1.0 + t);
            let m = (outer + self.overshoot(tau[0], tau[1])) / (alpha + beta);
            let pair = 0.5 * (e2 + e3) + 0.5 * m * (1.0 - t);
            let elastic = [e1 - m * (1.0 + t), pair, pair];
            let difference = elastic[0] - elastic[2];
            let u = self.stresses(&[2.0 * (1.0 + t), -1.0 + t, -1.0 + t]);
            let v = self.stresses(&[2.0 * (1.0 + s), -1.0 + s, -1.0 + s]);
            let dyad = (u.map(|stress| stress / (2.0 * (alpha + beta))), v);
            let loss = Loss { dyad, equal: Some((1, 2)) };
            Returned { elastic, loss: Some(loss), secants: [difference / upper, 0.0, difference / (e1 - e3)] }
        }
    }

    #[inline]
    fn yielded(&self, strain: &Vector3<f64>, scale: f64, history: &PlasticStrain) -> Update<PlasticStrain> {
        let trial = Ordered::of(strain);
        let returned = self.on_cone(&trial);
        if self.stresses(&returned.elastic)[0] - self.cut_off > YIELD_TOLERANCE * scale {
            return self.on_cut_off(strain, &trial, scale, history);
        }
        let elastic_strain = trial.by_axis(&returned.elastic);
        let two_g = 2.0 * self.elasticity.shear();
        let (tangent, secants) = match &returned.loss {
            Some(loss) => (trial.tangent(&self.elasticity, loss), returned.secants),
            None => (self.at_apex(), [self.apex_stiffness; 3]),
        };
        let secant = trial.secants(secants) * two_g;
        self.answer(strain, elastic_strain, tangent, secant, history)
    }

    #[inline]
    fn answer(
        &self,
        trial: &Vector3<f64>,
        elastic_strain: Vector3<f64>,
        tangent: Matrix3<f64>,
        secant: Vector3<f64>,
        history: &PlasticStrain,
    ) -> Update<PlasticStrain> {
        let kirchhoff = Hencky(self.elasticity).stress(&elastic_strain);
        let history = PlasticStrain(history.0 + (trial - elastic_strain).norm());
        Update { elastic_strain, kirchhoff, tangent, secant, plastic: true, history }
    }
}

impl Material for MohrCoulomb {
    type History = PlasticStrain;
    const PLASTIC: bool = true;

    #[inline]
    fn has_symmetric_tangent(&self) -> bool {
        self.dilation == self.friction.0
    }

    fn initial(&self, _point: &PointParameters) -> PlasticStrain {
        PlasticStrain::default()
    }

    fn apex(&self, _history: &PlasticStrain) -> Option<Apex> {
        let volumetric = self.tip() / self.elasticity.bulk();
        volumetric.is_finite().then_some(Apex { volumetric, stiffness: self.apex_stiffness })
    }

    #[inline]
    fn update(&self, trial: &Vector3<f64>, history: &PlasticStrain) -> Result<Update<PlasticStrain>, NoReturn> {
        let elastic = Hencky(self.elasticity).answer(trial);
        let (largest, smallest) = extremes(&elastic.kirchhoff);
        let overshoot = self.overshoot(largest, smallest).max(largest - self.cut_off);
        if overshoot > 0.0 {
            let scale = largest.abs().max(smallest.abs()).max(self.cohesion);
            if overshoot > YIELD_TOLERANCE * scale {
                return Ok(self.yielded(trial, scale, history));
            }
        }
        Ok(elastic.with_history(*history))
    }

    /// Four points at once where they do not yield.
    #[inline(always)]
    fn update_lanes(
        &self,
        trial: &[Lanes; 3],
        history: [&PlasticStrain; LANES],
    ) -> Result<LaneUpdate<PlasticStrain>, NoReturn> {
        let of = Lanes::of;
        let elastic = Hencky(self.elasticity).principal(trial);
        let (largest, smallest) = extremes_of_four(&elastic.kirchhoff);
        let (sin, cos) = self.friction;
        let strength = of(self.cohesion);
        let room = of(SURELY_ELASTIC) * (largest.absolute() + smallest.absolute() + strength);
        let overshoot = largest * of(1.0 + sin) - smallest * of(1.0 - sin) - of(2.0 * self.cohesion * cos);
        let is_below = overshoot.below(-room) & (largest - of(self.cut_off)).below(-room);
        let alone = |k: usize| self.update(&strain_of(trial, k), history[k]);
        LaneUpdate::elastic_but(elastic, !is_below, history, alone)
    }

    fn stored_energy(&self, elastic_strain: &Vector3<f64>, _history: &PlasticStrain) -> f64 {
        self.elasticity.energy(elastic_strain)
    }

    #[inline]
    fn elasticity(&self) -> Elasticity {
        self.elasticity
    }
}

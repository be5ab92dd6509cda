//! Tresca plasticity, associated, perfect or with a strength that changes: exact returns to face and edges.

use std::f64::consts::SQRT_2;

use nalgebra::Vector3;

use crate::field::NO_STRENGTH;
use crate::lanes::{LANES, Lanes, Number, four};
use crate::law::{SURELY_ELASTIC, YIELD_TOLERANCE, strain_of};
use crate::ordered::{Loss, Ordered, extremes, extremes_of_four};
use crate::strength::Shear;
use crate::{
    Elasticity, FieldCoupling, FieldUpdate, Hencky, LaneUpdate, Material, NoReturn, ParameterError,
    PlasticShear, PointParameters, Regularisable, UndrainedStrength, Update,
};

/// Tresca plasticity with Hencky elasticity: τ₁ − τ₃ ≤ 2 s_u(ξ), dξ = 2 Σ dλ over the active planes
/// (|dε_1 − dε_3| on a face). The flow preserves volume.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Tresca {
    elasticity: Elasticity,
    strength: UndrainedStrength,
}

impl Tresca {
    /// Elastic constants and undrained shear strength.
    ///
    /// # Errors
    /// A strength that softens as fast as ¾ G, or faster: a point on an edge would snap back.
    pub fn new(elasticity: Elasticity, strength: UndrainedStrength) -> Result<Self, ParameterError> {
        let law = Self { elasticity, strength };
        let expected = "below 3/4 of the shear modulus, or a point on an edge snaps back";
        strength.check(0.75 * elasticity.shear(), expected).map(|()| law)
    }

    /// The same law with other E and s_u, both positive [F/L²].
    #[inline]
    pub(crate) fn with_values(&self, young: f64, strength: f64) -> Self {
        Self { elasticity: self.elasticity.with_young(young), strength: self.strength.with_intact(strength) }
    }

    /// Undrained shear strength.
    #[inline]
    pub fn strength(&self) -> &UndrainedStrength {
        &self.strength
    }

    /// With ε₁ ≥ ε₂ ≥ ε₃, the face's return moves ε₁ and ε₃ by ½Δ each, where
    ///
    /// s_u(ξ + Δ) + G Δ = G (ε₁ − ε₃), D = D_e − G²/(h + G) m⊗m, m = (1, 0, −1), h = s_u'(ξ + Δ).
    ///
    /// It is right if it leaves the strains in order. `solve` finds Δ for a stiffness and a right-hand side.
    #[inline]
    fn yielded(
        &self,
        trial: &Ordered,
        history: &PlasticShear,
        solve: impl Fn(f64, f64) -> Shear,
    ) -> (Update<PlasticShear>, Flow) {
        let g = self.elasticity.shear();
        let [e1, e2, e3] = trial.strain;
        let (upper, lower) = trial.gaps();
        let face = solve(g, g * (e1 - e3));
        let half = 0.5 * face.increment;
        if upper < half || lower < half {
            return self.on_edge(trial, history, solve);
        }
        let m = g / (face.slope + g).sqrt();
        let loss = Loss { dyad: ([m, 0.0, -m], [m, 0.0, -m]), equal: None };
        let secants = [1.0 - half / upper, 1.0 - half / lower, face.strength / (g * (e1 - e3))];
        let update = self.answer(trial, [e1 - half, e2, e3 + half], &loss, secants, history.0 + face.increment);
        (update, Flow { dyad: loss.dyad.0, stiffness: face.slope + g, strength: face.strength })
    }

    /// An edge makes the strains of the smaller gap equal. With w = (1, 1, −2) for τ₁ = τ₂ or (2, −1, −1)
    /// for τ₂ = τ₃, and g the difference of the equal pair (places i and j),
    ///
    /// s_u(ξ + Δ) + ¾G Δ = ½G w·ε, Δε_p = ¼Δ w + ½ (ε_i − ε_j) g,
    /// D = D_e − G g⊗g − ¼G²/(h + ¾G) w⊗w.
    #[inline(never)]
    fn on_edge(
        &self,
        trial: &Ordered,
        history: &PlasticShear,
        solve: impl Fn(f64, f64) -> Shear,
    ) -> (Update<PlasticShear>, Flow) {
        let g = self.elasticity.shear();
        let [e1, e2, e3] = trial.strain;
        let (upper, lower) = trial.gaps();
        let is_compression = upper < lower;
        let (w, reach) = if is_compression {
            ([1.0, 1.0, -2.0], (e1 - e3) + lower)
        } else {
            ([2.0, -1.0, -1.0], upper + (e1 - e3))
        };
        let Shear { increment, strength, slope } = solve(0.75 * g, 0.5 * g * reach);
        let weight = 0.5 * g / (slope + 0.75 * g).sqrt();
        let dyad = w.map(|w| weight * w);
        // τ₁ − τ₃ = 2 s_u and the equal pair leave no freedom but the volume.
        let third = (e1 + e2 + e3) / 3.0;
        let elastic = w.map(|w| third + strength / (3.0 * g) * w);
        let ratio = |gap: f64| strength / (g * gap);
        let (equal, secants) = if is_compression {
            ((0, 1), [0.0, ratio(lower), ratio(e1 - e3)])
        } else {
            ((1, 2), [ratio(upper), 0.0, ratio(e1 - e3)])
        };
        let loss = Loss { dyad: (dyad, dyad), equal: Some(equal) };
        let update = self.answer(trial, elastic, &loss, secants, history.0 + increment);
        (update, Flow { dyad, stiffness: slope + 0.75 * g, strength })
    }

    /// `secants` are parts of 2G.
    #[inline]
    fn answer(
        &self,
        trial: &Ordered,
        elastic: [f64; 3],
        loss: &Loss,
        secants: [f64; 3],
        shear: f64,
    ) -> Update<PlasticShear> {
        let elastic_strain = trial.by_axis(&elastic);
        Update {
            elastic_strain,
            kirchhoff: Hencky(self.elasticity).stress(&elastic_strain),
            tangent: trial.tangent(&self.elasticity, loss),
            secant: trial.secants(secants) * (2.0 * self.elasticity.shear()),
            plastic: true,
            history: PlasticShear(shear),
        }
    }
}

/// How a point flows.
struct Flow {
    /// As in [`Loss`], in descending order [√(F/L²)].
    dyad: [f64; 3],
    /// Derivative of the left side of the return's equation with respect to Δ [F/L²].
    stiffness: f64,
    /// s_u after the return [F/L²].
    strength: f64,
}

impl Regularisable for Tresca {
    fn plastic_strain(&self, history: &PlasticShear) -> f64 {
        history.0 / SQRT_2
    }

    fn fastest_softening(&self) -> f64 {
        2.0 * self.strength.fastest_softening()
    }

    /// With s_u(ξ) + ½h (ξ − √2 k) in the place of s_u(ξ) the return is that of [`Material::update`]. With its equation
    /// s_u + c Δ = t and the vector v of its tangent D_e − v⊗v, ∂τ/∂k = −(h/√2)/√(s_u' + c) v and
    /// ∂κ/∂k = ½h/(s_u' + c), where s_u' holds ½h.
    fn update_with_field(
        &self,
        trial: &Vector3<f64>,
        history: &PlasticShear,
        field: FieldCoupling,
    ) -> Result<FieldUpdate<PlasticShear>, NoReturn> {
        let elastic = Hencky(self.elasticity).answer(trial);
        let local = self.strength.at(history.0);
        let (largest, smallest) = extremes(&elastic.kirchhoff);
        let overshoot = 0.5 * (largest - smallest) - local - field.added_strength(history.0);
        let scale = largest.abs().max(smallest.abs()).max(local);
        if overshoot > YIELD_TOLERANCE * scale {
            let ordered = Ordered::of(trial);
            let solve = |stiffness, reach| field.solve(&self.strength, history.0, stiffness, reach);
            let (update, flow) = self.yielded(&ordered, history, solve);
            if flow.strength <= 0.0 {
                return Err(NO_STRENGTH);
            }
            let by_field = ordered.by_axis(&flow.dyad) * (-field.modulus / (SQRT_2 * flow.stiffness.sqrt()));
            let driver_by_field = 0.5 * field.modulus / flow.stiffness;
            let driver = self.plastic_strain(&update.history);
            return Ok(FieldUpdate { update, by_field, driver, driver_by_field });
        }
        Ok(FieldUpdate::uncoupled(elastic.with_history(*history), self.plastic_strain(history)))
    }
}

impl Material for Tresca {
    type History = PlasticShear;
    const PLASTIC: bool = true;

    #[inline]
    fn has_symmetric_tangent(&self) -> bool {
        true
    }

    fn initial(&self, _point: &PointParameters) -> PlasticShear {
        PlasticShear::default()
    }

    #[inline]
    fn update(&self, trial: &Vector3<f64>, history: &PlasticShear) -> Result<Update<PlasticShear>, NoReturn> {
        let elastic = Hencky(self.elasticity).answer(trial);
        let strength = self.strength.at(history.0);
        let (largest, smallest) = extremes(&elastic.kirchhoff);
        let overshoot = 0.5 * (largest - smallest) - strength;
        if overshoot > 0.0 {
            let scale = largest.abs().max(smallest.abs()).max(strength);
            if overshoot > YIELD_TOLERANCE * scale {
                let solve = |stiffness, reach| self.strength.solve(history.0, stiffness, reach);
                return Ok(self.yielded(&Ordered::of(trial), history, solve).0);
            }
        }
        Ok(elastic.with_history(*history))
    }

    /// Four points at once where they do not yield.
    #[inline(always)]
    fn update_lanes(
        &self,
        trial: &[Lanes; 3],
        history: [&PlasticShear; LANES],
    ) -> Result<LaneUpdate<PlasticShear>, NoReturn> {
        let of = Lanes::of;
        let elastic = Hencky(self.elasticity).principal(trial);
        let (largest, smallest) = extremes_of_four(&elastic.kirchhoff);
        let strength = Lanes(four(|k| self.strength.at(history[k].0)));
        let room = of(SURELY_ELASTIC) * (largest.absolute() + smallest.absolute() + strength);
        let is_below = (of(0.5) * (largest - smallest) - strength).below(-room);
        let alone = |k: usize| self.update(&strain_of(trial, k), history[k]);
        LaneUpdate::elastic_but(elastic, !is_below, history, alone)
    }

    fn stored_energy(&self, elastic_strain: &Vector3<f64>, _history: &PlasticShear) -> f64 {
        self.elasticity.energy(elastic_strain)
    }

    fn undrained_strength(&self, history: &PlasticShear) -> Option<f64> {
        Some(self.strength.at(history.0))
    }

    #[inline]
    fn elasticity(&self) -> Elasticity {
        self.elasticity
    }
}

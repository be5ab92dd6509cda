//! Modified Cam-Clay at finite strain: hyperelastic, associated, hardening with plastic volume.

mod bracket;
mod elastic;
mod parameters;
mod return_map;
mod trial;

use nalgebra::Vector3;

use crate::deviator::Deviator;
use crate::lanes::{LANES, Lanes, Number, each, four};
use crate::law::strain_of;
use crate::{
    Consolidation, Elasticity, FieldInfo, History, LaneUpdate, Material, NoReturn, ParameterError,
    PointParameters, PrincipalUpdate, Update,
};
use elastic::Skeleton;
use parameters::Constants;
use trial::Trial;

pub use parameters::CamClayParameters;

/// Modified Cam-Clay. With p = −⅓ tr τ, q = √(3/2) |dev τ|, ε_v = tr ε and ε_s = √(2/3) |dev ε|, all
/// Kirchhoff's and logarithmic, it is elastic with the energy
///
/// ψ = κ p_r exp(ω) + (3/2) G₀ ε_s²,   ω = −ε_v/κ + 3g ε_s²/(2κ),   p = p_r exp(ω),   q = 3 (G₀ + g p) ε_s,
///
/// yields where f = q²/M² + p (p − p_c) > 0, flows along the gradient of f, and hardens by
///
/// p_c = p_c,n exp(−Δε_v,p/(λ − κ)).
///
/// So all of ln p against ln J is straight, whatever the step (Butterfield 1979), and no energy is made
/// in cycles (the shear modulus as Houlsby, Amorosi and Rojas 2005, with exponent 1). At zero elastic
/// strain p is p_r, not 0; p is positive in every state. Flow is associated, but hardening is not conjugate
/// to it: the tangent of plastic states is not symmetric.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct CamClay {
    skeleton: Skeleton,
    parameters: CamClayParameters,
    /// At zero elastic strain.
    elasticity: Elasticity,
}

/// Preconsolidation pressure p_c [F/L²], Kirchhoff's.
#[derive(Clone, Copy, PartialEq, PartialOrd, Debug, Default)]
pub struct Preconsolidation(
    /// The pressure.
    pub f64,
);

impl History for Preconsolidation {
    const NUMBERS: usize = 1;
    const FIELDS: &'static [FieldInfo] =
        &[FieldInfo { name: "preconsolidation_pressure", components: 1, unit: "F/L²" }];

    fn store(&self, to: &mut Vec<f64>) {
        to.push(self.0);
    }

    fn restore(from: &[f64]) -> Result<Self, String> {
        let error = |error: ParameterError| error.to_string();
        ParameterError::unless_positive("preconsolidation_pressure", from[0]).map(Self).map_err(error)
    }
}

impl CamClay {
    /// # Errors
    /// A parameter is out of range: M, κ, p_r, p_c positive; λ > κ; G₀, g not negative, and not both zero.
    pub fn new(parameters: CamClayParameters) -> Result<Self, ParameterError> {
        parameters.check()?;
        let CamClayParameters { swelling, shear, shear_ratio, reference_pressure, .. } = parameters;
        let bulk = reference_pressure / swelling;
        let elasticity = Elasticity::from_bulk_shear(bulk, shear + shear_ratio * reference_pressure)?;
        let skeleton = Skeleton { swelling, shear, shear_ratio, reference_pressure };
        Ok(Self { skeleton, parameters, elasticity })
    }

    /// Its parameters.
    #[inline]
    pub fn parameters(&self) -> &CamClayParameters {
        &self.parameters
    }

    /// K₀ of first compression without lateral strain: η₀ = ½ [−3Λ + √(9Λ² + 4M²)], K₀ = (3 − η₀)/(3 + 2η₀),
    /// Λ = 1 − κ/λ. Exact for G₀ = 0, and for g = 0 where elastic shear strains are small beside plastic ones.
    pub fn k0(&self) -> f64 {
        let CamClayParameters { critical_ratio, compression, swelling, .. } = self.parameters;
        let hardening = 3.0 * (1.0 - swelling / compression);
        let ratio = 0.5 * ((hardening * hardening + 4.0 * critical_ratio * critical_ratio).sqrt() - hardening);
        (3.0 - ratio) / (3.0 + 2.0 * ratio)
    }

    /// p_c of the yield surface through principal stresses [F/L²], p + q²/(M² p).
    fn preconsolidation(&self, kirchhoff: &Vector3<f64>) -> f64 {
        let split = Deviator::<f64>::of(&(*kirchhoff).into());
        let (p, along) =
            (-split.volumetric / 3.0, 1.5_f64.sqrt() * split.norm / self.parameters.critical_ratio);
        p + along * along / p
    }

    /// G₀ [F/L²], M, λ, κ, and g.
    pub(crate) fn values(&self) -> [f64; 5] {
        let CamClayParameters { critical_ratio, compression, swelling, shear, shear_ratio, .. } =
            self.parameters;
        [shear, critical_ratio, compression, swelling, shear_ratio]
    }

    /// The same law with other values.
    #[inline]
    pub(crate) fn with_values(
        &self,
        &[shear, critical_ratio, compression, swelling, shear_ratio]: &[f64; 5],
    ) -> Self {
        let skeleton = Skeleton { shear, swelling, shear_ratio, ..self.skeleton };
        let parameters =
            CamClayParameters { critical_ratio, compression, swelling, shear, shear_ratio, ..self.parameters };
        let pressure = skeleton.reference_pressure;
        let elasticity = Elasticity::of_moduli(pressure / swelling, shear + shear_ratio * pressure);
        Self { skeleton, parameters, elasticity }
    }

    /// Answers four points with other values each; those that Newton's method does not return are asked one by one.
    #[inline(always)]
    pub(crate) fn update_four(
        &self,
        values: [Lanes; 5],
        strain: &[Lanes; 3],
        history: [&Preconsolidation; LANES],
    ) -> Result<LaneUpdate<Preconsolidation>, NoReturn> {
        let constants = &Constants::of(values, self.skeleton.reference_pressure);
        let before = Lanes(four(|k| history[k].0));
        let trial = Trial::of(constants, strain, before);
        let (elastic, plastic) = (trial.elastic(strain), trial.yields);
        if !Lanes::any(plastic) {
            return Ok(LaneUpdate { principal: elastic, plastic, history: four(|k| *history[k]) });
        }
        let (returned, arrives) = trial.equations(constants, before).starting_at_trial(trial.state.p, plastic);
        let after = Lanes::pick(plastic, returned.preconsolidation, before);
        let principal = PrincipalUpdate::pick(plastic, &trial.plastic(&returned), &elastic);
        let answer = LaneUpdate { principal, plastic, history: four(|k| Preconsolidation(after.0[k])) };
        answer.but(plastic & !arrives, |k| {
            self.alone(&each(|a| values[a].0[k]), &strain_of(strain, k), history[k])
        })
    }

    /// Answers a point that few of four need.
    #[cold]
    #[inline(never)]
    fn alone(
        &self,
        values: &[f64; 5],
        strain: &Vector3<f64>,
        history: &Preconsolidation,
    ) -> Result<Update<Preconsolidation>, NoReturn> {
        self.with_values(values).update(strain, history)
    }
}

impl Material for CamClay {
    type History = Preconsolidation;
    const PLASTIC: bool = true;

    /// Only that of elastic states is.
    #[inline]
    fn has_symmetric_tangent(&self) -> bool {
        false
    }

    fn initial(&self, point: &PointParameters) -> Preconsolidation {
        Preconsolidation(match point.consolidation {
            Consolidation::OfLaw => self.parameters.preconsolidation,
            Consolidation::Pressure(pressure) => pressure,
            Consolidation::Stress(stress) => self.preconsolidation(&stress),
        })
    }

    fn elastic_strain(
        &self,
        kirchhoff: &Vector3<f64>,
        _history: &Preconsolidation,
    ) -> Result<Vector3<f64>, NoReturn> {
        let split = Deviator::<f64>::of(&(*kirchhoff).into());
        let p = -split.volumetric / 3.0;
        // Written so that what is not a number is refused as well.
        if !(p > 0.0 && p.is_finite()) {
            return Err(NoReturn { reason: "the law bears mean pressure above 0 only" });
        }
        let q = 1.5_f64.sqrt() * split.norm;
        let (volumetric, shear) = self.skeleton.strains(p, q);
        Ok((Vector3::from(split.direction()) * (1.5_f64.sqrt() * shear)).add_scalar(volumetric / 3.0))
    }

    fn stored_energy(&self, elastic_strain: &Vector3<f64>, _history: &Preconsolidation) -> f64 {
        let split = Deviator::<f64>::of(&(*elastic_strain).into());
        self.skeleton.energy(split.volumetric, split.shear())
    }

    #[inline]
    fn update(
        &self,
        strain: &Vector3<f64>,
        history: &Preconsolidation,
    ) -> Result<Update<Preconsolidation>, NoReturn> {
        let constants = Constants::of(self.values(), self.skeleton.reference_pressure);
        let strain = (*strain).into();
        let trial = Trial::of(&constants, &strain, history.0);
        if !trial.yields {
            return Ok(trial.elastic(&strain).with(false, *history));
        }
        let returned = trial.equations(&constants, history.0).solve(trial.state.p)?;
        Ok(trial.plastic(&returned).with(true, Preconsolidation(returned.preconsolidation)))
    }

    /// Four points at once, whatever their states.
    #[inline(always)]
    fn update_lanes(
        &self,
        strain: &[Lanes; 3],
        history: [&Preconsolidation; LANES],
    ) -> Result<LaneUpdate<Preconsolidation>, NoReturn> {
        let values = self.values();
        self.update_four(each(|k| Lanes::of(values[k])), strain, history)
    }

    #[inline]
    fn elasticity(&self) -> Elasticity {
        self.elasticity
    }
}

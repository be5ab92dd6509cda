//! Laws of scenes as laws of materials.

use crate::error::SceneError;
use crate::language::{ConeInput, ConeMatchInput, MaterialInput, Poisson, Positive, SofteningInput};
use mpm_material::{
    CamClay, CamClayParameters, ConeMatch, DruckerPrager, Elasticity, Hencky, Material, MohrCoulomb, NeoHooke,
    ParameterError, Tresca, Undrained, UndrainedStrength, VonMises,
};
use std::f64::consts::FRAC_1_SQRT_2;

/// Something that is done with a law, whichever it is.
pub(super) trait WithLaw {
    type Answer;

    fn with<M: Material + 'static>(self, law: M) -> Self::Answer;
}

/// Refuses parameters of a material named `name`.
pub(super) fn check(input: &MaterialInput, name: &str) -> Result<(), SceneError> {
    struct Nothing;
    impl WithLaw for Nothing {
        type Answer = ();

        fn with<M: Material + 'static>(self, _law: M) {}
    }
    with_law(input, Nothing)
        .map_err(|Refused { field, reason }| SceneError::new(format!("materials.{name}{field}"), reason))
}

/// Parameters that a law refuses.
#[derive(Debug)]
pub(super) struct Refused {
    /// Where they stand in the material: nothing, or `.softening.modulus`.
    field: String,
    reason: String,
}

impl std::fmt::Display for Refused {
    fn fmt(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        to.write_str(&self.reason)
    }
}

/// Names the place of a parameter, whose fields stand `inside` another.
fn inside(inside: &'static str) -> impl Fn(ParameterError) -> Refused {
    move |error| Refused { field: format!("{inside}.{}", error.name), reason: error.to_string() }
}

/// Makes the law of `input`, and hands it to `user`.
///
/// # Errors
/// What the law says of its parameters.
pub(super) fn with_law<U: WithLaw>(input: &MaterialInput, user: U) -> Result<U::Answer, Refused> {
    Ok(match *input {
        MaterialInput::Hencky { young, poisson, .. } => user.with(Hencky(elasticity(young, poisson)?)),
        MaterialInput::NeoHooke { young, poisson, .. } => {
            user.with(NeoHooke::new(elasticity(young, poisson)?).map_err(inside(""))?)
        }
        MaterialInput::VonMises { young, poisson, yield_radius, undrained_strength, softening, .. } => {
            user.with(von_mises(elasticity(young, poisson)?, yield_radius, undrained_strength, softening)?)
        }
        MaterialInput::Tresca { young, poisson, undrained_strength, softening, .. } => {
            let strength = strength(undrained_strength.0, softening)?;
            user.with(Tresca::new(elasticity(young, poisson)?, strength).map_err(too_fast)?)
        }
        MaterialInput::MohrCoulomb {
            young,
            poisson,
            cohesion,
            friction,
            dilation,
            tensile_strength,
            fluid_bulk,
            ..
        } => {
            let elasticity = elasticity(young, poisson)?;
            let mut law =
                MohrCoulomb::new(elasticity, cohesion.0, friction.0, dilation.0).map_err(inside(""))?;
            if let Some(tension) = tensile_strength {
                law = law.with_cut_off(tension.0).map_err(inside(""))?;
            }
            with_fluid(law, fluid_bulk, user)?
        }
        MaterialInput::DruckerPrager { young, poisson, cone, tension, fluid_bulk, .. } => {
            let mut law = drucker_prager(elasticity(young, poisson)?, cone).map_err(inside(".cone"))?;
            if let Some(tension) = tension {
                law = law.with_cut_off(tension.0).map_err(inside(""))?;
            }
            with_fluid(law, fluid_bulk, user)?
        }
        MaterialInput::CamClay {
            critical_ratio,
            compression,
            swelling,
            shear,
            shear_ratio,
            reference_pressure,
            preconsolidation,
            fluid_bulk,
            ..
        } => {
            let law = CamClay::new(CamClayParameters {
                critical_ratio: critical_ratio.0,
                compression: compression.0,
                swelling: swelling.0,
                shear: shear.0,
                shear_ratio: shear_ratio.0,
                reference_pressure: reference_pressure.0,
                preconsolidation: preconsolidation.0,
            });
            with_fluid(law.map_err(inside(""))?, fluid_bulk, user)?
        }
    })
}

fn elasticity(young: Positive, poisson: Poisson) -> Result<Elasticity, Refused> {
    Elasticity::from_young_poisson(young.0, poisson.0).map_err(inside(""))
}

fn with_fluid<M: Material + 'static, U: WithLaw>(
    law: M,
    fluid_bulk: Option<Positive>,
    user: U,
) -> Result<U::Answer, Refused> {
    Ok(match fluid_bulk {
        None => user.with(law),
        Some(bulk) => user.with(Undrained::new(law, bulk.0).map_err(inside(""))?),
    })
}

fn von_mises(
    elasticity: Elasticity,
    yield_radius: Option<Positive>,
    undrained_strength: Option<Positive>,
    softening: Option<SofteningInput>,
) -> Result<VonMises, Refused> {
    let (intact, is_radius) = match (yield_radius, undrained_strength) {
        (Some(radius), None) => (radius.0, true),
        (None, Some(strength)) => (strength.0, false),
        _ => {
            let reason =
                "expected exactly one of `yield_radius` and `undrained_strength`, which is yield_radius/√2";
            return Err(Refused { field: String::new(), reason: reason.into() });
        }
    };
    match (softening, is_radius) {
        (None, true) => VonMises::new(elasticity, intact).map_err(inside("")),
        (softening, _) => {
            let intact = if is_radius { intact * FRAC_1_SQRT_2 } else { intact };
            VonMises::with_strength(elasticity, strength(intact, softening)?).map_err(too_fast)
        }
    }
}

fn strength(intact: f64, softening: Option<SofteningInput>) -> Result<UndrainedStrength, Refused> {
    match softening {
        None => UndrainedStrength::perfect(intact).map_err(inside("")),
        Some(SofteningInput::Linear { modulus, residual }) => {
            UndrainedStrength::linear(intact, modulus.0, residual.0).map_err(inside(".softening"))
        }
        Some(SofteningInput::Remoulding { remoulded, shear_95 }) => {
            UndrainedStrength::remoulding(intact, remoulded.0, shear_95.0).map_err(inside(".softening"))
        }
    }
}

/// The rate of softening is no field of its own.
fn too_fast(error: ParameterError) -> Refused {
    Refused { field: ".softening".into(), reason: error.to_string() }
}

fn drucker_prager(elasticity: Elasticity, cone: ConeInput) -> Result<DruckerPrager, ParameterError> {
    match cone {
        ConeInput::Slopes { slope, flow_slope, strength } => {
            DruckerPrager::new(elasticity, slope.0, flow_slope.0, strength.0)
        }
        ConeInput::Matched { at, cohesion, friction, dilation } => {
            let at = match at {
                ConeMatchInput::Compression => ConeMatch::Compression,
                ConeMatchInput::Extension => ConeMatch::Extension,
                ConeMatchInput::PlaneStrain => ConeMatch::PlaneStrain,
                ConeMatchInput::IsochoricPlaneStrain => ConeMatch::IsochoricPlaneStrain,
            };
            DruckerPrager::matched(elasticity, at, cohesion.0, friction.0, dilation.0)
        }
    }
}

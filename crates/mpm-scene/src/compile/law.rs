//! Laws of scenes as laws of materials.

use super::quantity::Fields;
use crate::error::SceneError;
use crate::language::{ConeInput, ConeMatchInput, MaterialInput, Poisson, Positive, Quantity, SofteningInput};
use mpm_assembly::ShippedLaw;
use mpm_material::{
    Apex, CamClay, CamClayParameters, ConeMatch, DruckerPrager, Elasticity, Hencky, Material, MohrCoulomb,
    NeoHooke, ParameterError, Tresca, Undrained, UndrainedStrength, Varied, VolumeCorrected, VonMises,
};
use std::f64::consts::FRAC_1_SQRT_2;

/// Something that is done with a law, whichever it is.
pub(super) trait WithLaw {
    type Answer;

    /// A law of which only those points have parameters of their own that the scene gives any.
    fn with<M: Varied + Into<ShippedLaw>>(self, law: M) -> Self::Answer;

    /// A law that is wrapped, by pore fluid or so: to be used through [`mpm_material::PerPoint`], so that fewer kinds of
    /// bodies are compiled.
    fn with_wrapped<M: Varied>(self, law: M) -> Self::Answer;
}

/// Parameters that a law refuses.
#[derive(Debug)]
pub(crate) struct Refused {
    /// Where they stand in the material: nothing, or `.softening.modulus`.
    field: String,
    reason: String,
}

impl Refused {
    /// What the law says, without the place.
    pub(super) fn into_reason(self) -> String {
        self.reason
    }

    /// Names the point.
    pub(super) fn at_point(self, position: &[f64]) -> Self {
        Self { reason: format!("at the point {}: {}", place(position), self.reason), ..self }
    }

    /// As an error of the material named `name`.
    pub(super) fn of(self, name: &str) -> SceneError {
        self.at(&format!("materials.{name}"))
    }

    /// As an error of the law that stands at `path`.
    pub(super) fn at(self, path: &str) -> SceneError {
        SceneError::new(format!("{path}{}", self.field), self.reason)
    }
}

/// Why a body is not made.
pub(crate) enum Refusal {
    /// What is wrong with the shape or the number of points.
    Shape(String),
    /// What is wrong with the stress in which the body begins.
    Initial(String),
    /// What is wrong with the law at some point.
    Law(Refused),
}

impl From<String> for Refusal {
    fn from(reason: String) -> Self {
        Self::Shape(reason)
    }
}

/// Where quantities are asked for: their fields take a value at one point, or are refused.
#[derive(Clone, Copy)]
pub(super) struct Site<'a> {
    pub fields: &'a Fields<'a>,
    /// The point at rest `[L]`.
    pub position: &'a [f64],
}

/// A position, as messages name it.
pub(super) fn place(position: &[f64]) -> String {
    let numbers: Vec<String> = position.iter().map(f64::to_string).collect();
    format!("({})", numbers.join(", "))
}

/// Names the place of a parameter, whose fields stand `inside` another.
pub(super) fn inside(inside: &'static str) -> impl Fn(ParameterError) -> Refused {
    move |error| Refused { field: format!("{inside}.{}", error.name), reason: error.to_string() }
}

/// The number that a quantity is at a point.
pub(super) fn value<N: Copy + Into<f64>>(
    quantity: &Quantity<N>,
    name: &str,
    site: Option<Site<'_>>,
) -> Result<f64, Refused> {
    let refused = |reason: String| Refused { field: format!(".{name}"), reason };
    match (quantity, site) {
        (Quantity::Number(number), _) => Ok((*number).into()),
        (Quantity::Field(field), Some(site)) => site.fields.at(field, site.position).map_err(refused),
        (Quantity::Field(_), None) => {
            Err(refused("is a field, and no point is known where it takes a value".into()))
        }
    }
}

/// As [`value`], of a quantity that may be left out.
fn optional<N: Copy + Into<f64>>(
    quantity: &Option<Quantity<N>>,
    name: &str,
    site: Option<Site<'_>>,
) -> Result<Option<f64>, Refused> {
    quantity.as_ref().map(|quantity| value(quantity, name, site)).transpose()
}

/// Makes the law of `input` at a point, and hands it to `user`.
///
/// # Errors
/// What the law says of its parameters.
pub(super) fn with_law<U: WithLaw>(
    input: &MaterialInput,
    site: Option<Site<'_>>,
    user: U,
) -> Result<U::Answer, Refused> {
    let fluid = match input.fluid_bulk() {
        Some(bulk) => Some(value(bulk, "fluid_bulk", site)?),
        None => None,
    };
    match input {
        MaterialInput::Hencky { young, poisson, .. } => {
            Ok(user.with(Hencky(elasticity(young, *poisson, site)?)))
        }
        MaterialInput::NeoHooke { young, poisson, .. } => {
            Ok(user.with(NeoHooke::new(elasticity(young, *poisson, site)?).map_err(inside(""))?))
        }
        MaterialInput::VonMises { young, poisson, yield_radius, undrained_strength, softening, .. } => {
            let radius = optional(yield_radius, "yield_radius", site)?;
            let strength = optional(undrained_strength, "undrained_strength", site)?;
            Ok(user.with(von_mises(elasticity(young, *poisson, site)?, radius, strength, *softening)?))
        }
        MaterialInput::Tresca { young, poisson, undrained_strength, softening, .. } => {
            let strength = strength(value(undrained_strength, "undrained_strength", site)?, *softening)?;
            Ok(user.with(Tresca::new(elasticity(young, *poisson, site)?, strength).map_err(too_fast)?))
        }
        MaterialInput::MohrCoulomb { .. } => {
            wrapped(mohr_coulomb(input, site)?, input.corrects_volume(), fluid, user)
        }
        MaterialInput::DruckerPrager { .. } => {
            wrapped(drucker_prager(input, site)?, input.corrects_volume(), fluid, user)
        }
        MaterialInput::CamClay { .. } => wrapped(cam_clay(input, site)?, false, fluid, user),
    }
}

/// Hands a law to `user`, whose points close before they bear anything, or whose pores are full, where that is asked for.
fn wrapped<M: Varied + Into<ShippedLaw>, U: WithLaw>(
    law: M,
    corrects_volume: bool,
    fluid: Option<f64>,
    user: U,
) -> Result<U::Answer, Refused> {
    Ok(match (corrects_volume, fluid) {
        (false, None) => user.with(law),
        (true, None) => user.with_wrapped(VolumeCorrected::new(law)),
        (false, Some(bulk)) => user.with_wrapped(Undrained::new(law, bulk).map_err(inside(""))?),
        (true, Some(bulk)) => {
            user.with_wrapped(Undrained::new(VolumeCorrected::new(law), bulk).map_err(inside(""))?)
        }
    })
}

fn elasticity(
    young: &Quantity<Positive>,
    poisson: Poisson,
    site: Option<Site<'_>>,
) -> Result<Elasticity, Refused> {
    Elasticity::from_young_poisson(value(young, "young", site)?, poisson.0).map_err(inside(""))
}

fn von_mises(
    elasticity: Elasticity,
    yield_radius: Option<f64>,
    undrained_strength: Option<f64>,
    softening: Option<SofteningInput>,
) -> Result<VonMises, Refused> {
    let (intact, is_radius) = match (yield_radius, undrained_strength) {
        (Some(radius), None) => (radius, true),
        (None, Some(strength)) => (strength, false),
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
    // The strength itself is no part of its softening.
    let of_softening = |error: ParameterError| match error.name {
        "undrained_strength" => inside("")(error),
        _ => inside(".softening")(error),
    };
    match softening {
        None => UndrainedStrength::perfect(intact).map_err(inside("")),
        Some(SofteningInput::Linear { modulus, residual }) => {
            UndrainedStrength::linear(intact, modulus.0, residual.0).map_err(of_softening)
        }
        Some(SofteningInput::Remoulding { remoulded, shear_95 }) => {
            UndrainedStrength::remoulding(intact, remoulded.0, shear_95.0).map_err(of_softening)
        }
    }
}

/// The rate of softening is no field of its own.
fn too_fast(error: ParameterError) -> Refused {
    Refused { field: ".softening".into(), reason: error.to_string() }
}

fn mohr_coulomb(input: &MaterialInput, site: Option<Site<'_>>) -> Result<MohrCoulomb, Refused> {
    let MaterialInput::MohrCoulomb {
        young,
        poisson,
        cohesion,
        friction,
        dilation,
        tensile_strength,
        apex_stiffness,
        ..
    } = input
    else {
        unreachable!("asked of Mohr-Coulomb only");
    };
    let cohesion = value(cohesion, "cohesion", site)?;
    let angles = (value(friction, "friction", site)?, value(dilation, "dilation", site)?);
    let tension = optional(tensile_strength, "tensile_strength", site)?;
    let law = MohrCoulomb::new(elasticity(young, *poisson, site)?, cohesion, angles.0, angles.1);
    let law = law.and_then(|law| match tension {
        None => Ok(law),
        Some(tension) => law.with_cut_off(tension),
    });
    let law = law.and_then(|law| law.with_apex_stiffness(apex_stiffness.0)).map_err(inside(""))?;
    check_apex(input, law.apex(&Default::default()))?;
    Ok(law)
}

/// Refuses points that close where the law has no apex at which they come apart.
fn check_apex(input: &MaterialInput, apex: Option<Apex>) -> Result<(), Refused> {
    if !input.corrects_volume() || apex.is_some() {
        return Ok(());
    }
    let reason = "without friction, and beside the cut-off of a cone, the law has no apex at which points come apart: \
                  expected `volume_correction: false`";
    Err(Refused { field: ".volume_correction".into(), reason: reason.into() })
}

fn drucker_prager(input: &MaterialInput, site: Option<Site<'_>>) -> Result<DruckerPrager, Refused> {
    let MaterialInput::DruckerPrager { young, poisson, cone, tension, apex_stiffness, .. } = input else {
        unreachable!("asked of Drucker-Prager only");
    };
    let elasticity = elasticity(young, *poisson, site)?;
    let law = match cone {
        ConeInput::Slopes { slope, flow_slope, strength } => {
            let slope = value(slope, "cone.slope", site)?;
            let flow_slope = value(flow_slope, "cone.flow_slope", site)?;
            DruckerPrager::new(elasticity, slope, flow_slope, value(strength, "cone.strength", site)?)
        }
        ConeInput::Matched { at, cohesion, friction, dilation } => {
            let at = match at {
                ConeMatchInput::Compression => ConeMatch::Compression,
                ConeMatchInput::Extension => ConeMatch::Extension,
                ConeMatchInput::PlaneStrain => ConeMatch::PlaneStrain,
                ConeMatchInput::IsochoricPlaneStrain => ConeMatch::IsochoricPlaneStrain,
            };
            let cohesion = value(cohesion, "cone.cohesion", site)?;
            let friction = value(friction, "cone.friction", site)?;
            DruckerPrager::matched(elasticity, at, cohesion, friction, value(dilation, "cone.dilation", site)?)
        }
    };
    let mut law = law.map_err(inside(".cone"))?;
    if let Some(tension) = optional(tension, "tension", site)? {
        law = law.with_cut_off(tension).map_err(inside(""))?;
    }
    let law = law.with_apex_stiffness(apex_stiffness.0).map_err(inside(""))?;
    check_apex(input, law.apex(&Default::default()))?;
    Ok(law)
}

/// The law of Cam-Clay, for what only it is asked.
///
/// # Errors
/// What the law says of its parameters.
pub(super) fn cam_clay(input: &MaterialInput, site: Option<Site<'_>>) -> Result<CamClay, Refused> {
    let MaterialInput::CamClay {
        critical_ratio,
        compression,
        swelling,
        shear,
        shear_ratio,
        reference_pressure,
        preconsolidation,
        ..
    } = input
    else {
        unreachable!("asked of Cam-Clay only");
    };
    let parameters = CamClayParameters {
        critical_ratio: value(critical_ratio, "critical_ratio", site)?,
        compression: value(compression, "compression", site)?,
        swelling: value(swelling, "swelling", site)?,
        shear: value(shear, "shear", site)?,
        shear_ratio: value(shear_ratio, "shear_ratio", site)?,
        reference_pressure: reference_pressure.0,
        preconsolidation: value(preconsolidation, "preconsolidation", site)?,
    };
    CamClay::new(parameters).map_err(inside(""))
}

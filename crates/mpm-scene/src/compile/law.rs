//! Laws of scenes as laws of materials.

use super::quantity::{Fields, check_layers};
use crate::error::SceneError;
use crate::language::{
    ConeInput, ConeMatchInput, MaterialInput, PointField, Poisson, Positive, Quantity, SofteningInput,
};
use mpm_assembly::ShippedLaw;
use mpm_material::{
    CamClay, CamClayParameters, ConeMatch, DruckerPrager, Elasticity, Hencky, MohrCoulomb, NeoHooke,
    OwnParameters, ParameterError, Tresca, UndrainedStrength, Varied, VonMises,
};
use std::f64::consts::FRAC_1_SQRT_2;

/// Something that is done with a law, whichever it is.
pub(super) trait WithLaw {
    type Answer;

    /// `fluid` is the bulk modulus of pore fluid on top of it, where there is any `[F/L²]`.
    fn with<M: Varied + Into<ShippedLaw>>(self, law: M, fluid: Option<f64>) -> Self::Answer;
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

/// The parameters of one point.
#[derive(Clone, Copy, Debug)]
pub(super) struct OfPoint {
    pub own: OwnParameters,
    /// P-wave modulus `[F/L²]`.
    stiffness: f64,
    /// p_c of Cam-Clay `[F/L²]`.
    pub preconsolidation: Option<f64>,
}

/// Parameters of points, and which of the points is the stiffest.
pub(super) struct OfPoints {
    pub points: Vec<OfPoint>,
    pub stiffest: usize,
}

/// The fields of a material, and the places where they stand in it.
pub(super) fn fields_of(input: &MaterialInput) -> Vec<(&'static str, &PointField)> {
    let quantities = match input {
        MaterialInput::Hencky { young, .. } | MaterialInput::NeoHooke { young, .. } => {
            vec![("young", field(young))]
        }
        MaterialInput::VonMises { young, yield_radius, undrained_strength, .. } => vec![
            ("young", field(young)),
            ("yield_radius", yield_radius.as_ref().and_then(field)),
            ("undrained_strength", undrained_strength.as_ref().and_then(field)),
        ],
        MaterialInput::Tresca { young, undrained_strength, .. } => {
            vec![("young", field(young)), ("undrained_strength", field(undrained_strength))]
        }
        MaterialInput::MohrCoulomb { young, cohesion, tensile_strength, .. } => vec![
            ("young", field(young)),
            ("cohesion", field(cohesion)),
            ("tensile_strength", tensile_strength.as_ref().and_then(field)),
        ],
        MaterialInput::DruckerPrager { young, cone, tension, .. } => vec![
            ("young", field(young)),
            match cone {
                ConeInput::Slopes { strength, .. } => ("cone.strength", field(strength)),
                ConeInput::Matched { cohesion, .. } => ("cone.cohesion", field(cohesion)),
            },
            ("tension", tension.as_ref().and_then(field)),
        ],
        MaterialInput::CamClay { shear, preconsolidation, .. } => {
            vec![("shear", field(shear)), ("preconsolidation", field(preconsolidation))]
        }
    };
    quantities.into_iter().filter_map(|(name, field)| Some((name, field?))).collect()
}

fn field<N>(quantity: &Quantity<N>) -> Option<&PointField> {
    match quantity {
        Quantity::Number(_) => None,
        Quantity::Field(field) => Some(field),
    }
}

/// Refuses parameters of a material named `name`, as far as no point has to be known.
pub(super) fn check(input: &MaterialInput, name: &str) -> Result<(), SceneError> {
    for (field, of) in fields_of(input) {
        if let PointField::Layers(layers) = of {
            check_layers(layers).map_err(|it| SceneError::new(format!("materials.{name}.{field}"), it))?;
        }
    }
    struct Nothing;
    impl WithLaw for Nothing {
        type Answer = ();

        fn with<M: Varied + Into<ShippedLaw>>(self, _law: M, _fluid: Option<f64>) {}
    }
    if fields_of(input).is_empty() {
        with_law(input, None, Nothing).map_err(|refused| refused.of(name))?;
    }
    Ok(())
}

/// Parameters of the points at `positions`.
///
/// # Errors
/// The first point whose parameters the law refuses, or where a field has no value.
pub(super) fn of_points<const D: usize>(
    input: &MaterialInput,
    fields: &Fields<'_>,
    positions: &[[f64; D]],
) -> Result<OfPoints, Refused> {
    struct Own;
    impl WithLaw for Own {
        type Answer = (OwnParameters, f64);

        fn with<M: Varied + Into<ShippedLaw>>(self, law: M, fluid: Option<f64>) -> Self::Answer {
            (law.own(), law.elasticity().p_wave() + fluid.unwrap_or(0.0))
        }
    }
    let (mut points, mut stiffest) = (Vec::with_capacity(positions.len()), 0);
    for position in positions {
        let site = Site { fields, position };
        let at_point = |refused: Refused| Refused {
            reason: format!("at the point {}: {}", place(position), refused.reason),
            ..refused
        };
        let (own, stiffness) = with_law(input, Some(site), Own).map_err(at_point)?;
        let preconsolidation = match input {
            MaterialInput::CamClay { preconsolidation, .. } => {
                Some(value(preconsolidation, "preconsolidation", Some(site)).map_err(at_point)?)
            }
            _ => None,
        };
        points.push(OfPoint { own, stiffness, preconsolidation });
        if stiffness > points[stiffest].stiffness {
            stiffest = points.len() - 1;
        }
    }
    Ok(OfPoints { points, stiffest })
}

/// A position, as messages name it.
pub(super) fn place(position: &[f64]) -> String {
    let numbers: Vec<String> = position.iter().map(f64::to_string).collect();
    format!("({})", numbers.join(", "))
}

/// Names the place of a parameter, whose fields stand `inside` another.
fn inside(inside: &'static str) -> impl Fn(ParameterError) -> Refused {
    move |error| Refused { field: format!("{inside}.{}", error.name), reason: error.to_string() }
}

/// The number that a quantity is at a point.
fn value<N: Copy + Into<f64>>(
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
    Ok(match input {
        MaterialInput::Hencky { young, poisson, .. } => {
            user.with(Hencky(elasticity(young, *poisson, site)?), None)
        }
        MaterialInput::NeoHooke { young, poisson, .. } => {
            user.with(NeoHooke::new(elasticity(young, *poisson, site)?).map_err(inside(""))?, None)
        }
        MaterialInput::VonMises { young, poisson, yield_radius, undrained_strength, softening, .. } => {
            let radius = optional(yield_radius, "yield_radius", site)?;
            let strength = optional(undrained_strength, "undrained_strength", site)?;
            user.with(von_mises(elasticity(young, *poisson, site)?, radius, strength, *softening)?, None)
        }
        MaterialInput::Tresca { young, poisson, undrained_strength, softening, .. } => {
            let strength = strength(value(undrained_strength, "undrained_strength", site)?, *softening)?;
            user.with(Tresca::new(elasticity(young, *poisson, site)?, strength).map_err(too_fast)?, None)
        }
        MaterialInput::MohrCoulomb { fluid_bulk, .. } => {
            user.with(mohr_coulomb(input, site)?, fluid_bulk.map(f64::from))
        }
        MaterialInput::DruckerPrager { young, poisson, cone, tension, fluid_bulk, .. } => {
            let mut law = drucker_prager(elasticity(young, *poisson, site)?, cone, site)?;
            if let Some(tension) = optional(tension, "tension", site)? {
                law = law.with_cut_off(tension).map_err(inside(""))?;
            }
            user.with(law, fluid_bulk.map(f64::from))
        }
        MaterialInput::CamClay { fluid_bulk, .. } => {
            user.with(cam_clay(input, site)?, fluid_bulk.map(f64::from))
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
    let MaterialInput::MohrCoulomb { young, poisson, cohesion, friction, dilation, tensile_strength, .. } =
        input
    else {
        unreachable!("asked of Mohr-Coulomb only");
    };
    let cohesion = value(cohesion, "cohesion", site)?;
    let law = MohrCoulomb::new(elasticity(young, *poisson, site)?, cohesion, friction.0, dilation.0);
    match optional(tensile_strength, "tensile_strength", site)? {
        None => law.map_err(inside("")),
        Some(tension) => law.and_then(|law| law.with_cut_off(tension)).map_err(inside("")),
    }
}

fn drucker_prager(
    elasticity: Elasticity,
    cone: &ConeInput,
    site: Option<Site<'_>>,
) -> Result<DruckerPrager, Refused> {
    let law = match cone {
        ConeInput::Slopes { slope, flow_slope, strength } => {
            DruckerPrager::new(elasticity, slope.0, flow_slope.0, value(strength, "cone.strength", site)?)
        }
        ConeInput::Matched { at, cohesion, friction, dilation } => {
            let at = match at {
                ConeMatchInput::Compression => ConeMatch::Compression,
                ConeMatchInput::Extension => ConeMatch::Extension,
                ConeMatchInput::PlaneStrain => ConeMatch::PlaneStrain,
                ConeMatchInput::IsochoricPlaneStrain => ConeMatch::IsochoricPlaneStrain,
            };
            let cohesion = value(cohesion, "cone.cohesion", site)?;
            DruckerPrager::matched(elasticity, at, cohesion, friction.0, dilation.0)
        }
    };
    law.map_err(inside(".cone"))
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
        critical_ratio: critical_ratio.0,
        compression: compression.0,
        swelling: swelling.0,
        shear: value(shear, "shear", site)?,
        shear_ratio: shear_ratio.0,
        reference_pressure: reference_pressure.0,
        preconsolidation: value(preconsolidation, "preconsolidation", site)?,
    };
    CamClay::new(parameters).map_err(inside(""))
}

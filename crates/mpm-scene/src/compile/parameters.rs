//! Parameters of materials at the points: what is a number, and what a field.

use super::law::{Refused, Site, WithLaw, inside, value, with_law};
use super::quantity::{Fields, check_layers};
use crate::error::SceneError;
use crate::fill::Density;
use crate::language::{ConeInput, MaterialInput, PointField, Quantity};
use mpm_assembly::ShippedLaw;
use mpm_material::{OwnParameters, ParameterError, Varied};

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

/// The fields of a law, and the places where they stand in it; that of the density is no parameter of the law.
pub(super) fn fields_of(input: &MaterialInput) -> Vec<(&'static str, &PointField)> {
    let mut fields = match input {
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
        MaterialInput::MohrCoulomb { young, cohesion, friction, dilation, tensile_strength, .. } => vec![
            ("young", field(young)),
            ("cohesion", field(cohesion)),
            ("friction", field(friction)),
            ("dilation", field(dilation)),
            ("tensile_strength", tensile_strength.as_ref().and_then(field)),
        ],
        MaterialInput::DruckerPrager { young, cone, tension, .. } => {
            let [first, second, third] = fields_of_cone(cone);
            vec![("young", field(young)), first, second, third, ("tension", tension.as_ref().and_then(field))]
        }
        MaterialInput::CamClay {
            critical_ratio,
            compression,
            swelling,
            shear,
            shear_ratio,
            preconsolidation,
            ..
        } => vec![
            ("critical_ratio", field(critical_ratio)),
            ("compression", field(compression)),
            ("swelling", field(swelling)),
            ("shear", field(shear)),
            ("shear_ratio", field(shear_ratio)),
            ("preconsolidation", field(preconsolidation)),
        ],
    };
    fields.push(("fluid_bulk", input.fluid_bulk().and_then(field)));
    fields.into_iter().filter_map(|(name, field)| Some((name, field?))).collect()
}

fn fields_of_cone(cone: &ConeInput) -> [(&'static str, Option<&PointField>); 3] {
    match cone {
        ConeInput::Slopes { slope, flow_slope, strength } => [
            ("cone.slope", field(slope)),
            ("cone.flow_slope", field(flow_slope)),
            ("cone.strength", field(strength)),
        ],
        ConeInput::Matched { cohesion, friction, dilation, .. } => [
            ("cone.cohesion", field(cohesion)),
            ("cone.friction", field(friction)),
            ("cone.dilation", field(dilation)),
        ],
    }
}

fn field<N>(quantity: &Quantity<N>) -> Option<&PointField> {
    match quantity {
        Quantity::Number(_) => None,
        Quantity::Field(field) => Some(field),
    }
}

/// Refuses parameters of a material named `name`, as far as no point has to be known.
pub(super) fn check(input: &MaterialInput, name: &str) -> Result<(), SceneError> {
    let density = input.density().and_then(field).map(|of| ("density", of));
    for (field, of) in fields_of(input).into_iter().chain(density) {
        if let PointField::Layers(layers) = of {
            check_layers(layers).map_err(|it| SceneError::new(format!("materials.{name}.{field}"), it))?;
        }
    }
    struct Nothing;
    impl WithLaw for Nothing {
        type Answer = ();

        fn with<M: Varied + Into<ShippedLaw>>(self, _law: M) {}

        fn with_wrapped<M: Varied>(self, _law: M) {}
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

        fn with<M: Varied + Into<ShippedLaw>>(self, law: M) -> Self::Answer {
            (law.own(), law.elasticity().p_wave())
        }

        fn with_wrapped<M: Varied>(self, law: M) -> Self::Answer {
            (law.own(), law.elasticity().p_wave())
        }
    }
    let (mut points, mut stiffest) = (Vec::with_capacity(positions.len()), 0);
    for position in positions {
        let site = Site { fields, position };
        let at_point = |refused: Refused| refused.at_point(position);
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

/// Density of the points at `positions`, where it is given `[M/L^D]`.
///
/// # Errors
/// The first point where a field has no value, or none that a density can have.
pub(super) fn density<const D: usize>(
    input: &MaterialInput,
    fields: &Fields<'_>,
    positions: &[[f64; D]],
) -> Result<Option<Density>, Refused> {
    let Some(density) = input.density() else { return Ok(None) };
    if let Some(number) = density.number() {
        return Ok(Some(Density::Even(number)));
    }
    let at = |position: &[f64; D]| {
        let density = value(density, "density", Some(Site { fields, position }))?;
        ParameterError::unless_positive("density", density).map_err(inside(""))
    };
    let at = |position| at(position).map_err(|refused| refused.at_point(position));
    positions.iter().map(at).collect::<Result<_, _>>().map(Density::OfPoints).map(Some)
}

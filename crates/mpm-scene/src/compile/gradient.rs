//! Nodal fields that regularise laws.

use super::parameters::fields_of;
use crate::error::SceneError;
use crate::language::{DriverInput, GradientInput, MaterialInput};
use mpm_assembly::Space;
use mpm_material::{FieldDriver, ParameterError, Regularisation};

/// The regularisation that an input describes.
///
/// # Errors
/// What it says of its numbers.
pub(super) fn regularisation(input: &GradientInput) -> Result<Regularisation, ParameterError> {
    let driver = match input.driver {
        DriverInput::PlasticStrain => FieldDriver::PlasticStrain,
        DriverInput::Strain => FieldDriver::Strain,
    };
    Regularisation::new(driver, input.modulus.0, input.length.0)
}

/// Refuses a nodal field where there can be none: `averages` tells whether the body averages volume changes.
///
/// # Errors
/// Why the law of the material named `name` cannot have one.
pub(super) fn check(
    law: &MaterialInput,
    name: &str,
    (space, averages): (Space, bool),
) -> Result<(), SceneError> {
    let Some(gradient) = law.gradient() else { return Ok(()) };
    let refuse = |field: &str, reason: &str| {
        Err(SceneError::new(format!("materials.{name}.gradient{field}"), reason.to_owned()))
    };
    if space.is_axisymmetric() {
        return refuse(
            "",
            "no body of revolution has a nodal field: expected a scene in the plane or in space",
        );
    }
    if averages {
        return refuse("", "a body with `mean_dilatation` has no nodal field: leave out one of them");
    }
    if gradient.driver == DriverInput::PlasticStrain {
        if !matches!(law, MaterialInput::VonMises { .. } | MaterialInput::Tresca { .. }) {
            let reason = "`PlasticStrain` is the driver of `VonMises` and `Tresca` only: expected `Strain`";
            return refuse(".driver", reason);
        }
        if let Some((field, _)) = fields_of(law).first() {
            let reason = format!(
                "`PlasticStrain` needs parameters that are the same everywhere, and `{field}` is a field"
            );
            return refuse(".driver", &reason);
        }
    }
    Ok(())
}

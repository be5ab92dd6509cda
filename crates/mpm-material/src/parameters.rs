//! Parameters of laws, and of the points that a law is asked for.

use nalgebra::Vector3;
use thiserror::Error;

/// A material parameter outside its range.
#[derive(Clone, Copy, PartialEq, Debug, Error)]
#[error("{name} is {value}, expected {expected}")]
pub struct ParameterError {
    /// The parameter, as a scene calls it.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// What it must be instead.
    pub expected: &'static str,
}

impl ParameterError {
    /// Accepts a positive, finite value of the parameter `name`.
    ///
    /// # Errors
    /// Any other value.
    pub fn unless_positive(name: &'static str, value: f64) -> Result<f64, Self> {
        Self::unless(value > 0.0 && value.is_finite(), name, value, "a positive, finite number")
    }

    /// Accepts a finite value of the parameter `name` that is not negative.
    ///
    /// # Errors
    /// Any other value.
    pub fn unless_not_negative(name: &'static str, value: f64) -> Result<f64, Self> {
        Self::unless(value >= 0.0 && value.is_finite(), name, value, "a finite number of at least 0")
    }

    /// Accepts a value of which `holds` is true.
    ///
    /// # Errors
    /// `holds` is false.
    pub fn unless(holds: bool, name: &'static str, value: f64, expected: &'static str) -> Result<f64, Self> {
        if holds { Ok(value) } else { Err(Self { name, value, expected }) }
    }
}

/// What a law may know of a point when a body is made.
#[derive(Clone, Copy, PartialEq, Debug)]
#[non_exhaustive]
pub struct PointParameters {
    /// Position at rest `[L]`; in the plane its third component is zero.
    pub position: Vector3<f64>,
    /// Factor on the strength of the law at this point [-], 1 unless a body says otherwise: obeyed by
    /// [`crate::PerPoint`], and by [`crate::CamClay`] as a factor on its preconsolidation pressure.
    pub strength: f64,
}

impl PointParameters {
    /// A point that rests at `position` `[L]`.
    pub fn at(position: Vector3<f64>) -> Self {
        Self { position, strength: 1.0 }
    }
}

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

/// Most parameters that a point can have for itself.
pub const MOST_OWN: usize = 6;

/// Parameters of one point, in the order of [`crate::Varied::own_fields`]; those that the law has not are zero.
pub type OwnParameters = [f64; MOST_OWN];

/// What a law may know of a point when a body is made.
#[derive(Clone, Copy, PartialEq, Debug)]
#[non_exhaustive]
pub struct PointParameters {
    /// Position at rest `[L]`; in the plane its third component is zero.
    pub position: Vector3<f64>,
    /// The point's own parameters, for [`crate::PerPoint`]; none where the law's are meant.
    pub own: Option<OwnParameters>,
    /// Principal stresses under which it begins `[F/L²]`, if it does.
    pub stress: Option<Vector3<f64>>,
    /// How far the point was compressed in the past, for [`crate::CamClay`].
    pub consolidation: Consolidation,
}

/// What decides the preconsolidation pressure at the start.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub enum Consolidation {
    /// The law's parameter.
    #[default]
    OfLaw,
    /// The pressure itself [F/L²].
    Pressure(f64),
    /// The yield surface goes through these principal stresses [F/L²].
    Stress(Vector3<f64>),
}

impl PointParameters {
    /// A point that rests at `position` `[L]`.
    pub fn at(position: Vector3<f64>) -> Self {
        Self { position, own: None, stress: None, consolidation: Consolidation::OfLaw }
    }
}

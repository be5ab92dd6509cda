//! Numbers of which no shape, motion or interface can be made.

use mpm_grid::six_digits;

/// Name of a vertex of which the value is the number, from 1.
pub(crate) const VERTEX: &str = "vertex";

/// The same of a triangle.
pub(crate) const TRIANGLE: &str = "triangle";

/// A number outside its range.
#[derive(Clone, Copy, PartialEq, Debug, thiserror::Error)]
#[error("{name} {}{}, expected {expected}", if [VERTEX, TRIANGLE].contains(name) { "" } else { "is " }, six_digits(*value))]
pub struct ContactError {
    /// The number, as a scene calls it.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// What it must be instead.
    pub expected: &'static str,
}

impl ContactError {
    /// Accepts a value of which `holds` is true.
    ///
    /// # Errors
    /// `holds` is false.
    pub fn unless(holds: bool, name: &'static str, value: f64, expected: &'static str) -> Result<f64, Self> {
        if holds { Ok(value) } else { Err(Self { name, value, expected }) }
    }

    /// Accepts a positive, finite value of the number `name`.
    ///
    /// # Errors
    /// Any other value.
    pub fn unless_positive(name: &'static str, value: f64) -> Result<f64, Self> {
        Self::unless(value > 0.0 && value.is_finite(), name, value, "a positive, finite number")
    }

    /// Accepts a finite value of the number `name` that is not negative.
    ///
    /// # Errors
    /// Any other value.
    pub fn unless_not_negative(name: &'static str, value: f64) -> Result<f64, Self> {
        Self::unless(value >= 0.0 && value.is_finite(), name, value, "a finite number of at least 0")
    }

    /// Accepts finite values of the number `name`.
    ///
    /// # Errors
    /// The first value that is infinite or not a number.
    pub fn unless_finite(name: &'static str, values: &[f64]) -> Result<(), Self> {
        match values.iter().find(|value| !value.is_finite()) {
            None => Ok(()),
            Some(&value) => Err(Self { name, value, expected: "a finite number" }),
        }
    }
}

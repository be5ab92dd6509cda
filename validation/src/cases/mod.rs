//! The cases, in the order of the table.

mod determinism;
mod domain_control;
mod newton_rate;
mod patch;
mod rotation;
mod simple_stretch;
mod step_control;
mod tangent;

use crate::Case;

/// All cases.
pub const CASES: &[Case] = &[
    simple_stretch::FREE,
    simple_stretch::ROLLERS,
    newton_rate::CASE,
    tangent::CASE,
    rotation::CASE,
    patch::CASE,
    step_control::FAILURE,
    step_control::CUTS,
    domain_control::CASE,
    determinism::CASE,
];

/// Largest of some errors; not a number if one of them is not.
fn largest(errors: impl IntoIterator<Item = f64>) -> f64 {
    errors.into_iter().fold(0.0, |a, b| if b.is_nan() || b > a { b } else { a })
}

/// Largest difference between two lists that should be equal, against the size of `expected`;
/// not a number where their lengths differ.
fn relative(found: &[f64], expected: &[f64]) -> f64 {
    if found.len() != expected.len() {
        return f64::NAN;
    }
    let scale = largest(expected.iter().map(|x| x.abs()));
    largest(found.iter().zip(expected).map(|(a, b)| (a - b).abs())) / scale
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_that_is_no_number_is_not_lost() {
        assert!(largest([1.0, f64::NAN, 2.0]).is_nan());
        assert_eq!(largest([1.0, 3.0, 2.0]), 3.0);
        assert!(relative(&[1.0], &[1.0, 2.0]).is_nan());
        assert_eq!(relative(&[1.0, 2.5], &[1.0, 2.0]), 0.25);
    }
}

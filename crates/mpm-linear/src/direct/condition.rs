//! Estimate of a condition number.

use super::residual::image_of_known;
use crate::matrix::Matrix;

/// Steps of power and of inverse iteration.
const STEPS: usize = 10;

/// Estimate of the condition number |λ|_max / |λ|_min of a matrix: ten steps of power iteration, and ten of
/// inverse iteration with `solve`, which replaces b by K⁻¹ b. Both approach from below: a lower bound, mostly
/// within a factor of two. None where a vector vanishes or is not finite.
pub(super) fn estimate(matrix: Matrix<'_>, mut solve: impl FnMut(&mut Vec<f64>)) -> Option<f64> {
    let mut large = image_of_known(matrix);
    let mut largest = normalise(&mut large)?;
    for _ in 0..STEPS {
        large = matrix.times(&large);
        largest = normalise(&mut large)?;
    }
    let n = matrix.pattern.n_equations();
    let mut small: Vec<f64> = (0..n).map(|i| if i.is_multiple_of(3) { -1.0 } else { 1.0 }).collect();
    normalise(&mut small)?;
    let mut inverse = 0.0;
    for _ in 0..STEPS {
        solve(&mut small);
        inverse = normalise(&mut small)?;
    }
    Some(largest * inverse)
}

/// Makes a vector one of length 1; returns its length, if that is a number above 0.
fn normalise(x: &mut [f64]) -> Option<f64> {
    let length = x.iter().map(|x| x * x).sum::<f64>().sqrt();
    x.iter_mut().for_each(|x| *x /= length);
    (length > 0.0 && length.is_finite()).then_some(length)
}

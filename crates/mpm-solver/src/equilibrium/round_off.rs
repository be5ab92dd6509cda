//! Sizes of forces: what rounding can cause, and norms of any size.

use mpm_grid::Vector;

/// Forces that rounding can cause.
pub(crate) struct RoundOff {
    /// `Σ_p V⁰_p M |∇S_vp|` of every node: the force of a strain of one `[F]`.
    pub stiffness: Vec<f64>,
    /// A few units in the last place of it, over all nodes `[F]`.
    pub all: f64,
    /// Of every body, if there are several.
    pub bodies: Vec<BodyScale>,
}

/// What a body's out-of-balance force is compared with, besides its own force.
pub(crate) struct BodyScale {
    /// Active nodes that its points influence, ascending.
    pub nodes: Vec<u32>,
    /// The force of a strain of one, over its nodes `[F]`.
    pub stiffness: f64,
}

/// Euclidean norm of forces, whatever their size: squares that would overflow or vanish are scaled.
pub(crate) fn norm<const D: usize>(forces: impl Iterator<Item = Vector<D>> + Clone) -> f64 {
    let sum: f64 = forces.clone().map(|x| x.norm_squared()).sum();
    if sum.is_nan() || (sum.is_finite() && sum > f64::MIN_POSITIVE / f64::EPSILON) {
        return sum.sqrt();
    }
    let largest = forces.clone().map(|x| x.amax()).fold(0.0, f64::max);
    if largest == 0.0 || largest.is_infinite() {
        return largest;
    }
    largest * forces.map(|x| (x / largest).norm_squared()).sum::<f64>().sqrt()
}

/// The same of single numbers.
pub(crate) fn norm_of(numbers: &[f64]) -> f64 {
    norm(numbers.iter().map(|&x| Vector::<1>::new(x)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn norms_neither_overflow_nor_vanish() {
        for size in [1.0, 1e-320, 1e-250, 1e160, 1e307] {
            let norm = norm_of(&[3.0 * size, -4.0 * size]);
            assert!((norm / (5.0 * size) - 1.0).abs() < 1e-3, "{norm:e} of {size:e}");
        }
        assert_eq!((norm_of(&[]), norm_of(&[0.0])), (0.0, 0.0));
        assert!(norm_of(&[f64::NAN, 1e200]).is_nan() && norm_of(&[1e200, f64::NAN]).is_nan());
        assert!(norm_of(&[f64::INFINITY, 1.0]).is_infinite());
    }
}

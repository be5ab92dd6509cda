//! Principal values and axes of a symmetric tensor, to round-off also where values repeat.
//!
//! Two paths. Where z is a principal direction (plane strain) the closed form needs one square
//! root and one division; otherwise cyclic Jacobi rotations. Both are relative to the size of
//! the tensor given, so the excess b − I of a strain of 1e-10 keeps its digits. The textbook
//! formula with a cosine of a third of an angle is neither: it loses half the digits of nearly
//! equal values (1e-8), and fails on equal ones.

use nalgebra::{Matrix3, Vector3};

use crate::SymmetricTensor;

/// Principal values and the axes they belong to.
///
/// The order is a function of the components alone: in the plane, the larger in-plane value, the
/// smaller, then zz; in space, as the rotations leave them.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Spectrum {
    pub values: Vector3<f64>,
    pub frame: Frame,
}

/// Orthonormal principal axes.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Frame {
    /// Axis 0 lies in the plane at the angle θ from x, axis 1 at right angles, axis 2 is z. All
    /// that tensors need is the doubled angle: n₀⊗n₀ − n₁⊗n₁ = [[cos 2θ, sin 2θ], [sin 2θ, −cos 2θ]].
    Plane { cos_2: f64, sin_2: f64 },
    /// The axes are the columns.
    Space(Matrix3<f64>),
}

impl Spectrum {
    #[inline]
    pub fn of(tensor: &SymmetricTensor) -> Self {
        if tensor.is_plane() { Self::plane(tensor) } else { Self::space(tensor) }
    }

    /// Mohr's circle.
    #[inline]
    fn plane(tensor: &SymmetricTensor) -> Self {
        let SymmetricTensor { xx, yy, zz, xy, .. } = *tensor;
        let mean = 0.5 * (xx + yy);
        let half = 0.5 * (xx - yy);
        let square = half * half + xy * xy;
        // Equal values have no axes of their own: take x and y. The bound is where squares
        // begin to lose digits to underflow (a circle of 1e-154).
        let (radius, cos_2, sin_2) = if square < f64::MIN_POSITIVE {
            (0.0, 1.0, 0.0)
        } else {
            let radius = square.sqrt();
            (radius, half / radius, xy / radius)
        };
        Self { values: Vector3::new(mean + radius, mean - radius, zz), frame: Frame::Plane { cos_2, sin_2 } }
    }

    /// Cyclic Jacobi rotations (Golub and Van Loan, Matrix Computations, section 8.5).
    #[inline(never)]
    fn space(tensor: &SymmetricTensor) -> Self {
        // Quadratic convergence takes four or five sweeps; the bound only makes the end certain.
        const SWEEPS: usize = 16;

        let matrix = tensor.to_matrix();
        let scale = matrix.amax();
        let mut axes = Matrix3::identity();
        if !matrix.sum().is_finite() {
            return Self { values: Vector3::repeat(f64::NAN), frame: Frame::Space(axes) };
        }
        // Entries of at most one, so that no square under- or overflows.
        let mut a = matrix / scale;
        for _ in 0..SWEEPS {
            let first = rotate::<0, 1, 2>(&mut a, &mut axes);
            let second = rotate::<0, 2, 1>(&mut a, &mut axes);
            let third = rotate::<1, 2, 0>(&mut a, &mut axes);
            if !(first || second || third) {
                break;
            }
        }
        Self { values: a.diagonal() * scale, frame: Frame::Space(axes) }
    }
}

/// Turns axes `P` and `Q` so that `a[(P, Q)]` vanishes, and says so, unless it is negligible
/// already; `R` is the third axis. (Indices known at compile time save a fifth of the time.)
#[inline]
fn rotate<const P: usize, const Q: usize, const R: usize>(
    a: &mut Matrix3<f64>,
    axes: &mut Matrix3<f64>,
) -> bool {
    // Beyond round-off of the largest entry, one.
    const NEGLIGIBLE: f64 = 0.01 * f64::EPSILON;

    let a_pq = a[(P, Q)];
    if a_pq.abs() <= NEGLIGIBLE {
        return false;
    }
    // The tangent t of the angle: the smaller root of a_pq t² + (a_qq − a_pp) t − a_pq = 0.
    let gap = a[(Q, Q)] - a[(P, P)];
    let root = (gap * gap + 4.0 * a_pq * a_pq).sqrt().copysign(gap);
    let t = 2.0 * a_pq / (gap + root);
    let c = 1.0 / (t * t + 1.0).sqrt();
    let s = t * c;

    a[(P, P)] -= t * a_pq;
    a[(Q, Q)] += t * a_pq;
    a[(P, Q)] = 0.0;
    a[(Q, P)] = 0.0;
    let (a_rp, a_rq) = (a[(R, P)], a[(R, Q)]);
    let (rotated_p, rotated_q) = (c * a_rp - s * a_rq, s * a_rp + c * a_rq);
    a[(R, P)] = rotated_p;
    a[(P, R)] = rotated_p;
    a[(R, Q)] = rotated_q;
    a[(Q, R)] = rotated_q;
    for i in 0..3 {
        let (n_p, n_q) = (axes[(i, P)], axes[(i, Q)]);
        axes[(i, P)] = c * n_p - s * n_q;
        axes[(i, Q)] = s * n_p + c * n_q;
    }
    true
}

impl Frame {
    /// The tensor Σ_a values_a n_a ⊗ n_a.
    #[inline]
    pub fn compose(&self, values: &Vector3<f64>) -> SymmetricTensor {
        match self {
            Self::Plane { cos_2, sin_2 } => {
                let mean = 0.5 * (values[0] + values[1]);
                let radius = 0.5 * (values[0] - values[1]);
                SymmetricTensor {
                    xx: mean + radius * cos_2,
                    yy: mean - radius * cos_2,
                    zz: values[2],
                    xy: radius * sin_2,
                    yz: 0.0,
                    zx: 0.0,
                }
            }
            Self::Space(n) => {
                let sum = |i, j| (0..3).fold(0.0, |sum, a| sum + values[a] * n[(i, a)] * n[(j, a)]);
                SymmetricTensor {
                    xx: sum(0, 0),
                    yy: sum(1, 1),
                    zz: sum(2, 2),
                    xy: sum(0, 1),
                    yz: sum(1, 2),
                    zx: sum(2, 0),
                }
            }
        }
    }

    /// The axes as columns.
    #[inline]
    pub fn axes(&self) -> Matrix3<f64> {
        match *self {
            Self::Plane { cos_2, sin_2 } => {
                // Half the angle, −½π < θ ≤ ½π, from whichever of the two sums does not cancel.
                let (cos, sin) = if cos_2 >= 0.0 {
                    let cos = (0.5 * (1.0 + cos_2)).sqrt();
                    (cos, 0.5 * sin_2 / cos)
                } else {
                    let sin = (0.5 * (1.0 - cos_2)).sqrt().copysign(sin_2);
                    (0.5 * sin_2 / sin, sin)
                };
                Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0)
            }
            Self::Space(axes) => axes,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GAPS: [f64; 9] = [0.0, 1e-16, 1e-15, 1e-12, 1e-10, 1e-8, 1e-5, 1e-2, 0.3];

    fn plane(first: f64, second: f64, third: f64, angle: f64) -> SymmetricTensor {
        let (sin, cos) = angle.sin_cos();
        SymmetricTensor {
            xx: first * cos * cos + second * sin * sin,
            yy: first * sin * sin + second * cos * cos,
            zz: third,
            xy: (first - second) * sin * cos,
            ..SymmetricTensor::ZERO
        }
    }

    /// A tensor with the given values about axes that are aligned with nothing.
    fn space(values: [f64; 3]) -> SymmetricTensor {
        let axes = nalgebra::Rotation3::from_euler_angles(0.4, -0.9, 1.7);
        let matrix = axes * Matrix3::from_diagonal(&values.into()) * axes.inverse();
        SymmetricTensor::from_matrix(&matrix)
    }

    fn distance(a: &SymmetricTensor, b: &SymmetricTensor) -> f64 {
        (a.to_matrix() - b.to_matrix()).norm()
    }

    /// Orthonormal axes that diagonalise the tensor, all to a few units in the last place.
    fn check(tensor: &SymmetricTensor, spectrum: &Spectrum) {
        let n = spectrum.frame.axes();
        let scale = tensor.norm();
        assert!((n.transpose() * n - Matrix3::identity()).norm() < 3e-15, "{tensor:?}");
        let diagonal = n.transpose() * tensor.to_matrix() * n;
        let error = (diagonal - Matrix3::from_diagonal(&spectrum.values)).norm();
        assert!(error <= 5e-15 * scale, "{tensor:?}: {error}");
        let composed = spectrum.frame.compose(&spectrum.values);
        assert!(distance(&composed, tensor) <= 5e-15 * scale, "{tensor:?}");
    }

    #[test]
    fn both_paths_diagonalise_and_agree_in_the_plane() {
        for size in [1e-12, 1.0, 1e6] {
            for gap in GAPS {
                for step in -8..=8 {
                    let angle = 0.2 * f64::from(step);
                    let tensor = plane(size, size * (1.0 - gap), 0.7 * size, angle);
                    let (fast, general) = (Spectrum::plane(&tensor), Spectrum::space(&tensor));
                    check(&tensor, &fast);
                    check(&tensor, &general);
                    let (mut ours, mut theirs) = (fast.values, general.values);
                    ours.as_mut_slice().sort_by(f64::total_cmp);
                    theirs.as_mut_slice().sort_by(f64::total_cmp);
                    assert!((ours - theirs).norm() <= 1e-15 * size, "{tensor:?}");
                }
            }
        }
    }

    #[test]
    fn plane_response_equals_the_general_one() {
        for gap in GAPS {
            for step in -8..=8 {
                let excess = plane(0.8, 0.8 - gap, -0.3, 0.2 * f64::from(step));
                let log =
                    |spectrum: Spectrum| spectrum.frame.compose(&spectrum.values.map(|c| 0.5 * c.ln_1p()));
                let (fast, general) = (Spectrum::plane(&excess), Spectrum::space(&excess));
                assert!(distance(&log(fast), &log(general)) < 1e-14 * log(fast).norm());
            }
        }
    }

    #[test]
    fn space_is_accurate_for_nearly_equal_values() {
        for size in [1e-12, 1.0, 1e6] {
            for gap in GAPS {
                for values in [[1.0, 1.0 + gap, 1.3], [1.0, 1.0 + gap, 1.0 - 2.0 * gap]] {
                    let tensor = space(values.map(|value| size * value));
                    check(&tensor, &Spectrum::of(&tensor));
                }
            }
        }
    }

    #[test]
    fn plane_axes_at_equal_values_are_x_and_y() {
        for tensor in [SymmetricTensor::ZERO, plane(0.2, 0.2, 0.2, 0.0)] {
            let Spectrum { values, frame } = Spectrum::of(&tensor);
            assert_eq!(frame, Frame::Plane { cos_2: 1.0, sin_2: 0.0 });
            assert_eq!(frame.axes(), Matrix3::identity());
            assert_eq!(frame.compose(&values), tensor);
        }
    }

    #[test]
    fn values_too_small_to_square_stay_finite() {
        for size in [1e-150, 1e-160, 1e-300, 5e-324] {
            for tensor in [plane(size, -size, 0.0, 0.3), space([size, -size, 0.5 * size])] {
                let Spectrum { values, frame } = Spectrum::of(&tensor);
                assert!(values.iter().all(|value| value.abs() <= 2.0 * size), "{tensor:?}");
                assert!(frame.axes().iter().all(|component| component.is_finite()));
            }
        }
    }

    #[test]
    fn what_is_not_finite_ends_and_is_not_finite() {
        let finite = space([0.1, 0.2, 0.3]);
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for tensor in [
                SymmetricTensor { xx: bad, ..finite },
                SymmetricTensor { yz: bad, ..finite },
                SymmetricTensor { xy: bad, yz: 0.0, zx: 0.0, ..finite },
                SymmetricTensor { zz: bad, yz: 0.0, zx: 0.0, ..finite },
            ] {
                let values = Spectrum::of(&tensor).values;
                assert!(!values.iter().all(|value| value.is_finite()), "{tensor:?}");
            }
        }
    }
}

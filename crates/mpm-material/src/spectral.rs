//! Principal values and axes of a symmetric tensor, to round-off also where values repeat.
//!
//! Two paths. Where z is a principal direction (plane strain) the closed form needs one square
//! root and one division; otherwise cyclic Jacobi rotations. Both are relative to the size of
//! the tensor given, so the excess b − I of a strain of 1e-10 keeps its digits. The textbook
//! formula with a cosine of a third of an angle is neither: it loses half the digits of nearly
//! equal values (1e-8), and fails on equal ones.

use crate::SymmetricTensor;
use crate::lanes::Number;

/// Principal values and the axes they belong to.
///
/// The order is a function of the components alone: in the plane, the larger in-plane value, the
/// smaller, then zz; in space, as the rotations leave them.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Spectrum<T = f64> {
    pub values: [T; 3],
    pub frame: Frame<T>,
}

/// Orthonormal principal axes.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Frame<T = f64> {
    /// Axis 0 lies in the plane at the angle θ from x, axis 1 at right angles, axis 2 is z. All
    /// that tensors need is the doubled angle: n₀⊗n₀ − n₁⊗n₁ = [[cos 2θ, sin 2θ], [sin 2θ, −cos 2θ]].
    Plane { cos_2: T, sin_2: T },
    /// The axes are the columns: component, then axis.
    Space([[T; 3]; 3]),
}

impl Spectrum {
    #[inline]
    pub fn of(tensor: &SymmetricTensor) -> Self {
        if tensor.is_plane() { Self::plane(tensor) } else { Self::space(tensor) }
    }

    // Not inlined where one point is asked for: this is most of the work.
    #[inline(never)]
    fn space(tensor: &SymmetricTensor) -> Self {
        Self::in_space(tensor)
    }
}

impl<T: Number> Spectrum<T> {
    /// Mohr's circle, where z is a principal direction.
    #[inline(always)]
    pub fn plane(tensor: &SymmetricTensor<T>) -> Self {
        let SymmetricTensor { xx, yy, zz, xy, .. } = *tensor;
        let (mean, half) = (T::of(0.5) * (xx + yy), T::of(0.5) * (xx - yy));
        let square = half * half + xy * xy;
        // Equal values have no axes of their own: take x and y. The bound is where squares
        // begin to lose digits to underflow (a circle of 1e-154).
        let is_point = square.below(T::of(f64::MIN_POSITIVE));
        let root = square.root();
        let radius = T::pick(is_point, T::ZERO, root);
        let cos_2 = T::pick(is_point, T::of(1.0), half / root);
        let sin_2 = T::pick(is_point, T::ZERO, xy / root);
        Self { values: [mean + radius, mean - radius, zz], frame: Frame::Plane { cos_2, sin_2 } }
    }

    /// Cyclic Jacobi rotations (Golub and Van Loan, Matrix Computations, section 8.5).
    #[inline(always)]
    pub fn in_space(tensor: &SymmetricTensor<T>) -> Self {
        let [spectrum] = Self::of_several([tensor]);
        spectrum
    }

    /// As [`Self::in_space`], of several tensors by turns: a rotation waits for its roots and quotients, and meanwhile those of
    /// another tensor go on. Tensors and lanes that are done wait for the others.
    #[inline(always)]
    pub fn of_several<const N: usize>(tensors: [&SymmetricTensor<T>; N]) -> [Self; N] {
        // Quadratic convergence takes four or five sweeps; the bound only makes the end certain.
        const SWEEPS: usize = 16;

        // Loops, not closures: those may stay calls.
        let mut of = [Turned::NONE; N];
        for (it, tensor) in of.iter_mut().zip(tensors) {
            *it = Turned::of(tensor);
        }
        for _ in 0..SWEEPS {
            let mut is_turning = false;
            for it in &mut of {
                is_turning |= rotate::<T, 0, 1, 2>(&mut it.a, &mut it.axes);
            }
            for it in &mut of {
                is_turning |= rotate::<T, 0, 2, 1>(&mut it.a, &mut it.axes);
            }
            for it in &mut of {
                is_turning |= rotate::<T, 1, 2, 0>(&mut it.a, &mut it.axes);
            }
            if !is_turning {
                break;
            }
        }
        let mut spectra = [Spectrum { values: [T::ZERO; 3], frame: Frame::Space([[T::ZERO; 3]; 3]) }; N];
        for (spectrum, it) in spectra.iter_mut().zip(&of) {
            *spectrum = it.spectrum();
        }
        spectra
    }
}

/// A tensor in axes that are turned until they are principal ones.
#[derive(Clone, Copy)]
struct Turned<T> {
    /// Its entries over `scale`.
    a: [[T; 3]; 3],
    axes: [[T; 3]; 3],
    /// The largest entry.
    scale: T,
    /// Of its entries: finite where they are.
    sum: T,
}

impl<T: Number> Turned<T> {
    /// No tensor yet.
    const NONE: Self = Self { a: [[T::ZERO; 3]; 3], axes: [[T::ZERO; 3]; 3], scale: T::ZERO, sum: T::ZERO };

    #[inline(always)]
    fn of(tensor: &SymmetricTensor<T>) -> Self {
        let SymmetricTensor { xx, yy, zz, xy, yz, zx } = *tensor;
        let mut a = [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]];
        let (mut scale, mut sum) = (T::ZERO, T::ZERO);
        for entry in a.as_flattened() {
            let size = entry.absolute();
            scale = T::pick(size.above(scale), size, scale);
            sum += *entry;
        }
        let (one, zero) = (T::of(1.0), T::ZERO);
        let axes = [[one, zero, zero], [zero, one, zero], [zero, zero, one]];
        // A tensor that is not finite does not turn.
        let is_finite = sum.absolute().below(T::of(f64::INFINITY));
        // Entries of at most one, so that no square under- or overflows.
        for entry in a.as_flattened_mut() {
            *entry = T::pick(is_finite, *entry / scale, T::ZERO);
        }
        Self { a, axes, scale, sum }
    }

    #[inline(always)]
    fn spectrum(&self) -> Spectrum<T> {
        let Self { a, axes, scale, sum } = *self;
        let is_finite = sum.absolute().below(T::of(f64::INFINITY));
        let value = |k: usize| T::pick(is_finite, a[k][k] * scale, T::of(f64::NAN));
        Spectrum { values: [value(0), value(1), value(2)], frame: Frame::Space(axes) }
    }
}

/// Gives a number another value in some lanes.
#[inline(always)]
fn set<T: Number>(lanes: T::Mask, to: &mut T, value: T) {
    *to = T::pick(lanes, value, *to);
}

/// Turns axes `P` and `Q` so that `a[P][Q]` vanishes, and says so, unless it is negligible
/// already; `R` is the third axis. (Indices known at compile time save a fifth of the time.)
#[inline(always)]
fn rotate<T: Number, const P: usize, const Q: usize, const R: usize>(
    a: &mut [[T; 3]; 3],
    axes: &mut [[T; 3]; 3],
) -> bool {
    // Beyond round-off of the largest entry, one.
    const NEGLIGIBLE: f64 = 0.01 * f64::EPSILON;

    let a_pq = a[P][Q];
    let turns = a_pq.absolute().above(T::of(NEGLIGIBLE));
    if !T::any(turns) {
        return false;
    }
    // The tangent t of the angle: the smaller root of a_pq t² + (a_qq − a_pp) t − a_pq = 0.
    let gap = a[Q][Q] - a[P][P];
    let double = T::of(2.0) * a_pq;
    let square = double * double;
    let sum = gap + (gap * gap + square).root().signed_as(gap);
    let t = double / sum;
    // The cosine 1/√(1 + t²), without waiting for t.
    let c = sum.absolute() / (sum * sum + square).root();
    let s = t * c;

    let (a_pp, a_qq) = (a[P][P] - t * a_pq, a[Q][Q] + t * a_pq);
    set(turns, &mut a[P][P], a_pp);
    set(turns, &mut a[Q][Q], a_qq);
    set(turns, &mut a[P][Q], T::ZERO);
    a[Q][P] = a[P][Q];
    let (a_rp, a_rq) = (a[R][P], a[R][Q]);
    set(turns, &mut a[R][P], c * a_rp - s * a_rq);
    set(turns, &mut a[R][Q], s * a_rp + c * a_rq);
    a[P][R] = a[R][P];
    a[Q][R] = a[R][Q];
    for n in axes {
        let (n_p, n_q) = (n[P], n[Q]);
        set(turns, &mut n[P], c * n_p - s * n_q);
        set(turns, &mut n[Q], s * n_p + c * n_q);
    }
    true
}

/// Σ_a values_a n_ia n_ja.
#[inline(always)]
fn entry<T: Number>(values: &[T; 3], n_i: &[T; 3], n_j: &[T; 3]) -> T {
    values[0] * n_i[0] * n_j[0] + values[1] * n_i[1] * n_j[1] + values[2] * n_i[2] * n_j[2]
}

impl<T: Number> Frame<T> {
    /// The tensor Σ_a values_a n_a ⊗ n_a.
    #[inline(always)]
    pub fn compose(&self, values: &[T; 3]) -> SymmetricTensor<T> {
        match self {
            Self::Plane { cos_2, sin_2 } => {
                let mean = T::of(0.5) * (values[0] + values[1]);
                let radius = T::of(0.5) * (values[0] - values[1]);
                SymmetricTensor {
                    xx: mean + radius * *cos_2,
                    yy: mean - radius * *cos_2,
                    zz: values[2],
                    xy: radius * *sin_2,
                    yz: T::ZERO,
                    zx: T::ZERO,
                }
            }
            Self::Space(n) => SymmetricTensor {
                xx: entry(values, &n[0], &n[0]),
                yy: entry(values, &n[1], &n[1]),
                zz: entry(values, &n[2], &n[2]),
                xy: entry(values, &n[0], &n[1]),
                yz: entry(values, &n[1], &n[2]),
                zx: entry(values, &n[2], &n[0]),
            },
        }
    }

    /// The axes as columns.
    #[inline(always)]
    pub fn axes(&self) -> [[T; 3]; 3] {
        match *self {
            Self::Plane { cos_2, sin_2 } => {
                let (one, half) = (T::of(1.0), T::of(0.5));
                // Half the angle, −½π < θ ≤ ½π, from whichever of the two sums does not cancel.
                let is_flat = cos_2.compare(T::ZERO, |cos_2, zero| cos_2 >= zero);
                let long_cos = (half * (one + cos_2)).root();
                let long_sin = (half * (one - cos_2)).root().signed_as(sin_2);
                let cos = T::pick(is_flat, long_cos, half * sin_2 / long_sin);
                let sin = T::pick(is_flat, half * sin_2 / long_cos, long_sin);
                let zero = T::ZERO;
                [[cos, -sin, zero], [sin, cos, zero], [zero, zero, one]]
            }
            Self::Space(axes) => axes,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elementary::ln_1p;
    use crate::lanes::Lanes;
    use nalgebra::{Matrix3, Vector3};

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

    fn matrix(frame: &Frame) -> Matrix3<f64> {
        Matrix3::from(frame.axes()).transpose()
    }

    fn distance(a: &SymmetricTensor, b: &SymmetricTensor) -> f64 {
        (a.to_matrix() - b.to_matrix()).norm()
    }

    /// Orthonormal axes that diagonalise the tensor, all to a few units in the last place.
    fn check(tensor: &SymmetricTensor, spectrum: &Spectrum) {
        let n = matrix(&spectrum.frame);
        let scale = tensor.norm();
        assert!((n.transpose() * n - Matrix3::identity()).norm() < 3e-15, "{tensor:?}");
        let diagonal = n.transpose() * tensor.to_matrix() * n;
        let error = (diagonal - Matrix3::from_diagonal(&spectrum.values.into())).norm();
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
                    ours.sort_by(f64::total_cmp);
                    theirs.sort_by(f64::total_cmp);
                    let distance = Vector3::from(ours) - Vector3::from(theirs);
                    assert!(distance.norm() <= 1e-15 * size, "{tensor:?}");
                }
            }
        }
    }

    #[test]
    fn plane_response_equals_the_general_one() {
        for gap in GAPS {
            for step in -8..=8 {
                let excess = plane(0.8, 0.8 - gap, -0.3, 0.2 * f64::from(step));
                let log = |spectrum: Spectrum| spectrum.frame.compose(&spectrum.values.map(|c| 0.5 * ln_1p(c)));
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
            assert_eq!(matrix(&frame), Matrix3::identity());
            assert_eq!(frame.compose(&values), tensor);
        }
    }

    #[test]
    fn values_too_small_to_square_stay_finite() {
        for size in [1e-150, 1e-160, 1e-300, 5e-324] {
            for tensor in [plane(size, -size, 0.0, 0.3), space([size, -size, 0.5 * size])] {
                let Spectrum { values, frame } = Spectrum::of(&tensor);
                assert!(values.iter().all(|value| value.abs() <= 2.0 * size), "{tensor:?}");
                assert!(frame.axes().as_flattened().iter().all(|component| component.is_finite()));
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

    /// Four tensors at once have the bits of each alone, also where some of them have long converged.
    #[test]
    fn four_at_once_are_four() {
        let four = [
            space([0.1, 0.2, 0.3]),
            space([1.0, 1.0, 1.0 + 1e-9]),
            space([5e-324, 0.0, 1.0]),
            SymmetricTensor::ZERO,
        ];
        let lanes = |get: fn(&SymmetricTensor) -> f64| Lanes(four.each_ref().map(get));
        let tensor = SymmetricTensor {
            xx: lanes(|t| t.xx),
            yy: lanes(|t| t.yy),
            zz: lanes(|t| t.zz),
            xy: lanes(|t| t.xy),
            yz: lanes(|t| t.yz),
            zx: lanes(|t| t.zx),
        };
        let (plane, full) = (Spectrum::plane(&tensor), Spectrum::in_space(&tensor));
        let bits = |x: f64| if x.is_nan() { 0 } else { x.to_bits() };
        for (k, tensor) in four.iter().enumerate() {
            for (all, one) in [(&plane, Spectrum::plane(tensor)), (&full, Spectrum::space(tensor))] {
                for a in 0..3 {
                    assert_eq!(bits(all.values[a].0[k]), bits(one.values[a]), "{tensor:?}");
                    for i in 0..3 {
                        assert_eq!(
                            bits(all.frame.axes()[i][a].0[k]),
                            bits(one.frame.axes()[i][a]),
                            "{tensor:?}"
                        );
                    }
                }
            }
        }
    }
}

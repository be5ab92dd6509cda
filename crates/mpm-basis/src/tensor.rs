//! Determinant, inverse and right stretch of 1×1, 2×2 and 3×3 matrices.

use mpm_grid::{Block, Vector};

/// The determinant.
#[inline]
pub(crate) fn determinant<const D: usize>(m: &Block<D>) -> f64 {
    match D {
        1 => m[(0, 0)],
        2 => m[(0, 0)] * m[(1, 1)] - m[(0, 1)] * m[(1, 0)],
        3 => {
            let minor = |a: usize, b: usize| m[(1, a)] * m[(2, b)] - m[(1, b)] * m[(2, a)];
            m[(0, 0)] * minor(1, 2) + m[(0, 1)] * minor(2, 0) + m[(0, 2)] * minor(0, 1)
        }
        _ => unreachable!("space has one, two or three dimensions"),
    }
}

/// `M⁻ᵀ`, the cofactors over the determinant; not finite where M is singular, so that whatever is made
/// of it is refused later.
#[inline]
pub(crate) fn inverse_transpose<const D: usize>(m: &Block<D>) -> Block<D> {
    let per_det = 1.0 / determinant(m);
    Block::from_fn(|i, j| match D {
        1 => per_det,
        2 if i == j => m[(1 - i, 1 - j)] * per_det,
        2 => -m[(1 - i, 1 - j)] * per_det,
        _ => {
            let (a, b, c, d) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
            (m[(a, c)] * m[(b, d)] - m[(a, d)] * m[(b, c)]) * per_det
        }
    })
}

/// `U = √(FᵀF)` of an F with positive determinant.
///
/// U = QᵀF with the rotation Q of the polar decomposition. In the plane Q turns by the angle of
/// `(F_xx + F_yy, F_yx - F_xy)`, in closed form; else by Newton's iteration `Q ← ½ (γQ + (γQ)⁻ᵀ)` from
/// Q = F, scaled by `γ = (det Q)^(-1/D)` (Higham 1986).
#[inline]
pub(crate) fn right_stretch<const D: usize>(f: &Block<D>) -> Block<D> {
    if D == 2 {
        let (a, b) = (f[(0, 0)] + f[(1, 1)], f[(1, 0)] - f[(0, 1)]);
        let per_norm = 1.0 / (a * a + b * b).sqrt();
        let (cos, sin) = (a * per_norm, b * per_norm);
        let shear = cos * f[(0, 1)] + sin * f[(1, 1)];
        return Block::from_fn(|i, j| match (i, j) {
            (0, 0) => cos * f[(0, 0)] + sin * f[(1, 0)],
            (1, 1) => cos * f[(1, 1)] - sin * f[(0, 1)],
            _ => shear,
        });
    }
    right_stretch_iterated(f)
}

fn right_stretch_iterated<const D: usize>(f: &Block<D>) -> Block<D> {
    let mut q = *f;
    // Unscaled stretches of 1e±16 take 9 iterations; the bound only ends what is not a number.
    for _ in 0..40 {
        let scaled = q * determinant(&q).powf(-1.0 / D as f64);
        let next = (scaled + inverse_transpose(&scaled)) * 0.5;
        let change = (next - q).norm();
        q = next;
        // Convergence is quadratic: the next change would be of the order of rounding.
        if change <= 1e-9 {
            break;
        }
    }
    let u = q.tr_mul(f);
    (u + u.transpose()) * 0.5
}

/// The corner `x + Σ_d ±r_d` of a parallelepiped with half-vectors `r_d`, and its signs: plus where
/// bit d of `corner` is set.
#[inline]
pub(crate) fn signs<const D: usize>(corner: usize) -> Vector<D> {
    Vector::from_fn(|d, _| if corner >> d & 1 == 1 { 1.0 } else { -1.0 })
}

/// Corners in lexicographic order rearranged for drawing: round the outline in the plane.
pub(crate) fn outline<const D: usize>(corners: &[Vector<D>]) -> Vec<Vector<D>> {
    match corners {
        &[a, b, c, d] => vec![a, b, d, c],
        corners => corners.to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix2, Matrix3};

    #[test]
    fn determinants_agree_with_nalgebra_and_inverses_invert() {
        let plane = Matrix2::new(1.2, -0.3, 0.4, 0.9);
        let solid = Matrix3::new(1.2, -0.3, 0.1, 0.4, 0.9, -0.2, 0.05, 0.3, 1.1);
        assert!((determinant(&plane) - plane.determinant()).abs() < 1e-15);
        assert!((determinant(&solid) - solid.determinant()).abs() < 1e-15);
        assert!((inverse_transpose(&plane).transpose() * plane - Matrix2::identity()).norm() < 1e-15);
        assert!((inverse_transpose(&solid).transpose() * solid - Matrix3::identity()).norm() < 1e-15);
        assert!(inverse_transpose(&Matrix2::new(1.0, 2.0, 2.0, 4.0)).iter().all(|it| !it.is_finite()));
    }

    #[test]
    fn right_stretch_squares_to_the_cauchy_green_tensor() {
        let identity = Matrix3::<f64>::identity();
        assert_eq!(right_stretch(&identity), identity);
        for stretch in [1.0, 30.0, 1e4] {
            let f = Matrix3::new(1.2, -0.3, 0.1, 0.4, 0.9, -0.2, 0.05, 0.3, 1.1)
                * Matrix3::from_diagonal(&[stretch, 1.0, 1.0 / stretch].into());
            let u = right_stretch(&f);
            let c = f.transpose() * f;
            assert!((u * u - c).norm() < 1e-14 * c.norm(), "{stretch}");
            assert!(u.symmetric_eigenvalues().iter().all(|&it| it > 0.0), "{stretch}");
        }
        // In the plane U = (C + J I)/√(tr C + 2 J); here past a quarter turn.
        let f = Matrix2::new(-0.4, -1.1, 0.9, -0.2);
        let (c, j): (Matrix2<f64>, f64) = (f.transpose() * f, f.determinant());
        let expected = (c + Matrix2::identity() * j) / (c.trace() + 2.0 * j).sqrt();
        assert!((right_stretch(&f) - expected).norm() < 1e-15);
        assert!((right_stretch_iterated(&f) - expected).norm() < 1e-15);
        assert_eq!(right_stretch(&Matrix2::<f64>::identity()), Matrix2::identity());
        // Long and thin, the short side keeps its digits.
        let thin = Matrix2::new(0.8, -0.6, 0.6, 0.8) * Matrix2::new(1e6, 0.0, 0.0, 1e-6);
        let u = right_stretch(&thin);
        assert!((u[(0, 0)] - 1e6).abs() < 1e-9 && (u[(1, 1)] - 1e-6).abs() < 1e-10);
    }
}

//! From a displacement gradient to the trial elastic state, and small dense algebra in D dimensions.

use mpm_grid::{Block, Vector};
use mpm_material::elementary::exp_m1;
use mpm_material::lanes::Number;
use mpm_material::{SymmetricTensor, largest_log_stretch};

/// Inverse and determinant of a 1×1, 2×2 or 3×3 matrix; the inverse is meaningless where the
/// determinant is zero.
#[inline]
pub(crate) fn inverse_and_determinant<const D: usize>(m: &Block<D>) -> (Block<D>, f64) {
    let (inverse, determinant) = inverse_of(&m.data.0);
    (inverse.into(), determinant)
}

/// The same of columns, of one matrix or of four.
#[inline(always)]
pub(crate) fn inverse_of<T: Number, const D: usize>(m: &[[T; D]; D]) -> ([[T; D]; D], T) {
    let mut inverse = [[T::ZERO; D]; D];
    let one = T::of(1.0);
    let determinant = match D {
        1 => {
            inverse[0][0] = one / m[0][0];
            m[0][0]
        }
        2 => {
            let determinant = m[0][0] * m[1][1] - m[1][0] * m[0][1];
            let scale = one / determinant;
            inverse[0][0] = m[1][1] * scale;
            inverse[1][0] = -m[1][0] * scale;
            inverse[0][1] = -m[0][1] * scale;
            inverse[1][1] = m[0][0] * scale;
            determinant
        }
        3 => {
            // Loops, not closures: those may stay calls.
            for (i, column) in inverse.iter_mut().enumerate() {
                for (j, cofactor) in column.iter_mut().enumerate() {
                    let (a, b) = ((i + 1) % 3, (i + 2) % 3);
                    let (c, d) = ((j + 1) % 3, (j + 2) % 3);
                    *cofactor = m[c][a] * m[d][b] - m[d][a] * m[c][b];
                }
            }
            let determinant = m[0][0] * inverse[0][0] + m[1][0] * inverse[0][1] + m[2][0] * inverse[0][2];
            let scale = one / determinant;
            for entry in inverse.as_flattened_mut() {
                *entry = *entry * scale;
            }
            determinant
        }
        _ => unreachable!("space has one, two or three dimensions"),
    };
    (inverse, determinant)
}

/// `ΔF - I` of a load step.
#[derive(Clone, Copy)]
pub(crate) struct StepGradient<const D: usize> {
    /// Of the D coordinates, `Σ_v Δu_v ⊗ ∇S_vp`.
    pub block: Block<D>,
    /// Of the hoop, `k = Σ_v S_vp Δu_v,r / r_p`; 0 where there is none. With twist (D = 3) it is the last entry of the
    /// block, too.
    pub hoop: f64,
}

impl<const D: usize> StepGradient<D> {
    /// Of a point at radius `radius` `[L]` (which counts where there is a hoop); the rest runs over its nodes.
    #[inline(always)]
    pub fn of<const HOOP: bool>(
        increment: &[Vector<D>],
        (values, gradients): (&[f64], &[Vector<D>]),
        radius: f64,
    ) -> Self {
        let mut hoop = 0.0;
        if HOOP {
            hoop = increment.iter().zip(values).map(|(u, value)| u[0] * value).sum::<f64>() / radius;
        }
        let mut block = gradient(increment, gradients);
        if HOOP && D == 3 {
            // The angle of the step φ makes `ρ ∂φ/∂r` and `ρ ∂φ/∂z` with the radius at its end.
            for j in 0..D {
                block[(D - 1, j)] *= radius * (1.0 + hoop);
            }
            block[(D - 1, D - 1)] = hoop;
        }
        Self { block, hoop }
    }

    /// `det ΔF - 1` without forming the difference.
    #[inline]
    pub fn determinant_excess<const HOOP: bool>(&self) -> f64 {
        let in_plane = determinant_excess(&self.block);
        if HOOP && D == 2 { in_plane + self.hoop + in_plane * self.hoop } else { in_plane }
    }

    /// `b_tr - I` from `c = b_e,n - I`, see [`trial_excess`].
    #[inline]
    pub fn trial_excess<const HOOP: bool>(&self, excess: &SymmetricTensor) -> SymmetricTensor {
        trial_excess::<f64, D, HOOP>(&self.block.data.0, self.hoop, excess)
    }
}

/// The largest |ln λ| of points, λ the principal stretches of their ΔF in a load step `[-]`.
#[derive(Clone, Copy, Default)]
pub(crate) struct LargestStrain {
    pub strain: f64,
    /// Steps with `|ΔF ΔFᵀ - I|` up to this have no larger one, because |ln λ| is at most -½ ln(1 - |ΔF ΔFᵀ - I|).
    covered: f64,
}

impl LargestStrain {
    /// Takes a point into account, whose ΔF (in the plane with the hoop's stretch beside it) is this.
    #[inline]
    pub fn see<const D: usize, const HOOP: bool>(&mut self, step: &Block<D>, hoop: f64) {
        let gradient = StepGradient { block: step - Block::identity(), hoop: hoop - 1.0 };
        let excess = gradient.trial_excess::<HOOP>(&SymmetricTensor::ZERO);
        if excess.norm() > self.covered {
            self.join(largest_log_stretch(&excess));
        }
    }

    /// Takes the largest of other points into account.
    pub fn join(&mut self, strain: f64) {
        if strain > self.strain {
            (self.strain, self.covered) = (strain, -exp_m1(-2.0 * strain));
        }
    }
}

/// The determinant of a 1×1, 2×2 or 3×3 matrix `[-]`.
#[inline]
pub fn determinant<const D: usize>(f: &Block<D>) -> f64 {
    inverse_and_determinant(f).1
}

/// `det(I + H) - 1` without forming the difference.
#[inline]
pub(crate) fn determinant_excess<const D: usize>(h: &Block<D>) -> f64 {
    match D {
        1 => h[(0, 0)],
        2 => (h[(0, 0)] + h[(1, 1)]) + (h[(0, 0)] * h[(1, 1)] - h[(0, 1)] * h[(1, 0)]),
        _ => {
            let minor = |i: usize, j: usize| h[(i, i)] * h[(j, j)] - h[(i, j)] * h[(j, i)];
            h.trace() + (minor(0, 1) + minor(1, 2) + minor(2, 0)) + inverse_and_determinant(h).1
        }
    }
}

/// `b_tr - I` of `b_tr = ΔF b_e,n ΔFᵀ` from the columns of `ΔF = I + H` and `c = b_e,n - I`, without forming either
/// difference, so that strains of 1e-10 keep their digits:
/// `b_tr - I = H + Hᵀ + H Hᵀ + ΔF c ΔFᵀ`; of the hoop `2k + k² + c_θθ (1 + k)²`. Of one point or of four.
///
/// With D = 2 (plane strain) the third row and column of ΔF are those of the identity.
#[inline(always)]
pub(crate) fn trial_excess<T: Number, const D: usize, const HOOP: bool>(
    h: &[[T; D]; D],
    hoop: T,
    excess: &SymmetricTensor<T>,
) -> SymmetricTensor<T> {
    let (c, one) = (excess, T::of(1.0));
    match D {
        2 => {
            let (hxx, hxy, hyx, hyy) = (h[0][0], h[1][0], h[0][1], h[1][1]);
            let (fxx, fyy) = (one + hxx, one + hyy);
            // Rows of ΔF c.
            let (pxx, pxy) = (fxx * c.xx + hxy * c.xy, fxx * c.xy + hxy * c.yy);
            let (pyx, pyy) = (hyx * c.xx + fyy * c.xy, hyx * c.xy + fyy * c.yy);
            let stretch = one + hoop;
            SymmetricTensor {
                xx: (hxx + hxx) + (hxx * hxx + hxy * hxy) + (pxx * fxx + pxy * hxy),
                yy: (hyy + hyy) + (hyx * hyx + hyy * hyy) + (pyx * hyx + pyy * fyy),
                xy: (hxy + hyx) + (hxx * hyx + hxy * hyy) + (pxx * hyx + pxy * fyy),
                zz: if HOOP { (hoop + hoop) + hoop * hoop + c.zz * (stretch * stretch) } else { c.zz },
                yz: T::ZERO,
                zx: T::ZERO,
            }
        }
        3 => {
            let rows = [[c.xx, c.xy, c.zx], [c.xy, c.yy, c.yz], [c.zx, c.yz, c.zz]];
            // Row, then column.
            let mut by_row = [[T::ZERO; 3]; 3];
            for i in 0..3 {
                for j in 0..3 {
                    by_row[i][j] = h[j][i];
                }
            }
            let h = by_row;
            let mut f = h;
            for (i, row) in f.iter_mut().enumerate() {
                row[i] += one;
            }
            let mut fc = [[T::ZERO; 3]; 3];
            for i in 0..3 {
                for j in 0..3 {
                    fc[i][j] = f[i][0] * rows[0][j] + f[i][1] * rows[1][j] + f[i][2] * rows[2][j];
                }
            }
            let mut entries = [T::ZERO; 6];
            for (entry, (i, j)) in entries.iter_mut().zip([(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)]) {
                let (mut hh, mut fcf) = (T::ZERO, T::ZERO);
                for k in 0..3 {
                    hh += h[i][k] * h[j][k];
                    fcf += fc[i][k] * f[j][k];
                }
                *entry = (h[i][j] + h[j][i]) + hh + fcf;
            }
            let [xx, yy, zz, xy, yz, zx] = entries;
            SymmetricTensor { xx, yy, zz, xy, yz, zx }
        }
        _ => unreachable!("a body lives in the plane or in space"),
    }
}

/// In-plane part of a symmetric tensor, all of it in 3-D.
#[inline]
pub(crate) fn block<const D: usize>(t: &SymmetricTensor) -> Block<D> {
    let full = [[t.xx, t.xy, t.zx], [t.xy, t.yy, t.yz], [t.zx, t.yz, t.zz]];
    Block::from_fn(|i, j| full[i][j])
}

/// `Σ_v Δu_v ⊗ ∇S_vp`.
#[inline]
fn gradient<const D: usize>(increment: &[Vector<D>], gradients: &[Vector<D>]) -> Block<D> {
    let mut h = Block::zeros();
    for (u, g) in increment.iter().zip(gradients) {
        for j in 0..D {
            for i in 0..D {
                h[(i, j)] += u[i] * g[j];
            }
        }
    }
    h
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix2, Matrix3};

    fn excess_of<const D: usize>(h: &Block<D>, excess: &SymmetricTensor) -> SymmetricTensor {
        StepGradient { block: *h, hoop: 0.0 }.trial_excess::<false>(excess)
    }

    #[test]
    fn inverses_agree_with_nalgebra() {
        let plane = Matrix2::new(1.2, -0.3, 0.4, 0.9);
        let (inverse, determinant) = inverse_and_determinant(&plane);
        assert!((inverse * plane - Matrix2::identity()).norm() < 1e-15);
        assert!((determinant - plane.determinant()).abs() < 1e-15);
        let solid = Matrix3::new(1.2, -0.3, 0.1, 0.4, 0.9, -0.2, 0.05, 0.3, 1.1);
        let (inverse, determinant) = inverse_and_determinant(&solid);
        assert!((inverse * solid - Matrix3::identity()).norm() < 1e-15);
        assert!((determinant - solid.determinant()).abs() < 1e-15);
    }

    #[test]
    fn trial_excess_is_the_push_forward_minus_identity() {
        let c = SymmetricTensor { xx: 0.2, yy: -0.1, zz: 0.05, xy: 0.07, yz: -0.03, zx: 0.02 };
        let h = Matrix3::new(0.1, -0.3, 0.1, 0.4, -0.2, -0.2, 0.05, 0.3, 0.15);
        let f = Matrix3::identity() + h;
        let expected = f * (Matrix3::identity() + c.to_matrix()) * f.transpose() - Matrix3::identity();
        assert!((excess_of(&h, &c).to_matrix() - expected).norm() < 1e-15);

        let c = SymmetricTensor { yz: 0.0, zx: 0.0, ..c };
        let h = Matrix2::new(0.1, -0.3, 0.4, -0.2);
        let mut f = Matrix3::identity();
        f.fixed_view_mut::<2, 2>(0, 0).copy_from(&(Matrix2::identity() + h));
        let expected = f * (Matrix3::identity() + c.to_matrix()) * f.transpose() - Matrix3::identity();
        assert!((excess_of(&h, &c).to_matrix() - expected).norm() < 1e-15);
    }

    #[test]
    fn the_hoop_is_the_third_axis() {
        let c = SymmetricTensor { xx: 0.2, yy: -0.1, zz: 0.05, xy: 0.07, ..SymmetricTensor::ZERO };
        let step = StepGradient { block: Matrix2::new(0.1, -0.3, 0.4, -0.2), hoop: 0.15 };
        let mut h = Matrix3::zeros();
        h.fixed_view_mut::<2, 2>(0, 0).copy_from(&step.block);
        h[(2, 2)] = step.hoop;
        let trial = step.trial_excess::<true>(&c).to_matrix();
        assert!((trial - excess_of(&h, &c).to_matrix()).norm() < 1e-15);
        assert!((step.determinant_excess::<true>() - determinant_excess(&h)).abs() < 1e-15);
    }

    #[test]
    fn tiny_strains_keep_their_digits() {
        let h = Matrix2::new(1e-12, 3e-13, 0.0, -2e-12);
        let excess = excess_of(&h, &SymmetricTensor::ZERO);
        assert!((excess.xx / (2e-12 + 1e-24 + 9e-26) - 1.0).abs() < 1e-15);
    }

    /// Simple shear γ has the principal strains ± asinh(γ/2), whatever rotation comes on top; its volume does not change.
    #[test]
    fn the_strain_of_a_step_sees_shear_and_no_rotation() {
        let turned = |gamma: f64, angle: f64| {
            let (s, c) = angle.sin_cos();
            Block::<2>::new(c, -s, s, c) * Block::<2>::new(1.0, gamma, 0.0, 1.0)
        };
        let mut largest = LargestStrain::default();
        for (gamma, angle) in [(0.5, 0.0), (1.0, 2.5), (0.9, 0.3), (0.0, 3.0)] {
            largest.see::<2, false>(&turned(gamma, angle), 1.0);
        }
        assert!((largest.strain - 0.5_f64.asinh()).abs() < 1e-14, "{}", largest.strain);
        // A hoop counts as the others do.
        largest.see::<2, true>(&Block::identity(), 0.5);
        assert!((largest.strain - 2.0_f64.ln()).abs() < 1e-15, "{}", largest.strain);
        largest.see::<3, false>(&Block::from_diagonal(&Vector::<3>::new(1.0, 3.0, 1.0)), 1.0);
        assert!((largest.strain - 3.0_f64.ln()).abs() < 1e-15, "{}", largest.strain);
    }
}

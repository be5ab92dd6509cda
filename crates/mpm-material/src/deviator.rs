//! Volume and shape of principal strains, and the tangent of laws that see only two numbers of them.

use nalgebra::{Matrix3, Vector3};

/// √(2/3): with q = √(3/2) |dev τ| and ε_s = √(2/3) |e|, dev τ = √(2/3) q n and e = √(3/2) ε_s n.
const ROOT: f64 = 0.816_496_580_927_726;

const THIRD: f64 = 1.0 / 3.0;

/// Principal strains in two parts, ε = ⅓ ε_v 1 + |e| n.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Deviator {
    /// Volumetric strain ε_v = Σ ε_a.
    pub volumetric: f64,
    /// Deviator e.
    pub strain: Vector3<f64>,
    /// |e|.
    pub norm: f64,
}

impl Deviator {
    /// Differences of strains are exact where strains are nearly equal, so that n keeps its digits there;
    /// those of ε_a − ⅓ ε_v would not.
    #[inline]
    pub fn of(strain: &Vector3<f64>) -> Self {
        let (d01, d12, d20) = (strain[0] - strain[1], strain[1] - strain[2], strain[2] - strain[0]);
        let e = Vector3::new(d01 - d20, d12 - d01, d20 - d12) * THIRD;
        Self { volumetric: strain.sum(), strain: e, norm: e.norm() }
    }

    /// n = e/|e|; zero where e is.
    #[inline]
    pub fn direction(&self) -> Vector3<f64> {
        // What is no number has no direction either.
        if self.norm == 0.0 { Vector3::zeros() } else { self.strain / self.norm }
    }

    /// Deviatoric strain ε_s = √(2/3) |e|.
    #[inline]
    pub fn shear(&self) -> f64 {
        ROOT * self.norm
    }

    /// The strains ⅓ `volumetric` 1 + β e.
    #[inline]
    pub fn strains(&self, volumetric: f64, beta: f64) -> Vector3<f64> {
        (self.strain * beta).add_scalar(volumetric / 3.0)
    }

    /// The stresses −p 1 + √(2/3) q n.
    #[inline]
    pub fn stresses(&self, p: f64, q: f64) -> Vector3<f64> {
        (self.direction() * (ROOT * q)).add_scalar(-p)
    }

    /// ∂τ_a/∂ε_b of a law in p and q, given `a` = ∂(p, q)/∂(ε_v, ε_s) and the secant S = √(2/3) q/|e|:
    ///
    /// −1⊗(A₁₁ 1 + √(2/3) A₁₂ n) + √(2/3) n⊗(A₂₁ 1 + √(2/3) A₂₂ n) + S (I − ⅓ 1⊗1 − n⊗n).
    ///
    /// Where e = 0, A₂₂ has to be 3S/2, so that n need not be known.
    #[inline]
    pub fn tangent(&self, a: &[[f64; 2]; 2], secant: f64) -> Matrix3<f64> {
        let n = self.direction();
        let [[a11, a12], [a21, a22]] = *a;
        // Row a is one_a 1 + along_a n, with the coefficients gathered first.
        let (row_one, row_n) = (-a11 - secant / 3.0, -ROOT * a12);
        let (col_one, col_n) = (ROOT * a21, ROOT * ROOT * a22 - secant);
        Matrix3::from_fn(|i, j| {
            let identity = if i == j { secant } else { 0.0 };
            identity + (row_one + row_n * n[j]) + n[i] * (col_one + col_n * n[j])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_make_the_whole() {
        let strain = Vector3::new(0.2, -0.3, 0.05);
        let split = Deviator::of(&strain);
        assert!((split.strains(split.volumetric, 1.0) - strain).norm() < 1e-16);
        assert!((split.strain - split.direction() * split.norm).norm() < 1e-16);
        assert!((split.shear() * 1.5_f64.sqrt() - split.norm).abs() < 1e-16);
        let tau = split.stresses(3.0, 5.0);
        assert!((tau.sum() + 9.0).abs() < 1e-14);
        assert!((tau.add_scalar(3.0).norm() * 1.5_f64.sqrt() - 5.0).abs() < 1e-14);
    }

    #[test]
    fn directions_of_nearly_equal_strains_keep_their_digits() {
        let base = 0.3;
        let gaps = [f64::EPSILON, 1e-12, 1e-8];
        for gap in gaps {
            let strain = Vector3::new(base, base + gap, base);
            // The gap as it is after rounding of the sum.
            let exact = strain[1] - base;
            let split = Deviator::of(&strain);
            assert!((split.norm - exact * (2.0_f64 / 3.0).sqrt()).abs() < 1e-15 * exact);
        }
    }

    #[test]
    fn isotropic_elasticity_is_one_of_these_laws() {
        let (k, g) = (1000.0, 300.0);
        let split = Deviator::of(&Vector3::new(0.2, -0.3, 0.05));
        let tangent = split.tangent(&[[-k, 0.0], [0.0, 3.0 * g]], 2.0 * g);
        let hooke = Matrix3::from_diagonal_element(2.0 * g).add_scalar(k - 2.0 / 3.0 * g);
        assert!((tangent - hooke).norm() < 1e-12 * k);
    }
}

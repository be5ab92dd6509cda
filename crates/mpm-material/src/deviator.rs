//! Volume and shape of principal strains, and the tangent of laws that see only two numbers of them.

use crate::lanes::{Number, each};

/// √(2/3): with q = √(3/2) |dev τ| and ε_s = √(2/3) |e|, dev τ = √(2/3) q n and e = √(3/2) ε_s n.
const ROOT: f64 = 0.816_496_580_927_726;

const THIRD: f64 = 1.0 / 3.0;

/// Principal strains in two parts, ε = ⅓ ε_v 1 + |e| n; of one point or of four.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Deviator<T = f64> {
    /// Volumetric strain ε_v = Σ ε_a.
    pub volumetric: T,
    /// Deviator e.
    pub strain: [T; 3],
    /// |e|.
    pub norm: T,
}

impl<T: Number> Deviator<T> {
    /// Differences of strains are exact where strains are nearly equal, so that n keeps its digits there;
    /// those of ε_a − ⅓ ε_v would not.
    #[inline(always)]
    pub fn of(strain: &[T; 3]) -> Self {
        let [a, b, c] = *strain;
        let (ab, bc, ca) = (a - b, b - c, c - a);
        let third = T::of(THIRD);
        let e = [(ab - ca) * third, (bc - ab) * third, (ca - bc) * third];
        Self { volumetric: a + b + c, strain: e, norm: (e[0] * e[0] + e[1] * e[1] + e[2] * e[2]).root() }
    }

    /// n = e/|e|; zero where e is.
    #[inline(always)]
    pub fn direction(&self) -> [T; 3] {
        // What is no number has no direction either.
        let is_none = self.norm.compare(T::ZERO, |norm, zero| norm == zero);
        each(|a| T::pick(is_none, T::ZERO, self.strain[a] / self.norm))
    }

    /// Deviatoric strain ε_s = √(2/3) |e|.
    #[inline(always)]
    pub fn shear(&self) -> T {
        T::of(ROOT) * self.norm
    }

    /// The strains ⅓ `volumetric` 1 + β e.
    #[inline(always)]
    pub fn strains(&self, volumetric: T, beta: T) -> [T; 3] {
        each(|a| self.strain[a] * beta + volumetric / T::of(3.0))
    }

    /// The stresses −p 1 + √(2/3) q n.
    #[inline(always)]
    pub fn stresses(&self, p: T, q: T) -> [T; 3] {
        let n = self.direction();
        each(|a| n[a] * (T::of(ROOT) * q) - p)
    }

    /// ∂τ_a/∂ε_b of a law in p and q, given `a` = ∂(p, q)/∂(ε_v, ε_s) and the secant S = √(2/3) q/|e|:
    ///
    /// −1⊗(A₁₁ 1 + √(2/3) A₁₂ n) + √(2/3) n⊗(A₂₁ 1 + √(2/3) A₂₂ n) + S (I − ⅓ 1⊗1 − n⊗n).
    ///
    /// Where e = 0, A₂₂ has to be 3S/2, so that n need not be known.
    #[inline(always)]
    pub fn tangent(&self, a: &[[T; 2]; 2], secant: T) -> [[T; 3]; 3] {
        let n = self.direction();
        let [[a11, a12], [a21, a22]] = *a;
        // Row a is one_a 1 + along_a n, with the coefficients gathered first.
        let (row_one, row_n) = (-a11 - secant / T::of(3.0), T::of(-ROOT) * a12);
        let (col_one, col_n) = (T::of(ROOT) * a21, T::of(ROOT * ROOT) * a22 - secant);
        let row = |i: usize| {
            each(|j| {
                let isotropic = row_one + row_n * n[j];
                let isotropic = if i == j { secant + isotropic } else { isotropic };
                isotropic + n[i] * (col_one + col_n * n[j])
            })
        };
        [row(0), row(1), row(2)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Vector3};

    #[test]
    fn parts_make_the_whole() {
        let strain = Vector3::new(0.2, -0.3, 0.05);
        let split = Deviator::<f64>::of(&strain.into());
        let of = Vector3::from;
        assert!((of(split.strains(split.volumetric, 1.0)) - strain).norm() < 1e-16);
        assert!((of(split.strain) - of(split.direction()) * split.norm).norm() < 1e-16);
        assert!((split.shear() * 1.5_f64.sqrt() - split.norm).abs() < 1e-16);
        let tau = of(split.stresses(3.0, 5.0));
        assert!((tau.sum() + 9.0).abs() < 1e-14);
        assert!((tau.add_scalar(3.0).norm() * 1.5_f64.sqrt() - 5.0).abs() < 1e-14);
    }

    #[test]
    fn directions_of_nearly_equal_strains_keep_their_digits() {
        let base = 0.3;
        let gaps = [f64::EPSILON, 1e-12, 1e-8];
        for gap in gaps {
            let strain = [base, base + gap, base];
            // The gap as it is after rounding of the sum.
            let exact = strain[1] - base;
            let split = Deviator::<f64>::of(&strain);
            assert!((split.norm - exact * (2.0_f64 / 3.0).sqrt()).abs() < 1e-15 * exact);
        }
    }

    #[test]
    fn isotropic_elasticity_is_one_of_these_laws() {
        let (k, g) = (1000.0, 300.0);
        let split = Deviator::<f64>::of(&[0.2, -0.3, 0.05]);
        let rows = split.tangent(&[[-k, 0.0], [0.0, 3.0 * g]], 2.0 * g);
        let tangent = Matrix3::from_fn(|a, b| rows[a][b]);
        let hooke = Matrix3::from_diagonal_element(2.0 * g).add_scalar(k - 2.0 / 3.0 * g);
        assert!((tangent - hooke).norm() < 1e-12 * k);
    }
}

//! A measure of the total shear, and the stress and stiffness that come with it.
//!
//! ```text
//! m(F) = ln(1 + I/4)     I = tr C − 3 − 2 ln J     C = FᵀF, in plane strain tr C + 1
//! ∂m/∂F Fᵀ = M = 2/(4 + I) (b − 1)
//! ```
//!
//! In simple shear by γ: m = 2 ln cosh(asinh(γ/2)), γ²/4 where γ is small and 2 ln(γ/2) where it is large.

use crate::body::kinematics::determinant_excess;
use mpm_grid::Block;
use mpm_material::elementary::ln_1p;

/// m at a deformation gradient, and its derivatives.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShearMeasure<const D: usize> {
    /// m `[-]`.
    pub value: f64,
    /// 1/(4 + I).
    scale: f64,
    /// b − 1 `[-]`.
    excess: Block<D>,
}

impl<const D: usize> ShearMeasure<D> {
    /// Of F, formed without the differences so that small strains keep their digits.
    pub fn of(f: &Block<D>) -> Self {
        let h = f - Block::identity();
        let invariant = 2.0 * h.trace() + h.norm_squared() - 2.0 * ln_1p(determinant_excess(&h));
        Self {
            value: ln_1p(0.25 * invariant),
            scale: 1.0 / (4.0 + invariant),
            excess: h + h.transpose() + h * h.transpose(),
        }
    }

    /// M = ∂m/∂F Fᵀ.
    pub fn slope(&self) -> Block<D> {
        self.excess * (2.0 * self.scale)
    }

    /// Adds h M⊗M + h (m − k) ∂²m/∂F² (both carried to the end of the step) to the blocks `a[k][l][(i, j)]` of a spatial
    /// tangent; `modulus` is h `[F/L²]`:
    ///
    /// ```text
    /// a_ikjl += h (1 − (m − k)) M_ik M_jl + h (m − k)/(4 + I) (2 δ_ij b_kl + 2 δ_kj δ_il)
    /// ```
    pub fn add_tangent(&self, modulus: f64, field: f64, a: &mut [[Block<D>; D]; D]) {
        let slope = self.slope();
        let difference = self.value - field;
        let (dyad, geometric) = (modulus * (1.0 - difference), 2.0 * modulus * difference * self.scale);
        for (k, row) in a.iter_mut().enumerate() {
            for (l, block) in row.iter_mut().enumerate() {
                let b = self.excess[(k, l)] + if k == l { 1.0 } else { 0.0 };
                for j in 0..D {
                    for i in 0..D {
                        block[(i, j)] += dyad * slope[(i, k)] * slope[(j, l)];
                    }
                    block[(j, j)] += geometric * b;
                }
                block[(l, k)] += geometric;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn simple_shear_has_its_closed_form() {
        for shear in [1e-6_f64, 0.3, 5.0] {
            let mut f = Block::<2>::identity();
            f[(0, 1)] = shear;
            let exact = 2.0 * (0.5 * shear).asinh().cosh().ln();
            let found = ShearMeasure::of(&f).value;
            // The closed form itself has but a few digits where the shear is small.
            let expected = if shear < 1e-3 { 0.25 * shear * shear } else { exact };
            assert!((found / expected - 1.0).abs() < 1e-11, "{shear}: {found}");
        }
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        let f = Block::<3>::new(1.1, 0.3, -0.2, 0.1, 0.9, 0.25, -0.05, 0.15, 1.2);
        let (modulus, field, step) = (2.0, 0.013, 1e-6);
        let (here, inverse) = (ShearMeasure::of(&f), f.try_inverse().unwrap());
        let stress = |f: &Block<3>| {
            let measure = ShearMeasure::of(f);
            // First Piola stress h (m − k) M F⁻ᵀ.
            measure.slope() * f.try_inverse().unwrap().transpose() * (modulus * (measure.value - field))
        };
        let mut a = [[Block::<3>::zeros(); 3]; 3];
        here.add_tangent(modulus, field, &mut a);
        for (j, l) in (0..9).map(|n| (n / 3, n % 3)) {
            // δF = e_j ⊗ e_l F, so that the gradient at the end of the step is e_j ⊗ e_l.
            let mut direction = Block::<3>::zeros();
            direction[(j, l)] = 1.0;
            let beside = |by: f64| f + direction * f * by;
            let value =
                (ShearMeasure::of(&beside(step)).value - ShearMeasure::of(&beside(-step)).value) / (2.0 * step);
            assert!((value - here.slope()[(j, l)]).abs() < 1e-9);
            let change = (stress(&beside(step)) - stress(&beside(-step))) / (2.0 * step) * f.transpose();
            for (i, k) in (0..9).map(|n| (n / 3, n % 3)) {
                assert!((change[(i, k)] - a[k][l][(i, j)]).abs() < 1e-8, "{i}{k}{j}{l}");
            }
        }
        assert!((inverse * f - Block::identity()).norm() < 1e-12);
    }
}

//! Symmetric second-order tensors in three dimensions.

use nalgebra::Matrix3;

/// Symmetric second-order tensor in 3-D, by its six components; of [`crate::lanes::Lanes`] four at a time.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct SymmetricTensor<T = f64> {
    /// Component (x, x).
    pub xx: T,
    /// Component (y, y).
    pub yy: T,
    /// Component (z, z).
    pub zz: T,
    /// Components (x, y) and (y, x).
    pub xy: T,
    /// Components (y, z) and (z, y).
    pub yz: T,
    /// Components (z, x) and (x, z).
    pub zx: T,
}

impl SymmetricTensor {
    /// All components zero.
    pub const ZERO: Self = Self { xx: 0.0, yy: 0.0, zz: 0.0, xy: 0.0, yz: 0.0, zx: 0.0 };

    /// The unit tensor.
    pub const IDENTITY: Self = Self { xx: 1.0, yy: 1.0, zz: 1.0, ..Self::ZERO };

    /// The full 3×3 matrix.
    #[inline]
    pub fn to_matrix(&self) -> Matrix3<f64> {
        let Self { xx, yy, zz, xy, yz, zx } = *self;
        Matrix3::new(xx, xy, zx, xy, yy, yz, zx, yz, zz)
    }

    /// Symmetric part ½(A + Aᵀ) of a matrix A.
    #[inline]
    pub fn from_matrix(matrix: &Matrix3<f64>) -> Self {
        let mean = |i, j| 0.5 * (matrix[(i, j)] + matrix[(j, i)]);
        Self {
            xx: matrix[(0, 0)],
            yy: matrix[(1, 1)],
            zz: matrix[(2, 2)],
            xy: mean(0, 1),
            yz: mean(1, 2),
            zx: mean(2, 0),
        }
    }

    /// Sum of the diagonal.
    #[inline]
    pub fn trace(&self) -> f64 {
        self.xx + self.yy + self.zz
    }

    /// Frobenius norm √(A : A), the off-diagonal components counted twice.
    #[inline]
    pub fn norm(&self) -> f64 {
        let Self { xx, yy, zz, xy, yz, zx } = *self;
        (xx * xx + yy * yy + zz * zz + 2.0 * (xy * xy + yz * yz + zx * zx)).sqrt()
    }

    /// Whether z is exactly a principal direction, as in plane strain.
    #[inline]
    pub fn is_plane(&self) -> bool {
        self.yz == 0.0 && self.zx == 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLE: SymmetricTensor = SymmetricTensor { xx: 1.0, yy: 2.0, zz: 3.0, xy: 4.0, yz: 5.0, zx: 6.0 };

    #[test]
    fn matrix_places_every_component_and_returns_it() {
        assert_eq!(SAMPLE.to_matrix(), Matrix3::new(1.0, 4.0, 6.0, 4.0, 2.0, 5.0, 6.0, 5.0, 3.0));
        assert_eq!(SymmetricTensor::from_matrix(&SAMPLE.to_matrix()), SAMPLE);
        assert_eq!(SymmetricTensor::IDENTITY.to_matrix(), Matrix3::identity());
    }

    #[test]
    fn from_matrix_drops_the_skew_part() {
        let skew = Matrix3::new(0.0, 1.0, -2.0, -1.0, 0.0, 3.0, 2.0, -3.0, 0.0);
        assert_eq!(SymmetricTensor::from_matrix(&(SAMPLE.to_matrix() + skew)), SAMPLE);
    }

    #[test]
    fn trace_and_norm_are_those_of_the_matrix() {
        assert_eq!(SAMPLE.trace(), 6.0);
        assert!((SAMPLE.norm() - SAMPLE.to_matrix().norm()).abs() < 1e-14);
    }

    #[test]
    fn plane_means_exactly_no_shear_along_z() {
        assert!(SymmetricTensor { yz: 0.0, zx: -0.0, ..SAMPLE }.is_plane());
        assert!(!SymmetricTensor { yz: 1e-300, zx: 0.0, ..SAMPLE }.is_plane());
        assert!(!SymmetricTensor { yz: 0.0, zx: f64::NAN, ..SAMPLE }.is_plane());
    }
}

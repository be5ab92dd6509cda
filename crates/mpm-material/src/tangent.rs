//! From moduli in principal axes to the spatial tangent that a stiffness matrix is built from.

use nalgebra::{Matrix3, SMatrix, Vector3};

use crate::spectral::Frame;

/// The principal pairs of [`crate::Update::secant`].
const PAIRS: [(usize, usize); 3] = [(0, 1), (1, 2), (2, 0)];

/// Principal axes of a trial state, and the moduli along and between them.
///
/// Made by [`crate::respond`]; all work that only a stiffness needs waits for
/// [`PrincipalTangent::spatial_tangent`].
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct PrincipalTangent {
    pub(crate) frame: Frame,
    /// Principal excess c_a = λ_a² − 1 of the trial state.
    pub(crate) excess: Vector3<f64>,
    /// Trial strains ε_a = ln λ_a.
    pub(crate) strain: Vector3<f64>,
    pub(crate) kirchhoff: Vector3<f64>,
    pub(crate) tangent: Matrix3<f64>,
    pub(crate) secant: Vector3<f64>,
}

impl PrincipalTangent {
    /// Whether the moduli ∂τ_a/∂ε_b are symmetric, to the last bit, and the spatial tangent with them.
    #[inline]
    pub fn is_symmetric(&self) -> bool {
        let d = &self.tangent;
        d[(0, 1)] == d[(1, 0)] && d[(1, 2)] == d[(2, 1)] && d[(2, 0)] == d[(0, 2)]
    }

    /// Spatial tangent a_ikjl = C_ikjl + τ_kl δ_ij [F/L²] as blocks `a[k][l][(i, j)]`.
    ///
    /// It is the derivative of the nodal force V⁰ τ g_v, the geometric part included: a
    /// displacement δu_w of node w changes the force of node v by V⁰ g_v,k a_ikjl g_w,l δu_w,j
    /// where g = ΔF⁻ᵀ∇S. `D` is 2 (the x-y part) or 3.
    ///
    /// C is the derivative of τ as an objective rate and has both minor symmetries. In the
    /// principal axes of the trial state, with D_ab = ∂τ_a/∂ε_b:
    ///
    /// C_aabb = D_ab − 2 τ_a δ_ab, C_abab = (τ_a λ_b² − τ_b λ_a²)/(λ_a² − λ_b²).
    ///
    /// (Bonet and Wood 2008, Nonlinear Continuum Mechanics for Finite Element Analysis,
    /// section 6.6.) It has major symmetry, a_ikjl = a_jlik, where D is symmetric.
    #[inline]
    pub fn spatial_tangent<const D: usize>(&self) -> [[SMatrix<f64, D, D>; D]; D] {
        const { assert!(D == 2 || D == 3, "space has two or three dimensions") };
        match self.frame {
            Frame::Plane { cos_2, sin_2 } if D == 2 => self.in_plane(cos_2, sin_2),
            _ => self.in_space(),
        }
    }

    /// The two in-plane axes only. Their tensors are n₀⊗n₀ = ½(I + Q), n₁⊗n₁ = ½(I − Q) and
    /// n₀⊗n₁ + n₁⊗n₀ = R, so that C has five coefficients in I⊗I, I⊗Q, Q⊗I, Q⊗Q and R⊗R.
    #[inline]
    fn in_plane<const D: usize>(&self, cos_2: f64, sin_2: f64) -> [[SMatrix<f64, D, D>; D]; D] {
        let matrix = |m: [[f64; 2]; 2]| SMatrix::<f64, D, D>::from_fn(|i, j| m[i][j]);
        let one = SMatrix::identity();
        let q = matrix([[cos_2, sin_2], [sin_2, -cos_2]]);
        let r = matrix([[-sin_2, cos_2], [cos_2, sin_2]]);

        let t = &self.kirchhoff;
        let tau = one * (0.5 * (t[0] + t[1])) + q * (0.5 * (t[0] - t[1]));

        let (c00, c11) = (self.normal(0, 0), self.normal(1, 1));
        let (c01, c10) = (self.normal(0, 1), self.normal(1, 0));
        let (sum, cross) = (0.25 * (c00 + c11), 0.25 * (c01 + c10));
        let (difference, skew) = (0.25 * (c00 - c11), 0.25 * (c10 - c01));
        let by_one = one * (sum + cross) + q * (difference + skew);
        let by_q = one * (difference - skew) + q * (sum - cross);
        let by_r = r * self.shear(0);
        blocks(&tau, |i, k| {
            let isotropic = if i == k { by_one } else { SMatrix::zeros() };
            isotropic + by_q * q[(i, k)] + by_r * r[(i, k)]
        })
    }

    /// C = Σ_ab C_aabb (n_a⊗n_a)⊗(n_b⊗n_b) + Σ_pairs C_abab N⊗N, N = n_a⊗n_b + n_b⊗n_a.
    #[inline]
    fn in_space<const D: usize>(&self) -> [[SMatrix<f64, D, D>; D]; D] {
        let n = self.frame.axes();
        // Loops and arrays here, not iterator adaptors: those stay calls, and double the time.
        let dyad = |a, b| SMatrix::<f64, D, D>::from_fn(|i, k| n[(i, a)] * n[(k, b)]);
        let along = [dyad(0, 0), dyad(1, 1), dyad(2, 2)];

        let mut tau = SMatrix::zeros();
        let mut terms = [(SMatrix::zeros(), SMatrix::zeros()); 6];
        for a in 0..3 {
            tau += along[a] * self.kirchhoff[a];
            let row =
                along[0] * self.normal(a, 0) + along[1] * self.normal(a, 1) + along[2] * self.normal(a, 2);
            terms[a] = (along[a], row);

            let (b, c) = PAIRS[a];
            let between = dyad(b, c) + dyad(c, b);
            terms[3 + a] = (between, between * self.shear(a));
        }
        blocks(&tau, |i, k| {
            let mut c = SMatrix::zeros();
            for (p, q) in &terms {
                c += q * p[(i, k)];
            }
            c
        })
    }

    /// C_aabb.
    #[inline]
    fn normal(&self, a: usize, b: usize) -> f64 {
        let geometric = if a == b { 2.0 * self.kirchhoff[a] } else { 0.0 };
        self.tangent[(a, b)] - geometric
    }

    /// C_abab of a pair.
    ///
    /// With z = (λ_a² − λ_b²)/(λ_a² + λ_b²), so that ε_a − ε_b = artanh z, the quotient above is
    /// ½ S_ab (artanh z)/z − ½(τ_a + τ_b), S_ab the secant of stress over strain: the same
    /// number, without the cancellation as λ_a → λ_b.
    #[inline]
    fn shear(&self, pair: usize) -> f64 {
        let (a, b) = PAIRS[pair];
        let (c, eps, tau) = (&self.excess, &self.strain, &self.kirchhoff);
        let z = (c[a] - c[b]) / (2.0 + c[a] + c[b]);
        0.5 * (self.secant[pair] * artanh_ratio(z, eps[a] - eps[b]) - tau[a] - tau[b])
    }
}

/// The blocks a[k][l](i,j) = C_ikjl + τ_kl δ_ij; `moduli(i, k)` is the matrix C_ik·· in (j, l).
/// C is symmetric in i and k, so that half of them do.
#[inline]
fn blocks<const D: usize>(
    tau: &SMatrix<f64, D, D>,
    moduli: impl Fn(usize, usize) -> SMatrix<f64, D, D>,
) -> [[SMatrix<f64, D, D>; D]; D] {
    let mut a = [[SMatrix::zeros(); D]; D];
    for k in 0..D {
        for i in 0..=k {
            let c = moduli(i, k);
            for l in 0..D {
                for j in 0..D {
                    a[k][l][(i, j)] = c[(j, l)];
                    a[i][l][(k, j)] = c[(j, l)];
                }
            }
        }
    }
    for k in 0..D {
        for l in 0..D {
            for i in 0..D {
                a[k][l][(i, i)] += tau[(k, l)];
            }
        }
    }
    a
}

/// (artanh z)/z, given both z and `artanh` = artanh z.
#[inline]
fn artanh_ratio(z: f64, artanh: f64) -> f64 {
    let w = z * z;
    if w < 0.01 {
        // Σ w^m/(2m+1); the first term left out is 6e-18. Pairs keep the chain of
        // dependent operations short.
        let w2 = w * w;
        let low = (1.0 + w * (1.0 / 3.0)) + w2 * (1.0 / 5.0 + w * (1.0 / 7.0));
        let high = (1.0 / 9.0 + w * (1.0 / 11.0)) + w2 * (1.0 / 13.0 + w * (1.0 / 15.0));
        low + w2 * w2 * high
    } else {
        artanh / z
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Elasticity, Hencky, PlasticStrain, SymmetricTensor, VonMises, respond};

    #[test]
    fn artanh_ratio_is_exact_on_both_sides_of_its_switch() {
        // Reference: (ln(1+z) − ln(1−z))/2z, good to round-off for z of this size.
        for step in 0..400 {
            let z = 0.05 + 0.00025 * f64::from(step);
            let artanh = 0.5 * (z.ln_1p() - (-z).ln_1p());
            for signed in [z, -z] {
                let ratio = artanh_ratio(signed, artanh.copysign(signed));
                assert!((ratio - artanh / z).abs() < 1e-15, "z = {signed}");
            }
        }
        let (below, above) = (0.1_f64.next_down(), 0.1_f64.next_up().next_up());
        let jump = artanh_ratio(above, above.atanh()) - artanh_ratio(below, below.atanh());
        assert!(below * below < 0.01 && above * above >= 0.01);
        assert!(jump.abs() < 1e-15);
        assert_eq!(artanh_ratio(0.0, 0.0), 1.0);
    }

    #[test]
    fn shear_modulus_is_the_quotient_and_its_limit() {
        let elasticity = Elasticity::from_young_poisson(1000.0, 0.3).expect("in range");
        let law = VonMises::new(elasticity, 50.0).expect("positive");
        for gap in [1.0, 0.5, 0.1, 1e-2, 1e-3] {
            let b = [2.0, 2.0 - gap, 0.8];
            let excess =
                SymmetricTensor { xx: b[0] - 1.0, yy: b[1] - 1.0, zz: b[2] - 1.0, ..SymmetricTensor::ZERO };
            let modes = respond(&law, &excess, &PlasticStrain::default()).expect("it returns").tangent;
            for (pair, (i, j)) in PAIRS.into_iter().enumerate() {
                let tau = modes.kirchhoff;
                let quotient = (tau[i] * b[j] - tau[j] * b[i]) / (b[i] - b[j]);
                let error = (modes.shear(pair) - quotient).abs();
                assert!(error < 1e-13 / gap * 1000.0, "gap {gap}, pair {pair}: {error}");
            }
        }
        let equal = SymmetricTensor { xx: 0.4, yy: 0.4, zz: -0.1, ..SymmetricTensor::ZERO };
        let modes = respond(&law, &equal, &PlasticStrain::default()).expect("it returns").tangent;
        let d = modes.tangent;
        // With ε_0 = ε_1 also n_0 = n_1, and the flow drops out of the difference.
        let limit = 0.5 * (d[(0, 0)] - d[(0, 1)]) - modes.kirchhoff[0];
        assert!((modes.shear(0) - limit).abs() < 1e-12 * limit.abs());
    }

    #[test]
    fn undeformed_tangent_is_that_of_linear_elasticity() {
        let elasticity = Elasticity::from_young_poisson(1000.0, 0.3).expect("in range");
        let modes = respond(&Hencky(elasticity), &SymmetricTensor::ZERO, &()).expect("it returns").tangent;
        let a = modes.spatial_tangent::<3>();
        let delta = |i, j| if i == j { 1.0 } else { 0.0 };
        for (i, k, j, l) in (0..81).map(|m| (m / 27, m / 9 % 3, m / 3 % 3, m % 3)) {
            let exact = elasticity.lame() * delta(i, k) * delta(j, l)
                + elasticity.shear() * (delta(i, j) * delta(k, l) + delta(i, l) * delta(k, j));
            assert!((a[k][l][(i, j)] - exact).abs() < 1e-12 * 1000.0, "{i}{k}{j}{l}");
        }
    }
}

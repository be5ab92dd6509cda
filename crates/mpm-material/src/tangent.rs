//! From moduli in principal axes to the spatial tangent that a stiffness matrix is built from.

use nalgebra::{Matrix2, SMatrix};

use crate::lanes::Number;
use crate::spectral::Frame;

/// The principal pairs of [`crate::Update::secant`].
const PAIRS: [(usize, usize); 3] = [(0, 1), (1, 2), (2, 0)];

/// Principal axes of a trial state, and the moduli along and between them; of [`crate::lanes::Lanes`] those of four states.
///
/// Made by [`crate::respond`]; all work that only a stiffness needs waits for
/// [`PrincipalTangent::spatial_tangent`].
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct PrincipalTangent<T = f64> {
    pub(crate) frame: Frame<T>,
    /// Principal excess c_a = λ_a² − 1 of the trial state.
    pub(crate) excess: [T; 3],
    /// Trial strains ε_a = ln λ_a.
    pub(crate) strain: [T; 3],
    pub(crate) kirchhoff: [T; 3],
    /// ∂τ_a/∂ε_b as `[a][b]`.
    pub(crate) tangent: [[T; 3]; 3],
    pub(crate) secant: [T; 3],
}

/// Parts of the spatial tangent `a` of [`PrincipalTangent::spatial_tangent`] that belong to θ, a principal axis at right
/// angles to the plane `[F/L²]`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct HoopTangent {
    /// `a_ikθθ = Σ_a D_aθ n_a ⊗ n_a`, over the two axes in the plane: stress in the plane by the stretch of the hoop.
    pub by_hoop: Matrix2<f64>,
    /// `a_θθjl = Σ_a D_θa n_a ⊗ n_a`: stress of the hoop by stretches in the plane. Equals `by_hoop` where D is symmetric.
    pub of_hoop: Matrix2<f64>,
    /// `a_θθθθ = D_θθ - τ_θθ`.
    pub hoop: f64,
}

impl PrincipalTangent {
    /// The [moduli](Self::moduli) as blocks `a[k][l][(i, j)]`.
    #[inline]
    pub fn spatial_tangent<const D: usize>(&self) -> [[SMatrix<f64, D, D>; D]; D] {
        let a = self.moduli::<D>();
        std::array::from_fn(|k| std::array::from_fn(|l| SMatrix::from(a[l][k])))
    }

    /// The spatial tangent between the plane and its normal, which is a principal axis: of a body of revolution, where
    /// the stretch along the hoop is an unknown of the plane.
    #[inline]
    pub fn hoop_tangent(&self) -> HoopTangent {
        let (by_hoop, of_hoop, hoop) = self.hoop_moduli();
        HoopTangent { by_hoop: by_hoop.into(), of_hoop: of_hoop.into(), hoop }
    }
}

impl<T: Number> PrincipalTangent<T> {
    /// Whether the moduli ∂τ_a/∂ε_b are symmetric, to the last bit, and the spatial tangent with them.
    #[inline(always)]
    pub fn is_symmetric(&self) -> T::Mask {
        let same = |a: usize, b: usize| self.tangent[a][b].compare(self.tangent[b][a], |x, y| x == y);
        same(0, 1) & same(1, 2) & same(2, 0)
    }

    /// Spatial tangent a_ikjl = C_ikjl + τ_kl δ_ij [F/L²] as `a[l][k][j][i]`.
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
    #[inline(always)]
    pub fn moduli<const D: usize>(&self) -> [[[[T; D]; D]; D]; D] {
        const { assert!(D == 2 || D == 3, "space has two or three dimensions") };
        match self.frame {
            Frame::Plane { cos_2, sin_2 } if D == 2 => self.in_plane(cos_2, sin_2),
            _ => self.in_space(),
        }
    }

    /// The parts of [`HoopTangent`]: a_ikθθ, a_θθjl and a_θθθθ.
    #[inline(always)]
    pub fn hoop_moduli(&self) -> ([[T; 2]; 2], [[T; 2]; 2], T) {
        match self.frame {
            Frame::Plane { cos_2, sin_2 } => {
                let along = |first: T, second: T| {
                    let (mean, radius) = (T::of(0.5) * (first + second), T::of(0.5) * (first - second));
                    let across = radius * sin_2;
                    [[mean + radius * cos_2, across], [across, mean - radius * cos_2]]
                };
                let d = &self.tangent;
                (along(d[0][2], d[1][2]), along(d[2][0], d[2][1]), d[2][2] - self.kirchhoff[2])
            }
            Frame::Space(_) => {
                let a = self.in_space::<3>();
                let (mut by_hoop, mut of_hoop) = ([[T::ZERO; 2]; 2], [[T::ZERO; 2]; 2]);
                for k in 0..2 {
                    for i in 0..2 {
                        by_hoop[k][i] = a[2][k][2][i];
                        of_hoop[k][i] = a[k][2][i][2];
                    }
                }
                (by_hoop, of_hoop, a[2][2][2][2])
            }
        }
    }

    /// The two in-plane axes only. Their tensors are n₀⊗n₀ = ½(I + Q), n₁⊗n₁ = ½(I − Q) and
    /// n₀⊗n₁ + n₁⊗n₀ = R, so that C has five coefficients in I⊗I, I⊗Q, Q⊗I, Q⊗Q and R⊗R.
    #[inline(always)]
    fn in_plane<const D: usize>(&self, cos_2: T, sin_2: T) -> [[[[T; D]; D]; D]; D] {
        let (half, quarter) = (T::of(0.5), T::of(0.25));
        // Symmetric matrices as xx, yy, xy.
        let (q, r) = ([cos_2, -cos_2, sin_2], [-sin_2, sin_2, cos_2]);
        let isotropic = |one: T, along: T| [one + along * q[0], one + along * q[1], along * q[2]];

        let t = &self.kirchhoff;
        let tau = isotropic(half * (t[0] + t[1]), half * (t[0] - t[1]));

        let (c00, c11) = (self.normal(0, 0), self.normal(1, 1));
        let (c01, c10) = (self.normal(0, 1), self.normal(1, 0));
        let (sum, cross) = (quarter * (c00 + c11), quarter * (c01 + c10));
        let (difference, skew) = (quarter * (c00 - c11), quarter * (c10 - c01));
        let by_one = isotropic(sum + cross, difference + skew);
        let by_q = isotropic(difference - skew, sum - cross);
        let shear = self.shear(0);
        let mut c = [[T::ZERO; 3]; 3];
        for (ik, c) in c.iter_mut().enumerate() {
            for (jl, c) in c.iter_mut().enumerate() {
                let part = by_q[jl] * q[ik];
                *c = (if ik < 2 { by_one[jl] + part } else { part }) + (r[jl] * shear) * r[ik];
            }
        }
        blocks(&tau, &c)
    }

    /// C = Σ_ab C_aabb (n_a⊗n_a)⊗(n_b⊗n_b) + Σ_pairs C_abab N⊗N, N = n_a⊗n_b + n_b⊗n_a.
    #[inline(always)]
    fn in_space<const D: usize>(&self) -> [[[[T; D]; D]; D]; D] {
        let n = self.frame.axes();
        // Symmetric matrices as xx, yy, zz, xy, yz, zx.
        let mut along = [[T::ZERO; 6]; 3];
        for (a, along) in along.iter_mut().enumerate() {
            for (along, (i, k)) in along.iter_mut().zip(FULL_PAIRS) {
                *along = n[i][a] * n[k][a];
            }
        }
        let mut tau = [T::ZERO; 6];
        let mut terms = [([T::ZERO; 6], [T::ZERO; 6]); 6];
        for a in 0..3 {
            let (first, second, third) = (self.normal(a, 0), self.normal(a, 1), self.normal(a, 2));
            let (b, c) = PAIRS[a];
            let shear = self.shear(a);
            for pair in 0..6 {
                let (i, k) = FULL_PAIRS[pair];
                tau[pair] += along[a][pair] * self.kirchhoff[a];
                terms[a].0[pair] = along[a][pair];
                terms[a].1[pair] = along[0][pair] * first + along[1][pair] * second + along[2][pair] * third;
                let between = n[i][b] * n[k][c] + n[i][c] * n[k][b];
                terms[3 + a].0[pair] = between;
                terms[3 + a].1[pair] = between * shear;
            }
        }
        // Loops here, not iterator adaptors or closures: those stay calls.
        let mut c = [[T::ZERO; 6]; 6];
        for (ik, c) in c.iter_mut().enumerate() {
            for (p, q) in &terms {
                for jl in 0..6 {
                    c[jl] += q[jl] * p[ik];
                }
            }
        }
        blocks(&tau, &c)
    }

    /// C_aabb.
    #[inline(always)]
    fn normal(&self, a: usize, b: usize) -> T {
        if a == b { self.tangent[a][b] - T::of(2.0) * self.kirchhoff[a] } else { self.tangent[a][b] }
    }

    /// C_abab of a pair.
    ///
    /// With z = (λ_a² − λ_b²)/(λ_a² + λ_b²), so that ε_a − ε_b = artanh z, the quotient above is
    /// ½ S_ab (artanh z)/z − ½(τ_a + τ_b), S_ab the secant of stress over strain: the same
    /// number, without the cancellation as λ_a → λ_b.
    #[inline(always)]
    fn shear(&self, pair: usize) -> T {
        let (a, b) = PAIRS[pair];
        let (c, eps, tau) = (&self.excess, &self.strain, &self.kirchhoff);
        let z = (c[a] - c[b]) / (T::of(2.0) + c[a] + c[b]);
        T::of(0.5) * (self.secant[pair] * artanh_ratio(z, eps[a] - eps[b]) - tau[a] - tau[b])
    }
}

/// The components of a symmetric matrix in three dimensions, in the order of [`crate::SymmetricTensor`].
const FULL_PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];

/// Where the component (i, j) of a symmetric matrix stands among 3 in the plane or 6: the diagonal, then the others.
#[inline(always)]
const fn place(components: usize, i: usize, j: usize) -> usize {
    match (i == j, components, i + j) {
        (true, ..) => i,
        (_, 3, _) => 2,
        (.., 1) => 3,
        (.., 3) => 4,
        _ => 5,
    }
}

/// The moduli `a[l][k][j][i]` = C_ikjl + τ_kl δ_ij; `moduli[ik]` are the components C_ik·· of a symmetric matrix.
#[inline(always)]
fn blocks<T: Number, const D: usize, const C: usize>(
    tau: &[T; C],
    moduli: &[[T; C]; C],
) -> [[[[T; D]; D]; D]; D] {
    let mut a = [[[[T::ZERO; D]; D]; D]; D];
    for k in 0..D {
        for i in 0..=k {
            let c = &moduli[place(C, i, k)];
            for l in 0..D {
                for j in 0..D {
                    let c = c[place(C, j, l)];
                    a[l][k][j][i] = c;
                    a[l][i][j][k] = c;
                }
            }
        }
    }
    for (l, a) in a.iter_mut().enumerate() {
        for (k, a) in a.iter_mut().enumerate() {
            for (i, a) in a.iter_mut().enumerate() {
                a[i] += tau[place(C, k, l)];
            }
        }
    }
    a
}

/// (artanh z)/z, given both z and `artanh` = artanh z.
#[inline(always)]
fn artanh_ratio<T: Number>(z: T, artanh: T) -> T {
    let w = z * z;
    // Σ w^m/(2m+1); the first term left out is 6e-18. Pairs keep the chain of
    // dependent operations short.
    let w2 = w * w;
    let c = T::of;
    let low = (c(1.0) + w * c(1.0 / 3.0)) + w2 * (c(1.0 / 5.0) + w * c(1.0 / 7.0));
    let high = (c(1.0 / 9.0) + w * c(1.0 / 11.0)) + w2 * (c(1.0 / 13.0) + w * c(1.0 / 15.0));
    T::pick(w.below(c(0.01)), low + w2 * w2 * high, artanh / z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elementary::ln_1p;
    use crate::{DruckerPrager, Elasticity, Hencky, PlasticStrain, SymmetricTensor, VonMises, respond};

    #[test]
    fn artanh_ratio_is_exact_on_both_sides_of_its_switch() {
        // Reference: (ln(1+z) − ln(1−z))/2z, good to round-off for z of this size.
        for step in 0..400 {
            let z = 0.05 + 0.00025 * f64::from(step);
            let artanh = 0.5 * (ln_1p(z) - ln_1p(-z));
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
        let limit = 0.5 * (d[0][0] - d[0][1]) - modes.kirchhoff[0];
        assert!((modes.shear(0) - limit).abs() < 1e-12 * limit.abs());
    }

    #[test]
    fn the_hoop_is_the_third_direction_of_space() {
        let elasticity = Elasticity::from_young_poisson(1000.0, 0.3).expect("in range");
        let law = DruckerPrager::new(elasticity, 0.3, 0.1, 20.0).expect("in range");
        let excess = |size: f64| {
            let [xx, yy, zz, xy] = [-0.5, 0.2, -0.3, 0.2].map(|it| it * size);
            SymmetricTensor { xx, yy, zz, xy, ..SymmetricTensor::ZERO }
        };
        for stretch in [0.05, 1.0] {
            let response = respond(&law, &excess(stretch), &PlasticStrain::default()).expect("it returns");
            let (tangent, a) = (response.tangent.hoop_tangent(), response.tangent.in_space::<3>());
            for (i, k) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                assert!((tangent.by_hoop[(i, k)] - a[2][k][2][i]).abs() < 1e-12 * 1000.0);
                assert!((tangent.of_hoop[(i, k)] - a[k][2][i][2]).abs() < 1e-12 * 1000.0);
            }
            assert!((tangent.hoop - a[2][2][2][2]).abs() < 1e-12 * 1000.0);
            assert_eq!((tangent.by_hoop - tangent.of_hoop).norm() > 1.0, response.plastic);
        }
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

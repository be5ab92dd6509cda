//! The tangent of one point of a body of revolution that turns.
//!
//! With the unknowns (Δr, Δz, φ) of a node, φ the angle of the step, directions in the order (r, z, θ), and the radius
//! `ρ = r_p ΔF_θθ` at the end of the step, a displacement of node v changes the deformation gradient by `δΔF ΔF⁻¹ = Σ_A B_v^A δu_v^A`,
//!
//! ```text
//! B^r = e_r ⊗ g_v + e_θ ⊗ e_θ t_v        B^z = e_z ⊗ g_v        B^φ = ρ e_θ ⊗ g_v
//! f_v^A = V⁰ τ : B_v^A                   K_vw^AB = V⁰ (B_v^A : a : B_w^B + τ : ∂²ΔF/∂u_v^A ∂u_w^B ΔF⁻¹)
//! ```
//!
//! with `g_v` as in the plane, its third component 0. The only second derivatives are those by Δr and φ: the force of φ
//! is a torque, whose arm ρ grows with Δr. They are `ρ t_v (τ g_w)_θ`, and the same with v and w exchanged.

use crate::body::scatter::LOWER;
use mpm_grid::{Block, Vector};

/// What turns a stress into the forces of a point's nodes: τ or another tensor, and ρ.
#[derive(Clone, Copy)]
pub(crate) struct Turned<'a, const D: usize> {
    pub stress: &'a Block<D>,
    /// ρ `[L]`.
    pub radius: f64,
}

impl<const D: usize> Turned<'_, D> {
    /// `stress : B_v` of a node, but for the part of the hoop.
    #[inline(always)]
    pub fn force(&self, g: &Vector<D>) -> Vector<D> {
        let mut force = self.stress * g;
        force[D - 1] *= self.radius;
        force
    }
}

/// As [`add_tangent_of_point`](super::point_tangent::add_tangent_of_point), of points that turn; `a` is per volume, the
/// stress is not.
#[inline(always)]
pub(crate) fn add_turning_tangent<const D: usize, const TANGENT: u8>(
    (g, t): (&[Vector<D>], &[f64]),
    a: &[[Block<D>; D]; D],
    of: Turned<'_, D>,
    volume: f64,
    sums: &mut [Block<D>],
) {
    // Gradients lie in the section: their component along the hoop is 0.
    let (n, hoop) = (g.len(), D - 1);
    // (τ g_v)_θ.
    let shear =
        |g: &Vector<D>| (1..hoop).fold(of.stress[(hoop, 0)] * g[0], |sum, k| sum + of.stress[(hoop, k)] * g[k]);
    let mut at = 0;
    for w in 0..n {
        // half[k](i, B) = V⁰ a_ikjl B_w^B,jl
        let (weighted, hoop_w) = (g[w] * volume, t[w] * volume);
        let mut half: [Block<D>; D] = std::array::from_fn(|k| {
            let mut sum = a[k][0] * weighted[0];
            for l in 1..hoop {
                sum += a[k][l] * weighted[l];
            }
            sum
        });
        for k in 0..D {
            for i in 0..D {
                half[k][(i, hoop)] *= of.radius;
                half[k][(i, 0)] += a[k][hoop][(i, hoop)] * hoop_w;
            }
        }
        let shear_w = of.radius * shear(&g[w]);
        let from = if TANGENT == LOWER { w } else { 0 };
        for (v, sum) in (from..n).zip(&mut sums[at..]) {
            let mut block = half[0] * g[v][0];
            for k in 1..hoop {
                block += half[k] * g[v][k];
            }
            for j in 0..D {
                block[(hoop, j)] *= of.radius;
                block[(0, j)] += t[v] * half[hoop][(hoop, j)];
            }
            block[(0, hoop)] += t[v] * shear_w;
            block[(hoop, 0)] += of.radius * t[w] * shear(&g[v]);
            *sum += block;
        }
        at += n - from;
    }
}

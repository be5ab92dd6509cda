//! Mean dilatation: the volume change of a load step is that of the cell, not the point's own.
//!
//! Where flow keeps volume, every point asks the same of the few nodes of its cell, and bases of low order
//! cannot comply in all points at once: they lock, or the pressures of neighbours run away from each other.
//! Here only the mean over a cell is asked for (Nagtegaal, Parks & Rice 1974; in finite strain Simo, Taylor &
//! Pister 1985; for the MPM Coombs et al. 2018, whose ΔF̄ this is, though not their unsymmetric tangent). With
//! `J_p = det ΔF_p` and the volume ratio θ of the cell that holds the centre of point p at the start of the step,
//!
//! ```text
//! θ = Σ_q w_q J_q / Σ_q w_q,    ΔF̄_p = α_p ΔF_p,   α_p = (θ/J_p)^(1/D),   det ΔF̄_p = θ,
//! ```
//!
//! where q runs over the points of the cell with their volumes at the start of the step
//! ([`MeanDilatation::Points`]), or over quadrature points of the cell, which make θ the ratio of its volumes
//! exactly ([`MeanDilatation::Cell`]). What a point remembers (F, b_e, the law's history, a domain that follows
//! F) takes ΔF̄; its position follows the mesh. V⁰ τ weighs a point as ever.
//!
//! In plane strain ΔF̄ is scaled in the plane, by a square root: F_zz stays 1. A cube root in all three directions
//! would strain every point in z by `α_p - 1`, and plastic flow would keep that strain. In a body of revolution the hoop
//! is not fixed, and all three stretches take part: `α_p = (θ/J_p)^(1/3)`.
//!
//! # Force and tangent
//!
//! The force is the derivative of the incremental potential `Σ_p V⁰_p ψ(ΔF̄_p b_e,n ΔF̄_pᵀ)`, so that the tangent is
//! symmetric where that of the law is. With `g_vp = ΔF_p⁻ᵀ ∇S_vp`, the shares `s_q = w_q J_q / Σ w J`, and `ḡ_v = Σ_q s_q g_vq = ∂ ln θ/∂u_v`:
//!
//! ```text
//! δΔF̄ ΔF̄⁻¹ = Σ_v (δu_v ⊗ g_vp + (ḡ_v - g_vp)·δu_v I/D)
//! f_v  = Σ_p V⁰_p (τ_p - π_p I) g_vp + Π ḡ_v,      π = tr τ / D (of the D × D part),   Π = Σ_p V⁰_p π_p
//! K_vw = Σ_p V⁰_p g_vp · A_p · g_wp + q_v ⊗ ḡ_w + ḡ_v ⊗ q'_w + (Σ_p V⁰_p κ_p - Π) ḡ_v ⊗ ḡ_w
//!        + Π Σ_q s_q (g_vq ⊗ g_wq - g_wq ⊗ g_vq)
//! A_ikjl = a_ikjl - (δ_ik P'_jl + P_ik δ_jl)/D + κ δ_ik δ_jl + π δ_il δ_jk
//! P_ik = C_ikll + 2 τ_ik,      q_v  = Σ_p V⁰_p (P_p/D - κ_p I) g_vp,      κ = tr P / D²
//! P'_jl = C_iijl + 2 τ_jl,     q'_v = Σ_p V⁰_p (P'_p/D - κ_p I) g_vp
//! ```
//!
//! with the spatial tangent `a_ikjl = C_ikjl + τ_kl δ_ij` of [`mpm_material::PrincipalTangent::spatial_tangent`] at ΔF̄.
//! P' = P and q' = q where C is symmetric. The terms with π and Π are the second derivatives of `ln J_p` and `ln θ`. All
//! nodes of a cell couple: a cell is one set of [`Couplings`](crate::Couplings).
//!
//! In a body of revolution D is 3 in these formulas; the pairs (i, k) run over rr, rz, zr, zz and θθ, with
//! `∂ ln J/∂u_v = g_v + t_v e_r` in the place of `g_v`, and `-g_w ⊗ g_v - t_v t_w e_r ⊗ e_r` for the second derivative.

mod cells;
mod change;
mod moduli;
mod tangent;

pub use cells::{Dilatation, MeanDilatation};
pub(crate) use change::{Dilated, Scratch};

use crate::body::kinematics::{StepGradient, block};
use crate::body::scatter::FORCE;
use crate::body::trial::{InadmissiblePoint, dissipated};
use crate::body::turning_tangent::Turned;
use change::CellPoint;
use moduli::stretches;
use mpm_basis::CellPart;
use mpm_basis::parallel::each;
use mpm_grid::{Block, Vector};
use mpm_material::{Material, SymmetricTensor};

/// Cells per task; fixed, so that nothing depends on the number of threads.
const CELLS: usize = 256;

impl<const D: usize, M: Material, const HOOP: bool> Dilated<'_, D, M, HOOP> {
    /// Sums force and, where wanted, the tangent of a cell as in `DenseTangent`; returns the smallest `det ΔF`.
    pub(crate) fn sum<const TANGENT: u8>(
        &self,
        cell: usize,
        force: &mut [Vector<D>],
        tangent: &mut [Block<D>],
        s: &mut Scratch<D, M>,
    ) -> Result<f64, InadmissiblePoint> {
        let change = self.change(cell, s)?;
        force.fill(Vector::zeros());
        s.responses.clear();
        // Π.
        let mut pressure = 0.0;
        let mut at = 0;
        for part in self.parts(cell) {
            for point in &s.points[at..at + part.points.len()] {
                let response = self.respond(point, &change)?;
                let volume = self.committed.points.reference_volume[point.point];
                pressure += self.push(&response.kirchhoff, volume, &part, (point, s), force);
                if TANGENT != FORCE {
                    s.responses.push(response);
                }
            }
            at += part.points.len();
        }
        for (force, mean) in force.iter_mut().zip(&s.mean) {
            *force += mean * pressure;
        }
        if TANGENT != FORCE {
            self.tangent::<TANGENT>(cell, pressure, tangent, s);
        }
        Ok(change.smallest)
    }

    /// `ΔF̄ - I` of every point.
    pub(crate) fn steps(&self) -> Result<Vec<StepGradient<D>>, InadmissiblePoint> {
        let cells = self.dilatation.cells.len();
        let chunks: Vec<Result<Vec<(usize, StepGradient<D>)>, InadmissiblePoint>> =
            each(cells.div_ceil(CELLS), &|chunk| {
                let mut s = Scratch::default();
                let mut steps = Vec::new();
                for cell in chunk * CELLS..((chunk + 1) * CELLS).min(cells) {
                    let change = self.change(cell, &mut s)?;
                    steps.extend(s.points.iter().map(|it| (it.point, it.dilated::<HOOP>(change.excess))));
                }
                Ok(steps)
            });
        let none = StepGradient { block: Block::zeros(), hoop: 0.0 };
        let mut steps = vec![none; self.committed.points.len()];
        for chunk in chunks {
            for (point, step) in chunk? {
                steps[point] = step;
            }
        }
        Ok(steps)
    }

    /// As [`crate::dissipation`].
    pub(crate) fn dissipation(&self, gradient_sum: &mut [Vector<D>]) -> Result<f64, InadmissiblePoint> {
        let mut s = Scratch::default();
        let mut force = Vec::new();
        let mut energy = 0.0;
        for cell in 0..self.dilatation.cells.len() {
            let change = self.change(cell, &mut s)?;
            force.clear();
            force.resize(s.mean.len(), Vector::zeros());
            let mut pressure = 0.0;
            let mut at = 0;
            for part in self.parts(cell) {
                for point in &s.points[at..at + part.points.len()] {
                    let response = self.respond(point, &change)?;
                    if !response.plastic {
                        continue;
                    }
                    let p = point.point;
                    let volume = self.committed.points.reference_volume[p];
                    let step = point.dilated::<HOOP>(change.excess);
                    let trial = step.trial_excess::<HOOP>(&self.committed.points.elastic_excess[p]);
                    energy += volume * dissipated(self.committed.law, &trial, &response);
                    let mut stress = response.kirchhoff;
                    let mean = stress.trace() / 3.0;
                    stress.xx -= mean;
                    stress.yy -= mean;
                    stress.zz -= mean;
                    pressure += self.push(&stress, volume, &part, (point, &s), &mut force);
                }
                at += part.points.len();
            }
            for ((&node, force), mean) in self.dilatation.cells.nodes(cell).iter().zip(&force).zip(&s.mean) {
                gradient_sum[node as usize] += force + mean * pressure;
            }
        }
        Ok(energy)
    }

    /// Adds `V⁰ (τ - π I) g_v`, and with a hoop `V⁰ (τ_θθ - π) t_v e_r`, to the forces of a cell's nodes and returns
    /// `V⁰ π`.
    #[inline(always)]
    fn push(
        &self,
        tau: &SymmetricTensor,
        volume: f64,
        part: &CellPart<'_>,
        (point, s): (&CellPoint<D>, &Scratch<D, M>),
        force: &mut [Vector<D>],
    ) -> f64 {
        let stretches = const { stretches::<D, HOOP>() };
        let in_plane = block::<D>(tau) * volume;
        let hoop = tau.zz * volume;
        let pressure =
            if HOOP && D == 2 { (in_plane.trace() + hoop) / stretches } else { in_plane.trace() / stretches };
        let deviator = in_plane - Block::identity() * pressure;
        let turned = Turned { stress: &deviator, radius: point.radius };
        for (&at, g) in part.place.iter().zip(&s.g[point.at..]) {
            force[at as usize] += if HOOP && D == 3 { turned.force(g) } else { deviator * g };
        }
        if HOOP {
            for (&at, t) in part.place.iter().zip(&s.t[point.at..]) {
                force[at as usize][0] += (hoop - pressure) * t;
            }
        }
        pressure
    }
}

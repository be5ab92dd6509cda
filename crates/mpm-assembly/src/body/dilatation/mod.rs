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
//! would strain every point in z by `α_p - 1`, and plastic flow would keep that strain.
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

mod cells;
mod moduli;

pub use cells::{Dilatation, MeanDilatation};

use moduli::{Moduli, moduli};

use crate::body::kinematics::{
    block, determinant, determinant_excess, gradient, inverse_and_determinant, trial_excess,
};
use crate::body::scatter::{FORCE, LOWER, block_position, n_blocks};
use crate::body::trial::{Committed, InadmissiblePoint, dissipated};
use mpm_basis::parallel::each;
use mpm_basis::{CellPart, Connectivity};
use mpm_grid::{Block, Vector};
use mpm_material::{Material, Response, respond};

/// Cells per task; fixed, so that nothing depends on the number of threads.
const CELLS: usize = 256;

/// A body under mean dilatation in a trial displacement.
pub(crate) struct Dilated<'a, const D: usize, M: Material> {
    pub committed: Committed<'a, D, M>,
    pub connectivity: &'a Connectivity<D>,
    pub dilatation: &'a Dilatation<D>,
    /// `Δu_v` of every active node `[L]`.
    pub increment: &'a [Vector<D>],
}

/// What is known of the points of one cell, reused from cell to cell.
pub(crate) struct Scratch<const D: usize, M: Material> {
    points: Vec<CellPoint<D>>,
    /// `g_vp` of the points, one after the other `[1/L]`.
    g: Vec<Vector<D>>,
    /// `ḡ_v` of the nodes of the cell `[1/L]`.
    mean: Vec<Vector<D>>,
    /// `q_v` of the nodes of the cell.
    coupling: Vec<Vector<D>>,
    /// `q'_v` of the nodes of the cell; empty where it is `q_v`.
    pressure_coupling: Vec<Vector<D>>,
    responses: Vec<Response<M::History>>,
    /// `Δu_v` of one part's nodes, or of the corners.
    increment: Vec<Vector<D>>,
    /// `s_q` and `g_vq` of the quadrature points.
    share: Vec<f64>,
    corner_g: Vec<Vector<D>>,
    /// Blocks of one part.
    tangent: Vec<Block<D>>,
}

/// One point of the cell.
struct CellPoint<const D: usize> {
    point: usize,
    /// `ΔF - I`.
    h: Block<D>,
    /// `J - 1`.
    excess: f64,
    /// `s_p`, zero where the mean is not over the points.
    share: f64,
    /// Start of its `g`.
    at: usize,
}

/// Volume change of a cell.
struct Change {
    /// `θ - 1`.
    excess: f64,
    /// Smallest `det ΔF_p`.
    smallest: f64,
}

impl<const D: usize, M: Material> Default for Scratch<D, M> {
    fn default() -> Self {
        Self {
            points: Vec::new(),
            g: Vec::new(),
            mean: Vec::new(),
            coupling: Vec::new(),
            pressure_coupling: Vec::new(),
            responses: Vec::new(),
            increment: Vec::new(),
            share: Vec::new(),
            corner_g: Vec::new(),
            tangent: Vec::new(),
        }
    }
}

impl<const D: usize> CellPoint<D> {
    /// `ΔF̄ - I`.
    fn dilated(&self, theta_excess: f64) -> Block<D> {
        self.h + (self.h + Block::identity()) * stretch_excess::<D>(theta_excess, self.excess)
    }
}

/// `α - 1` from `θ - 1` and `J - 1`; zero where these are equal.
fn stretch_excess<const D: usize>(theta_excess: f64, excess: f64) -> f64 {
    ((theta_excess.ln_1p() - excess.ln_1p()) / D as f64).exp_m1()
}

impl<const D: usize, M: Material> Dilated<'_, D, M> {
    fn parts(&self, cell: usize) -> impl Iterator<Item = CellPart<'_>> {
        self.dilatation.cells.parts(self.connectivity, cell)
    }

    /// Fills the scratch but for responses and `q`.
    fn change(&self, cell: usize, s: &mut Scratch<D, M>) -> Result<Change, InadmissiblePoint> {
        let nodes = self.dilatation.cells.nodes(cell);
        let quadrature = self.dilatation.quadrature.of(cell);
        s.points.clear();
        s.g.clear();
        s.mean.clear();
        s.mean.resize(nodes.len(), Vector::zeros());
        s.share.clear();
        s.corner_g.clear();
        let mut smallest = f64::INFINITY;
        // Σ w and Σ w (J - 1).
        let (mut volume, mut change) = (0.0, 0.0);
        for part in self.parts(cell) {
            let group = self.connectivity.group(part.group);
            s.increment.clear();
            s.increment.extend(group.nodes.iter().map(|&node| self.increment[node as usize]));
            for k in part.points {
                let (point, gradients) = (group.first_point + k, group.point(k).1);
                let h = gradient(&s.increment, gradients);
                let (inverse, determinant_of_step) = inverse_and_determinant(&(Block::identity() + h));
                // Written so that a trial that is not a number is refused as well.
                if !(determinant_of_step > 0.0 && determinant_of_step.is_finite()) {
                    return Err(InadmissiblePoint::inverted(point, determinant_of_step));
                }
                smallest = smallest.min(determinant_of_step);
                let excess = determinant_excess(&h);
                let mut share = 0.0;
                if quadrature.is_none() {
                    let weight = self.committed.points.reference_volume[point]
                        * determinant(&self.committed.points.deformation_gradient[point]);
                    volume += weight;
                    change += weight * excess;
                    share = weight * determinant_of_step;
                }
                s.points.push(CellPoint { point, h, excess, share, at: s.g.len() });
                s.g.extend(gradients.iter().map(|gradient| inverse.tr_mul(gradient)));
            }
        }
        if let Some((weights, corners, gradients)) = quadrature {
            s.increment.clear();
            s.increment.extend(corners.iter().map(|&at| self.increment[nodes[at as usize] as usize]));
            for (weight, gradients) in weights.iter().zip(gradients.chunks_exact(1 << D)) {
                let h = gradient(&s.increment, gradients);
                let (inverse, determinant_of_step) = inverse_and_determinant(&(Block::identity() + h));
                volume += weight;
                change += weight * determinant_excess(&h);
                s.share.push(weight * determinant_of_step);
                s.corner_g.extend(gradients.iter().map(|gradient| inverse.tr_mul(gradient)));
            }
        }
        let excess = change / volume;
        if !(excess > -1.0 && excess.is_finite()) {
            return Err(InadmissiblePoint::inverted(s.points[0].point, 1.0 + excess));
        }

        let per_volume = 1.0 / (volume + change);
        if let Some((_, corners, _)) = quadrature {
            for (share, g) in s.share.iter_mut().zip(s.corner_g.chunks_exact(1 << D)) {
                *share *= per_volume;
                for (&at, g) in corners.iter().zip(g) {
                    s.mean[at as usize] += g * *share;
                }
            }
        } else {
            let mut points = s.points.iter_mut();
            for part in self.parts(cell) {
                for point in points.by_ref().take(part.points.len()) {
                    point.share *= per_volume;
                    for (&at, g) in part.place.iter().zip(&s.g[point.at..]) {
                        s.mean[at as usize] += g * point.share;
                    }
                }
            }
        }
        Ok(Change { excess, smallest })
    }

    fn respond(
        &self,
        point: &CellPoint<D>,
        change: &Change,
    ) -> Result<Response<M::History>, InadmissiblePoint> {
        let p = point.point;
        let trial = trial_excess(&point.dilated(change.excess), &self.committed.points.elastic_excess[p]);
        let response = respond(self.committed.law, &trial, &self.committed.history[p]);
        response.map_err(|reason| InadmissiblePoint::no_return(p, reason))
    }

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
                let tau = block::<D>(&response.kirchhoff) * self.committed.points.reference_volume[point.point];
                pressure += push(&tau, &part, &s.g[point.at..], force);
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

    fn tangent<const TANGENT: u8>(
        &self,
        cell: usize,
        pressure: f64,
        tangent: &mut [Block<D>],
        s: &mut Scratch<D, M>,
    ) {
        let n = s.mean.len();
        tangent.fill(Block::zeros());
        s.coupling.clear();
        s.coupling.resize(n, Vector::zeros());
        let is_lower = TANGENT == LOWER;
        s.pressure_coupling.clear();
        s.pressure_coupling.resize(if is_lower { 0 } else { n }, Vector::zeros());
        // Σ V⁰ κ.
        let mut bulk = 0.0;
        let mut k = 0;
        for part in self.parts(cell) {
            let m = part.place.len();
            s.tangent.clear();
            s.tangent.resize(n_blocks::<TANGENT>(m), Block::zeros());
            for _ in part.points {
                let (point, response) = (&s.points[k], &s.responses[k]);
                k += 1;
                let volume = self.committed.points.reference_volume[point.point];
                let Moduli { a, by_volume, of_pressure }: Moduli<D> =
                    moduli::<D, _, TANGENT>(response, volume, pressure * point.share);
                let kappa = by_volume.trace() / (D * D) as f64;
                bulk += kappa;
                let g = &s.g[point.at..point.at + m];
                let coupling = by_volume / D as f64 - Block::identity() * kappa;
                for (&at, g) in part.place.iter().zip(g) {
                    s.coupling[at as usize] += coupling * g;
                }
                if !is_lower {
                    let coupling = of_pressure / D as f64 - Block::identity() * kappa;
                    for (&at, g) in part.place.iter().zip(g) {
                        s.pressure_coupling[at as usize] += coupling * g;
                    }
                }
                let mut at = 0;
                for w in 0..m {
                    // As in the pass without: half[k](i, j) = A_ikjl g_w,l.
                    let half: [Block<D>; D] = std::array::from_fn(|k| {
                        let mut sum = Block::zeros();
                        for l in 0..D {
                            sum += a[k][l] * g[w][l];
                        }
                        sum
                    });
                    let from = if is_lower { w } else { 0 };
                    for (sum, g) in s.tangent[at..].iter_mut().zip(&g[from..]) {
                        for k in 0..D {
                            *sum += half[k] * g[k];
                        }
                    }
                    at += m - from;
                }
            }
            let mut blocks = s.tangent.iter();
            for (k, &w) in part.place.iter().enumerate() {
                let from = if is_lower { k } else { 0 };
                for (&v, sum) in part.place[from..].iter().zip(&mut blocks) {
                    tangent[block_position::<TANGENT>(n, v, w)] += sum;
                }
            }
        }
        self.cell_terms::<TANGENT>(cell, pressure, bulk, tangent, s);
    }

    /// Adds what the volume change of the cell couples; `bulk` is `Σ V⁰ κ`.
    #[inline]
    fn cell_terms<const TANGENT: u8>(
        &self,
        cell: usize,
        pressure: f64,
        bulk: f64,
        tangent: &mut [Block<D>],
        s: &Scratch<D, M>,
    ) {
        let (n, is_lower) = (s.mean.len(), TANGENT == LOWER);
        if let Some((_, corners, _)) = self.dilatation.quadrature.of(cell) {
            for (share, g) in s.share.iter().zip(s.corner_g.chunks_exact(1 << D)) {
                for (&w, g_w) in corners.iter().zip(g) {
                    for (&v, g_v) in corners.iter().zip(g).filter(|&(&v, _)| !is_lower || v >= w) {
                        let product = g_v * g_w.transpose();
                        tangent[block_position::<TANGENT>(n, v, w)] +=
                            (product - product.transpose()) * (pressure * share);
                    }
                }
            }
        }
        let mut blocks = tangent.iter_mut();
        for w in 0..n {
            let q = if is_lower { &s.coupling } else { &s.pressure_coupling };
            let column = q[w] + s.mean[w] * (bulk - pressure);
            let from = if is_lower { w } else { 0 };
            for (v, block) in (from..n).zip(&mut blocks) {
                *block += s.mean[v] * column.transpose() + s.coupling[v] * s.mean[w].transpose();
            }
        }
    }

    /// `ΔF̄ - I` of every point.
    pub(crate) fn steps(&self) -> Result<Vec<Block<D>>, InadmissiblePoint> {
        let cells = self.dilatation.cells.len();
        let chunks: Vec<Result<Vec<(usize, Block<D>)>, InadmissiblePoint>> =
            each(cells.div_ceil(CELLS), &|chunk| {
                let mut s = Scratch::default();
                let mut steps = Vec::new();
                for cell in chunk * CELLS..((chunk + 1) * CELLS).min(cells) {
                    let change = self.change(cell, &mut s)?;
                    steps.extend(s.points.iter().map(|it| (it.point, it.dilated(change.excess))));
                }
                Ok(steps)
            });
        let mut steps = vec![Block::zeros(); self.committed.points.len()];
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
                    let trial =
                        trial_excess(&point.dilated(change.excess), &self.committed.points.elastic_excess[p]);
                    energy += volume * dissipated(self.committed.law, &trial, &response);
                    let tau = &response.kirchhoff;
                    let deviator = block::<D>(tau) - Block::identity() * (tau.trace() / 3.0);
                    pressure += push(&(deviator * volume), &part, &s.g[point.at..], &mut force);
                }
                at += part.points.len();
            }
            for ((&node, force), mean) in self.dilatation.cells.nodes(cell).iter().zip(&force).zip(&s.mean) {
                gradient_sum[node as usize] += force + mean * pressure;
            }
        }
        Ok(energy)
    }
}

/// Adds `(τ - π I) g_v` to the forces of a cell's nodes and returns π.
fn push<const D: usize>(tau: &Block<D>, part: &CellPart<'_>, g: &[Vector<D>], force: &mut [Vector<D>]) -> f64 {
    let pressure = tau.trace() / D as f64;
    let deviator = tau - Block::identity() * pressure;
    for (&at, g) in part.place.iter().zip(g) {
        force[at as usize] += deviator * g;
    }
    pressure
}

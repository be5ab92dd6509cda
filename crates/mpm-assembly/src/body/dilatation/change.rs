//! The volume changes of a cell and of its points under a trial displacement.

use super::cells::Dilatation;
use super::moduli::stretches;
use crate::body::kinematics::{StepGradient, determinant, inverse_and_determinant};
use crate::body::trial::{Committed, InadmissiblePoint, StepOf, step_of};
use mpm_basis::{CellPart, Connectivity};
use mpm_grid::{Block, Vector};
use mpm_material::elementary::{exp_m1, ln_1p};
use mpm_material::{Material, Response, respond};

/// A body under mean dilatation in a trial displacement.
pub(crate) struct Dilated<'a, const D: usize, M: Material, const HOOP: bool> {
    pub committed: Committed<'a, D, M>,
    pub connectivity: &'a Connectivity<D>,
    pub dilatation: &'a Dilatation<D>,
    /// `Δu_v` of every active node `[L]`.
    pub increment: &'a [Vector<D>],
}

/// What is known of the points of one cell, reused from cell to cell.
pub(crate) struct Scratch<const D: usize, M: Material> {
    pub(super) points: Vec<CellPoint<D>>,
    /// `g_vp` of the points, one after the other `[1/L]`.
    pub(super) g: Vec<Vector<D>>,
    /// `t_vp` of the points, likewise; empty where there is no hoop `[1/L]`.
    pub(super) t: Vec<f64>,
    /// `ḡ_v` of the nodes of the cell, with `t̄_v e_r` where there is a hoop `[1/L]`.
    pub(super) mean: Vec<Vector<D>>,
    /// `q_v` of the nodes of the cell.
    pub(super) coupling: Vec<Vector<D>>,
    /// `q'_v` of the nodes of the cell; empty where it is `q_v`.
    pub(super) pressure_coupling: Vec<Vector<D>>,
    pub(super) responses: Vec<Response<M::History>>,
    /// `Δu_v` of one part's nodes, or of the corners.
    pub(super) increment: Vec<Vector<D>>,
    /// `s_q` and `g_vq` of the quadrature points.
    pub(super) share: Vec<f64>,
    pub(super) corner_g: Vec<Vector<D>>,
    /// `t_vq`; empty where there is no hoop.
    pub(super) corner_t: Vec<f64>,
    /// Blocks of one part.
    pub(super) tangent: Vec<Block<D>>,
}

/// One point of the cell.
pub(super) struct CellPoint<const D: usize> {
    pub(super) point: usize,
    /// `ΔF - I`.
    pub(super) h: StepGradient<D>,
    /// `J - 1`.
    pub(super) excess: f64,
    /// `s_p`, zero where the mean is not over the points.
    pub(super) share: f64,
    /// Radius at the end of the step `[L]`, of bodies of revolution.
    pub(super) radius: f64,
    /// Start of its `g` and `t`.
    pub(super) at: usize,
}

/// Volume change of a cell.
pub(super) struct Change {
    /// `θ - 1`.
    pub(super) excess: f64,
    /// Smallest `det ΔF_p`.
    pub(super) smallest: f64,
}

impl<const D: usize, M: Material> Default for Scratch<D, M> {
    fn default() -> Self {
        Self {
            points: Vec::new(),
            g: Vec::new(),
            t: Vec::new(),
            mean: Vec::new(),
            coupling: Vec::new(),
            pressure_coupling: Vec::new(),
            responses: Vec::new(),
            increment: Vec::new(),
            share: Vec::new(),
            corner_g: Vec::new(),
            corner_t: Vec::new(),
            tangent: Vec::new(),
        }
    }
}

impl<const D: usize, M: Material> Scratch<D, M> {
    /// Forgets a cell, for one of `n` nodes.
    fn clear(&mut self, n: usize) {
        self.points.clear();
        self.g.clear();
        self.t.clear();
        self.mean.clear();
        self.mean.resize(n, Vector::zeros());
        self.share.clear();
        self.corner_g.clear();
        self.corner_t.clear();
    }
}

impl<const D: usize> CellPoint<D> {
    /// `ΔF̄ - I`.
    pub(super) fn dilated<const HOOP: bool>(&self, theta_excess: f64) -> StepGradient<D> {
        let StepGradient { block, hoop } = self.h;
        let stretch = stretch_excess::<D, HOOP>(theta_excess, self.excess);
        // With twist the hoop is a part of the block as well.
        StepGradient {
            block: block + (block + Block::identity()) * stretch,
            hoop: if HOOP { hoop + (hoop + 1.0) * stretch } else { 0.0 },
        }
    }
}

/// `α - 1` from `θ - 1` and `J - 1`; zero where these are equal.
fn stretch_excess<const D: usize, const HOOP: bool>(theta_excess: f64, excess: f64) -> f64 {
    exp_m1((ln_1p(theta_excess) - ln_1p(excess)) / const { stretches::<D, HOOP>() })
}

impl<const D: usize, M: Material, const HOOP: bool> Dilated<'_, D, M, HOOP> {
    pub(super) fn parts(&self, cell: usize) -> impl Iterator<Item = CellPart<'_>> {
        self.dilatation.cells.parts(self.connectivity, cell)
    }

    /// Fills the scratch but for responses and `q`.
    pub(super) fn change(&self, cell: usize, s: &mut Scratch<D, M>) -> Result<Change, InadmissiblePoint> {
        let nodes = self.dilatation.cells.nodes(cell);
        s.clear(nodes.len());
        // Σ w and Σ w (J - 1).
        let (mut volume, mut change) = (0.0, 0.0);
        let quadrature = self.dilatation.quadrature.of(cell);
        let smallest = self.points(cell, quadrature.is_none(), s, &mut |weight, excess| {
            volume += weight;
            change += weight * excess;
        })?;
        if let Some(quadrature) = quadrature {
            s.increment.clear();
            s.increment
                .extend(quadrature.corners.iter().map(|&at| self.increment[nodes[at as usize] as usize]));
            for (weight, gradients, hoops) in quadrature.points() {
                // The hoops are over the radius already.
                let h = StepGradient::of::<HOOP>(&s.increment, (hoops, gradients), 1.0);
                let (inverse, mut determinant) = inverse_and_determinant(&(Block::identity() + h.block));
                if HOOP && D == 2 {
                    determinant *= 1.0 + h.hoop;
                }
                volume += weight;
                change += weight * h.determinant_excess::<HOOP>();
                s.share.push(weight * determinant);
                s.corner_g.extend(gradients.iter().map(|gradient| inverse.tr_mul(gradient)));
                if HOOP {
                    s.corner_t.extend(hoops.iter().map(|hoop| hoop / (1.0 + h.hoop)));
                }
            }
        }
        let excess = change / volume;
        if !(excess > -1.0 && excess.is_finite()) {
            return Err(InadmissiblePoint::inverted(s.points[0].point, 1.0 + excess));
        }
        self.mean(cell, 1.0 / (volume + change), s);
        Ok(Change { excess, smallest })
    }

    /// Lists the points of a cell and returns the smallest `det ΔF_p`; `weigh` is told weight and `J - 1` of each if
    /// they are weighed.
    #[inline(always)]
    fn points(
        &self,
        cell: usize,
        are_weighed: bool,
        s: &mut Scratch<D, M>,
        weigh: &mut impl FnMut(f64, f64),
    ) -> Result<f64, InadmissiblePoint> {
        let points = self.committed.points;
        let mut smallest = f64::INFINITY;
        for part in self.parts(cell) {
            let group = self.connectivity.group(part.group);
            s.increment.clear();
            s.increment.extend(group.nodes.iter().map(|&node| self.increment[node as usize]));
            for k in part.points {
                let (point, influences) = (group.first_point + k, group.point(k));
                let radius = points.position[point][0];
                let h = StepGradient::of::<HOOP>(&s.increment, influences, radius);
                let StepOf { hoop, inverse, determinant: of_step, .. } = step_of::<D, HOOP>(point, &h)?;
                smallest = smallest.min(of_step);
                let excess = h.determinant_excess::<HOOP>();
                let mut share = 0.0;
                if are_weighed {
                    let mut before = determinant(&points.deformation_gradient[point]);
                    if HOOP && D == 2 {
                        before *= points.hoop_stretch[point];
                    }
                    let weight = points.reference_volume[point] * before;
                    weigh(weight, excess);
                    share = weight * of_step;
                }
                let at = s.g.len();
                s.points.push(CellPoint { point, h, excess, share, radius: radius * hoop, at });
                s.g.extend(influences.1.iter().map(|gradient| inverse.tr_mul(gradient)));
                if HOOP {
                    s.t.extend(influences.0.iter().map(|value| value / (radius * hoop)));
                }
            }
        }
        Ok(smallest)
    }

    /// Makes shares of weighted volume changes, and sums the mean over the cell.
    #[inline(always)]
    fn mean(&self, cell: usize, per_volume: f64, s: &mut Scratch<D, M>) {
        if let Some(quadrature) = self.dilatation.quadrature.of(cell) {
            for (q, (share, g)) in s.share.iter_mut().zip(s.corner_g.chunks_exact(1 << D)).enumerate() {
                *share *= per_volume;
                for (c, (&at, g)) in quadrature.corners.iter().zip(g).enumerate() {
                    s.mean[at as usize] += g * *share;
                    if HOOP {
                        s.mean[at as usize][0] += s.corner_t[(q << D) + c] * *share;
                    }
                }
            }
            return;
        }
        let mut points = s.points.iter_mut();
        for part in self.parts(cell) {
            for point in points.by_ref().take(part.points.len()) {
                point.share *= per_volume;
                for (&at, g) in part.place.iter().zip(&s.g[point.at..]) {
                    s.mean[at as usize] += g * point.share;
                }
                if HOOP {
                    for (&at, t) in part.place.iter().zip(&s.t[point.at..]) {
                        s.mean[at as usize][0] += t * point.share;
                    }
                }
            }
        }
    }

    pub(super) fn respond(
        &self,
        point: &CellPoint<D>,
        change: &Change,
    ) -> Result<Response<M::History>, InadmissiblePoint> {
        let p = point.point;
        let trial =
            point.dilated::<HOOP>(change.excess).trial_excess::<HOOP>(&self.committed.points.elastic_excess[p]);
        let response = respond(self.committed.law, &trial, &self.committed.history[p]);
        response.map_err(|reason| InadmissiblePoint::no_return(p, reason))
    }
}

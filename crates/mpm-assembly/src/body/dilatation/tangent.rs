//! The tangent of a cell whose points share their volume change.

use super::change::{Dilated, Scratch};
use super::moduli::{Moduli, moduli, stretches};
use crate::body::kinematics::block;
use crate::body::point_tangent::add_tangent_of_point;
use crate::body::scatter::{LOWER, block_position, n_blocks};
use crate::body::turning_tangent::{Turned, add_turning_tangent};
use mpm_grid::{Block, Vector};
use mpm_material::Material;

impl<const D: usize, M: Material, const HOOP: bool> Dilated<'_, D, M, HOOP> {
    pub(super) fn tangent<const TANGENT: u8>(
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
                let Moduli { a, by_volume, of_pressure, kappa, hoop }: Moduli<D> =
                    moduli::<D, _, TANGENT, HOOP>(response, volume, pressure * point.share);
                bulk += kappa;
                let g = &s.g[point.at..point.at + m];
                let t = if HOOP { &s.t[point.at..point.at + m] } else { &[] };
                let stretches = const { stretches::<D, HOOP>() };
                let coupling = by_volume / stretches - Block::identity() * kappa;
                let forces = |stress: &Block<D>, g: &Vector<D>| match HOOP && D == 3 {
                    true => Turned { stress, radius: point.radius }.force(g),
                    false => stress * g,
                };
                for (&at, g) in part.place.iter().zip(g) {
                    s.coupling[at as usize] += forces(&coupling, g);
                }
                for (&at, t) in part.place.iter().zip(t) {
                    s.coupling[at as usize][0] += (hoop.by_volume / stretches - kappa) * t;
                }
                if !is_lower {
                    let coupling = of_pressure / stretches - Block::identity() * kappa;
                    for (&at, g) in part.place.iter().zip(g) {
                        s.pressure_coupling[at as usize] += forces(&coupling, g);
                    }
                    for (&at, t) in part.place.iter().zip(t) {
                        s.pressure_coupling[at as usize][0] += (hoop.of_pressure / stretches - kappa) * t;
                    }
                }
                if HOOP && D == 3 {
                    let stress = block::<D>(&response.kirchhoff) * volume;
                    let turned = Turned { stress: &stress, radius: point.radius };
                    add_turning_tangent::<D, TANGENT>((g, t), &a, turned, 1.0, &mut s.tangent);
                    continue;
                }
                let hoop = if HOOP { Some(hoop.a) } else { None };
                add_tangent_of_point::<D, TANGENT, HOOP>((g, t), (&a, hoop), 1.0, &mut s.tangent);
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
        if let Some(quadrature) = self.dilatation.quadrature.of(cell) {
            for (q, (share, g)) in s.share.iter().zip(s.corner_g.chunks_exact(1 << D)).enumerate() {
                let t = if HOOP { &s.corner_t[q << D..(q + 1) << D] } else { &[] };
                let corners = || quadrature.corners.iter().zip(g).enumerate();
                for (c_w, (&w, g_w)) in corners() {
                    for (c_v, (&v, g_v)) in corners().filter(|&(_, (&v, _))| !is_lower || v >= w) {
                        let product = g_v * g_w.transpose();
                        let mut block = product - product.transpose();
                        if HOOP {
                            block.column_mut(0).axpy(t[c_w], g_v, 1.0);
                            (0..D).for_each(|j| block[(0, j)] += t[c_v] * g_w[j]);
                        }
                        tangent[block_position::<TANGENT>(n, v, w)] += block * (pressure * share);
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
}

//! Moduli of a point whose volume change is that of its cell.

use crate::body::kinematics::block;
use crate::body::scatter::ALL;
use mpm_grid::Block;
use mpm_material::{HoopTangent, Response};
use nalgebra::Matrix2;

/// Moduli of a point under mean dilatation.
pub(super) struct Moduli<const D: usize> {
    /// V⁰ A as blocks `[k][l](i, j)`.
    pub a: [[Block<D>; D]; D],
    /// V⁰ P.
    pub by_volume: Block<D>,
    /// V⁰ P', which equals V⁰ P where C is symmetric.
    pub of_pressure: Block<D>,
    /// V⁰ κ.
    pub kappa: f64,
    /// Those of the hoop; zero where there is none.
    pub hoop: HoopModuli,
}

/// Entries of V⁰ A, V⁰ P and V⁰ P' that belong to the hoop.
pub(super) struct HoopModuli {
    /// `A_ikθθ`, `A_θθjl` and `A_θθθθ`.
    pub a: HoopTangent,
    /// `P_θθ`.
    pub by_volume: f64,
    /// `P'_θθ`.
    pub of_pressure: f64,
}

/// Stretches that share a change of volume: those of the D directions, and that of the hoop where there is one.
pub(super) const fn stretches<const D: usize, const HOOP: bool>() -> f64 {
    if HOOP { 3.0 } else { D as f64 }
}

/// The moduli of a point; A holds the point's part `twist` `= Π s_p` of the second derivative of `ln θ`, too.
pub(super) fn moduli<const D: usize, H, const TANGENT: u8, const HOOP: bool>(
    response: &Response<H>,
    volume: f64,
    twist: f64,
) -> Moduli<D> {
    let tau = block::<D>(&response.kirchhoff);
    let mut a = response.tangent.spatial_tangent::<D>();
    let mut by_volume = tau;
    for i in 0..D {
        for k in 0..D {
            for l in 0..D {
                by_volume[(i, k)] += a[k][l][(i, l)];
            }
        }
    }
    let none = HoopTangent { by_hoop: Matrix2::zeros(), of_hoop: Matrix2::zeros(), hoop: 0.0 };
    let mut hoop = HoopModuli { a: none, by_volume: 0.0, of_pressure: 0.0 };
    // With twist the hoop is one of the directions.
    if HOOP && D == 2 {
        hoop.a = response.tangent.hoop_tangent();
        let own = response.kirchhoff.zz + hoop.a.hoop;
        hoop.by_volume = (own + hoop.a.of_hoop.trace()) * volume;
        hoop.of_pressure = (own + hoop.a.by_hoop.trace()) * volume;
        by_volume += in_plane(&hoop.a.by_hoop);
    }
    by_volume *= volume;
    let mut of_pressure = by_volume;
    if TANGENT == ALL {
        of_pressure = tau;
        for j in 0..D {
            for l in 0..D {
                for k in 0..D {
                    of_pressure[(j, l)] += a[k][l][(k, j)];
                }
            }
        }
        if HOOP && D == 2 {
            of_pressure += in_plane(&hoop.a.of_hoop);
        }
        of_pressure *= volume;
    }
    let stretches = const { stretches::<D, HOOP>() };
    let mut kappa = by_volume.trace() / (stretches * stretches);
    let mut pressure = tau.trace() / stretches * volume;
    if HOOP && D == 2 {
        kappa += hoop.by_volume / (stretches * stretches);
        pressure += response.kirchhoff.zz / stretches * volume;
        let HoopTangent { by_hoop, of_hoop, hoop: own } = &mut hoop.a;
        let shared = |i: usize, j: usize| if i == j { kappa + twist } else { 0.0 };
        let less = |p: &Block<D>, of_hoop: f64, i: usize, j: usize| {
            (p[(i, j)] + if i == j { of_hoop } else { 0.0 }) / stretches
        };
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            by_hoop[(i, j)] =
                by_hoop[(i, j)] * volume + shared(i, j) - less(&by_volume, hoop.of_pressure, i, j);
            of_hoop[(i, j)] =
                of_hoop[(i, j)] * volume + shared(i, j) - less(&of_pressure, hoop.by_volume, i, j);
        }
        *own = *own * volume + kappa + pressure - (hoop.by_volume + hoop.of_pressure) / stretches;
    }
    for k in 0..D {
        for l in 0..D {
            let a = &mut a[k][l];
            *a *= volume;
            for other in 0..D {
                a[(k, other)] -= of_pressure[(other, l)] / stretches;
                a[(other, l)] -= by_volume[(other, k)] / stretches;
            }
            a[(k, l)] += kappa + twist;
            a[(l, k)] += pressure - twist;
        }
    }
    if HOOP && D == 3 {
        (hoop.by_volume, hoop.of_pressure) = (by_volume[(D - 1, D - 1)], of_pressure[(D - 1, D - 1)]);
    }
    Moduli { a, by_volume, of_pressure, kappa, hoop }
}

/// A matrix of the plane.
fn in_plane<const D: usize>(matrix: &Matrix2<f64>) -> Block<D> {
    Block::from_fn(|i, j| matrix[(i, j)])
}

//! Moduli of a point whose volume change is that of its cell.

use crate::body::kinematics::block;
use crate::body::scatter::ALL;
use mpm_grid::Block;
use mpm_material::Response;

/// Moduli of a point under mean dilatation.
pub(super) struct Moduli<const D: usize> {
    /// V⁰ A as blocks `[k][l](i, j)`.
    pub a: [[Block<D>; D]; D],
    /// V⁰ P.
    pub by_volume: Block<D>,
    /// V⁰ P', which equals V⁰ P where C is symmetric.
    pub of_pressure: Block<D>,
}

/// The moduli of a point; A holds the point's part `twist` `= Π s_p` of the second derivative of `ln θ`, too.
pub(super) fn moduli<const D: usize, H, const TANGENT: u8>(
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
        of_pressure *= volume;
    }
    let kappa = by_volume.trace() / (D * D) as f64;
    let pressure = tau.trace() / D as f64 * volume;
    for k in 0..D {
        for l in 0..D {
            let a = &mut a[k][l];
            *a *= volume;
            for other in 0..D {
                a[(k, other)] -= of_pressure[(other, l)] / D as f64;
                a[(other, l)] -= by_volume[(other, k)] / D as f64;
            }
            a[(k, l)] += kappa + twist;
            a[(l, k)] += pressure - twist;
        }
    }
    Moduli { a, by_volume, of_pressure }
}

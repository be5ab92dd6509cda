//! What is done about domains that have outgrown their cells.
//!
//! After a shear γ of many units a convected domain is a needle, γ times as long as it was. CPDI
//! samples the mesh at its far corners only: the needle no longer feels the cells that it passes
//! through, and adds stiffness to cells in which its stress does not belong. [`cap`] and [`reshape`]
//! shorten such a domain (as Homel, Brannon & Guilkey 2016 scale those of CPDI), [`split`] cuts it into
//! several (as Ma et al. 2009 split points of standard MPM).
//!
//! The size of a domain is that of its longest semi-axis, in cells: with the second moment
//! `S = 3/V ∫ (x - x̄) ⊗ (x - x̄) dV = Σ_k σ_k² u_k ⊗ u_k`, of a parallelepiped `R Rᵀ`, and the Jacobian J of
//! the cell around the point, a semi-axis has `σ_k |J⁻¹ u_k|` cells: 1 where a box is as long as its
//! cell, `1/n` with n points per direction at rest.

use crate::basis::{Basis, DomainPart};
use crate::corner::BEYOND;
use crate::domain::Domain;
use crate::tensor::inverse_transpose;
use mpm_grid::{Block, Mesh, Vector};

/// Excess over the limit that is left alone, so that rounding alone does not make a domain too long.
const SLACK: f64 = 1e-9;

/// What is done about domains longer than so many cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DomainControl {
    /// See [`cap`].
    Cap {
        /// Most cells of a semi-axis `[-]`.
        cells: f64,
    },
    /// See [`reshape`].
    Reshape {
        /// Most cells of a semi-axis `[-]`.
        cells: f64,
    },
    /// See [`split`].
    Split {
        /// Most cells of a semi-axis `[-]`.
        cells: f64,
    },
}

/// Shortens a domain to at most `cells` cells along each of its principal axes, about its point;
/// says whether that was needed.
///
/// Only the sampling of the mesh changes: the point keeps its F, volume, mass, and stress. S and ∇S stay
/// complete. Neighbouring domains gap afterwards. A point outside the mesh is left as it is.
pub fn cap<const D: usize>(mesh: &Mesh<D>, x: &Vector<D>, domain: &mut impl Domain<D>, cells: f64) -> bool {
    limit(mesh, x, domain, cells, |_| 1.0)
}

/// As [`cap`], and its other principal axes are lengthened so that the domain keeps its volume, as far as
/// they reach no limit themselves.
///
/// Where a body is sheared for long, its points come to stand as at rest, in other rows than before:
/// domains of their old size and shape tile it better than needles, or the cores of needles. A domain that
/// [`Domain::align`] can turn is laid along the edges of its cell, too: shear and shortening in turn let its
/// sides roll round its principal axes, and the corners of a lozenge reach into rows of cells that no side of
/// the box with the same second moment touches.
pub fn reshape<const D: usize>(mesh: &Mesh<D>, x: &Vector<D>, domain: &mut impl Domain<D>, cells: f64) -> bool {
    let reshaped = limit(mesh, x, domain, cells, |lost| 1.0 / lost);
    if reshaped && let Some(to_cells) = to_cells(mesh, x) {
        domain.align(&to_cells);
    }
    reshaped
}

/// Shortens principal axes to `cells` cells; the others grow by the factor `gain` of volume, which is told
/// the factor that was lost, shared evenly and not beyond the limit.
fn limit<const D: usize>(
    mesh: &Mesh<D>,
    x: &Vector<D>,
    domain: &mut impl Domain<D>,
    cells: f64,
    gain: impl Fn(f64) -> f64,
) -> bool {
    let (Some(spread), Some(to_cells)) = (domain.spread(), to_cells(mesh, x)) else { return false };
    let axes = semi_axes(&spread);
    let sizes = axes.map(|axis| (to_cells * axis).norm());
    let long = sizes.map(|size| size > cells * (1.0 + SLACK));
    if !long.contains(&true) {
        return false;
    }
    let lost: f64 = (0..D).filter(|&k| long[k]).map(|k| cells / sizes[k]).product();
    let others = long.iter().filter(|long| !**long).count();
    let growth = gain(lost).powf(1.0 / others.max(1) as f64);
    let mut map = Block::zeros();
    for k in 0..D {
        let factor = if long[k] { cells / sizes[k] } else { growth.min(cells / sizes[k]) };
        let square = axes[k].norm_squared();
        if square > 0.0 {
            map += axes[k] * axes[k].transpose() * (factor / square);
        }
    }
    domain.scale(x, &map);
    true
}

/// Halves a domain, and its halves, until none is longer than `cells` cells; empty where the domain is
/// not too long or cannot be halved.
///
/// Halves fill the domain. Each is cut across the side that is longest in its cell. Cutting stops where
/// more than `most` parts would be made; there are then more than `most`.
pub fn split<const D: usize, B: Basis<D>>(
    basis: &B,
    mesh: &Mesh<D>,
    x: &Vector<D>,
    domain: &B::Domain,
    cells: f64,
    most: usize,
) -> Vec<DomainPart<D, B::Domain>> {
    let mut parts = Vec::new();
    if !is_too_long(mesh, x, domain, cells) {
        return parts;
    }
    // The part to be looked at next is the last: parts come out in order along the domain.
    let mut open = vec![DomainPart { position: *x, domain: domain.clone(), share: 1.0 }];
    while let Some(part) = open.pop() {
        // This part and those still open are as many points already.
        let room = parts.len() + open.len() < most.max(1);
        let halves = if room && is_too_long(mesh, &part.position, &part.domain, cells) {
            to_cells(mesh, &part.position).and_then(|it| basis.halve(&part.domain, &part.position, &it))
        } else {
            None
        };
        match halves {
            None => parts.push(part),
            Some([mut first, mut second]) => {
                first.share *= part.share;
                second.share *= part.share;
                open.push(second);
                open.push(first);
            }
        }
    }
    if parts.len() == 1 { Vec::new() } else { parts }
}

/// Cells of the longest semi-axis of a domain; `None` where there is no domain or no cell `[-]`.
pub fn size<const D: usize>(mesh: &Mesh<D>, x: &Vector<D>, domain: &impl Domain<D>) -> Option<f64> {
    let (spread, to_cells) = (domain.spread()?, to_cells(mesh, x)?);
    Some(semi_axes(&spread).iter().map(|axis| (to_cells * axis).norm()).fold(0.0, f64::max))
}

/// Whether the longest semi-axis of a domain has more than `cells` cells.
pub fn is_too_long<const D: usize>(mesh: &Mesh<D>, x: &Vector<D>, domain: &impl Domain<D>, cells: f64) -> bool {
    size(mesh, x, domain).is_some_and(|size| size > cells * (1.0 + SLACK))
}

/// `J⁻¹` of the cell at `x`: takes half of a cell's edge to length 1.
fn to_cells<const D: usize>(mesh: &Mesh<D>, x: &Vector<D>) -> Option<Block<D>> {
    let place = mesh.locate(x, BEYOND).ok()?;
    Some(inverse_transpose(&mesh.linear_cell(place.cell).jacobian(&place.local)).transpose())
}

/// The direction that `to_cells` makes longest.
pub(crate) fn longest<const D: usize>(
    directions: impl IntoIterator<Item = Vector<D>>,
    to_cells: &Block<D>,
) -> usize {
    let mut longest = (0, f64::NEG_INFINITY);
    for (k, direction) in directions.into_iter().enumerate() {
        let length = (to_cells * direction).norm();
        if length > longest.1 {
            longest = (k, length);
        }
    }
    longest.0
}

/// The second moment of the corners of a box-like domain about their mean.
pub(crate) fn spread_of_corners<const D: usize>(corners: &[Vector<D>]) -> Block<D> {
    let n = corners.len() as f64;
    let centre = corners.iter().sum::<Vector<D>>() / n;
    corners.iter().map(|x| (x - centre) * (x - centre).transpose()).sum::<Block<D>>() / n
}

/// `x_c → x + A (x_c - x)`.
pub(crate) fn scale_corners<'a, const D: usize>(
    corners: impl IntoIterator<Item = &'a mut Vector<D>>,
    x: &Vector<D>,
    map: &Block<D>,
) {
    for corner in corners {
        *corner = x + map * (*corner - x);
    }
}

/// `σ_k u_k` of a second moment `Σ_k σ_k² u_k ⊗ u_k`, by Jacobi's rotations.
fn semi_axes<const D: usize>(spread: &Block<D>) -> [Vector<D>; D] {
    let (mut a, mut u) = (*spread, Block::<D>::identity());
    // Convergence is quadratic; the bound only ends what is not a number.
    for _ in 0..20 {
        let mut rotated = false;
        for q in 1..D {
            for p in 0..q {
                if a[(p, q)].abs() <= f64::EPSILON * (a[(p, p)] * a[(q, q)]).abs().sqrt() {
                    continue;
                }
                rotated = true;
                let theta = 0.5 * (a[(q, q)] - a[(p, p)]) / a[(p, q)];
                let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
                let c = 1.0 / t.hypot(1.0);
                let mut g = Block::<D>::identity();
                (g[(p, p)], g[(q, q)], g[(p, q)], g[(q, p)]) = (c, c, t * c, -t * c);
                a = g.transpose() * a * g;
                u *= g;
            }
        }
        if !rotated {
            break;
        }
    }
    std::array::from_fn(|k| u.column(k) * a[(k, k)].max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix2, Matrix3};

    #[test]
    fn semi_axes_are_orthogonal_and_make_up_the_moment() {
        let r = Matrix3::new(1.2, -0.3, 0.1, 0.4, 0.9, -0.2, 0.05, 0.3, 1.1);
        let needle = Matrix2::new(1.0, 300.0, 0.0, 1.0);
        fn check<const D: usize>(r: Block<D>, tolerance: f64) {
            let spread = r * r.transpose();
            let axes = semi_axes(&spread);
            let sum: Block<D> = axes.iter().map(|a| a * a.transpose()).sum();
            assert!((sum - spread).norm() < tolerance * spread.norm());
            for k in 1..D {
                let cosine = axes[0].dot(&axes[k]) / (axes[0].norm() * axes[k].norm());
                assert!(cosine.abs() < 1e-12, "{cosine:e}");
            }
        }
        check(r, 1e-14);
        check(needle, 1e-14);
        check(Matrix2::identity(), 1e-15);
        // σ of (1 γ; 0 1): (√(γ² + 4) ± γ)/2.
        let longest = semi_axes(&(needle * needle.transpose())).iter().map(|a| a.norm()).fold(0.0, f64::max);
        assert!((longest - 0.5 * (90_004_f64.sqrt() + 300.0)).abs() < 1e-11);
    }
}

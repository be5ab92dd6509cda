//! Domains that stand for rings about the axis r = 0 of the half plane (r, z): means weighted by r.
//!
//! With the corner functions M_c of a domain (bilinear, or linear in a triangle), its area A and its centroid's radius
//! r_p, `w̃_c = ∫ M_c r dA / (A r_p)` and `g̃_c = ∫ ∇M_c r dA / (A r_p)`. Then `Σ w̃_c = 1`, `Σ g̃_c = 0`,
//! `Σ x_c ⊗ g̃_c = I`, and with the plain weights w_c
//!
//! ```text
//! 2π A (r_p g̃_c + w_c e_r) = 2π Σ n_e (r_c/3 + r_c'/6)
//! ```
//!
//! over the two edges at the corner (n_e: outward normal times length, c': the other end): the surface of the ring that
//! belongs to the corner. Edges that two domains share cancel, which is why a uniform stress leaves no force between
//! them (Nairn & Guilkey 2015 weigh gradients so).

use crate::basis::RingSide;
use crate::corner::{BEYOND, Corner, CornerPoint};
use crate::influence::Stencil;
use crate::sampled::{self, Sample};
use crate::tensor::signs;
use mpm_grid::{Mesh, OutsideMesh, Vector};
use std::array::from_fn;

/// A corner of a domain that stands for a ring.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RingSample<const D: usize> {
    /// Position and plain weight, with the gradient weighted by r.
    pub sample: Sample<D>,
    /// `w̃_c` `[-]`.
    pub mass: f64,
}

/// The corners of a quadrilateral, lexicographic, with their plain weights; by 2 × 2 Gauss points, which are exact.
pub(crate) fn quadrilateral<const D: usize>(corners: [(Vector<D>, f64); 4]) -> [RingSample<D>; 4] {
    let at = 1.0 / 3.0_f64.sqrt();
    let mut moment = 0.0;
    let (mut mass, mut gradient) = ([0.0; 4], [[0.0; 2]; 4]);
    for q in 0..4 {
        let local = signs::<2>(q) * at;
        // M_c and its derivatives by the local coordinates.
        let functions: [[f64; 3]; 4] = from_fn(|c| {
            let s = signs::<2>(c);
            let (a, b) = (1.0 + s.x * local.x, 1.0 + s.y * local.y);
            [0.25 * a * b, 0.25 * s.x * b, 0.25 * s.y * a]
        });
        let sum = |of: usize, d: usize| (0..4).map(|c| functions[c][of] * corners[c].0[d]).sum::<f64>();
        let radius = sum(0, 0);
        let [[r_1, z_1], [r_2, z_2]] = [1, 2].map(|of| [sum(of, 0), sum(of, 1)]);
        let weight = radius * (r_1 * z_2 - z_1 * r_2);
        moment += weight;
        for c in 0..4 {
            let [m, m_1, m_2] = functions[c];
            mass[c] += m * weight;
            gradient[c][0] += (m_1 * z_2 - m_2 * z_1) * radius;
            gradient[c][1] += (m_2 * r_1 - m_1 * r_2) * radius;
        }
    }
    let per_moment = 1.0 / moment;
    from_fn(|c| RingSample {
        sample: Sample {
            position: corners[c].0,
            weight: corners[c].1,
            gradient: Vector::from_fn(|d, _| gradient[c][d] * per_moment),
        },
        mass: mass[c] * per_moment,
    })
}

/// The corners of a triangle: its gradients are uniform, so that no weight changes their mean.
pub(crate) fn triangle<const D: usize>(corners: [Sample<D>; 3]) -> [RingSample<D>; 3] {
    let radius = corners.iter().map(|corner| corner.position[0]).sum::<f64>() / 3.0;
    corners.map(|sample| {
        let mass = (sample.position[0] + 3.0 * radius) / (12.0 * radius);
        RingSample { sample, mass }
    })
}

/// Adds the influences of a ring with these corners to an empty stencil: plain values, weighted gradients.
///
/// # Errors
/// As [`sampled::influences`].
pub(crate) fn influences<const D: usize, const N: usize>(
    mesh: &Mesh<D>,
    corners: &[RingSample<D>; N],
    stencil: &mut Stencil<D>,
) -> Result<(), OutsideMesh<D>> {
    sampled::influences(mesh, &corners.map(|corner| corner.sample), stencil)
}

/// Adds the parts of a ring's mass as values to an empty stencil.
///
/// # Errors
/// As [`sampled::influences`].
pub(crate) fn masses<const D: usize, const N: usize>(
    mesh: &Mesh<D>,
    corners: &[RingSample<D>; N],
    stencil: &mut Stencil<D>,
) -> Result<(), OutsideMesh<D>> {
    let samples = corners.map(|corner| Sample { weight: corner.mass, ..corner.sample });
    sampled::influences(mesh, &samples, stencil)
}

/// Adds the corners of a ring.
///
/// # Errors
/// As [`sampled::corners`].
pub(crate) fn corners<const D: usize, const N: usize>(
    mesh: &Mesh<D>,
    point: &CornerPoint<D>,
    corners: &[RingSample<D>; N],
    to: &mut Vec<Corner<D>>,
) -> Result<(), OutsideMesh<D>> {
    for RingSample { sample, mass } in corners {
        to.push(Corner::at(mesh, sample.position, (area(point, sample), *mass))?);
    }
    Ok(())
}

/// Adds the parts of the nodes that carry the corners of a domain next to the ends of one of its sides; `outline` are its
/// corners round it. Between two corners, the nearer carries the more.
///
/// # Errors
/// As [`sampled::influences`].
pub(crate) fn side<const D: usize>(
    mesh: &Mesh<D>,
    outline: &[Vector<D>],
    side: &RingSide<D>,
    stencil: &mut Stencil<D>,
) -> Result<(), OutsideMesh<D>> {
    for (end, part) in side.ends.iter().zip(side.parts) {
        let on_edge = |k: usize| {
            let (a, b) = (outline[k], outline[(k + 1) % outline.len()]);
            let along = ((end - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
            ((a + (b - a) * along - end).norm(), along, [a, b])
        };
        let edges = (0..outline.len()).map(on_edge);
        let Some((_, along, corners)) = edges.min_by(|a, b| a.0.total_cmp(&b.0)) else { continue };
        for (x, share) in corners.iter().zip([1.0 - along, along]) {
            if share > 0.0 {
                let place = mesh.locate(x, BEYOND)?;
                mesh.values(&place, |node, n| stencil.add(node, n * share * part, Vector::zeros()));
            }
        }
    }
    Ok(())
}

/// `V_p (g̃_c + w_c e_r / r_p)`: the surface of the ring that belongs to a corner.
pub(crate) fn area<const D: usize>(point: &CornerPoint<D>, sample: &Sample<D>) -> Vector<D> {
    let mut area = sample.gradient * point.volume;
    area[0] += sample.weight * point.volume / point.position[0];
    area
}

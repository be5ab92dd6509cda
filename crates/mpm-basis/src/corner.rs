//! Corners of domains: where a body meets the surface of a rigid tool.
//!
//! A pressure on the corners `p a_c` balances a uniform stress exactly where nodes receive it by `W_cv = N_v(x_c)`,
//! because the gradients of the family CPDI are `∇S_vp = Σ_c N_v(x_c) g_c` and `a_c = V_p g_c`.

use crate::tensor::signs;
use mpm_grid::{Block, Mesh, NodeId, OutsideMesh, SplineProduct, Vector};
use std::f64::consts::TAU;

/// How far outside the mesh a corner may be, in cells; N_v of the boundary cell continue to there.
pub(crate) const BEYOND: f64 = 0.5;

/// A point whose corners are asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CornerPoint<const D: usize> {
    /// `x_p` `[L]`.
    pub position: Vector<D>,
    /// `V_p⁰`; of a ring the area of its cross section at rest `[L^D]`.
    pub reference_size: f64,
    /// `V_p`; of a ring the whole of it `[L^D]`, `[L³]`.
    pub volume: f64,
    /// Whether the point stands for a ring about the axis r = 0.
    pub is_ring: bool,
    /// F `[-]`.
    pub deformation_gradient: Block<D>,
}

/// A corner of a point's domain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner<const D: usize> {
    /// `x_c` `[L]`.
    pub position: Vector<D>,
    /// `a_c`: the part of the domain's surface that belongs to the corner, outward `[L^(D-1)]`; of a ring `[L²]`.
    pub area: Vector<D>,
    /// Part of the domain that belongs to the corner, the mean of its corner function (of a ring weighted by r) `[-]`.
    pub share: f64,
    /// Nodes that carry the corner and their weights `W_cv` `[-]`.
    pub(crate) carriers: Carriers<D>,
}

/// Nodes that carry a corner, with their weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Carriers<const D: usize> {
    /// Vertices of a cell; the first 2^D entries count.
    Vertices([(NodeId, f64); 8]),
    /// The functions of a mesh of splines.
    Splines(SplineProduct<D>),
}

impl<const D: usize> Corner<D> {
    /// Nodes and their weights, without those that are exactly zero.
    pub fn weights(&self) -> impl Iterator<Item = (NodeId, f64)> + '_ {
        let count = match &self.carriers {
            Carriers::Vertices(_) => 1 << D,
            Carriers::Splines(product) => product.len(),
        };
        let entry = |k: usize| match &self.carriers {
            Carriers::Vertices(nodes) => nodes[k],
            Carriers::Splines(product) => product.entry(k),
        };
        (0..count).map(entry).filter(|(_, weight)| *weight != 0.0)
    }

    /// The corner at `x` with the weights `N_v(x)` of the cell that holds it.
    ///
    /// # Errors
    /// The corner lies farther than half a cell outside the mesh.
    pub(crate) fn at(
        mesh: &Mesh<D>,
        x: Vector<D>,
        (area, share): (Vector<D>, f64),
    ) -> Result<Self, OutsideMesh<D>> {
        let place = mesh.locate(&x, BEYOND)?;
        if let Some(product) = mesh.spline_product(&place) {
            return Ok(Self { position: x, area, share, carriers: Carriers::Splines(product) });
        }
        let mut nodes = [(NodeId::from_index(0).expect("0 is a number"), 0.0); 8];
        let mut at = 0;
        mesh.values(&place, |node, value| {
            nodes[at] = (node, value);
            at += 1;
        });
        Ok(Self { position: x, area, share, carriers: Carriers::Vertices(nodes) })
    }
}

/// The corners of a box along the axes with these half lengths: half of the sides that meet there in the plane, a
/// quarter of the faces in space; of a ring, the parts of its surface by the linear functions along its sides.
///
/// # Errors
/// The first corner farther than half a cell outside the mesh.
pub(crate) fn of_box<const D: usize>(
    mesh: &Mesh<D>,
    (x, is_ring): (&Vector<D>, bool),
    half: &Vector<D>,
    to: &mut Vec<Corner<D>>,
) -> Result<(), OutsideMesh<D>> {
    let volume: f64 = half.product();
    for c in 0..1 << D {
        let s = signs::<D>(c);
        let position = x + half.component_mul(&s);
        let mut area = s.component_div(half) * volume;
        let mut share = 1.0 / f64::from(1 << D);
        if is_ring {
            // ½ r_c of the side along z, r_c/3 + r_c'/6 of that along r.
            let moment = s[0] * half[0] / 3.0;
            area[0] *= TAU * position[0];
            area[1] *= TAU * (x[0] + moment);
            share *= (x[0] + moment) / x[0];
        }
        to.push(Corner::at(mesh, position, (area, share))?);
    }
    Ok(())
}

//! Corners of domains: where a body meets the surface of a rigid tool.
//!
//! A pressure on the corners `p a_c` balances a uniform stress exactly where nodes receive it by `W_cv = N_v(x_c)`,
//! because the gradients of the family CPDI are `∇S_vp = Σ_c N_v(x_c) g_c` and `a_c = V_p g_c`.

use crate::tensor::{inverse_transpose, signs};
use mpm_grid::{Block, Mesh, NodeId, OutsideMesh, Vector};

/// How far outside the mesh a corner may be, in cells; N_v of the boundary cell continue to there.
pub(crate) const BEYOND: f64 = 0.5;

/// A point whose corners are asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CornerPoint<const D: usize> {
    /// `x_p` `[L]`.
    pub position: Vector<D>,
    /// `V_p⁰` `[L^D]`.
    pub reference_volume: f64,
    /// `V_p` `[L^D]`.
    pub volume: f64,
    /// F `[-]`.
    pub deformation_gradient: Block<D>,
}

/// A corner of a point's domain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner<const D: usize> {
    /// `x_c` `[L]`.
    pub position: Vector<D>,
    /// `a_c`: the part of the domain's surface that belongs to the corner, outward `[L^(D-1)]`.
    pub area: Vector<D>,
    /// Nodes that carry the corner and their weights `W_cv` `[-]`; the first 2^D entries count.
    nodes: [(NodeId, f64); 8],
}

impl<const D: usize> Corner<D> {
    /// Nodes and their weights, without those that are exactly zero.
    pub fn weights(&self) -> impl Iterator<Item = (NodeId, f64)> + '_ {
        self.nodes[..1 << D].iter().copied().filter(|(_, weight)| *weight != 0.0)
    }

    /// The corner at `x` with the weights `N_v(x)` of the cell that holds it.
    ///
    /// # Errors
    /// The corner lies farther than half a cell outside the mesh.
    pub(crate) fn at(mesh: &Mesh<D>, x: Vector<D>, area: Vector<D>) -> Result<Self, OutsideMesh<D>> {
        let place = mesh.locate(&x, BEYOND)?;
        let mut nodes = [(NodeId::from_index(0).expect("0 is a number"), 0.0); 8];
        let mut at = 0;
        mesh.values(&place, |node, value| {
            nodes[at] = (node, value);
            at += 1;
        });
        Ok(Self { position: x, area, nodes })
    }
}

/// The corners of a box along the axes with these half lengths: half of the sides that meet there in the plane, a
/// quarter of the faces in space.
///
/// # Errors
/// The first corner farther than half a cell outside the mesh.
pub(crate) fn of_box<const D: usize>(
    mesh: &Mesh<D>,
    x: &Vector<D>,
    half: &Vector<D>,
    to: &mut Vec<Corner<D>>,
) -> Result<(), OutsideMesh<D>> {
    let volume: f64 = half.product();
    for c in 0..1 << D {
        let s = signs::<D>(c);
        to.push(Corner::at(mesh, x + half.component_mul(&s), s.component_div(half) * volume)?);
    }
    Ok(())
}

/// The corners of a point without a domain: those of the parallelepiped `½ (V_p⁰)^(1/D) F`, which are carried by the
/// point's own cell, `W_cv = S_vp + ∇S_vp · (x_c - x_p)`.
///
/// # Errors
/// The point lies outside the mesh.
pub(crate) fn of_point<const D: usize>(
    mesh: &Mesh<D>,
    point: &CornerPoint<D>,
    to: &mut Vec<Corner<D>>,
) -> Result<(), OutsideMesh<D>> {
    let CornerPoint { position, reference_volume, volume, deformation_gradient } = point;
    let sides = deformation_gradient * (0.5 * reference_volume.powf(1.0 / D as f64));
    let push = inverse_transpose(&sides) * (volume / f64::from(1 << D));
    let place = mesh.locate(position, 0.0)?;
    for c in 0..1 << D {
        let s = signs::<D>(c);
        let arm = sides * s;
        let mut nodes = [(NodeId::from_index(0).expect("0 is a number"), 0.0); 8];
        let mut at = 0;
        mesh.values_and_gradients(&place, |node, value, gradient| {
            nodes[at] = (node, value + gradient.dot(&arm));
            at += 1;
        });
        to.push(Corner { position: position + arm, area: push * s, nodes });
    }
    Ok(())
}

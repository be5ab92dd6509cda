//! What a shape must tell of itself.

use crate::bounds::Bounds;
use crate::pose::Pose;
use mpm_grid::{Block, Vector};
use std::fmt::Debug;

/// A local minimum of the distance from a point to the surface of a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Near<const D: usize> {
    /// Signed distance φ `[L]`, negative inside.
    pub distance: f64,
    /// n = ∇φ `[-]`, a unit vector that points out of the shape.
    pub normal: Vector<D>,
    /// H = ∇∇φ `[1/L]`, symmetric, with H n = 0.
    pub hessian: Block<D>,
    /// Number of the edge, facet or vertex that is near; 0 where a shape has one smooth surface.
    pub feature: u32,
}

impl<const D: usize> Near<D> {
    /// The same in space, when it was found in the frame of a tool at this pose.
    #[must_use]
    pub fn turned(&self, pose: &Pose<D>) -> Self {
        let r = pose.rotation();
        Self { normal: r * self.normal, hessian: r * self.hessian * r.transpose(), ..*self }
    }

    /// `H = κ (I - n⊗n)` of what curves equally in all directions: κ = 1/distance to a point, 0 on a plane.
    pub(crate) fn round(distance: f64, normal: Vector<D>, curvature: f64, feature: u32) -> Self {
        let hessian = (Block::identity() - normal * normal.transpose()) * curvature;
        Self { distance, normal, hessian, feature }
    }
}

/// A small piece of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<const D: usize> {
    /// A place on the surface in the middle of the piece `[L]`.
    pub position: Vector<D>,
    /// The outward normal there `[-]`.
    pub normal: Vector<D>,
    /// The piece's area; in the plane its length `[L^(D-1)]`.
    pub area: f64,
}

/// A surface for drawing: segments in the plane, triangles in space, the solid on the left of a segment and behind a
/// triangle whose corners run anticlockwise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outline<const D: usize> {
    /// Positions `[L]`.
    pub vertices: Vec<Vector<D>>,
    /// Corners of each segment or triangle by number.
    pub facets: Vec<[u32; D]>,
}

impl<const D: usize> Outline<D> {
    /// Adds a vertex and returns its number.
    pub(crate) fn add(&mut self, vertex: Vector<D>) -> u32 {
        self.vertices.push(vertex);
        u32::try_from(self.vertices.len() - 1).expect("an outline has fewer than 2^32 vertices")
    }

    /// Takes the facets of another outline in.
    pub(crate) fn append(&mut self, other: &Self) {
        let first = u32::try_from(self.vertices.len()).expect("an outline has fewer than 2^32 vertices");
        self.vertices.extend_from_slice(&other.vertices);
        self.facets.extend(other.facets.iter().map(|facet| facet.map(|vertex| vertex + first)));
    }
}

/// A rigid body in its own frame, by the signed distance to its surface.
pub trait Shape<const D: usize>: Debug + Send + Sync {
    /// Appends the local minima of the distance from `x` `[L]` to the surface whose signed distance is below `reach`
    /// `[L]`, the nearest first. Outside and within the rounding of edges these are all minima whose normals differ by
    /// more than 30° from a nearer one's, so that a concave edge holds with both its faces; deeper inside it is the
    /// nearest one alone.
    fn near(&self, x: &Vector<D>, reach: f64, out: &mut Vec<Near<D>>);

    /// Signed distance φ from `x` to the surface, however far `[L]`.
    fn distance(&self, x: &Vector<D>) -> f64 {
        let mut near = Vec::new();
        self.near(x, f64::INFINITY, &mut near);
        near.first().map_or(f64::INFINITY, |near| near.distance)
    }

    /// A box around the shape.
    fn bounds(&self) -> Bounds<D>;

    /// Appends samples of the surface no farther apart than `spacing` `[L]`, whose areas sum to its area: at least those in the
    /// box `within`. Of a surface that has an end, where they are does not depend on the box.
    fn samples(&self, spacing: f64, within: &Bounds<D>, out: &mut Vec<Sample<D>>);

    /// The surface for drawing, with facets of about `spacing` `[L]` where it is curved; as much of one without end as
    /// lies in the box `within`.
    fn outline(&self, spacing: f64, within: &Bounds<D>) -> Outline<D>;

    /// How far it is through the thinnest part `[L]`, infinite where it has no other side.
    fn thickness(&self) -> f64;

    /// What it is, in a word or two.
    fn kind(&self) -> &'static str;

    /// The largest angle below 30° between facets that meet `[rad]`: facets that turn by less may stand for a smooth
    /// surface. 0 where it has none.
    fn facet_turn(&self) -> f64 {
        0.0
    }
}

/// Facets that turn by less from one to the next may stand for a smooth surface `[rad]`.
pub(crate) const SMOOTH: f64 = std::f64::consts::PI / 6.0;

/// Cosine of the angle by which the normals of two minima differ at least.
const APART: f64 = 0.866_025_403_784_438_6;

/// Sorts what was found from `from` on by distance and keeps of the minima with like normals the nearest; equal
/// distances stay in the order of their features.
pub(crate) fn keep_distinct<const D: usize>(out: &mut Vec<Near<D>>, from: usize) {
    out[from..].sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.feature.cmp(&b.feature)));
    let mut kept = from;
    for next in from..out.len() {
        let candidate = out[next];
        if out[from..kept].iter().all(|it| it.normal.dot(&candidate.normal) < APART) {
            out[kept] = candidate;
            kept += 1;
        }
    }
    out.truncate(kept);
}

/// The unit vector along an axis.
pub(crate) fn unit<const D: usize>(axis: usize) -> Vector<D> {
    Vector::from_fn(|d, _| if d == axis { 1.0 } else { 0.0 })
}

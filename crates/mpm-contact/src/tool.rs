//! Rigid bodies as unions of shapes.

use crate::bounds::Bounds;
use crate::error::ContactError;
use crate::pose::Pose;
use crate::shape::{Near, Outline, Sample, Shape};
use mpm_grid::Vector;
use nalgebra::Vector3;

/// A union of parts in one frame. Every part is met on its own, so that where two parts join both hold.
#[derive(Debug)]
pub struct Tool<const D: usize> {
    parts: Vec<Box<dyn Shape<D>>>,
}

/// How far a motion carries a shape along the normals that it has at first `[L]`.
fn carried<const D: usize>(shape: &dyn Shape<D>, from: &Pose<D>, to: &Pose<D>) -> f64 {
    let bounds = shape.bounds();
    let outline = shape.outline(shape.thickness(), &bounds);
    if outline.facets.is_empty() {
        return bounds.farthest(from, to);
    }
    let whole = |x: Vector<D>| Vector3::from_fn(|d, _| if d < D { x[d] } else { 0.0 });
    let along = |facet: &[u32; D]| {
        let corners = facet.map(|vertex| outline.vertices[vertex as usize]);
        let edge = |k: usize| whole(corners.get(k).map_or_else(Vector::zeros, |x| x - corners[0]));
        let normal = edge(1).cross(&if D == 2 { Vector3::z() } else { edge(2) });
        let normal = Vector::<D>::from_fn(|d, _| normal[d]).try_normalize(0.0).unwrap_or_else(Vector::zeros);
        let normal = from.turn(&normal);
        corners.iter().map(|x| (to.place(x) - from.place(x)).dot(&normal).abs()).fold(0.0, f64::max)
    };
    outline.facets.iter().map(along).fold(0.0, f64::max)
}

impl<const D: usize> Tool<D> {
    /// The union of some parts.
    ///
    /// # Errors
    /// `parts`: there are none.
    pub fn new(parts: Vec<Box<dyn Shape<D>>>) -> Result<Self, ContactError> {
        ContactError::unless(!parts.is_empty(), "parts", 0.0, "at least one part")?;
        Ok(Self { parts })
    }

    /// Its parts.
    pub fn into_parts(self) -> Vec<Box<dyn Shape<D>>> {
        self.parts
    }

    /// Number of parts.
    pub fn n_parts(&self) -> usize {
        self.parts.len()
    }

    /// A part by its number.
    pub fn part(&self, part: usize) -> &dyn Shape<D> {
        &*self.parts[part]
    }

    /// Appends what of a part is near to `x` `[L]` in space, where the tool stands at `pose`, as [`Shape::near`]
    /// does; normals and Hessians are in space.
    pub fn near(&self, part: usize, pose: &Pose<D>, x: &Vector<D>, reach: f64, out: &mut Vec<Near<D>>) {
        let from = out.len();
        self.parts[part].near(&pose.recall(x), reach, out);
        out[from..].iter_mut().for_each(|near| *near = near.turned(pose));
    }

    /// Signed distance to the union from a point `[L]` of the tool's frame, however far `[L]`.
    pub fn distance(&self, x: &Vector<D>) -> f64 {
        self.parts.iter().map(|part| part.distance(x)).fold(f64::INFINITY, f64::min)
    }

    /// Whether a point `[L]` of the tool's frame lies inside one of the parts.
    pub fn contains(&self, x: &Vector<D>) -> bool {
        let mut near = Vec::new();
        self.parts.iter().any(|part| {
            near.clear();
            part.near(x, 0.0, &mut near);
            !near.is_empty()
        })
    }

    /// A box around all parts, in the tool's frame.
    pub fn bounds(&self) -> Bounds<D> {
        self.parts.iter().fold(Bounds::empty(), |bounds, part| bounds.with(&part.bounds()))
    }

    /// The thickness of its thinnest part `[L]`.
    pub fn thickness(&self) -> f64 {
        self.parts.iter().map(|part| part.thickness()).fold(f64::INFINITY, f64::min)
    }

    /// How far a motion from one pose to another carries a part along its own normals `[L]`, and how thick that part is `[L]`:
    /// of the part where this is the most of its thickness. What slides along itself passes through nothing. None where no
    /// part has another side.
    pub fn carried(&self, from: &Pose<D>, to: &Pose<D>) -> Option<(f64, f64)> {
        let of_part = |part: usize| {
            let thickness = self.parts[part].thickness();
            thickness.is_finite().then(|| (carried(self.part(part), from, to), thickness))
        };
        let parts = (0..self.n_parts()).filter_map(of_part);
        parts.max_by(|a, b| (a.0 / a.1).total_cmp(&(b.0 / b.1)))
    }

    /// For each part the samples of its surface in the box `within`, no farther apart than `spacing` `[L]`, that no other part
    /// covers, in the tool's frame. Of two faces that lie on each other and face the same way, one is left out.
    pub fn samples(&self, spacing: f64, within: &Bounds<D>) -> Vec<Vec<Sample<D>>> {
        let sampled = |part: usize| {
            let mut samples = Vec::new();
            self.parts[part].samples(spacing, within, &mut samples);
            samples.retain(|it| within.contains(&it.position) && !self.covers(part, it, spacing));
            samples
        };
        (0..self.parts.len()).map(sampled).collect()
    }

    /// Whether another part than `own` covers a sample.
    fn covers(&self, own: usize, sample: &Sample<D>, spacing: f64) -> bool {
        let touching = 1e-9 * spacing;
        let mut near = Vec::new();
        let others = self.parts.iter().enumerate().filter(|(other, _)| *other != own);
        for (other, part) in others {
            near.clear();
            part.near(&sample.position, touching, &mut near);
            let covered =
                |it: &Near<D>| it.distance < -touching || it.normal.dot(&sample.normal) < 0.0 || other < own;
            if near.first().is_some_and(covered) {
                return true;
            }
        }
        false
    }

    /// The surfaces of all parts, for drawing, in the tool's frame.
    pub fn outline(&self, spacing: f64, within: &Bounds<D>) -> Outline<D> {
        let mut whole = Outline { vertices: Vec::new(), facets: Vec::new() };
        self.parts.iter().for_each(|part| whole.append(&part.outline(spacing, within)));
        whole
    }
}

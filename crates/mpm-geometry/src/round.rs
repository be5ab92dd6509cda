//! Cylinders and tubes as surfaces: prisms over polygons of the circles' areas.

use crate::triangles::Triangles;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// A cylinder, or a tube where `inner` is above 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Round {
    /// Direction of its axis, from 0.
    pub axis: usize,
    /// Where the axis passes, by the coordinates across it in their order (of x, y, z) `[L]`.
    pub centre: [f64; 2],
    /// Radius of the hole, or 0 `[L]`.
    pub inner: f64,
    /// Outer radius `[L]`.
    pub outer: f64,
    /// Ends along the axis `[L]`.
    pub ends: (f64, f64),
}

/// Sides of a polygon at least and at most.
const SIDES: (f64, f64) = (64.0, 4096.0);

impl Round {
    /// What it encloses `[L³]`.
    pub fn volume(&self) -> f64 {
        PI * (self.outer * self.outer - self.inner * self.inner) * (self.ends.1 - self.ends.0)
    }

    /// The two directions across the axis.
    pub fn across(&self) -> [usize; 2] {
        match self.axis {
            0 => [1, 2],
            1 => [0, 2],
            _ => [0, 1],
        }
    }

    /// A prism of the same volume whose sides stand off the circles by less than `accuracy` `[L]`.
    pub(crate) fn surface(&self, accuracy: f64) -> Triangles {
        // A side of half angle φ has the sagitta r (1 - cos φ), about r φ²/2.
        let wanted = PI / (2.0 * accuracy / self.outer).sqrt();
        let sides = (8.0 * (wanted / 8.0).ceil()).clamp(SIDES.0, SIDES.1) as u32;
        let step = 2.0 * PI / f64::from(sides);
        // Of a polygon of radius R the area is ½ n R² sin(2π/n).
        let equal_area = (step / step.sin()).sqrt();
        let hollow = self.inner > 0.0;
        let [d, e] = self.across();
        let mut vertices = Vec::new();
        for end in [self.ends.0, self.ends.1] {
            for &radius in &[self.outer, self.inner][..if hollow { 2 } else { 1 }] {
                for side in 0..sides {
                    let (sine, cosine) = (step * f64::from(side)).sin_cos();
                    let mut x = Vector3::zeros();
                    x[self.axis] = end;
                    x[d] = self.centre[0] + radius * equal_area * cosine;
                    x[e] = self.centre[1] + radius * equal_area * sine;
                    vertices.push(x);
                }
            }
        }
        let rings = if hollow { 2 } else { 1 };
        let at = |end: u32, ring: u32, side: u32| (end * rings + ring) * sides + side % sides;
        let mut facets = Vec::new();
        for side in 0..sides {
            let next = side + 1;
            let mut quad = |a: u32, b: u32, c: u32, d: u32| facets.extend([[a, b, c], [a, c, d]]);
            quad(at(0, 0, side), at(0, 0, next), at(1, 0, next), at(1, 0, side));
            if hollow {
                quad(at(0, 1, next), at(0, 1, side), at(1, 1, side), at(1, 1, next));
                quad(at(0, 1, side), at(0, 1, next), at(0, 0, next), at(0, 0, side));
                quad(at(1, 0, side), at(1, 0, next), at(1, 1, next), at(1, 1, side));
            }
        }
        if !hollow {
            // Fans from a corner: the ends are flat and convex.
            for side in 1..sides - 1 {
                facets.push([at(0, 0, 0), at(0, 0, side + 1), at(0, 0, side)]);
                facets.push([at(1, 0, 0), at(1, 0, side), at(1, 0, side + 1)]);
            }
        }
        if self.axis == 1 {
            // x, z, y is a left-handed order.
            facets.iter_mut().for_each(|facet| facet.swap(1, 2));
        }
        Triangles { vertices, facets }
    }
}

//! Discs in the plane, spheres in space, and holes of these shapes.

use crate::bounds::Bounds;
use crate::error::ContactError;
use crate::plane::parts;
use crate::shape::{Near, Outline, Sample, Shape, unit};
use mpm_grid::Vector;
use std::f64::consts::{PI, TAU};

/// A disc in the plane or a sphere in space; solid, or the solid around a hole.
#[derive(Clone, Debug, PartialEq)]
pub struct Sphere<const D: usize> {
    centre: Vector<D>,
    radius: f64,
    /// 1 where it is solid, -1 where it is a hole.
    outward: f64,
}

impl<const D: usize> Sphere<D> {
    /// The solid disc or sphere about `centre` `[L]`.
    ///
    /// # Errors
    /// `centre`, `radius`: not finite, or no positive radius.
    pub fn new(centre: Vector<D>, radius: f64) -> Result<Self, ContactError> {
        ContactError::unless_finite("centre", centre.as_slice())?;
        let radius = ContactError::unless_positive("radius", radius)?;
        Ok(Self { centre, radius, outward: 1.0 })
    }

    /// Everything but a disc or sphere: a wall around what lies inside.
    ///
    /// # Errors
    /// As of [`Self::new`].
    pub fn hole(centre: Vector<D>, radius: f64) -> Result<Self, ContactError> {
        Ok(Self { outward: -1.0, ..Self::new(centre, radius)? })
    }

    /// Cuts the sphere into samples or, between them, lines of equal latitude and longitude: calls `at` with the
    /// direction from the centre and the area of each piece.
    fn each_piece(&self, spacing: f64, mut at: impl FnMut(Vector<D>, f64)) {
        let direction = |sine: f64, cosine: f64, angle: f64| {
            Vector::from_fn(|d, _| match (D, d) {
                (_, 0) => sine * angle.cos(),
                (_, 1) => sine * angle.sin(),
                _ => cosine,
            })
        };
        if D == 2 {
            let n = parts(TAU * self.radius, spacing).max(8);
            for i in 0..n {
                let angle = TAU * (f64::from(i) + 0.5) / f64::from(n);
                at(direction(1.0, 0.0, angle), TAU * self.radius / f64::from(n));
            }
            return;
        }
        let bands = parts(PI * self.radius, spacing).max(4);
        let latitude = |b: f64| PI * b / f64::from(bands);
        for band in 0..bands {
            let (from, to) = (latitude(f64::from(band)), latitude(f64::from(band) + 1.0));
            let (sine, cosine) = (0.5 * (from + to)).sin_cos();
            let n = parts(TAU * self.radius * sine, spacing).max(3);
            let area = TAU * self.radius * self.radius * (from.cos() - to.cos()) / f64::from(n);
            for i in 0..n {
                at(direction(sine, cosine, TAU * (f64::from(i) + 0.5) / f64::from(n)), area);
            }
        }
    }
}

impl<const D: usize> Shape<D> for Sphere<D> {
    fn near(&self, x: &Vector<D>, reach: f64, out: &mut Vec<Near<D>>) {
        let r = x - self.centre;
        let from_centre = r.norm();
        let distance = self.outward * (from_centre - self.radius);
        if distance < reach {
            // At the centre every direction is as near as another.
            let (normal, curvature) =
                if from_centre > 0.0 { (r / from_centre, 1.0 / from_centre) } else { (unit::<D>(0), 0.0) };
            out.push(Near::round(distance, normal * self.outward, self.outward * curvature, 0));
        }
    }

    fn kind(&self) -> &'static str {
        if D == 2 { "disc" } else { "sphere" }
    }

    fn bounds(&self) -> Bounds<D> {
        if self.outward < 0.0 {
            return Bounds::everything();
        }
        Bounds { from: self.centre, to: self.centre }.grown(self.radius)
    }

    fn samples(&self, spacing: f64, within: &Bounds<D>, out: &mut Vec<Sample<D>>) {
        self.each_piece(spacing, |direction, area| {
            let position = self.centre + direction * self.radius;
            if within.contains(&position) {
                out.push(Sample { position, normal: direction * self.outward, area });
            }
        });
    }

    fn outline(&self, spacing: f64, _within: &Bounds<D>) -> Outline<D> {
        let mut outline = Outline::default();
        let around = parts(TAU * self.radius, spacing).clamp(if D == 2 { 96 } else { 48 }, 256);
        let bands = if D == 2 { 1 } else { around / 2 };
        for band in 0..=bands {
            let latitude = if D == 2 { 0.5 * PI } else { PI * f64::from(band) / f64::from(bands) };
            for i in 0..around {
                let angle = TAU * f64::from(i) / f64::from(around);
                let unit = [latitude.sin() * angle.cos(), latitude.sin() * angle.sin(), latitude.cos()];
                outline.add(self.centre + Vector::from_fn(|d, _| unit[d]) * self.radius);
            }
        }
        for band in 0..bands {
            for i in 0..around {
                let [a, b] = [i, (i + 1) % around].map(|it| band * around + it);
                let mut add = |corners: [u32; 3]| {
                    let mut facet: [u32; D] = std::array::from_fn(|k| corners[k]);
                    if self.outward < 0.0 {
                        facet.swap(0, 1);
                    }
                    outline.facets.push(facet);
                };
                if D == 2 {
                    add([a, b, b]);
                } else {
                    add([a, a + around, b + around]);
                    add([a, b + around, b]);
                }
            }
        }
        if D == 2 {
            outline.vertices.truncate(outline.facets.len());
        }
        outline
    }

    fn thickness(&self) -> f64 {
        if self.outward < 0.0 { f64::INFINITY } else { 2.0 * self.radius }
    }
}

//! Spheres as surfaces: triangles between lines of latitude and longitude, of the spheres' volumes.

use crate::triangles::Triangles;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// A solid sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Its centre `[L]`.
    pub centre: [f64; 3],
    /// Its radius `[L]`.
    pub radius: f64,
}

/// Meridians at least and at most, in fours: every plane through the centre across an axis cuts it in equal halves.
const MERIDIANS: (f64, f64) = (32.0, 1024.0);

impl Ball {
    /// What it encloses `[L³]`.
    pub fn volume(&self) -> f64 {
        4.0 / 3.0 * PI * self.radius.powi(3)
    }

    /// A polyhedron of the same volume whose facets stand off the sphere by about `accuracy` `[L]`.
    pub(crate) fn surface(&self, accuracy: f64) -> Triangles {
        let wanted = PI / (2.0 * accuracy / self.radius).sqrt();
        let meridians = (4.0 * (wanted / 4.0).ceil()).clamp(MERIDIANS.0, MERIDIANS.1) as u32;
        let bands = meridians / 2;
        let at = |band: u32, k: u32| {
            let (sine, cosine) = (PI * f64::from(band) / f64::from(bands)).sin_cos();
            let (sin, cos) = (2.0 * PI * f64::from(k % meridians) / f64::from(meridians)).sin_cos();
            Vector3::new(sine * cos, sine * sin, cosine)
        };
        let mut vertices = vec![Vector3::z()];
        for band in 1..bands {
            vertices.extend((0..meridians).map(|k| at(band, k)));
        }
        vertices.push(-Vector3::z());
        let last = vertices.len() as u32 - 1;
        let number = |band: u32, k: u32| 1 + (band - 1) * meridians + k % meridians;
        let mut facets = Vec::new();
        for k in 0..meridians {
            facets.push([0, number(1, k), number(1, k + 1)]);
            for band in 1..bands - 1 {
                let [a, b, c, d] =
                    [number(band, k), number(band + 1, k), number(band + 1, k + 1), number(band, k + 1)];
                facets.extend([[a, b, c], [a, c, d]]);
            }
            facets.push([last, number(bands - 1, k + 1), number(bands - 1, k)]);
        }
        let unit = Triangles { vertices, facets };
        // The polyhedron stands as much outside of the sphere as inside.
        let scale = self.radius * (4.0 / 3.0 * PI / unit.volume()).cbrt();
        unit.placed(scale, &self.centre)
    }
}

//! Triangles that share their vertices: a surface that nobody has checked yet.

use nalgebra::Vector3;

/// Triangles whose corners run anticlockwise seen from outside.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Triangles {
    /// All different `[L]`.
    pub(crate) vertices: Vec<Vector3<f64>>,
    pub(crate) facets: Vec<[u32; 3]>,
}

impl Triangles {
    /// Corners at equal coordinates become one vertex.
    pub(crate) fn weld(triangles: &[[[f64; 3]; 3]]) -> Self {
        // Zero of either sign is one coordinate.
        let mut corners: Vec<([f64; 3], u32)> =
            triangles.iter().flatten().zip(0..).map(|(x, k)| (x.map(|x| x + 0.0), k)).collect();
        let order = |a: &[f64; 3], b: &[f64; 3]| {
            a.iter()
                .zip(b)
                .map(|(a, b)| a.total_cmp(b))
                .find(|it| it.is_ne())
                .unwrap_or(std::cmp::Ordering::Equal)
        };
        corners.sort_unstable_by(|a, b| order(&a.0, &b.0).then(a.1.cmp(&b.1)));
        let mut surface = Self { vertices: Vec::new(), facets: vec![[0; 3]; triangles.len()] };
        for same in corners.chunk_by(|a, b| a.0 == b.0) {
            let vertex = surface.vertices.len() as u32;
            surface.vertices.push(same[0].0.into());
            for (_, corner) in same {
                surface.facets[*corner as usize / 3][*corner as usize % 3] = vertex;
            }
        }
        surface
    }

    /// Number of facets.
    pub(crate) fn n_facets(&self) -> usize {
        self.facets.len()
    }

    /// Corners of a facet `[L]`.
    pub(crate) fn corners(&self, facet: usize) -> [Vector3<f64>; 3] {
        self.facets[facet].map(|vertex| self.vertices[vertex as usize])
    }

    /// What it encloses, by the divergence theorem `[L³]`.
    pub(crate) fn volume(&self) -> f64 {
        // From a vertex rather than the origin, which may be far away.
        let from = self.vertices[0];
        let cones = (0..self.facets.len()).map(|k| {
            let [a, b, c] = self.corners(k).map(|x| x - from);
            a.dot(&b.cross(&c))
        });
        cones.sum::<f64>() / 6.0
    }

    /// Lowest and highest coordinates `[L]`.
    pub(crate) fn bounds(&self) -> (Vector3<f64>, Vector3<f64>) {
        let first = self.vertices[0];
        self.vertices.iter().fold((first, first), |(low, high), x| (low.inf(x), high.sup(x)))
    }

    /// The surface `scale` times as large about the origin, then moved by `shift` `[L]`; `scale` is positive.
    pub(crate) fn placed(mut self, scale: f64, shift: &[f64; 3]) -> Self {
        let shift = Vector3::from(*shift);
        for x in &mut self.vertices {
            *x = *x * scale + shift;
        }
        self
    }
}

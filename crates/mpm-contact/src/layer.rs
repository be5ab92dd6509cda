//! Figures of revolution in a layer: shapes of the half plane (r, z) whose third coordinate is the angle about the axis.
//!
//! Such a shape is the same at any angle, so that a tool that turns about the axis shifts along the third coordinate.

use crate::bounds::Bounds;
use crate::shape::{Near, Outline, Sample, Shape};
use mpm_grid::{Block, Vector, flattened, raised};

/// A shape of the half plane in its layer.
#[derive(Debug)]
pub struct InLayer(pub Box<dyn Shape<2>>);

fn section(bounds: &Bounds<3>) -> Bounds<2> {
    Bounds { from: flattened(&bounds.from), to: flattened(&bounds.to) }
}

impl Shape<3> for InLayer {
    fn near(&self, x: &Vector<3>, reach: f64, out: &mut Vec<Near<3>>) {
        let mut near = Vec::new();
        self.0.near(&flattened(x), reach, &mut near);
        out.extend(near.iter().map(|near| {
            let mut hessian = Block::<3>::zeros();
            hessian.fixed_view_mut::<2, 2>(0, 0).copy_from(&near.hessian);
            Near { distance: near.distance, normal: raised(&near.normal), hessian, feature: near.feature }
        }));
    }

    fn bounds(&self) -> Bounds<3> {
        let Bounds { from, to } = self.0.bounds();
        Bounds { from: raised(&from), to: raised(&to) }
    }

    fn samples(&self, spacing: f64, within: &Bounds<3>, out: &mut Vec<Sample<3>>) {
        let mut samples = Vec::new();
        self.0.samples(spacing, &section(within), &mut samples);
        out.extend(samples.iter().map(|sample| Sample {
            position: raised(&sample.position),
            normal: raised(&sample.normal),
            area: sample.area,
        }));
    }

    fn outline(&self, _spacing: f64, _within: &Bounds<3>) -> Outline<3> {
        // A section has segments, and no triangles.
        Outline { vertices: Vec::new(), facets: Vec::new() }
    }

    fn thickness(&self) -> f64 {
        self.0.thickness()
    }

    fn kind(&self) -> &'static str {
        self.0.kind()
    }

    fn facet_turn(&self) -> f64 {
        self.0.facet_turn()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Polygon, Sphere};

    #[test]
    fn a_layer_is_asked_in_its_section() {
        let ball = || Sphere::new(Vector::<2>::new(0.0, 1.0), 0.5).unwrap();
        let layer = InLayer(Box::new(ball()));
        let (mut expected, mut found) = (Vec::new(), Vec::new());
        ball().near(&Vector::<2>::new(0.3, 1.6), 1.0, &mut expected);
        layer.near(&Vector::<3>::new(0.3, 1.6, 40.0), 1.0, &mut found);
        assert_eq!((found.len(), found[0].distance), (1, expected[0].distance));
        assert_eq!(found[0].normal, raised(&expected[0].normal));
        assert_eq!(found[0].hessian[(0, 1)], expected[0].hessian[(0, 1)]);
        assert_eq!(found[0].hessian.column(2).norm(), 0.0);
        assert_eq!(layer.thickness(), ball().thickness());
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.0, 2.0]].map(Vector::<2>::from).to_vec();
        let square = InLayer(Box::new(Polygon::new(square, 0.0).unwrap()));
        let mut samples = Vec::new();
        square.samples(0.1, &square.bounds().grown(0.1), &mut samples);
        let length: f64 = samples.iter().map(|sample| sample.area).sum();
        assert!((length - 6.0).abs() < 1e-12 && samples.iter().all(|sample| sample.position[2] == 0.0));
    }
}

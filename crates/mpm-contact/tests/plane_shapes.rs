//! Distances, normals and Hessians of planes, discs, spheres and polygons.

mod common;

use common::{Random, derivatives_hold, near};
use mpm_contact::{Bounds, Plane, Polygon, Sample, Shape, Sphere};
use mpm_grid::Vector;
use std::f64::consts::{PI, TAU};

type Vec2 = Vector<2>;

fn polygon(vertices: &[[f64; 2]], rounding: f64) -> Polygon {
    Polygon::new(vertices.iter().map(|&x| Vec2::from(x)).collect(), rounding).unwrap()
}

/// An L with one concave corner.
const ANGLE: [[f64; 2]; 6] = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];

/// Distance to a segment.
fn to_segment(x: &Vec2, a: &Vec2, b: &Vec2) -> f64 {
    let along = (b - a) * ((x - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
    (x - a - along).norm()
}

/// Even and odd crossings of a ray.
fn is_inside(x: &Vec2, vertices: &[[f64; 2]]) -> bool {
    let n = vertices.len();
    let crossed = |i: &usize| {
        let (a, b) = (vertices[*i], vertices[(i + 1) % n]);
        (a[1] > x[1]) != (b[1] > x[1]) && x[0] < a[0] + (b[0] - a[0]) * (x[1] - a[1]) / (b[1] - a[1])
    };
    (0..n).filter(crossed).count() % 2 == 1
}

#[test]
fn a_sharp_polygon_agrees_with_brute_force() {
    let shape = polygon(&ANGLE, 0.0);
    let mut random = Random(1);
    for _ in 0..4000 {
        let x = Vec2::new(random.between(-2.0, 5.0), random.between(-2.0, 4.0));
        let n = ANGLE.len();
        let distances = (0..n).map(|i| to_segment(&x, &ANGLE[i].into(), &ANGLE[(i + 1) % n].into()));
        let least = distances.fold(f64::INFINITY, f64::min);
        let expected = if is_inside(&x, &ANGLE) { -least } else { least };
        assert!((near(&shape, &x)[0].distance - expected).abs() < 1e-14, "{x:?}");
    }
}

/// The shape shrunk by ρ and grown again, from points on its rounded boundary.
#[test]
fn a_rounded_polygon_agrees_with_its_boundary() {
    let (shape, rounding) = (polygon(&ANGLE, 0.2), 0.2);
    let mut samples: Vec<Sample<2>> = Vec::new();
    shape.samples(1e-3, &Bounds::everything(), &mut samples);
    let length: f64 = samples.iter().map(|it| it.area).sum();
    // Five convex corners lose 2ρ and gain a quarter circle each.
    assert!((length - (10.0 - 5.0 * rounding * (2.0 - 0.5 * PI))).abs() < 1e-12, "{length}");
    for sample in &samples {
        let found = near(&shape, &sample.position)[0];
        assert!(found.distance.abs() < 1e-14 && found.normal.dot(&sample.normal) > 1.0 - 1e-5);
    }
    let mut random = Random(2);
    for _ in 0..500 {
        let x = Vec2::new(random.between(-1.0, 4.0), random.between(-1.0, 3.0));
        let least = samples.iter().map(|it| (it.position - x).norm()).fold(f64::INFINITY, f64::min);
        // Inside the skeleton of the shrunk shape the sign alone is compared.
        let found = near(&shape, &x)[0].distance;
        assert!((found.abs() - least).abs() < 2e-3, "{x:?}: {found} {least}");
    }
}

#[test]
fn derivatives_agree_with_finite_differences() {
    let mut random = Random(3);
    let shapes: [&dyn Shape<2>; 5] = [
        &polygon(&ANGLE, 0.2),
        &polygon(&ANGLE, 0.0),
        &Sphere::new(Vec2::new(1.0, 1.0), 0.8).unwrap(),
        &Sphere::hole(Vec2::new(1.0, 1.0), 2.5).unwrap(),
        &Plane::new(Vec2::new(1.0, 0.0), Vec2::new(-1.0, 2.0)).unwrap(),
    ];
    for shape in shapes {
        let checked =
            (0..500).filter(|_| derivatives_hold(shape, &random.vector(-1.0, 4.0), 1e-5, 1e-8)).count();
        assert!(checked > 450, "{checked}");
    }
    let shapes: [&dyn Shape<3>; 2] = [
        &Sphere::new(Vector::<3>::new(1.0, 1.0, 0.5), 0.8).unwrap(),
        &Plane::new(Vector::<3>::new(1.0, 0.0, 0.0), Vector::<3>::new(-1.0, 2.0, 0.3)).unwrap(),
    ];
    for shape in shapes {
        assert!((0..100).all(|_| derivatives_hold(shape, &random.vector(-1.0, 4.0), 1e-5, 1e-8)));
    }
}

#[test]
fn a_concave_corner_holds_with_both_faces() {
    for rounding in [0.0, 0.1] {
        let shape = polygon(&ANGLE, rounding);
        let mut out = Vec::new();
        shape.near(&Vec2::new(1.05, 1.02), 0.3, &mut out);
        assert_eq!(out.len(), 2);
        assert!((out[0].distance - 0.02).abs() < 1e-15 && (out[0].normal - Vec2::new(0.0, 1.0)).norm() < 1e-15);
        assert!((out[1].distance - 0.05).abs() < 1e-15 && (out[1].normal - Vec2::new(1.0, 0.0)).norm() < 1e-15);
    }
    // An acute notch: a corner inside both faces meets both.
    let notch =
        polygon(&[[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [2.5, 2.0], [2.0, 1.0], [1.5, 2.0], [0.0, 2.0]], 0.1);
    let mut out = Vec::new();
    notch.near(&Vec2::new(2.0, 1.1), 0.3, &mut out);
    assert_eq!(out.len(), 2);
    assert!((out[0].distance - out[1].distance).abs() < 1e-15);
}

#[test]
fn what_lies_behind_another_face_is_not_met() {
    // A U: on the left of its left arm, the inner face of the right arm looks this way.
    let shape = polygon(
        &[[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [2.9, 2.0], [2.9, 0.1], [0.1, 0.1], [0.1, 2.0], [0.0, 2.0]],
        0.02,
    );
    let found = near(&shape, &Vec2::new(-0.01, 1.0));
    assert_eq!(found.len(), 1, "{found:?}");
    assert!((found[0].distance - 0.01).abs() < 1e-15);
    assert_eq!(near(&shape, &Vec2::new(1.5, 1.0)).len(), 3);
    assert!((shape.thickness() - 0.1).abs() < 1e-15);
}

/// The distance and, beyond the concave corner, the force of a penalty are continuous.
#[test]
fn distances_are_continuous_over_corners() {
    let shape = polygon(&ANGLE, 0.2);
    for (at, radius) in [([3.0, 1.0], 0.5), ([0.0, 0.0], 0.4), ([1.0, 2.0], 0.25)] {
        let place = |k: u32| {
            let (sine, cosine) = (TAU * f64::from(k) / 1000.0).sin_cos();
            Vec2::from(at) + Vec2::new(cosine, sine) * radius
        };
        let outside: Vec<bool> = (0..=1000).map(|k| near(&shape, &place(k))[0].distance > -0.15).collect();
        for k in (0..1000).filter(|&k| outside[k] && outside[k + 1]) {
            let k = u32::try_from(k).unwrap();
            let (a, b) = (near(&shape, &place(k))[0], near(&shape, &place(k + 1))[0]);
            assert!((a.distance - b.distance).abs() < 4e-3 && (a.normal - b.normal).norm() < 0.05, "{k}");
        }
    }
}

#[test]
fn surfaces_have_their_areas() {
    let mut samples = Vec::new();
    Sphere::new(Vector::<3>::zeros(), 2.0).unwrap().samples(0.3, &Bounds::everything(), &mut samples);
    let area: f64 = samples.iter().map(|it| it.area).sum();
    assert!((area - 16.0 * PI).abs() < 1e-12);
    assert!(samples.iter().all(|it| it.area <= 0.3 * 0.3));
    let mut samples = Vec::new();
    let box_of = Bounds { from: Vector::<3>::new(0.0, 0.0, -1.0), to: Vector::<3>::new(2.0, 3.0, 1.0) };
    let plane = Plane::new(Vector::<3>::zeros(), Vector::<3>::new(0.0, 0.0, 2.0)).unwrap();
    plane.samples(0.25, &box_of, &mut samples);
    assert!((samples.iter().map(|it| it.area).sum::<f64>() - 6.0).abs() < 1e-12);
    assert_eq!(plane.bounds().to[2], 0.0);
}

#[test]
fn outlines_face_outwards() {
    let within = Bounds { from: Vec2::repeat(-3.0), to: Vec2::repeat(5.0) };
    let shapes: [&dyn Shape<2>; 4] = [
        &polygon(&ANGLE, 0.2),
        &Sphere::new(Vec2::new(1.0, 1.0), 0.8).unwrap(),
        &Sphere::hole(Vec2::new(1.0, 1.0), 2.5).unwrap(),
        &Plane::new(Vec2::new(1.0, 0.0), Vec2::new(-1.0, 2.0)).unwrap(),
    ];
    for shape in shapes {
        let outline = shape.outline(0.05, &within);
        assert!(!outline.facets.is_empty());
        for facet in &outline.facets {
            let [a, b] = facet.map(|k| outline.vertices[usize::try_from(k).unwrap()]);
            let found = near(shape, &((a + b) * 0.5))[0];
            assert!(found.distance.abs() < 0.01 && (b - a).perp(&found.normal) < 0.0, "{shape:?} {a:?} {b:?}");
        }
    }
    let sphere = Sphere::new(Vector::<3>::zeros(), 2.0).unwrap();
    let within = Bounds { from: Vector::<3>::repeat(-3.0), to: Vector::<3>::repeat(5.0) };
    let plane = Plane::new(Vector::<3>::zeros(), Vector::<3>::new(0.3, -0.2, 2.0)).unwrap();
    for shape in [&sphere as &dyn Shape<3>, &plane] {
        let outline = shape.outline(0.2, &within);
        for facet in &outline.facets {
            let [a, b, c] = facet.map(|k| outline.vertices[usize::try_from(k).unwrap()]);
            let found = near(shape, &((a + b + c) / 3.0))[0];
            assert!(found.distance.abs() < 0.02 && (b - a).cross(&(c - a)).dot(&found.normal) >= -1e-12);
        }
    }
}

#[test]
fn bad_shapes_are_refused() {
    let refused = |vertices: &[[f64; 2]], rounding: f64| {
        Polygon::new(vertices.iter().map(|&x| Vec2::from(x)).collect(), rounding).unwrap_err().name
    };
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    assert_eq!(refused(&square[..2], 0.0), "number of vertices");
    assert_eq!(refused(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]], 0.0), "vertex");
    assert_eq!(refused(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], 0.0), "vertex");
    assert_eq!(refused(&[[0.0, 0.0], [1.0, f64::NAN], [1.0, 0.0]], 0.0), "vertices");
    assert_eq!(refused(&square, 0.5), "rounding");
    assert_eq!(refused(&square, -0.1), "rounding");
    assert_eq!(refused(&ANGLE, 0.6), "rounding");
    assert!(Polygon::new(square.iter().rev().map(|&x| Vec2::from(x)).collect(), 0.4).is_ok());
    for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(Sphere::new(Vec2::zeros(), radius).unwrap_err().name, "radius");
    }
    assert_eq!(Plane::new(Vec2::zeros(), Vec2::zeros()).unwrap_err().name, "normal");
}

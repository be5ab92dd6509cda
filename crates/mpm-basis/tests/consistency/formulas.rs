//! Published closed forms, relations between bases, and gradients against differences.

use crate::completeness::{corner_weights, influences};
use crate::random::{Random, cases};
use mpm_basis::{
    Basis, Cpdi1, Cpdi2Hexahedron, Cpdi2q, Cpdi2t, Domain, Gimp, HalfLengths, Hexahedron, Influence,
    Parallelepiped, Quadrilateral, Simplex, Smpm,
};
use mpm_grid::{Axis, Block, Layout, Mesh, Vector};
use std::array::from_fn;

/// 1-D GIMP function on cells of size h (Charlton, Coombs & Augarde 2017), for l <= h/2.
fn published(r: f64, l: f64, h: f64) -> f64 {
    match r.abs() {
        r if r < l => 1.0 - (r * r + l * l) / (2.0 * h * l),
        r if r < h - l => 1.0 - r / h,
        r if r < h + l => (h + l - r).powi(2) / (4.0 * h * l),
        _ => 0.0,
    }
}

#[test]
fn gimp_is_the_published_function() {
    let mut random = Random::new(4);
    let h = 0.5;
    let axis = Axis::uniform(0.0, 4.0, 8).unwrap();
    let mesh = Mesh::at_rest(&Layout::<2>::on_axes([axis.clone(), axis]).unwrap());
    for _ in 0..2000 {
        let x = Vector::<2>::new(2.0, 2.0) + random.vector(1.0);
        let mut domain = HalfLengths::at_rest(Vector::<2>::new(1.0, 1.0));
        domain.current = Vector::<2>::from_fn(|_, _| h * random.between(0.01, 0.5));
        let mut total = 0.0;
        for Influence { node, value, .. } in influences(&Gimp::default(), &mesh, &x, &domain).unwrap() {
            let r = x - mesh.position(node);
            let expected = published(r.x, domain.current.x, h) * published(r.y, domain.current.y, h);
            assert!((value - expected).abs() < 1e-14, "{value} {expected}");
            total += expected;
        }
        assert!((total - 1.0).abs() < 1e-13, "no node is missing");
    }
}

/// Largest difference of `∇S` and central differences of S, relative to the largest `∇S`.
fn gradient_error<const D: usize, B: Basis<D>>(
    basis: &B,
    mesh: &Mesh<D>,
    x: Vector<D>,
    domain: &B::Domain,
) -> f64 {
    let entries = influences(basis, mesh, &x, domain).unwrap();
    let largest = entries.iter().map(|it| it.gradient.amax()).fold(0.0, f64::max);
    let step = 1e-6;
    let mut error = 0.0_f64;
    for d in 0..D {
        let mut moved = [x, x];
        moved[0][d] += step;
        moved[1][d] -= step;
        let [above, below] = moved.map(|x| influences(basis, mesh, &x, domain).unwrap());
        let value = |entries: &[Influence<D>], node| {
            entries.iter().find(|it| it.node == node).map_or(0.0, |it| it.value)
        };
        for entry in &entries {
            let slope = (value(&above, entry.node) - value(&below, entry.node)) / (2.0 * step);
            error = error.max((slope - entry.gradient[d]).abs());
        }
    }
    error / largest
}

fn check_gradients<const D: usize>(random: &mut Random) {
    let case = cases::<D>(random).swap_remove(0);
    let error = gradient_error(&Smpm, &case.mesh, case.x, &());
    assert!(error < 1e-8, "sMPM: {error:e}");
    let mut domain = HalfLengths::at_rest(Vector::repeat(1.0));
    domain.current = Vector::from_fn(|_, _| case.h * random.between(0.2, 1.4));
    let error = gradient_error(&Gimp::default(), &case.mesh, case.x, &domain);
    assert!(error < 1e-5, "GIMP: {error:e}");
}

#[test]
fn gradients_are_the_slopes_of_values() {
    let mut random = Random::new(5);
    for _ in 0..100 {
        check_gradients::<2>(&mut random);
        check_gradients::<3>(&mut random);
    }
}

fn same<const D: usize>(name: &str, one: &[Influence<D>], two: &[Influence<D>]) {
    assert_eq!(one.len(), two.len(), "{name}");
    let largest = one.iter().map(|it| it.gradient.norm()).fold(0.0, f64::max);
    for (a, b) in one.iter().zip(two) {
        assert_eq!(a.node, b.node, "{name}");
        assert!((a.value - b.value).abs() < 1e-13, "{name}: {a:?} {b:?}");
        assert!((a.gradient - b.gradient).norm() < 1e-12 * largest, "{name}: {a:?} {b:?}");
    }
}

fn corner<const D: usize>(x: &Vector<D>, r: &Block<D>, c: usize) -> Vector<D> {
    x + r * Vector::from_fn(|d, _| if c >> d & 1 == 1 { 1.0 } else { -1.0 })
}

#[test]
fn convected_domains_that_are_parallelepipeds_are_cpdi1() {
    let mut random = Random::new(6);
    for _ in 0..100 {
        for case in cases::<2>(&mut random) {
            let r = case.parallelepiped(&mut random).current;
            let one = influences(&Cpdi1, &case.mesh, &case.x, &Parallelepiped::at_rest(r)).unwrap();
            let quad = Quadrilateral::at_rest(from_fn(|c| corner(&case.x, &r, c)));
            assert!(quad.distortion() < 1e-11);
            same(case.name, &one, &influences(&Cpdi2q::default(), &case.mesh, &case.x, &quad).unwrap());

            // The mean of the gradients over both triangles of a parallelogram is its gradient.
            let [a, b, c, d] = quad.corners;
            let mut mean: Vec<Influence<2>> = Vec::new();
            for others in [[b, d], [d, c]] {
                let triangle = Simplex::at_rest(a, others);
                for entry in influences(&Cpdi2t::default(), &case.mesh, &case.x, &triangle).unwrap() {
                    let gradient = entry.gradient * 0.5;
                    match mean.iter_mut().find(|it| it.node == entry.node) {
                        Some(it) => it.gradient += gradient,
                        None => mean.push(Influence { gradient, ..entry }),
                    }
                }
            }
            for entry in &one {
                let found = mean.iter().find(|it| it.node == entry.node).expect("the same nodes");
                let error = (found.gradient - entry.gradient).norm();
                assert!(error < 1e-12 * (1.0 + entry.gradient.norm()) / r.norm(), "{}: {error:e}", case.name);
            }
        }
        for case in cases::<3>(&mut random) {
            let r = case.parallelepiped(&mut random).current;
            let one = influences(&Cpdi1, &case.mesh, &case.x, &Parallelepiped::at_rest(r)).unwrap();
            let hexahedron = Hexahedron::at_rest(from_fn(|c| corner(&case.x, &r, c)));
            assert!(hexahedron.distortion() < 1e-11);
            same(case.name, &one, &influences(&Cpdi2Hexahedron, &case.mesh, &case.x, &hexahedron).unwrap());
        }
    }
}

/// On a mesh of one cell the four S are the bilinear moments of the corners under their weights.
#[test]
fn quadrilateral_weights_agree_with_quadrature() {
    let mut random = Random::new(7);
    let axis = Axis::uniform(-4.0, 4.0, 1).unwrap();
    let mesh = Mesh::at_rest(&Layout::<2>::on_axes([axis.clone(), axis]).unwrap());
    let mut negative = 0;
    for _ in 0..500 {
        let corners = from_fn(|c| corner(&Vector::<2>::zeros(), &Block::identity(), c) + random.vector(2.0));
        let quad = Quadrilateral::at_rest(corners);
        if quad.area().abs() < 0.3 {
            continue;
        }
        let weights = corner_weights(&corners);
        // x, y and xy of the corners, read through S of the four nodes.
        let mut moments = [0.0; 3];
        for entry in influences(&Cpdi2q::default(), &mesh, &Vector::<2>::zeros(), &quad).unwrap() {
            let at = mesh.position(entry.node);
            for (moment, value) in moments.iter_mut().zip([at.x, at.y, at.x * at.y]) {
                *moment += entry.value * value;
            }
        }
        for (k, moment) in moments.into_iter().enumerate() {
            let expected: f64 = corners.iter().zip(weights).map(|(x, w)| w * [x.x, x.y, x.x * x.y][k]).sum();
            assert!((moment - expected).abs() < 1e-12, "{moment} {expected}");
        }
        let smallest = weights.into_iter().fold(f64::INFINITY, f64::min);
        let report = Cpdi2q::default().diagnose(&mesh, &Vector::<2>::zeros(), &quad).unwrap();
        assert!((report.smallest_weight - smallest).abs() < 1e-13);
        negative += usize::from(smallest < 0.0);
        // Convex exactly where no corner's Jacobian has lost its sign.
        let cell = mpm_grid::LinearCell::new(from_fn(|c| corners[c % 4]));
        assert_eq!(report.distortion < 1.0, cell.is_valid(quad.area().signum()), "{corners:?}");
    }
    assert!(negative > 5, "distorted enough to have negative weights");
}

#[test]
fn reports_count_single_corners() {
    let axis = Axis::uniform(0.0, 3.0, 3).unwrap();
    let mesh = Mesh::at_rest(&Layout::<2>::on_axes([axis.clone(), axis]).unwrap());
    let at = |x, y| Vector::<2>::new(x, y);
    // Two corners in the first cell, one in the next: nodes at x = 2 see that one only.
    let sliver = Simplex::at_rest(at(0.5, 0.5), [at(1.5, 0.5), at(0.5, 0.501)]);
    let report = Cpdi2t::default().diagnose(&mesh, &at(0.8, 0.5), &sliver).unwrap();
    assert_eq!((report.single_corner_nodes, report.corners_outside), (2, 0));
    assert_eq!(report.measure, 1.0);
    assert!((report.distortion - 0.001_f64.sqrt() * 1000.0 * (1.0 + 1e-6_f64).sqrt()).abs() < 1e-8);
    let half_square = Simplex::at_rest(at(0.5, 0.5), [at(1.5, 0.5), at(0.5, 1.5)]);
    assert!((half_square.distortion() - 2.0_f64.sqrt()).abs() < 1e-14);
}

#[test]
fn outlines_go_round() {
    let square = |x: &Vector<2>| Parallelepiped::at_rest(Block::<2>::identity() * x.x);
    let at = |x, y| Vector::<2>::new(x, y);
    let expected = [at(0.0, 1.0), at(2.0, 1.0), at(2.0, 3.0), at(0.0, 3.0)];
    assert_eq!(square(&at(1.0, 2.0)).outline(&at(1.0, 2.0)), expected);
    let domain = HalfLengths::at_rest(at(1.0, 1.0));
    assert_eq!(domain.outline(&at(1.0, 2.0)), expected);
    let quad = Quadrilateral::at_rest([expected[0], expected[1], expected[3], expected[2]]);
    assert_eq!(quad.outline(&at(1.0, 2.0)), expected);
    assert!(Domain::<2>::outline(&(), &at(1.0, 2.0)).is_empty());
}

//! The linear cell on randomly distorted quadrilaterals and hexahedra.

use mpm_grid::{Axis, Block, Layout, LinearCell, Mesh, Span, Vector};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use std::array::from_fn;

/// A unit cell far from the origin, mapped affinely, its corners moved by `noise` of an edge.
fn distorted<const D: usize>(noise: &[f64], affine: &[f64]) -> LinearCell<D> {
    let a = Block::<D>::from_fn(|i, j| f64::from(u8::from(i == j)) + 0.3 * affine[i * D + j]);
    LinearCell::new(from_fn(|c| {
        let unit = Vector::from_fn(|d, _| f64::from(u8::from(c >> d & 1 == 1)));
        let offset = Vector::from_fn(|d, _| noise[c * D + d]);
        a * (unit + offset) + Vector::from_element(5.0)
    }))
}

fn vector<const D: usize>(numbers: &[f64]) -> Vector<D> {
    Vector::from_fn(|d, _| numbers[d])
}

fn check<const D: usize>(cell: &LinearCell<D>, local: &Vector<D>) {
    let x = cell.position(local);
    let n = LinearCell::values(local);
    let g = cell.gradients(local);
    let corners = || cell.corners().iter().take(1 << D);

    assert!((n.iter().sum::<f64>() - 1.0).abs() < 1e-14, "partition of unity");
    let sum = g.iter().fold(Vector::zeros(), |s: Vector<D>, g| s + g);
    assert!(sum.norm() < 1e-12, "Σ∇N = {sum}");
    let linear = corners().zip(g).fold(Block::zeros(), |s: Block<D>, (x, g)| s + x * g.transpose());
    assert!((linear - Block::identity()).norm() < 1e-11, "Σ x ⊗ ∇N = {linear}");

    let found = cell.local(&x).expect("a valid cell has an inverse map");
    assert!((found - local).norm() < 1e-11, "{found} instead of {local}");

    for d in 0..D {
        let mut step = Vector::<D>::zeros();
        step[d] = 1e-5;
        let [up, down] = [x + step, x - step].map(|x| LinearCell::values(&cell.local(&x).unwrap()));
        for c in 0..1 << D {
            let difference = (up[c] - down[c]) / 2e-5;
            assert!((difference - g[c][d]).abs() < 1e-7, "∂N_{c}/∂x_{d}: {difference}, {}", g[c][d]);
        }
    }
}

/// The same cases in every run, and no files written on failure.
fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Default::default() }
}

proptest! {
    #![proptest_config(cases(256))]
    #[test]
    fn quadrilaterals(
        noise in prop::collection::vec(-0.2..0.2, 24),
        affine in prop::collection::vec(-1.0..1.0, 4),
        local in prop::collection::vec(-1.2..1.2, 2),
    ) {
        let cell = distorted::<2>(&noise, &affine);
        prop_assume!(cell.is_valid(1.0) && cell.determinant(&vector(&local)) > 0.02);
        check(&cell, &vector(&local));
    }

    #[test]
    fn hexahedra(
        noise in prop::collection::vec(-0.1..0.1, 24),
        affine in prop::collection::vec(-1.0..1.0, 9),
        local in prop::collection::vec(-1.1..1.1, 3),
    ) {
        let cell = distorted::<3>(&noise, &affine);
        prop_assume!(cell.is_valid(1.0) && cell.determinant(&vector(&local)) > 0.02);
        check(&cell, &vector(&local));
    }

    #[test]
    fn pieces_fill_their_cell(
        noise in prop::collection::vec(-0.1..0.1, 24),
        cut in prop::collection::vec(-0.9..0.9, 3),
    ) {
        pieces_sum::<2>(&distorted(&noise, &[0.0; 4]), &vector(&cut));
        pieces_sum::<3>(&distorted(&noise, &[0.0; 9]), &vector(&cut));
    }
}

fn pieces_sum<const D: usize>(cell: &LinearCell<D>, cut: &Vector<D>) {
    let mut volume = 0.0;
    for c in 0..1 << D {
        let upper = |d: usize| c >> d & 1 == 1;
        let from = Vector::from_fn(|d, _| if upper(d) { cut[d] } else { -1.0 });
        let to = Vector::from_fn(|d, _| if upper(d) { 1.0 } else { cut[d] });
        let piece = cell.piece(&from, &to);
        let middle = (from + to) * 0.5;
        let through = piece.position(&Vector::zeros()) - cell.position(&middle);
        assert!(through.norm() < 1e-14, "a piece is the same map");
        volume += piece.volume();
    }
    assert!((volume - cell.volume()).abs() < 1e-13, "{volume} of {}", cell.volume());
}

#[test]
fn volumes_are_exact() {
    let plane = |x, y| Vector::<2>::new(x, y);
    let mut corners = [Vector::zeros(); 8];
    corners[..4].copy_from_slice(&[plane(0.0, 0.0), plane(3.0, 0.0), plane(0.0, 1.0), plane(2.0, 2.0)]);
    // Shoelace: ½ |3·2 - 2·0 + 2·1 - 0·2| with corners in turn (0,0) (3,0) (2,2) (0,1).
    assert!((LinearCell::new(corners).volume() - 4.0).abs() < 1e-15);
    corners.swap(0, 1);
    corners.swap(2, 3);
    assert!((LinearCell::new(corners).volume() - 4.0).abs() < 1e-15, "either hand");

    // A frustum: square base 2×2, top 1×1, height 3.
    let frustum = LinearCell::<3>::new(from_fn(|c| {
        let half = if c >> 2 == 0 { 1.0 } else { 0.5 };
        let side = |d: usize| if c >> d & 1 == 0 { -half } else { half };
        Vector::<3>::new(side(0), side(1), if c >> 2 == 0 { 0.0 } else { 3.0 })
    }));
    assert!((frustum.volume() - 7.0).abs() < 1e-14);
}

#[test]
fn special_shapes_are_inverted() {
    let shapes: [[(f64, f64); 4]; 4] = [
        // rectangle, strong shear, trapezium (one pair of sides parallel), nearly a triangle
        [(0.0, 0.0), (2.0, 0.0), (0.0, 1.0), (2.0, 1.0)],
        [(0.0, 0.0), (1.0, 0.0), (40.0, 1.0), (41.0, 1.0)],
        [(-1.0, 0.0), (1.0, 0.0), (-3.0, 1.0), (3.0, 1.0)],
        [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.51, 0.51)],
    ];
    for shape in shapes {
        let cell = LinearCell::<2>::new(from_fn(|c| {
            shape.get(c).map_or(Vector::zeros(), |&(x, y)| Vector::<2>::new(x, y))
        }));
        for i in 0..=8 {
            for j in 0..=8 {
                let local = Vector::<2>::new(f64::from(i) / 4.0 - 1.0, f64::from(j) / 4.0 - 1.0);
                let found = cell.local(&cell.position(&local)).unwrap();
                assert!((found - local).norm() < 1e-11, "{shape:?}: {found} instead of {local}");
            }
        }
    }
}

#[test]
fn beyond_a_fold_there_is_no_local_coordinate() {
    // The sides of this trapezium meet at (0, -½): nothing is mapped below, on this branch.
    let shape = [(-1.0, 0.0), (1.0, 0.0), (-3.0, 1.0), (2.0, 1.5)];
    let cell = LinearCell::<2>::new(from_fn(|c| {
        shape.get(c).map_or(Vector::zeros(), |&(x, y)| Vector::<2>::new(x, y))
    }));
    let found: Vec<_> = (0..40).map(|i| cell.local(&Vector::<2>::new(0.3, -0.25 * f64::from(i)))).collect();
    assert!(found.iter().any(Option::is_none));
    for (i, local) in found.into_iter().enumerate() {
        if let Some(local) = local {
            let y = cell.position(&local)[1] + 0.25 * i as f64;
            assert!(y.abs() < 1e-9 && cell.determinant(&local) > -1e-9);
        }
    }
}

#[test]
fn the_diagonal_is_that_of_the_box_around_the_mesh() {
    let axes = [Axis::uniform(-1.0, 2.0, 3).unwrap(), Axis::uniform(0.0, 4.0, 2).unwrap()];
    assert_eq!(Mesh::at_rest(&Layout::on_axes(axes).unwrap()).diagonal(), 5.0);
    let radii = Axis::uniform(1.0, 2.0, 2).unwrap();
    let ring = Layout::<2>::ring([7.0, 1.0], radii, 16, Span::Full, None).unwrap();
    assert!((Mesh::at_rest(&ring).diagonal() - 4.0 * 2.0_f64.sqrt()).abs() < 1e-12);
}

//! Domains that stand for rings: weights against tables and the edges of domains, completeness of what is weighted by r.

use crate::completeness::corner_weights;
use crate::random::{Random, cases};
use mpm_basis::{
    Basis, Corner, CornerPoint, Cpdi1, Cpdi2q, Cpdi2t, Fallback, FallbackDomain, Gimp, HalfLengths, Influence,
    Quadrilateral, Smpm, Stencil, Stencils,
};
use mpm_grid::{Axis, Block, Layout, Mesh, Vector};
use std::f64::consts::TAU;

fn rows(table: &str) -> Vec<Vec<f64>> {
    let lines = table.lines().filter(|line| !line.starts_with('#')).skip(1);
    lines.map(|line| line.split(',').map(|it| it.parse().unwrap()).collect()).collect()
}

/// Lexicographic from anticlockwise, and back.
const ROUND: [usize; 4] = [0, 1, 3, 2];

fn corners<B: Basis<2>>(
    basis: &B,
    mesh: &Mesh<2>,
    x: Vector<2>,
    area: f64,
    domain: &B::Domain,
) -> Vec<Corner<2>> {
    let volume = TAU * x[0] * area;
    let (reference_size, deformation_gradient) = (area, Block::identity());
    let point = CornerPoint { position: x, reference_size, volume, is_ring: true, deformation_gradient };
    let mut corners = Vec::new();
    basis.corners(mesh, &point, domain, &mut corners).unwrap();
    corners
}

#[test]
fn corner_weights_are_those_of_the_table() {
    let axis = |from: f64, to: f64| Axis::uniform(from, to, 4).unwrap();
    let mesh = Mesh::at_rest(&Layout::<2>::on_axes([axis(-4.0, 12.0), axis(-4.0, 4.0)]).unwrap());
    for domain in rows(include_str!("../tables/ring_quadrilateral.csv")).chunks(4) {
        let position = |c: usize| Vector::<2>::new(domain[ROUND[c]][2], domain[ROUND[c]][3]);
        let quadrilateral = Quadrilateral::at_rest(std::array::from_fn(position));
        let (radius, volume) = (domain[0][10], domain[0][11]);
        let weigh = |c: usize| domain[ROUND[c]][4];
        let x = (0..4).map(|c| position(c) * weigh(c)).sum::<Vector<2>>();
        assert!((x[0] / radius - 1.0).abs() < 1e-14);
        assert!((TAU * radius * quadrilateral.area() / volume - 1.0).abs() < 1e-13);
        let made = corners(&Cpdi2q::default(), &mesh, x, quadrilateral.area(), &quadrilateral);
        for (c, corner) in made.iter().enumerate() {
            let row = &domain[ROUND[c]];
            let mut expected = Vector::<2>::new(row[8], row[9]) * volume;
            expected[0] += row[4] * volume / radius;
            assert!((corner.area - expected).norm() < 3e-14 * expected.norm().max(volume), "{row:?}");
            assert!((corner.share - row[7]).abs() < 1e-14, "{row:?}");
        }
    }
}

/// Sums over z of a ring's influences by node along r: S, mean weighted by r, slope weighted by r.
#[test]
fn radial_factors_of_gimp_are_those_of_the_table() {
    let lines = [0.0, 0.25, 0.5, 0.8, 1.1, 1.6, 2.0];
    let axes = [Axis::graded(lines.to_vec()).unwrap(), Axis::uniform(0.0, 1.0, 3).unwrap()];
    let mesh = Mesh::at_rest(&Layout::<2>::on_axes(axes).unwrap());
    for point in rows(include_str!("../tables/ring_gimp.csv")).chunk_by(|a, b| a[0] == b[0]) {
        let x = Vector::<2>::new(point[0][1], 0.4);
        let mut domain = HalfLengths::at_rest(Vector::<2>::new(point[0][2], 0.2));
        domain.current = domain.initial;
        let (mut plain, mut masses) = (Stencil::new(), Stencil::new());
        Gimp::default().ring_influences(&mesh, &x, &domain, &mut plain).unwrap();
        Gimp::default().ring_masses(&mesh, &x, &domain, &mut masses).unwrap();
        let sum = |entries: &[Influence<2>], r: f64, of: &dyn Fn(&Influence<2>) -> f64| {
            let at = entries.iter().filter(|it| mesh.position(it.node)[0] == r);
            at.map(of).sum::<f64>()
        };
        for row in point {
            let found = [
                sum(plain.entries(), row[4], &|it| it.value),
                sum(masses.entries(), row[4], &|it| it.value),
                sum(plain.entries(), row[4], &|it| it.gradient[0]),
            ];
            for (found, expected) in found.iter().zip(&row[5..]) {
                assert!((found - expected).abs() < 1e-14 * expected.abs().max(1.0), "{row:?}: {found}");
            }
        }
        assert!((plain.entries().iter().map(|it| it.value).sum::<f64>() - 1.0).abs() < 1e-14);
    }
}

fn check<B: Basis<2>>(name: &str, basis: &B, mesh: &Mesh<2>, x: Vector<2>, domain: &B::Domain) {
    let (mut ring, mut masses) = (Stencil::new(), Stencil::new());
    basis.ring_influences(mesh, &x, domain, &mut ring).unwrap();
    basis.ring_masses(mesh, &x, domain, &mut masses).unwrap();
    let [ring, masses] = [&mut ring, &mut masses].map(|it| {
        it.finish();
        it.entries()
    });
    let size = ring.iter().map(|it| it.gradient.norm()).sum::<f64>();
    let unity = [ring, masses].map(|it| it.iter().map(|it| it.value).sum::<f64>() - 1.0);
    let none = ring.iter().map(|it| it.gradient).sum::<Vector<2>>() / size;
    let one = ring.iter().map(|it| mesh.position(it.node) * it.gradient.transpose()).sum::<Block<2>>();
    let here = ring.iter().map(|it| mesh.position(it.node) * it.value).sum::<Vector<2>>();
    assert!(unity.iter().all(|it| it.abs() < 1e-13), "{name}: {unity:?}");
    assert!(none.norm() < 1e-12, "{name}: {none}");
    assert!((one - Block::identity()).norm() < 1e-11 * size.max(1.0), "{name}: {one}");
    assert!((here - x).norm() < 1e-12 * x.norm(), "{name}: {here}");
    for it in masses {
        assert!(ring.binary_search_by_key(&it.node, |entry| entry.node).is_ok(), "{name}: a node of its own");
    }
}

/// Parts of the surface at the corners of a polygon, `2π Σ n_e (r_c/3 + r_c'/6)` over the two edges at each.
fn edges(round: &[Vector<2>]) -> Vec<Vector<2>> {
    let n = round.len();
    let twice: f64 = (0..n).map(|k| round[k].perp(&round[(k + 1) % n])).sum();
    let hand = twice.signum();
    let mut parts = vec![Vector::<2>::zeros(); n];
    for k in 0..n {
        let (a, b) = (round[k], round[(k + 1) % n]);
        let normal = Vector::<2>::new(b.y - a.y, a.x - b.x) * (hand * TAU);
        parts[k] += normal * (a.x / 3.0 + b.x / 6.0);
        parts[(k + 1) % n] += normal * (b.x / 3.0 + a.x / 6.0);
    }
    parts
}

fn agree(name: &str, made: &[Corner<2>], round: &[usize]) {
    let outline: Vec<Vector<2>> = round.iter().map(|&c| made[c].position).collect();
    let expected = edges(&outline);
    let size = expected.iter().map(|it| it.norm()).sum::<f64>();
    for (&c, expected) in round.iter().zip(expected) {
        assert!((made[c].area - expected).norm() < 1e-12 * size, "{name}, corner {c}");
    }
    assert!((made.iter().map(|it| it.share).sum::<f64>() - 1.0).abs() < 1e-13, "{name}");
}

#[test]
fn rings_are_complete_and_their_corners_have_the_edges_that_meet_there() {
    let mut random = Random::new(17);
    for _ in 0..100 {
        for case in cases::<2>(&mut random) {
            let (mesh, name) = (&case.mesh, case.name);
            check(name, &Smpm, mesh, case.x, &());
            let domain = case.parallelepiped(&mut random);
            check(name, &Cpdi1, mesh, case.x, &domain);
            let fallen = FallbackDomain::Fallen(domain);
            check(name, &Fallback { basis: Smpm, beyond: 0.0 }, mesh, case.x, &fallen);
            let area = 4.0 * domain.current.determinant().abs();
            agree(name, &corners(&Cpdi1, mesh, case.x, area, &domain), &ROUND);
            agree(name, &corners(&Smpm, mesh, case.x, 0.01 * area, &()), &ROUND);
            if Basis::<2>::suits(&Gimp::default(), mesh).is_ok() {
                let mut domain = HalfLengths::at_rest(Vector::repeat(1.0));
                domain.current = Vector::from_fn(|_, _| case.h * random.between(0.1, 1.6));
                check(name, &Gimp::default(), mesh, case.x, &domain);
                let area = 4.0 * domain.current.product();
                agree(name, &corners(&Gimp::default(), mesh, case.x, area, &domain), &ROUND);
            }
            let quadrilateral = case.quadrilateral(&mut random);
            let weights = corner_weights(&quadrilateral.corners);
            let x = (0..4).map(|c| quadrilateral.corners[c] * weights[c]).sum();
            let area = quadrilateral.area();
            check(name, &Cpdi2q::default(), mesh, x, &quadrilateral);
            agree(name, &corners(&Cpdi2q::default(), mesh, x, area.abs(), &quadrilateral), &ROUND);
            let triangle = case.simplex(&mut random);
            let x = (triangle.first + triangle.others[0] + triangle.others[1]) / 3.0;
            check(name, &Cpdi2t::default(), mesh, x, &triangle);
            let area = triangle.volume().abs();
            agree(name, &corners(&Cpdi2t::default(), mesh, x, area, &triangle), &[0, 1, 2]);
        }
    }
}

#[test]
fn masses_are_kept_where_they_are_wanted() {
    let axes = [Axis::uniform(0.0, 1.0, 4).unwrap(), Axis::uniform(0.0, 1.0, 4).unwrap()];
    let mesh = Mesh::at_rest(&Layout::<2>::on_axes(axes).unwrap());
    let x = [Vector::<2>::new(0.2, 0.4), Vector::<2>::new(0.6, 0.6)];
    let domains = [HalfLengths::at_rest(Vector::<2>::new(0.1, 0.1)); 2];
    let sums = [true, false].map(|with_masses| {
        let stencils = Stencils::of_rings(&Gimp::default(), &mesh, (&x, &domains), with_masses).unwrap();
        let space = mpm_grid::NodeSpace::vertices(mesh.lattice().clone());
        let active = mpm_basis::ActiveNodes::of(&space, std::slice::from_ref(&stencils));
        let connectivity = mpm_basis::Connectivity::of(stencils, &active);
        let groups = (0..connectivity.n_groups()).map(|group| connectivity.group(group));
        groups.map(|it| it.masses.iter().zip(it.values).map(|(a, b)| (a - b).abs()).sum::<f64>()).sum::<f64>()
    });
    assert!(sums[0] > 0.1 && sums[1] == 0.0, "{sums:?}");
}

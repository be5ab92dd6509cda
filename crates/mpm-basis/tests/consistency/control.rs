//! Domains that have outgrown their cells: shortened, reshaped and split ones are domains like any.

use crate::completeness::check;
use crate::random::Random;
use mpm_basis::domain_control::{cap, is_too_long, reshape, size, split};
use mpm_basis::{
    Basis, CornerWeights, Cpdi1, Cpdi2Hexahedron, Cpdi2Tetrahedron, Cpdi2q, Cpdi2t, Domain, Fallback, Gimp,
    Parallelepiped, Seed, Smpm,
};
use mpm_grid::{Axis, Block, Layout, LinearCell, Mesh, Span, Vector};
use nalgebra::DMatrix;
use std::array::from_fn;

/// Most cells of a semi-axis.
const CELLS: f64 = 0.8;

/// A piece of about half a cell in the middle of the mesh, sheared to several cells' length.
fn needle<const D: usize>(centre: &Vector<D>, random: &mut Random) -> LinearCell<D> {
    let corners = from_fn(|c| {
        let mut x = Vector::<D>::from_fn(|d, _| if c >> d & 1 == 1 { 0.25 } else { -0.25 });
        x += random.vector(0.04);
        x[0] += random.between(5.9, 6.1) * x[1];
        x + centre
    });
    LinearCell::new(corners)
}

fn seeds<const D: usize, B: Basis<D>>(basis: &B, piece: &LinearCell<D>) -> Vec<Seed<D, B::Domain>> {
    let mut seeds = Vec::new();
    basis.seed(piece, &mut |seed| seeds.push(seed));
    seeds
}

fn shortened<const D: usize, B: Basis<D>>(name: &str, basis: &B, mesh: &Mesh<D>, piece: &LinearCell<D>) {
    for seed in seeds(basis, piece) {
        let x = seed.position;
        let volume = |domain: &B::Domain| {
            let spread = domain.spread().unwrap();
            DMatrix::from_fn(D, D, |i, j| spread[(i, j)]).determinant().sqrt()
        };
        let before = volume(&seed.domain);
        assert!(size(mesh, &x, &seed.domain).unwrap() > 1.0, "{name}: no needle");

        let mut capped = seed.domain.clone();
        assert!(cap(mesh, &x, &mut capped, CELLS), "{name}");
        assert!((size(mesh, &x, &capped).unwrap() - CELLS).abs() < 1e-12, "{name}: not at the limit");
        assert!(volume(&capped) < 0.9 * before, "{name}: as large as before");
        check(name, basis, mesh, x, &capped);

        let mut reshaped = seed.domain.clone();
        assert!(reshape(mesh, &x, &mut reshaped, CELLS), "{name}");
        assert!((size(mesh, &x, &reshaped).unwrap() - CELLS).abs() < 1e-12, "{name}: not at the limit");
        // The volume is kept where no other axis meets the limit, as in the plane's slender needles.
        let kept = volume(&reshaped) / before;
        assert!(kept > 1.01 * volume(&capped) / before && kept < 1.0 + 1e-10, "{name}: volume {kept}");
        let slender = D == 2 && before < 0.9 * (0.5 * CELLS).powi(2);
        assert!(!slender || kept > 1.0 - 1e-10, "{name}: volume {kept}");
        check(name, basis, mesh, x, &reshaped);

        assert!(!cap(mesh, &x, &mut capped, CELLS), "{name}: shortened again");
        assert!(split(basis, mesh, &x, &capped, CELLS, 100).is_empty(), "{name}: a short domain is split");
    }
}

fn divided<const D: usize, B: Basis<D>>(name: &str, basis: &B, mesh: &Mesh<D>, piece: &LinearCell<D>) {
    for seed in seeds(basis, piece) {
        let parts = split(basis, mesh, &seed.position, &seed.domain, CELLS, 100);
        assert!((2..100).contains(&parts.len()), "{name}: {} parts", parts.len());
        let mut whole = 0.0;
        let mut centre = Vector::zeros();
        for part in &parts {
            assert!(part.share > 0.0, "{name}");
            assert!(!is_too_long(mesh, &part.position, &part.domain, CELLS), "{name}: still too long");
            check(name, basis, mesh, part.position, &part.domain);
            whole += part.share;
            centre += part.position * part.share;
        }
        assert!((whole - 1.0).abs() < 1e-14, "{name}: shares sum to {whole}");
        assert!((centre - seed.position).norm() < 1e-12, "{name}: centre off by {}", centre - seed.position);
        // Cutting stops as soon as there are too many.
        assert_eq!(split(basis, mesh, &seed.position, &seed.domain, CELLS, 1).len(), 2, "{name}");
    }
}

fn both<const D: usize, B: Basis<D>>(name: &str, basis: &B, mesh: &Mesh<D>, piece: &LinearCell<D>) {
    shortened(name, basis, mesh, piece);
    divided(name, basis, mesh, piece);
}

#[test]
fn shortened_and_divided_domains_are_complete() {
    let mut random = Random::new(12);
    let axis = || Axis::uniform(0.0, 12.0, 12).unwrap();
    let plane = Mesh::at_rest(&Layout::on_axes([axis(), axis()]).unwrap());
    let radii = Axis::geometric(3.0, 15.0, 12, 1.5).unwrap();
    let ring = Mesh::at_rest(&Layout::ring([6.0, -3.0], radii, 60, Span::Full, None).unwrap());
    for mesh in [&plane, &ring] {
        for _ in 0..20 {
            let piece = needle(&Vector::<2>::new(5.9, 6.2), &mut random);
            both("CPDI1", &Cpdi1, mesh, &piece);
            both("CPDI2q", &Cpdi2q { weights: CornerWeights::Current }, mesh, &piece);
            both("CPDI2q, frozen", &Cpdi2q { weights: CornerWeights::Frozen }, mesh, &piece);
            both("CPDI2t", &Cpdi2t::default(), mesh, &piece);
            both("fallback", &Fallback { basis: Cpdi2q::default(), beyond: 0.9 }, mesh, &piece);
        }
    }
    let solid = Mesh::at_rest(&Layout::on_axes([axis(), axis(), axis()]).unwrap());
    for _ in 0..20 {
        let piece = needle(&Vector::<3>::new(5.9, 6.2, 5.5), &mut random);
        both("CPDI1, space", &Cpdi1, &solid, &piece);
        both("CPDI2 hexahedron", &Cpdi2Hexahedron, &solid, &piece);
        both("CPDI2 tetrahedron", &Cpdi2Tetrahedron, &solid, &piece);
    }
}

#[test]
fn boxes_along_the_axes_are_cut_across() {
    let axis = || Axis::uniform(0.0, 12.0, 12).unwrap();
    let mesh = Mesh::at_rest(&Layout::on_axes([axis(), axis()]).unwrap());
    let x = |c: usize| Vector::<2>::new(if c & 1 == 1 { 7.5 } else { 4.5 }, if c & 2 == 2 { 6.4 } else { 6.0 });
    both("GIMP", &Gimp::default(), &mesh, &LinearCell::new(from_fn(x)));
}

#[test]
fn parallelograms_fill_their_point_and_go_on_from_where_they_were_shortened() {
    let axis = || Axis::uniform(0.0, 12.0, 12).unwrap();
    let mesh = Mesh::at_rest(&Layout::on_axes([axis(), axis()]).unwrap());
    let mut random = Random::new(3);
    let x = Vector::<2>::new(6.1, 5.8);
    let mut domain = seeds(&Cpdi1, &needle(&x, &mut random)).remove(0).domain;
    // As if F had made the needle.
    let f = Block::<2>::new(1.0, 5.0, 0.1, 1.4);
    domain.initial = f.try_inverse().unwrap() * domain.current;

    let area = domain.current.determinant();
    let parts = split(&Cpdi1, &mesh, &x, &domain, CELLS, 100);
    let sum: f64 = parts.iter().map(|part| part.domain.current.determinant()).sum();
    assert!((sum / area - 1.0).abs() < 1e-12);

    let needle = domain;
    assert!(cap(&mesh, &x, &mut domain, CELLS));
    assert!((f * domain.initial - domain.current).norm() < 1e-12, "F does not lead to the capped domain");
    // The principal axes stay: A = r r⁻¹ is symmetric with eigenvalues 1 and below 1.
    let map = domain.current * needle.current.try_inverse().unwrap();
    assert!((map - map.transpose()).norm() < 1e-12);
    let mut values: Vec<f64> = map.symmetric_eigenvalues().iter().copied().collect();
    values.sort_by(f64::total_cmp);
    assert!((values[1] - 1.0).abs() < 1e-12 && values[0] < 0.9, "{values:?}");
}

#[test]
fn reshaped_parallelepipeds_lie_along_their_cells() {
    fn dynamic<const D: usize>(m: &Block<D>) -> DMatrix<f64> {
        DMatrix::from_fn(D, D, |i, j| m[(i, j)])
    }
    fn check<const D: usize>(mesh: &Mesh<D>, x: Vector<D>, r: Block<D>, f: Block<D>) {
        let back = dynamic(&f).try_inverse().unwrap();
        let needle = Parallelepiped { initial: Block::from_fn(|i, j| back[(i, j)]) * r, current: r };
        // Cells have edge 1.
        let edge = Block::identity() * 2.0;
        let mut domain = needle;
        domain.align(&edge);
        let (before, after) = (r * r.transpose(), domain.current * domain.current.transpose());
        assert!((after - before).norm() < 1e-14 * before.norm());
        let volume = |domain: &Parallelepiped<D>| dynamic(&domain.current).determinant();
        assert!((volume(&domain) / volume(&needle) - 1.0).abs() < 1e-12, "not of the same hand");

        let mut domain = needle;
        assert!(reshape(mesh, &x, &mut domain, CELLS));
        assert!((f * domain.initial - domain.current).norm() < 1e-12, "F does not lead to the reshaped domain");
        // In the thinnest direction the corners reach no farther than the second moment does, and
        // in the k-th no more than √k as far.
        let spread = domain.current * domain.current.transpose();
        let mut reach: Vec<(f64, f64)> = (0..D)
            .map(|d| (spread[(d, d)].sqrt(), domain.current.row(d).iter().map(|it| it.abs()).sum()))
            .collect();
        reach.sort_by(|a, b| a.0.total_cmp(&b.0));
        assert!((reach[0].1 / reach[0].0 - 1.0).abs() < 1e-12, "{reach:?}");
        for (k, (least, reach)) in reach.iter().enumerate() {
            assert!(*reach <= least * ((k + 1) as f64).sqrt() * (1.0 + 1e-12));
        }
        // Done again nothing changes: not the spread, and so not the factor.
        let mut again = domain;
        again.align(&edge);
        assert!((again.current - domain.current).norm() < 1e-12);
    }
    let axis = || Axis::uniform(0.0, 12.0, 12).unwrap();
    let plane = Mesh::at_rest(&Layout::on_axes([axis(), axis()]).unwrap());
    // A square whose sides have rolled by 45 degrees, sheared.
    let turn = Block::<2>::new(1.0, -1.0, 1.0, 1.0) * 0.17;
    check(
        &plane,
        Vector::<2>::new(6.1, 5.8),
        Block::<2>::new(1.0, 3.0, 0.0, 1.0) * turn,
        Block::<2>::new(1.0, 5.0, 0.1, 1.4),
    );
    check(
        &plane,
        Vector::<2>::new(6.1, 5.8),
        -Block::<2>::new(1.0, 0.0, 2.5, 1.0) * turn,
        Block::<2>::identity(),
    );
    let solid = Mesh::at_rest(&Layout::on_axes([axis(), axis(), axis()]).unwrap());
    let r = Block::<3>::new(0.2, 0.9, 0.1, -0.1, 0.3, 0.2, 0.1, -0.2, 0.25);
    check(
        &solid,
        Vector::<3>::new(5.9, 6.2, 5.5),
        r,
        Block::<3>::new(1.0, 0.2, 0.0, 0.1, 1.1, 0.3, 0.0, -0.2, 0.9),
    );
}

#[test]
fn points_without_a_domain_or_a_cell_are_left_alone() {
    let axis = || Axis::uniform(0.0, 2.0, 2).unwrap();
    let mesh = Mesh::at_rest(&Layout::on_axes([axis(), axis()]).unwrap());
    let x = Vector::<2>::new(0.5, 0.5);
    assert!(!cap(&mesh, &x, &mut (), CELLS));
    assert!(split(&Smpm, &mesh, &x, &(), CELLS, 100).is_empty());
    let mut domain = seeds(&Cpdi1, &needle(&Vector::<2>::new(40.0, 0.0), &mut Random::new(1))).remove(0).domain;
    assert!(!cap(&mesh, &Vector::<2>::new(40.0, 0.0), &mut domain, CELLS));
}

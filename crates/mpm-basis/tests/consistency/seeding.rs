//! Points at rest: their volumes, positions, domains and numbers.

use crate::completeness::{check, influences};
use crate::random::{Random, cases};
use mpm_basis::{
    Basis, Cpdi1, Cpdi2Hexahedron, Cpdi2Tetrahedron, Cpdi2q, Cpdi2t, Domain, Fallback, FallbackDomain, Gimp,
    Smpm, TriangleSplit,
};
use mpm_grid::{LinearCell, Mesh, Vector};

/// Seeds a cell with `n` points per direction and returns how many these were.
fn seed_cell<const D: usize, B: Basis<D>>(name: &str, basis: &B, mesh: &Mesh<D>, n: u32) -> usize {
    let cell: [u32; D] = mesh.lattice().cells().map(|cells| cells / 2);
    let whole = mesh.linear_cell(cell);
    let n = basis.pieces_per_cell(n).unwrap();
    let line = |k: u32| 2.0 * f64::from(k) / f64::from(n) - 1.0;
    let (mut volume, mut count, mut first_moment) = (0.0, 0, Vector::<D>::zeros());
    for piece in 0..n.pow(D as u32) {
        let index = Vector::<D>::from_fn(|d, _| f64::from(piece / n.pow(d as u32) % n));
        let from = index.map(|k| line(k as u32));
        let to = index.map(|k| line(k as u32 + 1));
        basis.seed(&whole.piece(&from, &to), &mut |seed| {
            volume += seed.volume;
            first_moment += seed.position * seed.volume;
            count += 1;
            check(name, basis, mesh, seed.position, &seed.domain);
            if mesh.rectilinear().is_some() {
                // Domains that end on the cell's own grid lines do not touch the neighbours.
                let nodes = influences(basis, mesh, &seed.position, &seed.domain).unwrap();
                let corners = &mesh.lattice().corners(cell)[..1 << D];
                assert!(nodes.iter().all(|it| corners.contains(&it.node)), "{name}: {nodes:?}");
            }
        });
    }
    let error = volume / whole.volume() - 1.0;
    assert!(error.abs() < 1e-13, "{name}: volume off by {error:e}");
    // Exact where points sit at centroids; within the cell in any case.
    assert!(
        (first_moment / volume - whole.position(&Vector::zeros())).norm() < whole.volume().powf(1.0 / D as f64)
    );
    count
}

#[test]
fn seeds_fill_the_cell() {
    let mut random = Random::new(8);
    for case in cases::<2>(&mut random) {
        let (name, mesh) = (case.name, &case.mesh);
        for n in [2, 4] {
            let squares = (n * n) as usize;
            assert_eq!(seed_cell(name, &Smpm, mesh, n), squares);
            assert_eq!(seed_cell(name, &Cpdi1, mesh, n), squares);
            assert_eq!(seed_cell(name, &Cpdi2q::default(), mesh, n), squares);
            for (split, count) in [
                (TriangleSplit::Slash, 2 * squares),
                (TriangleSplit::Backslash, 2 * squares),
                (TriangleSplit::Cross, squares),
            ] {
                assert_eq!(seed_cell(name, &Cpdi2t { split }, mesh, n), count);
                assert_eq!(seed_cell(name, &Fallback { basis: Cpdi2t { split }, beyond: 9.0 }, mesh, n), count);
            }
            if name == "graded box" {
                assert_eq!(seed_cell(name, &Gimp::default(), mesh, n), squares);
            }
        }
    }
    for case in cases::<3>(&mut random) {
        let (name, mesh) = (case.name, &case.mesh);
        assert_eq!(seed_cell(name, &Smpm, mesh, 2), 8);
        assert_eq!(seed_cell(name, &Cpdi1, mesh, 2), 8);
        assert_eq!(seed_cell(name, &Cpdi2Hexahedron, mesh, 2), 8);
        // Cells of a bent box have warped faces; a ring's are plane.
        if name != "bent box" {
            assert_eq!(seed_cell(name, &Cpdi2Tetrahedron, mesh, 2), 48);
        }
    }
}

#[test]
fn slash_rises_from_the_lower_left() {
    let square = LinearCell::new(std::array::from_fn(|c| Vector::<2>::new((c % 2) as f64, (c / 2 % 2) as f64)));
    for (split, cut) in [
        (TriangleSplit::Slash, [Vector::<2>::new(0.0, 0.0), Vector::<2>::new(1.0, 1.0)]),
        (TriangleSplit::Backslash, [Vector::<2>::new(1.0, 0.0), Vector::<2>::new(0.0, 1.0)]),
    ] {
        let basis = Cpdi2t { split };
        basis.seed(&square, &mut |seed| {
            let corners = seed.domain.outline(&seed.position);
            assert!(cut.iter().all(|end| corners.contains(end)), "{split:?}: {corners:?}");
            assert!(seed.domain.initial_volume > 0.0);
        });
    }
    let centre = Vector::<2>::new(0.5, 0.5);
    let cross = Cpdi2t::default();
    cross.seed(&square, &mut |seed| {
        assert!(seed.domain.outline(&seed.position).contains(&centre) && seed.volume == 0.25);
    });
}

#[test]
fn tetrahedra_have_the_hand_of_their_cell() {
    for case in cases::<3>(&mut Random::new(13)) {
        let cell = case.mesh.linear_cell([2, 2, 2]);
        let hand = cell.determinant(&Vector::zeros()).signum();
        Cpdi2Tetrahedron.seed(&cell, &mut |seed| assert!(seed.domain.initial_volume * hand > 0.0));
    }
}

#[test]
fn crossed_diagonals_need_an_even_number() {
    assert_eq!(Cpdi2t::default().pieces_per_cell(6), Ok(3));
    assert!(Cpdi2t::default().pieces_per_cell(3).unwrap_err().contains("even"));
    assert_eq!(Cpdi2t { split: TriangleSplit::Slash }.pieces_per_cell(3), Ok(3));
    assert_eq!(Basis::<3>::pieces_per_cell(&Cpdi1, 3), Ok(3));
}

#[test]
fn reserves_have_the_volume_of_their_point() {
    for case in cases::<3>(&mut Random::new(9)) {
        let cell = case.mesh.linear_cell([2, 2, 2]);
        let basis = Fallback { basis: Cpdi2Hexahedron, beyond: 0.5 };
        basis.seed(&cell, &mut |seed| {
            let FallbackDomain::Sound { half_vectors, .. } = seed.domain else { panic!("fallen at rest") };
            assert!((8.0 * half_vectors.determinant().abs() / seed.volume - 1.0).abs() < 1e-13);
        });
    }
}

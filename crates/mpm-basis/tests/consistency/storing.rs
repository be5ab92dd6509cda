//! Domains return from a checkpoint as they were.

use mpm_basis::{Domain, FallbackDomain, HalfLengths, Hexahedron, Parallelepiped, Quadrilateral, Simplex};
use mpm_grid::{Block, Vector};
use std::array::from_fn;
use std::fmt::Debug;

#[track_caller]
fn returns<const D: usize, T: Domain<D> + PartialEq + Debug>(domain: T) {
    let mut numbers = vec![7.0];
    domain.store(&mut numbers);
    assert_eq!(numbers.len(), 1 + T::NUMBERS);
    assert_eq!(T::restore(&numbers[1..]).unwrap(), domain);
}

/// All different, so that no two may be exchanged.
fn numbered<const D: usize>(from: f64) -> Vector<D> {
    Vector::from_fn(|i, _| from + 0.1 * i as f64)
}

fn matrix<const D: usize>(from: f64) -> Block<D> {
    Block::from_fn(|i, j| from + 0.1 * i as f64 + 0.01 * j as f64)
}

#[test]
fn domains_return_as_they_were() {
    returns::<2, _>(());
    returns(HalfLengths::<3> { initial: numbered(1.0), current: numbered(2.0) });
    returns(Parallelepiped::<2> { initial: matrix(1.0), current: matrix(2.0) });
    returns(Parallelepiped::<3> { initial: matrix(1.0), current: matrix(2.0) });
    let quadrilateral = Quadrilateral {
        corners: from_fn(|c| numbered(c as f64)),
        initial_area: -5.0,
        initial_hourglass: numbered(6.0),
    };
    returns(quadrilateral);
    returns(Hexahedron { corners: from_fn(|c| numbered(c as f64)), initial_volume: 9.0 });
    let triangle = Simplex::<2> {
        first: numbered(1.0),
        others: from_fn(|c| numbered(2.0 + c as f64)),
        initial_volume: 5.0,
    };
    returns(triangle);
    returns(Simplex::<3> {
        first: numbered(1.0),
        others: from_fn(|c| numbered(2.0 + c as f64)),
        initial_volume: -5.0,
    });
    returns(FallbackDomain::Sound { domain: triangle, half_vectors: matrix::<2>(8.0) });
    let fallen = Parallelepiped { initial: matrix(1.0), current: matrix(2.0) };
    returns(FallbackDomain::<2, Simplex<2>>::Fallen(fallen));
}

#[test]
fn what_no_domain_can_be_is_refused() {
    assert!(HalfLengths::<2>::restore(&[1.0, 1.0, 0.0, 1.0]).is_err());
    assert!(Simplex::<2>::restore(&[0.0; 7]).is_err());
    assert!(FallbackDomain::<2, Simplex<2>>::restore(&[2.0; 12]).is_err());
}

//! Domains as plain numbers, for a file from which a run goes on.

use crate::{FallbackDomain, HalfLengths, Hexahedron, Parallelepiped, Quadrilateral, Simplex};
use mpm_grid::{Block, Vector};
use std::array::from_fn;

/// A domain that can be written down as `NUMBERS` numbers and read back, bit for bit.
pub trait StoredDomain: Sized {
    /// Numbers per domain.
    const NUMBERS: usize;

    /// Appends exactly `NUMBERS` numbers.
    fn store(&self, to: &mut Vec<f64>);

    /// The domain of `NUMBERS` finite numbers.
    ///
    /// # Errors
    /// What no domain of this kind can be.
    fn recall(from: &[f64]) -> Result<Self, String>;
}

impl StoredDomain for () {
    const NUMBERS: usize = 0;

    fn store(&self, _to: &mut Vec<f64>) {}

    fn recall(_from: &[f64]) -> Result<Self, String> {
        Ok(())
    }
}

impl<const D: usize> StoredDomain for HalfLengths<D> {
    const NUMBERS: usize = 2 * D;

    fn store(&self, to: &mut Vec<f64>) {
        to.extend(self.initial.iter().chain(self.current.iter()));
    }

    fn recall(from: &[f64]) -> Result<Self, String> {
        match from.iter().find(|length| **length <= 0.0) {
            Some(length) => Err(format!("a half length is {length}, expected above 0")),
            None => Ok(Self { initial: vector(from), current: vector(&from[D..]) }),
        }
    }
}

impl<const D: usize> StoredDomain for Parallelepiped<D> {
    const NUMBERS: usize = 2 * D * D;

    fn store(&self, to: &mut Vec<f64>) {
        to.extend(self.initial.iter().chain(self.current.iter()));
    }

    fn recall(from: &[f64]) -> Result<Self, String> {
        Ok(Self { initial: block(from), current: block(&from[D * D..]) })
    }
}

impl StoredDomain for Quadrilateral {
    const NUMBERS: usize = 11;

    fn store(&self, to: &mut Vec<f64>) {
        to.extend(self.corners.iter().flat_map(|corner| corner.iter()));
        to.push(self.initial_area);
        to.extend(self.initial_hourglass.iter());
    }

    fn recall(from: &[f64]) -> Result<Self, String> {
        let corners = from_fn(|c| vector(&from[2 * c..]));
        Ok(Self { corners, initial_area: extent(from[8])?, initial_hourglass: vector(&from[9..]) })
    }
}

impl StoredDomain for Hexahedron {
    const NUMBERS: usize = 25;

    fn store(&self, to: &mut Vec<f64>) {
        to.extend(self.corners.iter().flat_map(|corner| corner.iter()));
        to.push(self.initial_volume);
    }

    fn recall(from: &[f64]) -> Result<Self, String> {
        Ok(Self { corners: from_fn(|c| vector(&from[3 * c..])), initial_volume: extent(from[24])? })
    }
}

impl<const D: usize> StoredDomain for Simplex<D> {
    const NUMBERS: usize = D * (D + 1) + 1;

    fn store(&self, to: &mut Vec<f64>) {
        to.extend(self.first.iter().chain(self.others.iter().flat_map(|corner| corner.iter())));
        to.push(self.initial_volume);
    }

    fn recall(from: &[f64]) -> Result<Self, String> {
        let others = from_fn(|c| vector(&from[D * (c + 1)..]));
        Ok(Self { first: vector(from), others, initial_volume: extent(from[D * (D + 1)])? })
    }
}

/// First 0 and then the domain with the parallelepiped in reserve, or 1 and then the parallelepiped;
/// filled up with zeros.
impl<const D: usize, Domain: StoredDomain> StoredDomain for FallbackDomain<D, Domain> {
    const NUMBERS: usize = {
        let (sound, fallen) = (Domain::NUMBERS + D * D, 2 * D * D);
        1 + if sound > fallen { sound } else { fallen }
    };

    fn store(&self, to: &mut Vec<f64>) {
        let end = to.len() + Self::NUMBERS;
        match self {
            FallbackDomain::Sound { domain, half_vectors } => {
                to.push(0.0);
                domain.store(to);
                to.extend(half_vectors.iter());
            }
            FallbackDomain::Fallen(domain) => {
                to.push(1.0);
                domain.store(to);
            }
        }
        to.resize(end, 0.0);
    }

    fn recall(from: &[f64]) -> Result<Self, String> {
        match from[0] {
            0.0 => Ok(FallbackDomain::Sound {
                domain: Domain::recall(&from[1..=Domain::NUMBERS])?,
                half_vectors: block(&from[1 + Domain::NUMBERS..]),
            }),
            1.0 => Ok(FallbackDomain::Fallen(Parallelepiped::recall(&from[1..])?)),
            other => Err(format!("a domain is of kind {other}, expected 0 or 1")),
        }
    }
}

/// A signed volume at rest.
fn extent(volume: f64) -> Result<f64, String> {
    if volume == 0.0 { Err("a domain has no volume at rest".into()) } else { Ok(volume) }
}

fn vector<const D: usize>(from: &[f64]) -> Vector<D> {
    Vector::from_column_slice(&from[..D])
}

fn block<const D: usize>(from: &[f64]) -> Block<D> {
    Block::from_column_slice(&from[..D * D])
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fmt::Debug;

    #[track_caller]
    fn returns<T: StoredDomain + PartialEq + Debug>(domain: T) {
        let mut numbers = vec![7.0];
        domain.store(&mut numbers);
        assert_eq!(numbers.len(), 1 + T::NUMBERS);
        assert_eq!(T::recall(&numbers[1..]).unwrap(), domain);
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
        returns(());
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
        assert!(HalfLengths::<2>::recall(&[1.0, 1.0, 0.0, 1.0]).is_err());
        assert!(Simplex::<2>::recall(&[0.0; 7]).is_err());
        assert!(FallbackDomain::<2, Simplex<2>>::recall(&[2.0; 12]).is_err());
    }
}

//! What points are called.

use crate::message::{Reader, Writer};

/// What a point is called on all ranks. Keys of a body sort as one rank alone has its points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key {
    /// Number of the point at the start of the run, or of the one that it is a part of.
    pub number: u64,
    /// Which part it is: digits of the parts of parts from the highest bit on; 0 for a whole point.
    pub path: u64,
    /// How many bits of the path are digits.
    pub digits: u32,
}

impl Key {
    /// Those of the points of a body at the start.
    pub(crate) fn first(points: usize) -> Vec<Self> {
        (0..points).map(|point| Self { number: point as u64, ..Self::default() }).collect()
    }

    /// Those of points with these numbers.
    pub(crate) fn numbered(numbers: &[u64]) -> Vec<Self> {
        numbers.iter().map(|&number| Self { number, ..Self::default() }).collect()
    }

    /// Those of its parts, ascending.
    pub(crate) fn parts(self, count: usize) -> Vec<Self> {
        let digits = self.digits + count.next_power_of_two().trailing_zeros();
        assert!(digits <= 64, "parts of a point are not a 2^64th of it");
        let part = |k: u64| Self { path: self.path | k.checked_shl(64 - digits).unwrap_or(0), digits, ..self };
        (0..count as u64).map(part).collect()
    }
}

/// The keys of the points of each body that this rank has, ascending as the points.
pub(crate) type Keys = Vec<Vec<Key>>;

pub(crate) fn write_keys(keys: &[Key], to: &mut Writer) {
    to.counts(keys.iter().map(|key| key.number));
    to.counts(keys.iter().map(|key| key.path));
    to.counts(keys.iter().map(|key| u64::from(key.digits)));
}

pub(crate) fn read_keys(from: &mut Reader<'_>) -> Vec<Key> {
    let (numbers, paths, digits) = (from.counts(), from.counts(), from.counts());
    let all = numbers.into_iter().zip(paths).zip(digits);
    all.map(|((number, path), digits)| Key { number, path, digits: digits as u32 }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_of_parts_sort_in_the_place_of_their_point() {
        let [before, point, after] = [0, 1, 2].map(|number| Key { number, ..Key::default() });
        let halves = point.parts(2);
        let mut all = vec![before];
        for half in &halves {
            all.extend(half.parts(3).into_iter().flat_map(|third| third.parts(2)));
        }
        all.push(after);
        assert_eq!(all.len(), 14);
        assert!(all.windows(2).all(|pair| pair[0] < pair[1]), "{all:?}");
        // As deep as it goes.
        let deep = (0..32).fold(point, |key, _| key.parts(4)[3]);
        assert_eq!((deep.digits, deep.path), (64, u64::MAX));
    }
}

//! 32-bit numbers of nodes and cells: half the memory traffic of `usize` in connectivity lists.
//!
//! The only place where an index changes its width.

/// Number of a grid node, from 0; depends on the lattice only, so it survives every mesh motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(u32);

impl NodeId {
    /// The node with this number; `None` where the number exceeds 32 bits.
    pub fn from_index(index: usize) -> Option<Self> {
        u32::try_from(index).ok().map(Self)
    }

    /// The node's number, for use as an index.
    #[inline]
    pub fn index(self) -> usize {
        to_usize(self.0)
    }

    #[inline]
    pub(crate) fn new(number: u32) -> Self {
        Self(number)
    }

    #[inline]
    pub(crate) fn number(self) -> u32 {
        self.0
    }
}

/// Number of a grid cell, from 0, lexicographic with the first lattice direction fastest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CellId(u32);

impl CellId {
    /// The cell with this number; `None` where the number exceeds 32 bits.
    pub fn from_index(index: usize) -> Option<Self> {
        u32::try_from(index).ok().map(Self)
    }

    /// The cell's number, for use as an index.
    #[inline]
    pub fn index(self) -> usize {
        to_usize(self.0)
    }

    #[inline]
    pub(crate) fn new(number: u32) -> Self {
        Self(number)
    }

    #[inline]
    pub(crate) fn number(self) -> u32 {
        self.0
    }
}

/// Widens a 32-bit index; lossless on every platform the project supports (at least 32 bits).
#[inline]
pub(crate) fn to_usize(index: u32) -> usize {
    index as usize
}

/// The whole cells in `t`, at most `cells - 1`; 0 for negative `t` and for NaN.
#[inline]
pub(crate) fn whole(t: f64, cells: u32) -> u32 {
    // A float-to-integer `as` saturates, which is the clamp wanted here.
    (t as u32).min(cells - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_beyond_32_bits_are_refused() {
        assert_eq!(NodeId::from_index(7).map(NodeId::index), Some(7));
        assert_eq!(CellId::from_index(9).map(CellId::index), Some(9));
        assert!(NodeId::from_index(1 << 32).is_none());
        assert!(CellId::from_index(1 << 32).is_none());
    }

    #[test]
    fn whole_cells_saturate() {
        assert_eq!(whole(2.7, 10), 2);
        assert_eq!(whole(-3.0, 10), 0);
        assert_eq!(whole(f64::INFINITY, 10), 9);
        assert_eq!(whole(f64::NAN, 10), 0);
    }
}

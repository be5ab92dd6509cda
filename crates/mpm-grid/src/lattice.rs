//! The combinatorics of a grid: numbers of nodes and cells, without positions.

use std::array::from_fn;

use crate::index::{CellId, NodeId, to_usize};

/// A rectangular arrangement of cells, possibly closed on itself in some directions.
///
/// Nodes and cells are numbered lexicographically, the first direction fastest. A periodic
/// direction of n cells has n nodes: the last cell ends on the first node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lattice<const D: usize> {
    cells: [u32; D],
    periodic: [bool; D],
    nodes: [u32; D],
    n_nodes: u32,
    n_cells: u32,
    /// ⌈2⁶⁴/nodes⌉, by which a multiplication divides, see [`quotient`].
    per_nodes: [u64; D],
}

/// What a lattice cannot be made of.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LatticeError {
    /// A direction with too few cells.
    #[error("direction {direction} has {cells} cells; at least {least} are needed")]
    TooFewCells {
        /// Lattice direction, from 0.
        direction: usize,
        /// Cells asked for.
        cells: u32,
        /// Fewest cells possible: 1, or 3 where the direction is periodic.
        least: u32,
    },
    /// More nodes or cells than 32 bits can number.
    #[error("the lattice has more nodes than a 32-bit number can count")]
    TooLarge,
}

impl<const D: usize> Lattice<D> {
    /// A lattice of `cells` per direction, closed on itself in the `periodic` directions.
    pub fn new(cells: [u32; D], periodic: [bool; D]) -> Result<Self, LatticeError> {
        const { assert!(1 <= D && D <= 3, "space has one, two or three dimensions") };
        let mut nodes = [0; D];
        let (mut n_nodes, mut n_cells) = (1_u32, 1_u32);
        for direction in 0..D {
            // With fewer than three, two cells would share all their nodes.
            let least = if periodic[direction] { 3 } else { 1 };
            let count = cells[direction];
            if count < least {
                return Err(LatticeError::TooFewCells { direction, cells: count, least });
            }
            let extra = u32::from(!periodic[direction]);
            nodes[direction] = count.checked_add(extra).ok_or(LatticeError::TooLarge)?;
            n_nodes = n_nodes.checked_mul(nodes[direction]).ok_or(LatticeError::TooLarge)?;
            n_cells = n_cells.checked_mul(count).ok_or(LatticeError::TooLarge)?;
        }
        // At least two nodes in each direction: the reciprocal fits.
        let per_nodes = nodes.map(|n| u64::MAX / u64::from(n) + 1);
        Ok(Self { cells, periodic, nodes, n_nodes, n_cells, per_nodes })
    }

    /// Cells in each direction.
    pub fn cells(&self) -> [u32; D] {
        self.cells
    }

    /// Nodes in each direction.
    pub fn nodes(&self) -> [u32; D] {
        self.nodes
    }

    /// Which directions close on themselves.
    pub fn periodic(&self) -> [bool; D] {
        self.periodic
    }

    /// Number of nodes.
    pub fn n_nodes(&self) -> usize {
        to_usize(self.n_nodes)
    }

    /// Number of cells.
    pub fn n_cells(&self) -> usize {
        to_usize(self.n_cells)
    }

    /// The node at a multi-index.
    #[inline]
    pub fn node(&self, index: [u32; D]) -> NodeId {
        debug_assert!((0..D).all(|d| index[d] < self.nodes[d]), "{index:?} is not a node");
        NodeId::new(join(index, self.nodes))
    }

    /// The multi-index of a node.
    #[inline]
    pub fn node_index(&self, node: NodeId) -> [u32; D] {
        debug_assert!(node.number() < self.n_nodes, "{node:?} is not a node");
        let mut number = node.number();
        from_fn(|d| {
            if d + 1 == D {
                return number;
            }
            let quotient = quotient(number, self.per_nodes[d]);
            let i = number - quotient * self.nodes[d];
            number = quotient;
            i
        })
    }

    /// The cell at a multi-index.
    #[inline]
    pub fn cell(&self, index: [u32; D]) -> CellId {
        debug_assert!((0..D).all(|d| index[d] < self.cells[d]), "{index:?} is not a cell");
        CellId::new(join(index, self.cells))
    }

    /// The multi-index of a cell.
    #[inline]
    pub fn cell_index(&self, cell: CellId) -> [u32; D] {
        debug_assert!(cell.number() < self.n_cells, "{cell:?} is not a cell");
        split(cell.number(), self.cells)
    }

    /// The nodes at the corners of a cell: the first 2^D entries, lexicographic, first direction
    /// fastest (further entries repeat the first corner).
    pub fn corners(&self, cell: [u32; D]) -> [NodeId; 8] {
        let sides = self.sides(&cell);
        from_fn(|c| corner(&sides, if c < 1 << D { c } else { 0 }))
    }

    /// Every edge between neighbouring nodes once, for drawing.
    pub fn edges(&self) -> impl Iterator<Item = [NodeId; 2]> + '_ {
        (0..self.n_nodes).flat_map(move |number| {
            let node = NodeId::new(number);
            let index = self.node_index(node);
            (0..D).filter_map(move |d| {
                let mut next = index;
                next[d] += 1;
                if next[d] == self.nodes[d] {
                    next[d] = 0;
                }
                (next[d] > 0 || self.periodic[d]).then(|| [node, self.node(next)])
            })
        })
    }

    /// Share of the lower and upper side of the cell in its corners' node numbers, per direction.
    #[inline]
    pub(crate) fn sides(&self, cell: &[u32; D]) -> [[u32; 2]; D] {
        debug_assert!((0..D).all(|d| cell[d] < self.cells[d]), "{cell:?} is not a cell");
        let mut stride = 1;
        from_fn(|d| {
            let lower = cell[d];
            let upper = if lower + 1 == self.nodes[d] { 0 } else { lower + 1 };
            let side = [lower * stride, upper * stride];
            stride = stride.wrapping_mul(self.nodes[d]);
            side
        })
    }

    /// Multi-index of the node at corner `c` (bit d set: upper side in direction d) of a cell.
    #[inline]
    pub(crate) fn corner_index(&self, cell: &[u32; D], c: usize) -> [u32; D] {
        from_fn(|d| match cell[d] + u32::from(c >> d & 1 == 1) {
            end if end == self.nodes[d] => 0,
            inside => inside,
        })
    }

    /// The next cell up in a direction, round the seam if that is periodic; `None` at the end.
    pub fn above(&self, mut cell: [u32; D], direction: usize) -> Option<[u32; D]> {
        let last = cell[direction] + 1 == self.cells[direction];
        cell[direction] = match (last, self.periodic[direction]) {
            (false, _) => cell[direction] + 1,
            (true, true) => 0,
            (true, false) => return None,
        };
        Some(cell)
    }

    /// The next cell down in a direction, round the seam if that is periodic; `None` at the end.
    pub fn below(&self, mut cell: [u32; D], direction: usize) -> Option<[u32; D]> {
        cell[direction] = match (cell[direction], self.periodic[direction]) {
            (0, true) => self.cells[direction] - 1,
            (0, false) => return None,
            (i, _) => i - 1,
        };
        Some(cell)
    }
}

/// The node at corner `c` (bit d set: upper side in direction d) from [`Lattice::sides`].
#[inline]
pub(crate) fn corner<const D: usize>(sides: &[[u32; 2]; D], c: usize) -> NodeId {
    let mut number = 0;
    for (d, side) in sides.iter().enumerate() {
        number += side[c >> d & 1];
    }
    NodeId::new(number)
}

#[inline]
fn join<const D: usize>(index: [u32; D], counts: [u32; D]) -> u32 {
    (0..D).rev().fold(0, |number, d| number * counts[d] + index[d])
}

/// n/d of 32-bit numbers from `per` = ⌈2⁶⁴/d⌉ and d > 1: exact for all of them (Lemire, Kaser and Kurz,
/// *Faster remainder by direct computation*, 2019), at a third of the time of a division.
#[inline]
fn quotient(n: u32, per: u64) -> u32 {
    ((u128::from(per) * u128::from(n)) >> 64) as u32
}

#[inline]
fn split<const D: usize>(mut number: u32, counts: [u32; D]) -> [u32; D] {
    from_fn(|d| {
        let i = number % counts[d];
        number /= counts[d];
        i
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_multi_indices_invert_each_other() {
        let lattice = Lattice::new([3, 4, 2], [false, true, false]).unwrap();
        assert_eq!((lattice.n_nodes(), lattice.n_cells()), (4 * 4 * 3, 3 * 4 * 2));
        for i in 0..lattice.n_nodes() {
            let node = NodeId::from_index(i).unwrap();
            assert_eq!(lattice.node(lattice.node_index(node)), node);
        }
        for i in 0..lattice.n_cells() {
            let cell = CellId::from_index(i).unwrap();
            assert_eq!(lattice.cell(lattice.cell_index(cell)), cell);
        }
        assert_eq!(lattice.node([1, 2, 1]).index(), 1 + 4 * (2 + 4));
    }

    #[test]
    fn quotients_are_those_of_division() {
        let numbers = [0, 1, 2, 3, 4, 999, 1000, 65_535, 65_536, u32::MAX / 2, u32::MAX - 1, u32::MAX];
        for d in [2, 3, 5, 7, 251, 1000, 65_535, 65_536, 65_537, u32::MAX - 1, u32::MAX] {
            for n in numbers.into_iter().chain(numbers.map(|k| (k / d) * d)) {
                assert_eq!(quotient(n, u64::MAX / u64::from(d) + 1), n / d, "{n} / {d}");
            }
        }
    }

    #[test]
    fn corners_are_lexicographic_and_close_the_seam() {
        let lattice = Lattice::new([4, 2], [true, false]).unwrap();
        let corners = |cell| lattice.corners(cell).map(NodeId::index);
        assert_eq!(corners([1, 1])[..4], [5, 6, 9, 10]);
        assert_eq!(corners([3, 0])[..4], [3, 0, 7, 4]);
        for c in 0..4 {
            let index = lattice.corner_index(&[3, 1], c);
            assert_eq!(lattice.node(index), lattice.corners([3, 1])[c]);
        }
    }

    #[test]
    fn edges_are_listed_once() {
        let lattice = Lattice::new([4, 2], [true, false]).unwrap();
        let mut edges: Vec<[usize; 2]> = lattice.edges().map(|edge| edge.map(NodeId::index)).collect();
        // Three rings of four and two times four between them.
        assert_eq!(edges.len(), 3 * 4 + 2 * 4);
        assert!(edges.contains(&[3, 0]) && edges.contains(&[7, 11]) && !edges.contains(&[8, 0]));
        edges.iter_mut().for_each(|edge| edge.sort_unstable());
        edges.sort_unstable();
        edges.dedup();
        assert_eq!(edges.len(), 20);
    }

    #[test]
    fn neighbours_stop_at_ends_and_wrap_round_seams() {
        let lattice = Lattice::new([4, 2], [true, false]).unwrap();
        assert_eq!(lattice.above([3, 0], 0), Some([0, 0]));
        assert_eq!(lattice.below([0, 0], 0), Some([3, 0]));
        assert_eq!(lattice.above([3, 0], 1), Some([3, 1]));
        assert_eq!(lattice.above([3, 1], 1), None);
        assert_eq!(lattice.below([3, 0], 1), None);
    }

    #[test]
    fn impossible_lattices_are_refused() {
        let short = LatticeError::TooFewCells { direction: 1, cells: 2, least: 3 };
        assert_eq!(Lattice::new([4, 2], [false, true]), Err(short));
        assert_eq!(Lattice::new([65_535, 65_536], [false; 2]), Err(LatticeError::TooLarge));
        assert!(Lattice::new([65_534, 65_534], [false; 2]).is_ok());
        assert_eq!(Lattice::new([u32::MAX], [false]), Err(LatticeError::TooLarge));
    }
}

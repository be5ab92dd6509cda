//! Where the blocks of the finest matrix come from.

use super::arithmetic::Block;
use crate::matrix::Pattern;
use std::ops::Range;

/// A block that the caller stores.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Source {
    /// Node of the column.
    pub column: u32,
    /// Number of the block among those stored for the column; [`TRANSPOSED`] is added where it is to be transposed.
    pub slot: u32,
}

pub(crate) const TRANSPOSED: u32 = 1 << 31;

impl Source {
    #[inline]
    pub(crate) fn read<const D: usize>(self, pattern: Pattern<'_>, values: &[f64]) -> Block<D> {
        let first = self.column as usize * D;
        let slot = (self.slot & !TRANSPOSED) as usize * D;
        let at = |i: usize, j: usize| values[pattern.column_start[first + j] + slot + i];
        if !pattern.is_symmetric() {
            return Block::from_fn(at);
        }
        if slot == 0 {
            return Block::from_fn(|i, j| at(i.max(j) - i.min(j), i.min(j)));
        }
        // Column j lacks the j entries above its diagonal.
        let block = Block::from_fn(|i, j| values[pattern.column_start[first + j] + slot + i - j]);
        if self.slot & TRANSPOSED == 0 { block } else { block.transpose() }
    }
}

/// The blocks that are stored for a node's columns.
pub(crate) struct Column<'a, const D: usize> {
    /// Rows of the first of these columns, whose diagonal block is complete.
    rows: &'a [usize],
}

impl<'a, const D: usize> Column<'a, D> {
    pub(crate) fn of(pattern: Pattern<'a>, node: usize) -> Self {
        Self { rows: pattern.rows_of(node * D) }
    }

    /// Number of blocks.
    pub(crate) fn len(&self) -> usize {
        self.rows.len() / D
    }

    /// Nodes of the first block's rows and of the last one's.
    pub(crate) fn span(&self) -> (usize, usize) {
        let of = |row: Option<&usize>| row.expect("every node couples with itself") / D;
        (of(self.rows.first()), of(self.rows.last()))
    }

    /// Tells node and slot of the blocks whose rows belong to one of these nodes.
    pub(crate) fn within(&self, nodes: &Range<usize>, mut see: impl FnMut(usize, u32)) {
        let (first, last) = self.span();
        if first >= nodes.end || last < nodes.start {
            return;
        }
        let node = |slot: usize| self.rows[slot * D] / D;
        let mut from = 0;
        if first < nodes.start {
            let mut end = self.len();
            while from < end {
                let middle = (from + end) / 2;
                if node(middle) < nodes.start { from = middle + 1 } else { end = middle }
            }
        }
        for slot in from..self.len() {
            let other = node(slot);
            if other >= nodes.end {
                break;
            }
            see(other, slot as u32);
        }
    }

    /// Tells the node of each block's rows, and the block's slot.
    pub(crate) fn for_each(&self, mut see: impl FnMut(usize, u32)) {
        for (slot, rows) in self.rows.chunks_exact(D).enumerate() {
            see(rows[0] / D, slot as u32);
        }
    }
}

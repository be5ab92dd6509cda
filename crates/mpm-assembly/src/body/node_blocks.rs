//! A dense tangent with four row nodes side by side.

use mpm_grid::Block;
use mpm_material::lanes::{LANES, Lanes};

/// A dense tangent as it is summed.
#[derive(Clone, Copy)]
pub(crate) struct NodeBlocks<'a, const D: usize> {
    /// Packs of row nodes.
    pub packs: usize,
    /// Blocks by column node, pack of row nodes, column and row of the block. Where only the rows from the diagonal down
    /// are summed, those above it mean nothing.
    pub blocks: &'a [Lanes],
}

impl<const D: usize> NodeBlocks<'_, D> {
    /// The block of row node v and column node w.
    #[inline(always)]
    pub fn block(&self, v: usize, w: usize) -> Block<D> {
        let of = &self.blocks[(w * self.packs + v / LANES) * D * D..][..D * D];
        let lane = v % LANES;
        Block::from_fn(|i, j| of[j * D + i].0[lane])
    }
}

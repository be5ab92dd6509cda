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

/// One block of it.
#[derive(Clone, Copy)]
pub(crate) struct LaneBlock<'a, const D: usize> {
    of: &'a [Lanes],
    lane: usize,
}

impl<'a, const D: usize> NodeBlocks<'a, D> {
    /// The block of row node v and column node w, where it stands.
    #[inline(always)]
    pub fn lane(&self, v: usize, w: usize) -> LaneBlock<'a, D> {
        LaneBlock { of: &self.blocks[(w * self.packs + v / LANES) * D * D..][..D * D], lane: v % LANES }
    }

    /// The same block.
    #[inline(always)]
    pub fn block(&self, v: usize, w: usize) -> Block<D> {
        let LaneBlock { of, lane } = self.lane(v, w);
        Block::from_fn(|i, j| of[j * D + i].0[lane])
    }
}

impl<const D: usize> LaneBlock<'_, D> {
    /// The numbers of column j.
    #[inline(always)]
    pub fn column(&self, j: usize) -> impl Iterator<Item = f64> {
        self.of[j * D..(j + 1) * D].iter().map(|lanes| lanes.0[self.lane])
    }
}

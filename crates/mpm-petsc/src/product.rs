//! Galerkin products of ranks, `Pᵀ A P`.
//!
//! A rank multiplies its own rows of A, and what falls into rows of other ranks is sent to them and added in the order of the
//! ranks, as the parts of the finest matrix are: the same bits every time, on any number of ranks.

use crate::assembly::Assembly;
use crate::blocks::Blocks;
use crate::error::PetscError;
use crate::handles::Mat;
use crate::rows::{Parts, Rows};
use mpm_cluster::Wire;

/// Part of a node's value that is interpolated from a coarse node, or of what a coarse node gathers from a fine one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Weight {
    /// The coarse node, or the fine one.
    pub(crate) node: u32,
    /// Bit i says that component i is interpolated.
    pub(crate) components: u8,
    pub(crate) weight: f64,
}

/// Weights of nodes, one after the other.
#[derive(Debug)]
pub(crate) struct Weights {
    start: Vec<usize>,
    entry: Vec<Weight>,
}

impl Weights {
    pub(crate) fn new() -> Self {
        Self { start: vec![0], entry: Vec::new() }
    }

    /// Adds one for the node at hand.
    pub(crate) fn push(&mut self, weight: Weight) {
        self.entry.push(weight);
    }

    /// Goes on with the next node.
    pub(crate) fn end(&mut self) {
        self.start.push(self.entry.len());
    }

    /// How many nodes have weights.
    fn len(&self) -> usize {
        self.start.len() - 1
    }

    pub(crate) fn of(&self, node: usize) -> &[Weight] {
        &self.entry[self.start[node]..self.start[node + 1]]
    }

    /// Of each of `n` coarse nodes those of the first `fine` ones that have it for a parent.
    pub(crate) fn transposed(&self, fine: usize, n: usize) -> Self {
        let mut start = vec![0; n + 1];
        let entries = &self.entry[..self.start[fine]];
        entries.iter().for_each(|it| start[it.node as usize + 1] += 1);
        (0..n).for_each(|node| start[node + 1] += start[node]);
        let mut next = start.clone();
        let mut entry = vec![Weight { node: 0, components: 0, weight: 0.0 }; entries.len()];
        for node in 0..fine {
            for it in self.of(node) {
                let place = &mut next[it.node as usize];
                entry[*place] = Weight { node: node as u32, ..*it };
                *place += 1;
            }
        }
        Self { start, entry }
    }
}

/// How the coarse matrix comes from a matrix of one structure.
pub(crate) struct Product {
    /// Of each node that has a column: own ones first, then those of other ranks.
    parents: Weights,
    children: Weights,
    /// What this rank has of each coarse node's row.
    blocks: Blocks,
    assembly: Assembly,
}

impl Product {
    /// Of the matrix's rows on this rank and the parents of its columns among `n` coarse nodes.
    pub(crate) fn blocks(
        parts: &Parts<'_>,
        block: usize,
        (parents, children): (&Weights, &Weights),
        n: usize,
    ) -> Blocks {
        let own = parts.own.rows() / block;
        // Children have many neighbours in common.
        let mut seen_by = vec![u32::MAX; parents.len()];
        Blocks::by_rows(n, |coarse, see| {
            for child in children.of(coarse) {
                let child = child.node as usize;
                let others = parts.others.iter().flat_map(|it| it.nodes(child, block).map(|node| own + node));
                for node in parts.own.nodes(child, block).chain(others) {
                    if std::mem::replace(&mut seen_by[node], coarse as u32) != coarse as u32 {
                        parents.of(node).iter().for_each(|it| see(it.node));
                    }
                }
            }
        })
    }

    pub(crate) fn of((parents, children): (Weights, Weights), blocks: Blocks, assembly: Assembly) -> Self {
        Self { parents, children, blocks, assembly }
    }

    /// Writes the product with the matrix whose rows are these into the coarse matrix.
    pub(crate) fn take<const D: usize>(
        &self,
        wire: &dyn Wire,
        parts: &Parts<'_>,
        coarse: &Mat,
    ) -> Result<(), PetscError> {
        let n = self.blocks.start.len() - 1;
        let mut gathered = Gathered::<D>::new(parts.own.rows() / D, self.parents.len());
        // Where the blocks of a coarse row stand.
        let mut place = vec![0; n];
        let mut product: Vec<[[f64; D]; D]> = Vec::new();
        self.assembly.take_blocks(wire, coarse, |put| {
            for row in 0..n {
                let columns = self.blocks.row(row);
                columns.iter().enumerate().for_each(|(k, &node)| place[node as usize] = k);
                product.clear();
                product.resize(columns.len(), [[0.0; D]; D]);
                self.children.of(row).iter().for_each(|child| gathered.add(parts, child));
                for (node, sum) in gathered.sums() {
                    for to in self.parents.of(node) {
                        let block = &mut product[place[to.node as usize]];
                        add(block, |p, q| sum[p][q], (to.weight, u8::MAX, to.components));
                    }
                }
                gathered.clear();
                product.iter().for_each(&mut *put);
            }
        })
    }
}

/// A sum of rows: blocks by the nodes of their columns, in the order in which these came.
struct Gathered<const D: usize> {
    own: usize,
    /// Where the block of a column is, if it has one.
    slot: Vec<u32>,
    node: Vec<u32>,
    sum: Vec<[[f64; D]; D]>,
}

impl<const D: usize> Gathered<D> {
    /// Of rows whose columns are these own nodes and so many in all.
    fn new(own: usize, columns: usize) -> Self {
        Self { own, slot: vec![u32::MAX; columns], node: Vec::new(), sum: Vec::new() }
    }

    /// Adds a row times its weight.
    fn add(&mut self, parts: &Parts<'_>, row: &Weight) {
        self.add_rows(&parts.own, 0, row);
        if let Some(others) = &parts.others {
            self.add_rows(others, self.own, row);
        }
    }

    fn add_rows(&mut self, rows: &Rows<'_>, first: usize, row: &Weight) {
        for (node, values) in rows.blocks::<D>(row.node as usize) {
            let node = first + node;
            let slot = &mut self.slot[node];
            if *slot == u32::MAX {
                *slot = self.node.len() as u32;
                self.node.push(node as u32);
                self.sum.push([[0.0; D]; D]);
            }
            let sum = &mut self.sum[*slot as usize];
            add(sum, |p, q| values[p][q], (row.weight, row.components, u8::MAX));
        }
    }

    fn sums(&self) -> impl Iterator<Item = (usize, &[[f64; D]; D])> {
        self.node.iter().map(|&node| node as usize).zip(&self.sum)
    }

    fn clear(&mut self) {
        self.node.iter().for_each(|&node| self.slot[node as usize] = u32::MAX);
        self.node.clear();
        self.sum.clear();
    }
}

/// `to += weight · values` in the rows and columns whose bits are set.
#[inline(always)]
fn add<const D: usize>(
    to: &mut [[f64; D]; D],
    values: impl Fn(usize, usize) -> f64,
    (weight, rows, columns): (f64, u8, u8),
) {
    let all = (1_u8 << D) - 1;
    if rows & columns & all == all {
        for (p, to) in to.iter_mut().enumerate() {
            to.iter_mut().enumerate().for_each(|(q, to)| *to += weight * values(p, q));
        }
        return;
    }
    for p in (0..D).filter(|p| rows & (1 << p) != 0) {
        (0..D).filter(|q| columns & (1 << q) != 0).for_each(|q| to[p][q] += weight * values(p, q));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three nodes of one equation each; the coarse nodes stand at the outer ones.
    #[test]
    fn blocks_and_sums_are_those_of_the_product() {
        let (start, column) = ([0, 2, 5, 7], [0, 1, 0, 1, 2, 1, 2]);
        let value = [2.0, -1.0, -1.0, 2.0, -1.0, -1.0, 2.0];
        let parts = Parts { own: Rows { start: &start, column: &column, value: &value }, others: None };
        let mut parents = Weights::new();
        for of_node in [&[(0, 1.0)][..], &[(0, 0.5), (1, 0.5)], &[(1, 1.0)]] {
            of_node.iter().for_each(|&(node, weight)| parents.push(Weight { node, components: 1, weight }));
            parents.end();
        }
        let children = parents.transposed(3, 2);
        assert_eq!(children.of(1).iter().map(|it| it.node).collect::<Vec<_>>(), [1, 2]);
        let blocks = Product::blocks(&parts, 1, (&parents, &children), 2);
        assert_eq!((blocks.row(0), blocks.row(1)), (&[0, 1][..], &[0, 1][..]));
        let mut gathered = Gathered::<1>::new(3, 3);
        children.of(0).iter().for_each(|child| gathered.add(&parts, child));
        let mut sums: Vec<(usize, f64)> = gathered.sums().map(|(node, sum)| (node, sum[0][0])).collect();
        sums.sort_by_key(|it| it.0);
        // The first row and half of the second.
        assert_eq!(sums, [(0, 1.5), (1, 0.0), (2, -0.5)]);
        gathered.clear();
        assert_eq!(gathered.sums().count(), 0);
    }

    #[test]
    fn components_that_are_not_interpolated_are_left_out() {
        let mut to = [[0.0; 2]; 2];
        add(&mut to, |p, q| 1.0 + (2 * p + q) as f64, (2.0, 0b01, u8::MAX));
        assert_eq!(to, [[2.0, 4.0], [0.0, 0.0]]);
        add(&mut to, |_, _| 1.0, (1.0, u8::MAX, 0b10));
        assert_eq!(to, [[2.0, 5.0], [0.0, 1.0]]);
    }
}

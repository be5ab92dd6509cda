//! The nodes of a rank in a load step: whose they are, their numbers among those of all ranks, and who shares them.

use mpm_grid::NodeId;
use std::rc::Rc;

/// Nodes that this rank has in common with one other, by their numbers here.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Common {
    /// The other rank.
    pub rank: usize,
    /// Numbers of the nodes on this rank, ascending.
    pub nodes: Vec<u32>,
}

/// The active nodes of a rank.
///
/// A rank has the nodes that its points influence and those that it owns. Nodes of all ranks are numbered rank by rank, the
/// nodes of an owner in ascending order of [`NodeId`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Numbering {
    /// The nodes, ascending.
    pub nodes: Vec<NodeId>,
    /// Their lattice indices, 0 in directions that do not exist.
    pub index: Vec<[u32; 3]>,
    /// Whether this rank owns them.
    pub owned: Rc<[bool]>,
    /// Their numbers among the nodes of all ranks.
    pub global: Vec<u64>,
    /// Number of the first node that this rank owns.
    pub first: u64,
    /// Nodes that this rank owns.
    pub n_owned: usize,
    /// Nodes of all ranks.
    pub n_all: u64,
    /// What this rank has of other ranks' nodes, in the order of the ranks.
    pub of_owner: Vec<Common>,
    /// What other ranks have of this rank's nodes, in the order of the ranks.
    pub of_sharer: Vec<Common>,
}

impl Numbering {
    /// Number on this rank of a node of all ranks, if this rank has it.
    pub fn local(&self, global: u64) -> Option<usize> {
        if (self.first..self.first + self.n_owned as u64).contains(&global) {
            // Own nodes ascend in both numbers.
            let nth = (global - self.first) as usize;
            return (0..self.nodes.len()).filter(|&v| self.owned[v]).nth(nth);
        }
        self.global.iter().position(|&it| it == global)
    }

    /// Nodes that this rank shares with others.
    pub fn n_shared(&self) -> usize {
        let mut shared: Vec<u32> = self
            .of_owner
            .iter()
            .chain(&self.of_sharer)
            .flat_map(|common| common.nodes.iter().copied())
            .collect();
        shared.sort_unstable();
        shared.dedup();
        shared.len()
    }
}

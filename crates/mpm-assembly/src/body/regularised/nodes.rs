//! The nodes on which the nodal field lives: those that points of regularised bodies influence.

use crate::unknowns::{Block, CoupledPlaces, UnknownId, Unknowns};
use mpm_basis::Connectivity;

/// The nodes of the nodal field in a load step, one unknown each, ascending with the active nodes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FieldNodes {
    /// How many of them come before each active node; all of them at the end.
    before: Vec<u32>,
    block: Block,
}

/// Of every active node 1 where points of these bodies influence it, else 0.
pub fn reached<const D: usize>(bodies: &[&Connectivity<D>], n_nodes: usize) -> Vec<f64> {
    let mut reached = vec![0.0; n_nodes];
    for connectivity in bodies {
        for set in 0..connectivity.n_node_sets() {
            connectivity.node_set(set).iter().for_each(|&node| reached[node as usize] = 1.0);
        }
    }
    reached
}

impl FieldNodes {
    /// Those of some regularised bodies. Their unknowns are the first that belong to no node's displacement.
    ///
    /// # Panics
    /// If there are other such unknowns already.
    pub fn of<const D: usize>(bodies: &[&Connectivity<D>], unknowns: &mut Unknowns<D>) -> Self {
        Self::where_reached(&reached(bodies, unknowns.n_nodes()), unknowns)
    }

    /// Those active nodes that are [reached] so often: where several ranks share the bodies, by the points of any rank.
    ///
    /// # Panics
    /// As [`Self::of`].
    pub fn where_reached<const D: usize>(reached: &[f64], unknowns: &mut Unknowns<D>) -> Self {
        assert_eq!(unknowns.n_own(), 0, "the nodal field comes before the unknowns of contributions");
        let mut before = Vec::with_capacity(reached.len() + 1);
        let mut count = 0;
        before.push(count);
        for &times in reached {
            count += u32::from(times > 0.0);
            before.push(count);
        }
        Self { before, block: unknowns.push(count as usize, 1) }
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.entry(self.before.len() - 1)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// How many come before an active node: its own number among them, if it is one.
    #[inline]
    pub fn entry(&self, node: usize) -> usize {
        self.before[node] as usize
    }

    /// The active nodes, in order.
    pub fn active(&self) -> impl Iterator<Item = usize> {
        (0..self.before.len() - 1).filter(|&node| self.before[node] < self.before[node + 1])
    }

    /// The unknown of a node, by its number among the nodes of the field.
    pub(crate) fn unknown(&self, entry: usize) -> UnknownId {
        self.block.unknown(entry, 0)
    }

    /// The field among the unknowns that belong to no node's displacement `[-]`.
    pub fn values<'a>(&self, own: &'a [f64]) -> &'a [f64] {
        self.block.of(own)
    }

    /// What a body couples: the displacements and the field of the nodes that its points share.
    pub fn couplings<const D: usize>(&self, connectivity: &Connectivity<D>) -> CoupledPlaces {
        let mut places = CoupledPlaces::default();
        for set in 0..connectivity.n_node_sets() {
            let nodes = connectivity.node_set(set);
            let field = nodes.iter().map(|&node| self.block.place(self.entry(node as usize)));
            places.push(nodes.iter().copied().chain(field));
        }
        places
    }
}

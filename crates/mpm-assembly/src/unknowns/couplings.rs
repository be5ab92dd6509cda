//! Sets of places (nodes, for bodies) that couple all with all: what the pattern, the strips, and the scatter are made
//! from.

use super::Place;
use mpm_basis::Connectivity;

/// Sets of places that the tangent couples, all with all.
pub trait Couplings: Send + Sync {
    /// Number of sets.
    fn n_sets(&self) -> usize;

    /// Places of a set, ascending; of a node that is its active number.
    fn set(&self, set: usize) -> &[u32];
}

/// Sets of places, one after the other.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CoupledPlaces {
    places: Vec<Place>,
    /// End of every set.
    end: Vec<usize>,
}

impl CoupledPlaces {
    /// Adds a set; its places may come in any order.
    pub fn push(&mut self, places: impl IntoIterator<Item = Place>) {
        let first = self.places.len();
        self.places.extend(places);
        self.places[first..].sort_unstable();
        self.end.push(self.places.len());
    }
}

impl Couplings for CoupledPlaces {
    fn n_sets(&self) -> usize {
        self.end.len()
    }

    fn set(&self, set: usize) -> &[Place] {
        let first = set.checked_sub(1).map_or(0, |before| self.end[before]);
        &self.places[first..self.end[set]]
    }
}

/// Node sets: points couple the nodes that they share.
impl<const D: usize> Couplings for Connectivity<D> {
    #[inline]
    fn n_sets(&self) -> usize {
        self.n_node_sets()
    }

    #[inline]
    fn set(&self, set: usize) -> &[u32] {
        self.node_set(set)
    }
}

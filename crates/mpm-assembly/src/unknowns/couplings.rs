//! Sets of places (nodes, for bodies) that couple all with all: what the pattern, the strips, and the scatter are made
//! from.

use super::Place;
use crate::body::Dilatation;
use mpm_basis::Links;

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

/// Supports: points couple the nodes that they share.
impl<const D: usize> Couplings for Links<D> {
    #[inline]
    fn n_sets(&self) -> usize {
        self.n_supports()
    }

    #[inline]
    fn set(&self, set: usize) -> &[u32] {
        self.support_nodes(set)
    }
}

/// A body's links, with the cells that couple its points where it has mean dilatation.
#[derive(Clone, Debug)]
pub struct Linked<const D: usize> {
    /// Groups of points and their influences.
    pub links: Links<D>,
    /// Cells over which volume changes are averaged, where they are.
    pub dilatation: Option<Dilatation<D>>,
}

impl<const D: usize> From<Links<D>> for Linked<D> {
    fn from(links: Links<D>) -> Self {
        Self { links, dilatation: None }
    }
}

impl<const D: usize> Linked<D> {
    /// Number of points behind a set.
    pub(crate) fn n_points(&self, set: usize) -> usize {
        match &self.dilatation {
            None => {
                let groups = self.links.support_groups(set).iter();
                groups.map(|&group| self.links.group_points(group as usize).len()).sum()
            }
            Some(dilatation) => dilatation.cells().n_points(set),
        }
    }
}

/// Supports of points, or cells where these couple their points.
impl<const D: usize> Couplings for Linked<D> {
    #[inline]
    fn n_sets(&self) -> usize {
        self.dilatation.as_ref().map_or_else(|| self.links.n_supports(), |it| it.cells().len())
    }

    #[inline]
    fn set(&self, set: usize) -> &[u32] {
        match &self.dilatation {
            None => self.links.support_nodes(set),
            Some(dilatation) => dilatation.cells().nodes(set),
        }
    }
}

//! What couples a body's points: the nodes that they share, or the cells over which volume changes are averaged.

use super::dilatation::Dilatation;
use crate::unknowns::Couplings;
use mpm_basis::Connectivity;

/// A body's connectivity, with the cells that couple its points where it has mean dilatation.
#[derive(Clone, Debug)]
pub struct BodyConnectivity<const D: usize> {
    /// Groups of points and their influences.
    pub connectivity: Connectivity<D>,
    /// Cells over which volume changes are averaged, where they are.
    pub dilatation: Option<Dilatation<D>>,
}

impl<const D: usize> From<Connectivity<D>> for BodyConnectivity<D> {
    fn from(connectivity: Connectivity<D>) -> Self {
        Self { connectivity, dilatation: None }
    }
}

impl<const D: usize> BodyConnectivity<D> {
    /// Number of points behind a set.
    pub(crate) fn n_points(&self, set: usize) -> usize {
        match &self.dilatation {
            None => {
                let groups = self.connectivity.node_set_groups(set).iter();
                groups.map(|&group| self.connectivity.group_points(group as usize).len()).sum()
            }
            Some(dilatation) => dilatation.cells().n_points(set),
        }
    }
}

/// Node sets of points, or cells where these couple their points.
impl<const D: usize> Couplings for BodyConnectivity<D> {
    #[inline]
    fn n_sets(&self) -> usize {
        self.dilatation.as_ref().map_or_else(|| self.connectivity.n_node_sets(), |it| it.cells().len())
    }

    #[inline]
    fn set(&self, set: usize) -> &[u32] {
        match &self.dilatation {
            None => self.connectivity.node_set(set),
            Some(dilatation) => dilatation.cells().nodes(set),
        }
    }
}

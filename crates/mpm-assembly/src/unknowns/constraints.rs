//! Prescribed components of nodal displacement.
//!
//! Unknowns that belong to no node's displacement are never prescribed: a contribution that wants one of its own to stay
//! gives it stiffness and no force.

use super::Unknowns;
use mpm_grid::Vector;

/// Which components of which active nodes are prescribed in a load step, and their increments.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraints<const D: usize> {
    /// Bit i is set where component i is prescribed.
    mask: Vec<u8>,
    /// Prescribed increments, zero elsewhere `[L]`.
    increment: Vec<Vector<D>>,
    driven: bool,
}

impl<const D: usize> Constraints<D> {
    /// Nothing prescribed on `n_active` nodes.
    pub fn none(n_active: usize) -> Self {
        Self { mask: vec![0; n_active], increment: vec![Vector::zeros(); n_active], driven: false }
    }

    /// Prescribes one component of one active node; a later call replaces an earlier one.
    pub fn prescribe(&mut self, node: usize, component: usize, increment: f64) {
        assert!(component < D, "component {component} in {D} dimensions");
        self.mask[node] |= 1 << component;
        self.increment[node][component] = increment;
        self.driven |= increment != 0.0;
    }

    /// Whether a component is prescribed.
    #[inline]
    pub fn is_prescribed(&self, node: usize, component: usize) -> bool {
        self.mask[node] & (1 << component) != 0
    }

    /// Whether the unknown of an equation is prescribed.
    pub fn is_held(&self, unknowns: &Unknowns<D>, equation: usize) -> bool {
        unknowns.node_of(equation).is_some_and(|(node, component)| self.is_prescribed(node, component))
    }

    /// Bits of the prescribed components of a node.
    #[inline]
    pub(crate) fn mask(&self, node: usize) -> u8 {
        self.mask[node]
    }

    /// Prescribed increments, zero where nothing is prescribed `[L]`.
    pub fn increment(&self) -> &[Vector<D>] {
        &self.increment
    }

    /// Whether any increment differs from zero.
    pub fn is_driven(&self) -> bool {
        self.driven
    }

    /// Number of active nodes.
    pub fn n_nodes(&self) -> usize {
        self.mask.len()
    }

    /// Number of components that are not prescribed.
    pub fn n_free(&self) -> usize {
        self.mask.iter().map(|mask| D - mask.count_ones() as usize).sum()
    }

    /// `values` with every prescribed component set to zero.
    pub fn free_part(&self, values: &mut [Vector<D>]) {
        for (value, mask) in values.iter_mut().zip(&self.mask) {
            for i in 0..D {
                if mask & (1 << i) != 0 {
                    value[i] = 0.0;
                }
            }
        }
    }
}

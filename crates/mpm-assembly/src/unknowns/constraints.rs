//! Prescribed components of nodal displacement.
//!
//! Unknowns that belong to no node's displacement are never prescribed: a contribution that wants one of its own to stay
//! gives it stiffness and no force.

use super::Unknowns;
use mpm_grid::Vector;

/// Bit of a node on the axis of a body of revolution.
const ON_AXIS: u8 = 1 << 7;

/// Which components of which active nodes are prescribed in a load step, and their increments.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraints<const D: usize> {
    /// Bit i is set where component i is prescribed, and the last where the node lies on an axis.
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

    /// Holds the radial component, the first, of a node on the axis of a body of revolution.
    ///
    /// The hoop stiffness of that component grows as the nearest point comes closer to the axis: on the diagonal of the
    /// tangent it is replaced by the stiffness along the axis, so that the scale of the pivots is that of the problem.
    pub fn hold_on_axis(&mut self, node: usize) {
        self.prescribe(node, 0, 0.0);
        self.mask[node] |= ON_AXIS;
    }

    /// Whether a node is held on the axis.
    pub(crate) fn is_on_axis(&self, node: usize) -> bool {
        self.mask[node] & ON_AXIS != 0
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

    /// Bits of the prescribed components of a node; 0 where there are none.
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
        self.mask.iter().map(|mask| D - (mask & !ON_AXIS).count_ones() as usize).sum()
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

//! The influence of one material point on one node, and the list of them that a basis fills.

use mpm_grid::{NodeId, Vector};

/// How one material point influences one node: `S_vp` and its gradient with respect to
/// start-of-step positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Influence<const D: usize> {
    /// The node v.
    pub node: NodeId,
    /// `S_vp` `[-]`.
    pub value: f64,
    /// `∂S_vp/∂X̃` `[1/L]`.
    pub gradient: Vector<D>,
}

/// All influences of one point, ascending in node once [`Stencil::finish`] has run.
#[derive(Clone, Debug, Default)]
pub struct Stencil<const D: usize> {
    entries: Vec<Influence<D>>,
}

impl<const D: usize> Stencil<D> {
    /// An empty stencil.
    pub fn new() -> Self {
        Self { entries: Vec::new() }
    }

    /// Forgets all influences and keeps the memory.
    pub fn clear(&mut self) {
        self.entries.clear();
    }

    /// Adds to the influence on `node`; several additions to one node are summed by `finish`.
    #[inline]
    pub fn add(&mut self, node: NodeId, value: f64, gradient: Vector<D>) {
        self.entries.push(Influence { node, value, gradient });
    }

    /// Adds to the influence that was the `at`-th to be added.
    #[inline]
    pub(crate) fn add_to(&mut self, at: usize, value: f64, gradient: Vector<D>) {
        let entry = &mut self.entries[at];
        entry.value += value;
        entry.gradient += gradient;
    }

    /// Drops influences that are exactly zero: nodes opposite to the grid line that a corner of a
    /// domain lies on.
    #[inline]
    pub(crate) fn drop_zeros(&mut self) {
        self.entries.retain(|it| it.value != 0.0 || it.gradient != Vector::<D>::zeros());
    }

    /// Sorts by node and sums the additions to each node in the order they were made.
    #[inline]
    pub fn finish(&mut self) {
        // The nodes of a cell come in order, each once.
        if self.entries.windows(2).all(|pair| pair[0].node < pair[1].node) {
            return;
        }
        // Insertion sort: stable, and quickest for the few nearly sorted entries of a point.
        for end in 1..self.entries.len() {
            let entry = self.entries[end];
            let mut at = end;
            while at > 0 && self.entries[at - 1].node > entry.node {
                self.entries[at] = self.entries[at - 1];
                at -= 1;
            }
            self.entries[at] = entry;
        }
        self.entries.dedup_by(|next, kept| {
            let same = next.node == kept.node;
            if same {
                kept.value += next.value;
                kept.gradient += next.gradient;
            }
            same
        });
    }

    /// The influences.
    pub fn entries(&self) -> &[Influence<D>] {
        &self.entries
    }
}

//! Who owns which node.

/// Which rank owns a node.
pub trait Owners {
    /// The owner of the node at these lattice lines.
    fn owner(&self, node: [u32; 3]) -> usize;
}

impl<F: Fn([u32; 3]) -> usize> Owners for F {
    fn owner(&self, node: [u32; 3]) -> usize {
        self(node)
    }
}

//! What a linear solver is told of a system.

/// The nodes of a system: where they stand, which serves order and coarsening.
#[derive(Clone, Copy, Debug)]
pub struct Place<'a> {
    /// Lattice index of each node.
    pub index: &'a [[u32; 3]],
    /// Coordinates of the lattice lines in each direction `[L]`.
    pub lines: &'a [Vec<f64>; 3],
    /// Number of lines of each direction that closes on itself.
    pub periodic: [Option<u32>; 3],
}

//! Sparse matrices as the solvers take them.

/// Whether a matrix equals its transpose, and with that which of its entries are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Symmetry {
    /// K = Kᵀ. The lower triangle is stored; the diagonal, always present, is the first entry of each column.
    Symmetric,
    /// K ≠ Kᵀ in general. Both triangles are stored; the diagonal, always present, stands among the rows of its column.
    Unsymmetric,
}

/// Lower triangle of a symmetric sparse matrix by columns.
///
/// Rows ascend within a column and the diagonal, always present, is the first. Column j holds
/// entries `column_start[j]..column_start[j + 1]`; there are n + 1 column starts.
#[derive(Clone, Copy, Debug)]
pub struct SymmetricPattern<'a> {
    /// Where each column starts in `row`, and the number of entries at the end; n + 1 numbers.
    pub column_start: &'a [usize],
    /// Row of each entry.
    pub row: &'a [usize],
}

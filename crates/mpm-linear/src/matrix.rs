//! Sparse matrices as the solvers take them.

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

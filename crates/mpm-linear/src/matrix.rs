//! Sparse matrices as the solvers take them: a pattern, and values that are borrowed.

use rayon::prelude::*;

/// Nodes that are worth a task.
const FEW_NODES: usize = 4096;

/// Whether a matrix equals its transpose, and with that which of its entries are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Symmetry {
    /// K = Kᵀ. The lower triangle is stored; the diagonal, always present, is the first entry of each column.
    Symmetric,
    /// K ≠ Kᵀ in general. Both triangles are stored; the diagonal, always present, stands among the rows of its column.
    Unsymmetric,
}

/// Where the entries of a sparse n × n matrix stand, by columns.
///
/// Rows ascend within a column. Column j holds the entries `column_start[j]..column_start[j + 1]`.
///
/// The first `block · blocks` equations belong to nodes: node v has the equations `block · v` to
/// `block · v + block − 1`, which couple with the same equations of other nodes. The remaining
/// equations belong to no node.
#[derive(Clone, Copy, Debug)]
pub struct Pattern<'a> {
    /// Where each column starts in `row`, and the number of entries at the end; n + 1 numbers.
    pub column_start: &'a [usize],
    /// Row of each entry.
    pub row: &'a [usize],
    /// Which triangles are stored.
    pub symmetry: Symmetry,
    /// Equations of each node.
    pub block: usize,
    /// Number of nodes.
    pub blocks: usize,
}

impl<'a> Pattern<'a> {
    /// Lower triangle of a symmetric matrix with `block` equations for each node and no others.
    ///
    /// # Panics
    /// If the number of equations is no multiple of `block`.
    pub fn symmetric(column_start: &'a [usize], row: &'a [usize], block: usize) -> Self {
        Self::of_nodes(column_start, row, Symmetry::Symmetric, block)
    }

    /// Both triangles of a matrix with `block` equations for each node and no others.
    ///
    /// # Panics
    /// If the number of equations is no multiple of `block`.
    pub fn unsymmetric(column_start: &'a [usize], row: &'a [usize], block: usize) -> Self {
        Self::of_nodes(column_start, row, Symmetry::Unsymmetric, block)
    }

    fn of_nodes(column_start: &'a [usize], row: &'a [usize], symmetry: Symmetry, block: usize) -> Self {
        let n = column_start.len() - 1;
        assert!(n.is_multiple_of(block), "{n} equations are not {block} for each node");
        Self { column_start, row, symmetry, block, blocks: n / block }
    }

    /// Number of equations n.
    pub fn n_equations(&self) -> usize {
        self.column_start.len() - 1
    }

    /// Number of stored entries.
    pub fn n_entries(&self) -> usize {
        self.row.len()
    }

    /// Rows of the entries of a column.
    pub(crate) fn rows_of(&self, column: usize) -> &'a [usize] {
        &self.row[self.column_start[column]..self.column_start[column + 1]]
    }

    /// Whether only the lower triangle is stored.
    pub fn is_symmetric(&self) -> bool {
        self.symmetry == Symmetry::Symmetric
    }

    /// Whether every equation belongs to a node.
    pub fn has_blocks_only(&self) -> bool {
        self.block * self.blocks == self.n_equations()
    }

    /// Whether every equation belongs to a node, and all equations of a node couple with all of its neighbours'.
    pub fn has_whole_blocks(&self) -> bool {
        let block = self.block;
        let is_whole = |rows: &[usize]| {
            rows[0].is_multiple_of(block) && rows.windows(2).all(|pair| pair[1] == pair[0] + 1)
        };
        let has_whole = |node: usize| {
            let first = self.rows_of(node * block);
            // Columns of a symmetric matrix begin at the diagonal.
            let lacking = |j: usize| if self.is_symmetric() { j } else { 0 };
            first.len().is_multiple_of(block)
                && first.chunks_exact(block).all(is_whole)
                && (1..block).all(|j| self.rows_of(node * block + j) == &first[lacking(j)..])
        };
        self.has_blocks_only()
            && if self.blocks < FEW_NODES {
                (0..self.blocks).all(has_whole)
            } else {
                (0..self.blocks).into_par_iter().with_min_len(FEW_NODES).all(has_whole)
            }
    }

    /// Refuses what the fields cannot mean.
    ///
    /// # Panics
    /// If the fields are not as their documentation says.
    pub(crate) fn check(&self) {
        let Self { column_start, row, .. } = *self;
        assert_eq!(column_start.last(), Some(&row.len()), "column starts end with the number of entries");
        assert!(self.block * self.blocks <= self.n_equations(), "more equations of nodes than equations");
        let has_diagonal = column_start.windows(2).enumerate().all(|(j, s)| match self.symmetry {
            Symmetry::Symmetric => s[0] < s[1] && row[s[0]] == j,
            Symmetry::Unsymmetric => s[0] <= s[1] && row[s[0]..s[1]].binary_search(&j).is_ok(),
        });
        assert!(has_diagonal, "every column has its diagonal, of a symmetric matrix as its first entry");
    }
}

/// A sparse matrix K.
#[derive(Clone, Copy, Debug)]
pub struct Matrix<'a> {
    /// Where its entries stand.
    pub pattern: Pattern<'a>,
    /// Value of each entry.
    pub values: &'a [f64],
}

impl Matrix<'_> {
    /// The column of the first entry that is not a finite number; none where all of them are finite.
    pub fn first_not_finite(&self) -> Option<usize> {
        let entry = self.values.iter().position(|value| !value.is_finite())?;
        Some(self.pattern.column_start.partition_point(|&start| start <= entry) - 1)
    }

    /// The diagonal entry of an equation, in units of K.
    ///
    /// # Panics
    /// If there is no such equation.
    pub fn diagonal(&self, equation: usize) -> f64 {
        let (start, end) = (self.pattern.column_start[equation], self.pattern.column_start[equation + 1]);
        let before = match self.pattern.symmetry {
            Symmetry::Symmetric => 0,
            Symmetry::Unsymmetric => self.pattern.row[start..end].partition_point(|&row| row < equation),
        };
        self.values[start + before]
    }

    /// Size of the largest entry that is stored for a column.
    pub(crate) fn largest_of_column(&self, column: usize) -> f64 {
        let entries = self.pattern.column_start[column]..self.pattern.column_start[column + 1];
        self.values[entries].iter().fold(0.0, |largest, value| largest.max(value.abs()))
    }

    /// K w.
    pub fn times(&self, w: &[f64]) -> Vec<f64> {
        let Pattern { column_start, row, .. } = self.pattern;
        let is_symmetric = self.pattern.is_symmetric();
        let mut image = vec![0.0; w.len()];
        for j in 0..image.len() {
            let entries = column_start[j]..column_start[j + 1];
            for (&i, &k) in row[entries.clone()].iter().zip(&self.values[entries]) {
                image[i] += k * w[j];
                if is_symmetric && i != j {
                    image[j] += k * w[i];
                }
            }
        }
        image
    }

    /// The first equation whose row holds nothing but zeros.
    pub(crate) fn first_empty_row(&self) -> Option<usize> {
        let mut held = vec![false; self.pattern.n_equations()];
        for j in 0..held.len() {
            for entry in self.pattern.column_start[j]..self.pattern.column_start[j + 1] {
                if self.values[entry] != 0.0 {
                    held[self.pattern.row[entry]] = true;
                    held[j] |= self.pattern.is_symmetric();
                }
            }
        }
        held.iter().position(|held| !held)
    }
}

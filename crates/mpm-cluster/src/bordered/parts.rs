//! The parts of a matrix with a border, and the small system of the border.

use mpm_linear::{Pattern, Symmetry};

/// Part of the terms that have made a pivot below which it is their rounding.
const ROUNDING: f64 = 1e-13;

/// Where the entries of a pattern stand: those between nodes, and those of the unknowns behind them.
pub(super) struct Parts {
    symmetry: Symmetry,
    block: usize,
    blocks: usize,
    n_behind: usize,
    /// The pattern of the nodes, and where its entries stand among all.
    column_start: Vec<usize>,
    row: Vec<usize>,
    entry: Vec<usize>,
    /// Rows, columns and places of entries: of C, of B, and in the corner; of a symmetric matrix B is that of C.
    below: Vec<[usize; 3]>,
    right: Vec<[usize; 3]>,
    corner: Vec<[usize; 3]>,
}

impl Parts {
    pub(super) fn of(pattern: Pattern<'_>) -> Self {
        let n = pattern.block * pattern.blocks;
        let mut parts = Self {
            symmetry: pattern.symmetry,
            block: pattern.block,
            blocks: pattern.blocks,
            n_behind: pattern.n_equations() - n,
            column_start: vec![0],
            row: Vec::new(),
            entry: Vec::new(),
            below: Vec::new(),
            right: Vec::new(),
            corner: Vec::new(),
        };
        for column in 0..pattern.n_equations() {
            for entry in pattern.column_start[column]..pattern.column_start[column + 1] {
                let row = pattern.row[entry];
                match (row < n, column < n) {
                    (true, true) => {
                        parts.row.push(row);
                        parts.entry.push(entry);
                    }
                    (false, true) => parts.below.push([row - n, column, entry]),
                    (true, false) => parts.right.push([row, column - n, entry]),
                    (false, false) => parts.corner.push([row - n, column - n, entry]),
                }
            }
            if column < n {
                parts.column_start.push(parts.row.len());
            }
        }
        parts
    }

    fn is_symmetric(&self) -> bool {
        self.symmetry == Symmetry::Symmetric
    }

    /// Equations of nodes.
    pub(super) fn n_of_nodes(&self) -> usize {
        self.block * self.blocks
    }

    /// The pattern of A.
    pub(super) fn of_nodes(&self) -> Pattern<'_> {
        Pattern {
            column_start: &self.column_start,
            row: &self.row,
            symmetry: self.symmetry,
            block: self.block,
            blocks: self.blocks,
        }
    }

    /// The values of A.
    pub(super) fn values_of_nodes(&self, values: &[f64]) -> Vec<f64> {
        self.entry.iter().map(|&entry| values[entry]).collect()
    }

    /// The rows of C, column and value.
    pub(super) fn rows(&self, values: &[f64]) -> Vec<Vec<(usize, f64)>> {
        let mut rows = vec![Vec::new(); self.n_behind];
        self.below.iter().for_each(|&[row, column, entry]| rows[row].push((column, values[entry])));
        rows
    }

    /// The columns of B.
    pub(super) fn columns(&self, values: &[f64]) -> Vec<Vec<f64>> {
        let mut columns = vec![vec![0.0; self.n_of_nodes()]; self.n_behind];
        match self.is_symmetric() {
            true => self.below.iter().for_each(|&[k, node, entry]| columns[k][node] = values[entry]),
            false => self.right.iter().for_each(|&[node, k, entry]| columns[k][node] = values[entry]),
        }
        columns
    }

    /// E, row by row.
    pub(super) fn corner(&self, values: &[f64]) -> Vec<f64> {
        let mut corner = vec![0.0; self.n_behind * self.n_behind];
        for &[row, column, entry] in &self.corner {
            corner[row * self.n_behind + column] = values[entry];
            if self.is_symmetric() {
                corner[column * self.n_behind + row] = values[entry];
            }
        }
        corner
    }
}

/// The system of the unknowns behind those of nodes, by elimination with partial pivoting.
#[derive(Default)]
pub(super) struct Reduced {
    n: usize,
    /// Both factors, row by row.
    rows: Vec<f64>,
    /// Which row was taken for each pivot.
    order: Vec<usize>,
}

impl Reduced {
    /// Of `E - C A⁻¹B`, row by row, where E was `corner`.
    ///
    /// # Errors
    /// The unknown that nothing resists.
    pub(super) fn of(mut rows: Vec<f64>, corner: &[f64]) -> Result<Self, usize> {
        let n = rows.len().isqrt();
        let mut order: Vec<usize> = (0..n).collect();
        for k in 0..n {
            let largest = |i: &usize| rows[i * n + k].abs();
            let pivot = (k..n).max_by(|a, b| largest(a).total_cmp(&largest(b))).unwrap_or(k);
            let size = (0..n).map(|i| corner[i * n + k].abs()).fold(0.0, f64::max);
            // A number that is none is no pivot either.
            let is_pivot = rows[pivot * n + k].abs() > ROUNDING * size;
            if !is_pivot {
                return Err(k);
            }
            order.swap(k, pivot);
            (0..n).for_each(|j| rows.swap(k * n + j, pivot * n + j));
            for i in k + 1..n {
                let factor = rows[i * n + k] / rows[k * n + k];
                rows[i * n + k] = factor;
                (k + 1..n).for_each(|j| rows[i * n + j] -= factor * rows[k * n + j]);
            }
        }
        Ok(Self { n, rows, order })
    }

    pub(super) fn solve(&self, rhs: Vec<f64>) -> Vec<f64> {
        let Self { n, rows, order } = self;
        let mut x: Vec<f64> = order.iter().map(|&row| rhs[row]).collect();
        for i in 0..*n {
            let known: f64 = (0..i).map(|j| rows[i * n + j] * x[j]).sum();
            x[i] -= known;
        }
        for i in (0..*n).rev() {
            let known: f64 = (i + 1..*n).map(|j| rows[i * n + j] * x[j]).sum();
            x[i] = (x[i] - known) / rows[i * n + i];
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_system_is_solved_and_a_singular_one_named() {
        let rows = vec![0.0, 2.0, 1.0, 4.0, 1.0, -2.0, 1.0, 1.0, 3.0];
        let reduced = Reduced::of(rows.clone(), &rows).unwrap();
        let x = [0.5, -1.5, 2.0];
        let rhs = (0..3).map(|i| (0..3).map(|j| rows[3 * i + j] * x[j]).sum()).collect();
        assert!(reduced.solve(rhs).iter().zip(x).all(|(a, b)| (a - b).abs() < 1e-14));
        assert_eq!(Reduced::of(vec![1.0, 0.0, 0.0, 0.0], &[1.0, 0.0, 0.0, 0.0]).err(), Some(1));
        assert_eq!(Reduced::of(vec![f64::NAN], &[1.0]).err(), Some(0));
    }

    #[test]
    fn the_parts_of_a_matrix_with_a_border() {
        // Two nodes of one equation, and one unknown behind them: lower triangle.
        let (column_start, row) = ([0, 3, 5, 6], [0, 1, 2, 1, 2, 2]);
        let symmetry = Symmetry::Symmetric;
        let pattern = Pattern { column_start: &column_start, row: &row, symmetry, block: 1, blocks: 2 };
        let (parts, values) = (Parts::of(pattern), [4.0, 1.0, 2.0, 5.0, 3.0, 9.0]);
        assert_eq!((parts.of_nodes().column_start, parts.of_nodes().row), (&[0, 2, 3][..], &[0, 1, 1][..]));
        assert_eq!(parts.values_of_nodes(&values), [4.0, 1.0, 5.0]);
        assert_eq!(parts.rows(&values), [[(0, 2.0), (1, 3.0)]]);
        assert_eq!((parts.columns(&values), parts.corner(&values)), (vec![vec![2.0, 3.0]], vec![9.0]));
    }
}

//! A symmetric matrix made unsymmetric, as frictional flow that is not associated makes tangents.

use mpm_linear::{Matrix, Pattern, Symmetry};

/// Part of each entry that is added below the diagonal and taken away above it.
const SKEW: f64 = 0.02;

/// Both triangles of a matrix, of which its symmetric part is known.
pub struct Skewed {
    column_start: Vec<usize>,
    row: Vec<usize>,
    values: Vec<f64>,
    block: usize,
    blocks: usize,
}

impl Skewed {
    /// From the lower triangle of the symmetric part.
    pub fn of(lower: Matrix<'_>) -> Self {
        let Pattern { column_start: start, row: lower_row, block, blocks, .. } = lower.pattern;
        let n = lower.pattern.n_equations();
        let mut column_start = vec![0; n + 1];
        for j in 0..n {
            for &i in &lower_row[start[j]..start[j + 1]] {
                column_start[j + 1] += 1;
                column_start[i + 1] += usize::from(i != j);
            }
        }
        for j in 0..n {
            column_start[j + 1] += column_start[j];
        }
        let mut next = column_start.clone();
        let (mut row, mut values) = (vec![0; column_start[n]], vec![0.0; column_start[n]]);
        let mut put = |i: usize, j: usize, value: f64| {
            (row[next[j]], values[next[j]]) = (i, value);
            next[j] += 1;
        };
        // Column by column an entry above the diagonal comes before those below: rows ascend.
        for j in 0..n {
            let entries = start[j]..start[j + 1];
            for (&i, &value) in lower_row[entries.clone()].iter().zip(&lower.values[entries]) {
                if i == j {
                    put(i, j, value);
                } else {
                    put(i, j, (1.0 + SKEW) * value);
                    put(j, i, (1.0 - SKEW) * value);
                }
            }
        }
        Self { column_start, row, values, block, blocks }
    }

    /// The matrix.
    pub fn matrix(&self) -> Matrix<'_> {
        let Self { column_start, row, values, block, blocks } = self;
        let pattern =
            Pattern { column_start, row, symmetry: Symmetry::Unsymmetric, block: *block, blocks: *blocks };
        Matrix { pattern, values }
    }
}

//! Matrices with a further field on the nodes, written with the equations of each node side by side.
//!
//! Node v has D equations, and one behind those of all nodes for the field. Interleaved it has N = D + 1; nodes without the field
//! have zeros there. The equation of the field is scaled by a power of two, so that its diagonal is about as large as those of
//! the others: smoothing does not feel that, but the norm of the residual does.

use super::hierarchy::Multigrid;
use super::outcome::{Converged, Failure};
use crate::matrix::{Matrix, Pattern, Symmetry};
use crate::solver::LatticePlaces;

/// Where an entry that is not stored would stand.
const NOTHING: u32 = u32::MAX;

/// A hierarchy of a matrix with N − 1 equations for each node and a further field on the nodes.
pub(crate) struct Interleaved<const N: usize> {
    column_start: Vec<usize>,
    row: Vec<usize>,
    symmetry: Symmetry,
    /// Where each entry stands among the caller's.
    source: Vec<u32>,
    /// The equation of the field at each node, or [`NOTHING`].
    field: Vec<u32>,
    values: Vec<f64>,
    scale: f64,
    multigrid: Multigrid<N>,
    /// Right-hand side and solution.
    vector: Vec<f64>,
}

impl<const N: usize> Interleaved<N> {
    /// None where the pattern has not N − 1 equations for each node, or some of these do not couple with all of a
    /// neighbour's. `node_of` tells the node of each equation behind those of the nodes.
    pub(crate) fn analyse(
        pattern: Pattern<'_>,
        node_of: impl Fn(usize) -> Option<usize>,
        places: LatticePlaces<'_>,
    ) -> Option<Self> {
        let n = pattern.blocks;
        if pattern.block + 1 != N || pattern.n_entries() >= NOTHING as usize {
            return None;
        }
        let mut field = vec![NOTHING; n];
        for equation in pattern.block * n..pattern.n_equations() {
            field[node_of(equation)?] = u32::try_from(equation).ok()?;
        }
        let (column_start, row) = structure::<N>(pattern);
        let source = sources::<N>(pattern, &field, &column_start, &row);
        let symmetry = pattern.symmetry;
        let interleaved = Pattern { column_start: &column_start, row: &row, symmetry, block: N, blocks: n };
        let multigrid = Multigrid::analyse(interleaved, places)?;
        let values = vec![0.0; row.len()];
        let vector = vec![0.0; n * N];
        Some(Self { column_start, row, symmetry, source, field, values, scale: 1.0, multigrid, vector })
    }

    /// As [`Multigrid::take_as`].
    pub(crate) fn take_as(&mut self, symmetry: Symmetry) {
        self.multigrid.take_as(symmetry);
    }

    /// As [`Multigrid::prepare`].
    pub(crate) fn prepare(&mut self, matrix: Matrix<'_>) -> Result<(), Failure> {
        self.scale = self.scale_of(matrix);
        self.take(matrix, Multigrid::prepare)
    }

    /// As [`Multigrid::update`].
    pub(crate) fn update(&mut self, matrix: Matrix<'_>) -> Result<(), Failure> {
        self.take(matrix, Multigrid::update)
    }

    /// Writes the values side by side and hands them on.
    fn take(
        &mut self,
        matrix: Matrix<'_>,
        to: impl Fn(&mut Multigrid<N>, Matrix<'_>) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let of_field = |equation: usize| {
            if equation % N == N - 1 { self.scale } else { 1.0 }
        };
        for (column, entries) in self.column_start.windows(2).enumerate() {
            for entry in entries[0]..entries[1] {
                let value = match self.source[entry] {
                    NOTHING => 0.0,
                    source => matrix.values[source as usize],
                };
                self.values[entry] = value * of_field(column) * of_field(self.row[entry]);
            }
        }
        let pattern = Pattern {
            column_start: &self.column_start,
            row: &self.row,
            symmetry: self.symmetry,
            block: N,
            blocks: self.field.len(),
        };
        to(&mut self.multigrid, Matrix { pattern, values: &self.values })
    }

    /// As [`Multigrid::solve`].
    pub(crate) fn solve(
        &mut self,
        x: &mut [f64],
        tolerance: f64,
        iterations: u32,
    ) -> Result<Converged, Failure> {
        for (node, equations) in self.vector.chunks_exact_mut(N).enumerate() {
            equations[..N - 1].copy_from_slice(&x[node * (N - 1)..(node + 1) * (N - 1)]);
            equations[N - 1] = match self.field[node] {
                NOTHING => 0.0,
                equation => x[equation as usize] * self.scale,
            };
        }
        let outcome = self.multigrid.solve(&mut self.vector, tolerance, iterations);
        for (node, equations) in self.vector.chunks_exact(N).enumerate() {
            x[node * (N - 1)..(node + 1) * (N - 1)].copy_from_slice(&equations[..N - 1]);
            if self.field[node] != NOTHING {
                x[self.field[node] as usize] = equations[N - 1] * self.scale;
            }
        }
        outcome
    }

    /// A power of two near the root of the mean diagonal of the nodes' equations over that of the field.
    fn scale_of(&self, matrix: Matrix<'_>) -> f64 {
        let n = (N - 1) * self.field.len();
        let mean = |equations: std::ops::Range<usize>| {
            let count = equations.len() as f64;
            equations.map(|equation| matrix.diagonal(equation).abs()).sum::<f64>() / count
        };
        let ratio = (mean(0..n) / mean(n..matrix.pattern.n_equations())).sqrt();
        if ratio.is_normal() { ratio.log2().round().clamp(-500.0, 500.0).exp2() } else { 1.0 }
    }
}

/// Columns and rows of N equations for each node.
fn structure<const N: usize>(pattern: Pattern<'_>) -> (Vec<usize>, Vec<usize>) {
    let n = pattern.blocks;
    let (mut column_start, mut row) = (Vec::with_capacity(n * N + 1), Vec::new());
    column_start.push(0);
    for node in 0..n {
        let rows = pattern.rows_of(node * (N - 1));
        let nodes = rows.iter().take_while(|&&row| row < (N - 1) * n).step_by(N - 1).map(|row| row / (N - 1));
        for j in 0..N {
            let lacking = if pattern.is_symmetric() { j } else { 0 };
            let all = nodes.clone().flat_map(|other| N * other..N * (other + 1));
            row.extend(all.skip(lacking));
            column_start.push(row.len());
        }
    }
    (column_start, row)
}

/// Where each entry stands among the caller's.
fn sources<const N: usize>(
    pattern: Pattern<'_>,
    field: &[u32],
    column_start: &[usize],
    row: &[usize],
) -> Vec<u32> {
    // The equation that the caller knows.
    let equation = |interleaved: usize| match (interleaved / N, interleaved % N) {
        (node, i) if i == N - 1 => (field[node] != NOTHING).then_some(field[node] as usize),
        (node, i) => Some(node * (N - 1) + i),
    };
    let mut source = Vec::with_capacity(row.len());
    for (column, entries) in column_start.windows(2).enumerate() {
        for &row in &row[entries[0]..entries[1]] {
            let found = equation(column).zip(equation(row)).and_then(|(column, row)| {
                // A symmetric matrix stores the lower triangle.
                let is_stored = !pattern.is_symmetric() || row >= column;
                let (column, row) = if is_stored { (column, row) } else { (row, column) };
                let at = pattern.rows_of(column).binary_search(&row).ok()?;
                Some((pattern.column_start[column] + at) as u32)
            });
            source.push(found.unwrap_or(NOTHING));
        }
    }
    source
}

//! LU with partial pivoting of a symmetric matrix that neither LLᵀ nor LBLᵀ can factorise: faer's, on both
//! triangles, in an order (COLAMD) that leaves room for free pivoting.

use crate::matrix::Pattern;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::sparse::linalg::lu::{LuRef, NumericLu, SymbolicLu, factorize_symbolic_lu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par};

/// Both triangles of a pattern by columns.
struct Full {
    column_start: Vec<usize>,
    row: Vec<usize>,
    /// Where each entry stands in the lower triangle.
    source: Vec<usize>,
}

impl Full {
    fn new(lower: Pattern<'_>) -> Self {
        let n = lower.column_start.len() - 1;
        let mut column_start = vec![0; n + 1];
        for j in 0..n {
            for &i in &lower.row[lower.column_start[j]..lower.column_start[j + 1]] {
                column_start[j + 1] += 1;
                if i != j {
                    column_start[i + 1] += 1;
                }
            }
        }
        for j in 0..n {
            column_start[j + 1] += column_start[j];
        }
        let mut next = column_start.clone();
        let mut row = vec![0; column_start[n]];
        let mut source = vec![0; column_start[n]];
        let mut put = |i: usize, j: usize, entry: usize| {
            row[next[j]] = i;
            source[next[j]] = entry;
            next[j] += 1;
        };
        // Column j receives rows i < j while column i is visited, then its own: rows ascend.
        for j in 0..n {
            for entry in lower.column_start[j]..lower.column_start[j + 1] {
                let i = lower.row[entry];
                put(i, j, entry);
                if i != j {
                    put(j, i, entry);
                }
            }
        }
        Self { column_start, row, source }
    }

    fn structure(&self) -> SymbolicSparseColMatRef<'_, usize> {
        let n = self.column_start.len() - 1;
        SymbolicSparseColMatRef::new_checked(n, n, &self.column_start, None, &self.row)
    }
}

/// Analysis and factors of one pattern.
pub(super) struct SymmetricLu {
    full: Full,
    values: Vec<f64>,
    symbolic: SymbolicLu<usize>,
    numeric: NumericLu<usize, f64>,
    scratch: MemBuffer,
}

impl SymmetricLu {
    /// Analyses a pattern; nothing if memory does not suffice.
    pub(super) fn analyse(lower: Pattern<'_>) -> Option<Self> {
        let full = Full::new(lower);
        let symbolic = factorize_symbolic_lu(full.structure(), Default::default()).ok()?;
        let work = StackReq::or(
            symbolic.factorize_numeric_lu_scratch::<f64>(Par::Seq, Default::default()),
            symbolic.solve_in_place_scratch::<f64>(1, Par::Seq),
        );
        let scratch = MemBuffer::try_new(work).ok()?;
        let values = vec![0.0; full.row.len()];
        Some(Self { full, values, symbolic, numeric: NumericLu::new(), scratch })
    }

    /// Factorises the matrix with this lower triangle; nothing if that fails, whatever the reason.
    pub(super) fn factorise(mut self, lower: &[f64]) -> Option<Self> {
        for (value, &entry) in self.values.iter_mut().zip(&self.full.source) {
            *value = lower[entry];
        }
        self.symbolic
            .factorize_numeric_lu(
                &mut self.numeric,
                SparseColMatRef::new(self.full.structure(), &self.values),
                Par::Seq,
                MemStack::new(&mut self.scratch),
                Default::default(),
            )
            .ok()?;
        Some(self)
    }

    /// Replaces b by x.
    pub(super) fn solve(&mut self, x: &mut [f64]) {
        let n = x.len();
        LuRef::new_unchecked(&self.symbolic, &self.numeric).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(x, n, 1),
            Par::Seq,
            MemStack::new(&mut self.scratch),
        );
    }
}

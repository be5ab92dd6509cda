//! LLᵀ and LBLᵀ: faer's supernodal factorisations, with our order, memory and reading of pivots.

use super::pivots::Pivots;
use crate::matrix::{Matrix, Pattern};
use crate::report::{Factored, Method, OutOfMemory, Pivot};
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt::factor::LltError;
use faer::perm::PermRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::supernodal::{SupernodalLltRef, SymbolicSupernodalCholesky};
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, IntranodeLbltRef, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};
use std::hint::black_box;

/// Structure of the factor of a pattern, eliminated in this order (new to old).
pub(super) fn analyse(pattern: Pattern<'_>, order: &[usize]) -> Result<SymbolicCholesky<usize>, OutOfMemory> {
    let n = order.len();
    let mut position = vec![0; n];
    for (k, &equation) in order.iter().enumerate() {
        position[equation] = k;
    }
    let order = SymmetricOrdering::Custom(PermRef::new_checked(order, &position, n));
    factorize_symbolic_cholesky(structure(pattern), Side::Lower, order, symbolic_params())
        .map_err(|_| OutOfMemory { equations: n, factor_entries: 0 })
}

/// Always supernodes: LBLᵀ pivots inside them. faer's rule for merging small ones was the best of
/// those tried.
fn symbolic_params() -> CholeskySymbolicParams<'static> {
    CholeskySymbolicParams {
        supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
        ..Default::default()
    }
}

fn structure(pattern: Pattern<'_>) -> SymbolicSparseColMatRef<'_, usize> {
    let n = pattern.column_start.len() - 1;
    SymbolicSparseColMatRef::new_checked(n, n, pattern.column_start, None, pattern.row)
}

/// Memory that outlives an analysis.
#[derive(Default)]
pub(super) struct Memory {
    factor: Vec<f64>,
    scratch: Option<MemBuffer>,
}

/// Analysis and factor of one pattern.
pub(super) struct Cholesky {
    symbolic: SymbolicCholesky<usize>,
    /// L by supernodes, each a column-major block of its columns and their nonzero rows.
    factor: Vec<f64>,
    scratch: MemBuffer,
    /// Off-diagonal entry of each 2×2 pivot at its first column, else 0 (LBLᵀ only).
    off_diagonal: Vec<f64>,
    /// Order of the pivots within supernodes and its inverse (LBLᵀ only).
    exchange: Vec<usize>,
    exchange_inverse: Vec<usize>,
}

/// Seconds that an operation of a dense factorisation takes here, one thread, by a `clock` that tells
/// processor time `[s]`.
pub fn dense_operation(clock: impl Fn() -> f64) -> f64 {
    const SIZE: usize = 384;
    let matrix = faer::Mat::from_fn(SIZE, SIZE, |i, j| if i == j { SIZE as f64 } else { 0.5 });
    let once = || {
        let start = clock();
        black_box(black_box(&matrix).llt(Side::Lower).is_ok());
        clock() - start
    };
    let shortest = (0..4).map(|_| once()).fold(f64::INFINITY, f64::min);
    shortest / (SIZE.pow(3) as f64 / 3.0)
}

impl Cholesky {
    /// Makes room for the factor and for the work of every method.
    pub(super) fn allocate(symbolic: SymbolicCholesky<usize>, memory: Memory) -> Result<Self, OutOfMemory> {
        let n = symbolic.nrows();
        let entries = symbolic.len_val();
        let error = OutOfMemory { equations: n, factor_entries: entries };
        let Memory { mut factor, scratch } = memory;
        if factor.capacity() < entries {
            // The next pattern will be a little larger or smaller: some room keeps the memory.
            factor = Vec::new();
            factor.try_reserve_exact(entries + entries / 8).map_err(|_| error)?;
        }
        factor.resize(entries, 0.0);

        let work = StackReq::any_of(&[
            symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default()),
            symbolic.factorize_numeric_intranode_lblt_scratch::<f64>(Par::Seq, Default::default()),
            symbolic.solve_in_place_scratch::<f64>(1, Par::Seq),
        ]);
        let bytes = work.unaligned_bytes_required();
        let scratch = match scratch.filter(|kept| kept.len() >= bytes) {
            Some(kept) => kept,
            None => MemBuffer::try_new(StackReq::new::<u8>(bytes + bytes / 8)).map_err(|_| error)?,
        };
        Ok(Self {
            symbolic,
            factor,
            scratch,
            off_diagonal: Vec::new(),
            exchange: Vec::new(),
            exchange_inverse: Vec::new(),
        })
    }

    /// The memory, for the next analysis.
    pub(super) fn into_memory(self) -> Memory {
        Memory { factor: self.factor, scratch: Some(self.scratch) }
    }

    pub(super) fn factor_entries(&self) -> usize {
        self.symbolic.len_val()
    }

    /// Factorises by LLᵀ, or returns the first pivot that is not positive.
    pub(super) fn llt(&mut self, matrix: Matrix<'_>) -> Result<Factored, Pivot> {
        let result = self.symbolic.factorize_numeric_llt(
            &mut self.factor,
            SparseColMatRef::new(structure(matrix.pattern), matrix.values),
            Side::Lower,
            Default::default(),
            Par::Seq,
            MemStack::new(&mut self.scratch),
            Default::default(),
        );
        if let Err(LltError::NonPositivePivot { index }) = result {
            // The failing diagonal entry is left as elimination found it.
            let mut value = f64::NAN;
            self.for_each_diagonal(|k, d| {
                if k == index {
                    value = d;
                }
            });
            return Err(self.pivot(matrix, index, value));
        }
        let mut pivots = Pivots::default();
        self.for_each_diagonal(|k, d| pivots.add(self.pivot(matrix, k, d * d)));
        Ok(pivots.report(Method::Llt))
    }

    /// Factorises by LBLᵀ, or returns the first pivot that is zero or not finite.
    pub(super) fn lblt(&mut self, matrix: Matrix<'_>) -> Result<Factored, Pivot> {
        let n = self.symbolic.nrows();
        // faer does not write the off-diagonal of a 1×1 pivot at the end of a supernode.
        self.off_diagonal.clear();
        self.off_diagonal.resize(n, 0.0);
        self.exchange.resize(n, 0);
        self.exchange_inverse.resize(n, 0);
        self.symbolic.factorize_numeric_intranode_lblt(
            &mut self.factor,
            &mut self.off_diagonal,
            &mut self.exchange,
            &mut self.exchange_inverse,
            SparseColMatRef::new(structure(matrix.pattern), matrix.values),
            Side::Lower,
            Par::Seq,
            MemStack::new(&mut self.scratch),
            Default::default(),
        );
        let mut pivots = Pivots::default();
        let mut upper: Option<f64> = None;
        self.for_each_diagonal(|k, d| {
            let here = self.exchange[k];
            match upper.take() {
                None if self.off_diagonal[k] != 0.0 => upper = Some(d),
                None => pivots.add(self.pivot(matrix, here, d)),
                Some(a) => {
                    for eigenvalue in eigenvalues(a, self.off_diagonal[k - 1], d) {
                        let one = self.pivot(matrix, self.exchange[k - 1], eigenvalue);
                        let other = self.pivot(matrix, here, eigenvalue);
                        pivots.add(if one.relative < other.relative { one } else { other });
                    }
                }
            }
        });
        match pivots.unusable {
            Some(pivot) => Err(pivot),
            None => Ok(pivots.report(Method::Lblt)),
        }
    }

    /// Replaces b by x with the factor of LLᵀ.
    pub(super) fn solve_llt(&mut self, x: &mut [f64]) {
        let n = x.len();
        LltRef::new(&self.symbolic, &self.factor).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(x, n, 1),
            Par::Seq,
            MemStack::new(&mut self.scratch),
        );
    }

    /// Replaces b by x with the factor of LBLᵀ.
    pub(super) fn solve_lblt(&mut self, x: &mut [f64]) {
        let n = x.len();
        let exchange = PermRef::new_checked(&self.exchange, &self.exchange_inverse, n);
        IntranodeLbltRef::new(&self.symbolic, &self.factor, &self.off_diagonal, exchange)
            .solve_in_place_with_conj(
                Conj::No,
                MatMut::from_column_major_slice_mut(x, n, 1),
                Par::Seq,
                MemStack::new(&mut self.scratch),
            );
    }

    /// Calls `see` with each step of elimination and the diagonal entry of its column of the factor.
    fn for_each_diagonal(&self, mut see: impl FnMut(usize, f64)) {
        let Some(supernodal) = supernodal(&self.symbolic) else { return };
        let factor = SupernodalLltRef::new(supernodal, &self.factor);
        for s in 0..supernodal.n_supernodes() {
            let supernode = factor.supernode(s);
            let block = supernode.val();
            for j in 0..block.ncols() {
                see(supernode.start() + j, block[(j, j)]);
            }
        }
    }

    /// The pivot of elimination step `k`, in the caller's numbering.
    fn pivot(&self, matrix: Matrix<'_>, k: usize, value: f64) -> Pivot {
        let order = self.symbolic.perm().expect("the order is ours").arrays().0;
        let equation = order[k];
        let diagonal = matrix.diagonal(equation);
        let relative = if value == 0.0 { 0.0 } else { value.abs() / diagonal.abs() };
        Pivot { equation, value, relative }
    }
}

/// Supernodes of a factor; none only for a system without equations.
fn supernodal(symbolic: &SymbolicCholesky<usize>) -> Option<&SymbolicSupernodalCholesky<usize>> {
    match symbolic.raw() {
        SymbolicCholeskyRaw::Supernodal(supernodal) => Some(supernodal),
        SymbolicCholeskyRaw::Simplicial(_) => {
            assert_eq!(symbolic.nrows(), 0, "supernodes were asked for");
            None
        }
    }
}

/// Eigenvalues of [[a, b], [b, c]]; the smaller one by the determinant, without cancellation.
fn eigenvalues(a: f64, b: f64, c: f64) -> [f64; 2] {
    let mean = 0.5 * (a + c);
    let radius = (0.5 * (a - c)).hypot(b);
    let large = if mean < 0.0 { mean - radius } else { mean + radius };
    let small = if large == 0.0 { 0.0 } else { (a / large) * c - (b / large) * b };
    [small, large]
}

/// An order with little fill from the pattern alone, by minimum degree (P. R. Amestoy, T. A. Davis and
/// I. S. Duff, SIAM J. Matrix Anal. Appl. 17, 1996).
///
/// # Errors
/// If memory does not suffice.
pub(super) fn minimum_degree(pattern: Pattern<'_>) -> Result<Vec<usize>, OutOfMemory> {
    let symbolic = by_minimum_degree(pattern)?;
    Ok(symbolic.perm().map_or_else(Vec::new, |order| order.arrays().0.to_vec()))
}

fn by_minimum_degree(pattern: Pattern<'_>) -> Result<SymbolicCholesky<usize>, OutOfMemory> {
    factorize_symbolic_cholesky(structure(pattern), Side::Lower, SymmetricOrdering::Amd, symbolic_params())
        .map_err(|_| OutOfMemory { equations: pattern.n_equations(), factor_entries: 0 })
}

/// Entries of the factor with faer's minimum-degree order and our supernodes, to compare with.
#[cfg(test)]
pub(super) fn entries_by_minimum_degree(pattern: Pattern<'_>) -> usize {
    by_minimum_degree(pattern).unwrap().len_val()
}

//! Elimination of the first equations of a front: LLᵀ, LBLᵀ and LU by faer's dense kernels.
//!
//! Large fronts are divided into tiles, whose size is fixed, and which are worked on in parallel.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::{lblt, llt};
use faer::linalg::lu::partial_pivoting::factor::{lu_in_place, lu_in_place_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_unit_lower_triangular_in_place};
use faer::{Accum, ColMut, MatMut, MatRef, Par};

/// Rows or columns of a tile, at most; at least half as many.
const TILE: usize = 256;

/// Columns that LLᵀ of a large front eliminates at a time.
const PANEL: usize = 256;

/// How fronts are eliminated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// L Lᵀ.
    Llt,
    /// L B Lᵀ, 1×1 and 2×2 pivots chosen among the equations that a front eliminates.
    Lblt,
    /// L U, rows exchanged among the equations that a front eliminates.
    Lu,
}

/// The numbers of a front. Matrices are stored by columns; those of symmetric fronts hold lower triangles.
pub(super) struct Numbers<'a> {
    pub(super) n_eliminated: usize,
    pub(super) n_rest: usize,
    /// Columns that are eliminated, with the rows of the rest.
    pub(super) columns: &'a mut [f64],
    /// Rows that are eliminated, in the columns of the rest; empty if the front is symmetric.
    pub(super) right: &'a mut [f64],
    /// Rows and columns of the rest.
    pub(super) remainder: &'a mut [f64],
    /// Row whose pivot is used at each step, and the inverse.
    pub(super) exchange: &'a mut [usize],
    pub(super) inverse: &'a mut [usize],
    /// Off-diagonal entry of each 2×2 pivot at its first step, else 0.
    pub(super) off_diagonal: &'a mut [f64],
}

/// Memory for the work on fronts.
pub(super) struct Work {
    scratch: MemBuffer,
    /// Of LBLᵀ: rows of the rest, before they are divided by pivots. Of LU: a column.
    rows: Vec<f64>,
}

impl Work {
    /// For fronts that eliminate up to this many equations; None if memory does not suffice.
    pub(super) fn new(kind: Kind, widest: usize) -> Option<Self> {
        let scratch = match kind {
            Kind::Llt => llt::factor::cholesky_in_place_scratch::<f64>(widest, Par::Seq, Default::default()),
            Kind::Lblt => {
                lblt::factor::cholesky_in_place_scratch::<usize, f64>(widest, Par::Seq, Default::default())
            }
            Kind::Lu => lu_in_place_scratch::<usize, f64>(widest, widest, Par::Seq, Default::default()),
        };
        let scratch = StackReq::new::<u8>(scratch.unaligned_bytes_required());
        Some(Self { scratch: MemBuffer::try_new(scratch).ok()?, rows: Vec::new() })
    }
}

impl Numbers<'_> {
    /// Eliminates; tells whether rows were exchanged an odd number of times.
    ///
    /// # Errors
    /// The first pivot of LLᵀ that is not positive, which is left as elimination has found it.
    pub(super) fn eliminate(self, kind: Kind, work: &mut Work, in_tiles: bool) -> Result<bool, usize> {
        let tile = if in_tiles { TILE } else { usize::MAX };
        match kind {
            Kind::Llt => self.llt(work, tile).map(|()| false),
            Kind::Lblt => {
                self.lblt(work, tile);
                Ok(false)
            }
            Kind::Lu => Ok(self.lu(work, tile)),
        }
    }

    fn llt(self, work: &mut Work, tile: usize) -> Result<(), usize> {
        let Self { n_eliminated, n_rest, columns, remainder, .. } = self;
        let mut columns = MatMut::from_column_major_slice_mut(columns, n_eliminated + n_rest, n_eliminated);
        let panel = if tile == usize::MAX { n_eliminated } else { PANEL };
        for first in (0..n_eliminated).step_by(panel) {
            let width = panel.min(n_eliminated - first);
            let (_, own) = columns.as_mut().split_at_row_mut(first);
            let (_, own) = own.split_at_col_mut(first);
            let (own, later) = own.split_at_col_mut(width);
            let (mut square, below) = own.split_at_row_mut(width);
            llt::factor::cholesky_in_place(
                square.as_mut(),
                Default::default(),
                Par::Seq,
                MemStack::new(&mut work.scratch),
                Default::default(),
            )
            .map_err(|llt::factor::LltError::NonPositivePivot { index }| first + index)?;
            let mut below = below;
            let square = square.as_ref();
            for_row_tiles(below.as_mut(), tile, &|below| {
                solve_lower_triangular_in_place(square, below.transpose_mut(), Par::Seq);
            });
            let (_, later) = later.split_at_row_mut(width);
            subtract_lower(later, below.as_ref(), below.as_ref(), tile);
        }
        let below = columns.as_ref().split_at_row(n_eliminated).1;
        let remainder = MatMut::from_column_major_slice_mut(remainder, n_rest, n_rest);
        subtract_lower(remainder, below, below, tile);
        Ok(())
    }

    fn lblt(self, work: &mut Work, tile: usize) {
        let Self { n_eliminated, n_rest, columns, remainder, exchange, inverse, off_diagonal, .. } = self;
        let columns = MatMut::from_column_major_slice_mut(columns, n_eliminated + n_rest, n_eliminated);
        let (mut square, mut below) = columns.split_at_row_mut(n_eliminated);
        // faer does not write the off-diagonal of a 1×1 pivot at the end.
        off_diagonal.fill(0.0);
        lblt::factor::cholesky_in_place(
            square.as_mut(),
            ColMut::from_slice_mut(off_diagonal).as_diagonal_mut(),
            exchange,
            inverse,
            Par::Seq,
            MemStack::new(&mut work.scratch),
            Default::default(),
        );
        if n_rest == 0 {
            return;
        }
        // Rows of L B, then of L.
        work.rows.resize(n_rest * n_eliminated, 0.0);
        let mut rows = MatMut::from_column_major_slice_mut(&mut work.rows, n_rest, n_eliminated);
        for (to, &from) in exchange.iter().enumerate() {
            rows.as_mut().col_mut(to).copy_from(below.as_ref().col(from));
        }
        let square = square.as_ref();
        for_row_tiles(rows.as_mut(), tile, &|rows| {
            solve_unit_lower_triangular_in_place(square, rows.transpose_mut(), Par::Seq);
        });
        divide(square, off_diagonal, rows.as_ref(), below.as_mut());
        let remainder = MatMut::from_column_major_slice_mut(remainder, n_rest, n_rest);
        subtract_lower(remainder, below.as_ref(), rows.as_ref(), tile);
    }

    fn lu(self, work: &mut Work, tile: usize) -> bool {
        let Self { n_eliminated, n_rest, columns, right, remainder, exchange, inverse, .. } = self;
        let columns = MatMut::from_column_major_slice_mut(columns, n_eliminated + n_rest, n_eliminated);
        let (mut square, mut below) = columns.split_at_row_mut(n_eliminated);
        let (exchanged, _) = lu_in_place(
            square.as_mut(),
            exchange,
            inverse,
            Par::Seq,
            MemStack::new(&mut work.scratch),
            Default::default(),
        );
        if n_rest > 0 {
            work.rows.resize(n_eliminated, 0.0);
            for values in right.chunks_exact_mut(n_eliminated) {
                exchange.iter().zip(&mut work.rows).for_each(|(&from, to)| *to = values[from]);
                values.copy_from_slice(&work.rows[..n_eliminated]);
            }
            let mut right = MatMut::from_column_major_slice_mut(right, n_eliminated, n_rest);
            let square = square.as_ref();
            let mut solve = || {
                for_row_tiles(below.as_mut(), tile, &|below| {
                    solve_lower_triangular_in_place(square.transpose(), below.transpose_mut(), Par::Seq);
                });
            };
            let solve_right = |right: MatMut<'_, f64>| {
                for_row_tiles(right.transpose_mut(), tile, &|right| {
                    solve_unit_lower_triangular_in_place(square, right.transpose_mut(), Par::Seq);
                });
            };
            if n_rest > tile {
                rayon::join(solve, || solve_right(right.as_mut()));
            } else {
                solve();
                solve_right(right.as_mut());
            }
            let remainder = MatMut::from_column_major_slice_mut(remainder, n_rest, n_rest);
            subtract(remainder, below.as_ref(), right.as_ref(), tile);
        }
        exchanged.transposition_count % 2 == 1
    }
}

/// Divides rows of L B by the pivots B: 1×1, or 2×2 where the off-diagonal is not 0.
fn divide(square: MatRef<'_, f64>, off_diagonal: &[f64], from: MatRef<'_, f64>, mut to: MatMut<'_, f64>) {
    let mut j = 0;
    while j < off_diagonal.len() {
        let off = off_diagonal[j];
        if off == 0.0 {
            let factor = square[(j, j)].recip();
            let column = from.col(j).iter();
            to.as_mut().col_mut(j).iter_mut().zip(column).for_each(|(to, from)| *to = from * factor);
            j += 1;
            continue;
        }
        let [first, second] = pair(square[(j, j)], off, square[(j + 1, j + 1)]);
        for i in 0..from.nrows() {
            let (x, y) = (from[(i, j)], from[(i, j + 1)]);
            to[(i, j)] = first[0] * x + first[1] * y;
            to[(i, j + 1)] = second[0] * x + second[1] * y;
        }
        j += 2;
    }
}

/// The inverse of [[a, b], [b, c]] with b ≠ 0, without overflow of products.
pub(super) fn pair(a: f64, b: f64, c: f64) -> [[f64; 2]; 2] {
    let (a, c) = (a / b, c / b);
    let factor = (a * c - 1.0).recip() / b;
    [[c * factor, -factor], [-factor, a * factor]]
}

/// Calls `work` with tiles of rows.
fn for_row_tiles(matrix: MatMut<'_, f64>, tile: usize, work: &(impl Fn(MatMut<'_, f64>) + Sync)) {
    let n = matrix.nrows();
    if n <= tile {
        if n > 0 {
            work(matrix);
        }
        return;
    }
    let (upper, lower) = matrix.split_at_row_mut(n / 2);
    rayon::join(|| for_row_tiles(upper, tile, work), || for_row_tiles(lower, tile, work));
}

/// Subtracts `left · rightᵀ` below and on the diagonal of the first rows of `from`; lower rows may follow.
fn subtract_lower(from: MatMut<'_, f64>, left: MatRef<'_, f64>, right: MatRef<'_, f64>, tile: usize) {
    let n = from.ncols();
    if n == 0 {
        return;
    }
    if n > tile {
        let (first, second) = from.split_at_col_mut(n / 2);
        let (_, second) = second.split_at_row_mut(n / 2);
        let (left_below, right_below) = (left.split_at_row(n / 2).1, right.split_at_row(n / 2).1);
        rayon::join(
            || subtract_lower(first, left, right, tile),
            || subtract_lower(second, left_below, right_below, tile),
        );
        return;
    }
    let (square, below) = from.split_at_row_mut(n);
    let (upper, lower) = left.split_at_row(n);
    let right = right.split_at_row(n).0.transpose();
    triangular::matmul(
        square,
        BlockStructure::TriangularLower,
        Accum::Add,
        upper,
        BlockStructure::Rectangular,
        right,
        BlockStructure::Rectangular,
        -1.0,
        Par::Seq,
    );
    for_product_rows(below, lower, right, tile);
}

/// Subtracts `left · right` by tiles of rows.
fn for_product_rows(from: MatMut<'_, f64>, left: MatRef<'_, f64>, right: MatRef<'_, f64>, tile: usize) {
    let n = from.nrows();
    if n == 0 {
        return;
    }
    if n > tile {
        let (upper, lower) = from.split_at_row_mut(n / 2);
        let (left_upper, left_lower) = left.split_at_row(n / 2);
        rayon::join(
            || for_product_rows(upper, left_upper, right, tile),
            || for_product_rows(lower, left_lower, right, tile),
        );
        return;
    }
    matmul(from, Accum::Add, left, right, -1.0, Par::Seq);
}

/// Subtracts `left · right` by tiles.
fn subtract(from: MatMut<'_, f64>, left: MatRef<'_, f64>, right: MatRef<'_, f64>, tile: usize) {
    let n = from.ncols();
    if n > tile {
        let (first, second) = from.split_at_col_mut(n / 2);
        let (right_first, right_second) = right.split_at_col(n / 2);
        rayon::join(|| subtract(first, left, right_first, tile), || subtract(second, left, right_second, tile));
        return;
    }
    for_product_rows(from, left, right, tile);
}

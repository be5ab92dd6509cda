//! Multifrontal LU of an unsymmetric matrix: rows are exchanged within the block that a front eliminates.
//!
//! The fronts are those of LLᵀ of the same structure, so no more is filled than there; each is eliminated by faer's
//! dense kernels. A tangent's pivots stand mostly near its diagonal. Where a front has no usable pivot of its own, the
//! whole matrix is left to [`super::column_lu`].

use super::fronts::{Front, Fronts};
use super::pivots::Pivots;
use crate::matrix::{Matrix, Pattern};
use crate::report::{Factored, Method, OutOfMemory, Pivot, Sign};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::factor::{lu_in_place, lu_in_place_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_unit_lower_triangular_in_place};
use faer::{Accum, MatMut, Par};

/// A pivot below this part of the largest entry of its column is what rounding has left of zero.
pub(super) const NO_DIGITS: f64 = 1e-13;

/// Structure and factors of one pattern.
pub(super) struct FrontLu {
    /// Equation at each step of elimination.
    order: Vec<usize>,
    fronts: Fronts,
    /// L and U by fronts: the columns that each eliminates, then the rows of U to the right of them.
    numbers: Vec<f64>,
    /// Step whose row is the pivot's at each step.
    row: Vec<usize>,
    row_inverse: Vec<usize>,
    /// Remainders of fronts of even and of odd levels that no parent has taken yet.
    kept: [Vec<f64>; 2],
    scratch: MemBuffer,
    /// A column of a front, or the solution at the steps.
    work: Vec<f64>,
}

impl FrontLu {
    /// Finds the structure for an order of elimination (new to old) and makes room for the factors.
    pub(super) fn allocate(pattern: Pattern<'_>, order: &[usize]) -> Result<Self, OutOfMemory> {
        let n = order.len();
        let fronts = Fronts::new(pattern, order)?;
        let error = OutOfMemory { equations: n, factor_entries: fronts.n_numbers };
        let room = |size: usize| {
            let mut numbers = Vec::new();
            numbers.try_reserve_exact(size).map_err(|_| error).map(|()| numbers)
        };
        let mut numbers = room(fronts.n_numbers)?;
        numbers.resize(fronts.n_numbers, 0.0);
        let kept = [room(fronts.most_kept[0])?, room(fronts.most_kept[1])?];
        let widest = fronts.fronts.iter().map(Front::n_eliminated).max().unwrap_or(0);
        let scratch = lu_in_place_scratch::<usize, f64>(widest, widest, Par::Seq, Default::default());
        let scratch = MemBuffer::try_new(scratch).map_err(|_| error)?;
        let (row, row_inverse) = (vec![0; n], vec![0; n]);
        Ok(Self { order: order.to_vec(), fronts, numbers, row, row_inverse, kept, scratch, work: vec![0.0; n] })
    }

    /// Numbers that both factors of a pattern will have.
    pub(super) fn predict_entries(pattern: Pattern<'_>, order: &[usize]) -> Result<usize, OutOfMemory> {
        Ok(Fronts::new(pattern, order)?.n_numbers)
    }

    /// Numbers of both factors.
    pub(super) fn factor_entries(&self) -> usize {
        self.numbers.len()
    }

    /// Factorises, or returns the pivot that is none.
    pub(super) fn factorise(&mut self, matrix: Matrix<'_>) -> Result<Factored, Pivot> {
        let mut pivots = Pivots::default();
        let mut is_negative = false;
        self.kept.iter_mut().for_each(Vec::clear);
        for k in 0..self.fronts.fronts.len() {
            self.assemble(k, matrix.values);
            is_negative ^= self.eliminate(k);
            self.add_pivots(k, matrix, &mut pivots, &mut is_negative)?;
        }
        let sign = if is_negative { Sign::Negative } else { Sign::Positive };
        // Eigenvalues have other signs than the pivots of LU.
        Ok(Factored { determinant_sign: Some(sign), inertia: None, ..pivots.report(Method::Lu) })
    }

    /// Sums entries of the matrix and the remainders of its children in a front; its own remainder is put on the stack.
    fn assemble(&mut self, k: usize, values: &[f64]) {
        let Fronts { fronts, entries, .. } = &self.fronts;
        let front = &fronts[k];
        let (n_eliminated, n_rest, n_columns) = (front.n_eliminated(), front.n_rest(), front.n_columns());
        let height = n_eliminated + n_rest;
        let numbers = &mut self.numbers[front.start..front.start + n_columns + front.n_right()];
        numbers.fill(0.0);
        for entry in &entries[front.entries.clone()] {
            numbers[entry.place] += values[entry.source];
        }
        let (columns, right) = numbers.split_at_mut(n_columns);
        let [even, odd] = &mut self.kept;
        let (own, of_children) = if front.level == 0 { (even, odd) } else { (odd, even) };
        let begin = own.len();
        own.resize(begin + n_rest * n_rest, 0.0);
        let remainder = &mut own[begin..];
        for &child in front.children.iter().rev() {
            let places = &fronts[child].place_in_parent;
            let size = places.len();
            let from = of_children.len() - size * size;
            let eliminated = places.partition_point(|&place| place < n_eliminated);
            for (column, &place) in of_children[from..].chunks_exact(size.max(1)).zip(places) {
                let (upper, lower) = column.split_at(eliminated);
                if place < n_eliminated {
                    let sums = &mut columns[place * height..(place + 1) * height];
                    places.iter().zip(column).for_each(|(&i, value)| sums[i] += value);
                } else {
                    let j = place - n_eliminated;
                    let sums = &mut right[j * n_eliminated..(j + 1) * n_eliminated];
                    places.iter().zip(upper).for_each(|(&i, value)| sums[i] += value);
                    let sums = &mut remainder[j * n_rest..(j + 1) * n_rest];
                    places[eliminated..]
                        .iter()
                        .zip(lower)
                        .for_each(|(&i, value)| sums[i - n_eliminated] += value);
                }
            }
            of_children.truncate(from);
        }
    }

    /// Eliminates the first equations of a front; returns whether its rows were exchanged an odd number of times.
    fn eliminate(&mut self, k: usize) -> bool {
        let front = &self.fronts.fronts[k];
        let (n_eliminated, n_rest, n_columns) = (front.n_eliminated(), front.n_rest(), front.n_columns());
        let numbers = &mut self.numbers[front.start..front.start + n_columns + front.n_right()];
        let (columns, right) = numbers.split_at_mut(n_columns);
        let columns = MatMut::from_column_major_slice_mut(columns, n_eliminated + n_rest, n_eliminated);
        let (mut square, below) = columns.split_at_row_mut(n_eliminated);
        let exchange = &mut self.row[front.steps.clone()];
        let (exchanged, _) = lu_in_place(
            square.as_mut(),
            exchange,
            &mut self.row_inverse[front.steps.clone()],
            Par::Seq,
            MemStack::new(&mut self.scratch),
            Default::default(),
        );
        if n_rest > 0 {
            let column = &mut self.work[..n_eliminated];
            for values in right.chunks_exact_mut(n_eliminated) {
                exchange.iter().zip(&mut *column).for_each(|(&from, to)| *to = values[from]);
                values.copy_from_slice(column);
            }
            let mut right = MatMut::from_column_major_slice_mut(right, n_eliminated, n_rest);
            let mut below = below;
            solve_unit_lower_triangular_in_place(square.as_ref(), right.as_mut(), Par::Seq);
            solve_lower_triangular_in_place(
                square.as_ref().transpose(),
                below.as_mut().transpose_mut(),
                Par::Seq,
            );
            let kept = &mut self.kept[front.level];
            let begin = kept.len() - n_rest * n_rest;
            let remainder = MatMut::from_column_major_slice_mut(&mut kept[begin..], n_rest, n_rest);
            matmul(remainder, Accum::Add, below.as_ref(), right.as_ref(), -1.0, Par::Seq);
        }
        exchanged.transposition_count % 2 == 1
    }

    /// Reads the pivots of a front, or returns the one that is none.
    fn add_pivots(
        &self,
        k: usize,
        matrix: Matrix<'_>,
        pivots: &mut Pivots,
        is_negative: &mut bool,
    ) -> Result<(), Pivot> {
        let front = &self.fronts.fronts[k];
        let height = front.n_eliminated() + front.n_rest();
        for (j, step) in front.steps.clone().enumerate() {
            let value = self.numbers[front.start + j * height + j];
            let equation = self.order[step];
            let relative = value.abs() / matrix.diagonal(equation).abs();
            let pivot = Pivot { equation, value, relative };
            if !value.is_finite() || value.abs() <= NO_DIGITS * matrix.largest_of_column(equation) {
                return Err(pivot);
            }
            *is_negative ^= value < 0.0;
            pivots.add(pivot);
        }
        Ok(())
    }

    /// Replaces b by x.
    pub(super) fn solve(&mut self, b: &mut [f64]) {
        let Self { order, fronts, numbers, row, work: x, .. } = self;
        order.iter().zip(&mut *x).for_each(|(&equation, x)| *x = b[equation]);
        for front in &fronts.fronts {
            let height = front.n_eliminated() + front.n_rest();
            let own = front.steps.clone();
            let exchanged: Vec<f64> = row[own.clone()].iter().map(|&k| x[own.start + k]).collect();
            x[own.clone()].copy_from_slice(&exchanged);
            let columns = &numbers[front.start..front.start + front.n_columns()];
            for (j, column) in columns.chunks_exact(height).enumerate() {
                let value = x[own.start + j];
                let (above, below) = column.split_at(front.n_eliminated());
                x[own.start + j + 1..own.end]
                    .iter_mut()
                    .zip(&above[j + 1..])
                    .for_each(|(x, l)| *x -= l * value);
                front.rest.iter().zip(below).for_each(|(&step, l)| x[step] -= l * value);
            }
        }
        for front in fronts.fronts.iter().rev() {
            let (n_eliminated, height) = (front.n_eliminated(), front.n_eliminated() + front.n_rest());
            let own = front.steps.clone();
            let right = front.start + front.n_columns();
            let right = &numbers[right..right + front.n_right()];
            for (&step, column) in front.rest.iter().zip(right.chunks_exact(n_eliminated)) {
                let value = x[step];
                x[own.clone()].iter_mut().zip(column).for_each(|(x, u)| *x -= u * value);
            }
            let columns = &numbers[front.start..front.start + front.n_columns()];
            for (j, column) in columns.chunks_exact(height).enumerate().rev() {
                let value = x[own.start + j] / column[j];
                x[own.start + j] = value;
                x[own.start..own.start + j].iter_mut().zip(column).for_each(|(x, u)| *x -= u * value);
            }
        }
        order.iter().zip(&*x).for_each(|(&equation, x)| b[equation] = *x);
    }
}

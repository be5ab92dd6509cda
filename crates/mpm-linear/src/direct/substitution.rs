//! Solution with a factor by fronts.

use super::elimination::{Kind, pair};
use super::fronts::{Front, Fronts};
use super::tree::{Downward, Upward};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_unit_lower_triangular_in_place,
    solve_unit_upper_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Accum, MatMut, MatRef, Par};
use std::ops::Range;

/// A factor by fronts.
#[derive(Default)]
pub(super) struct Factor {
    /// The columns that each front eliminates, and of LU the rows to the right of them.
    pub(super) numbers: Vec<f64>,
    /// Step, counted within its front, whose equation has the pivot at each step.
    pub(super) exchange: Vec<usize>,
    pub(super) inverse: Vec<usize>,
    /// Off-diagonal entry of each 2×2 pivot at its first step, else 0 (LBLᵀ).
    pub(super) off_diagonal: Vec<f64>,
}

/// The pass with L, from the leaves to the roots.
pub(super) struct Forward<'a> {
    pub(super) fronts: &'a Fronts,
    pub(super) factor: &'a Factor,
    pub(super) kind: Kind,
}

/// The pass with B and Lᵀ, or U, from the roots to the leaves.
pub(super) struct Backward<'a> {
    pub(super) fronts: &'a Fronts,
    pub(super) factor: &'a Factor,
    pub(super) kind: Kind,
}

impl<'a> Upward for Forward<'a> {
    type Part = &'a mut [f64];

    fn subtrees(&self, range: Range<usize>, x: &'a mut [f64]) -> Option<Vec<f64>> {
        let mut kept = Vec::new();
        self.visit(range, x, (&mut kept, &mut Vec::new()));
        Some(kept)
    }

    fn front(&self, k: usize, own: &'a mut [f64], children: Vec<Vec<f64>>) -> Option<Vec<f64>> {
        let (front, mut values) = (&self.fronts.fronts[k], Vec::new());
        begin(front, own, &mut values);
        for (&child, of_child) in self.fronts.children(k).iter().zip(&children).rev() {
            add(&mut values, self.fronts.places(child), of_child);
        }
        self.eliminate(front, own, &mut values);
        values.drain(..front.n_eliminated());
        Some(values)
    }
}

/// Takes the values of the equations of a front; of those that are left nothing has been added yet.
fn begin(front: &Front, own: &[f64], values: &mut Vec<f64>) {
    values.clear();
    values.extend_from_slice(own);
    values.resize(front.height(), 0.0);
}

fn add(values: &mut [f64], places: &[usize], of_child: &[f64]) {
    places.iter().zip(of_child).for_each(|(&place, value)| values[place] += value);
}

impl Forward<'_> {
    /// Visits the fronts of a few subtrees. `kept` holds what fronts have handed on and no parent has taken yet, in the end
    /// that of the last; `values` are of one front.
    pub(super) fn visit(
        &self,
        range: Range<usize>,
        mut x: &mut [f64],
        (kept, values): (&mut Vec<f64>, &mut Vec<f64>),
    ) {
        kept.clear();
        for k in range {
            let front = &self.fronts.fronts[k];
            let (own, rest) = x.split_at_mut(front.n_eliminated());
            x = rest;
            begin(front, own, values);
            for &child in self.fronts.children(k).iter().rev() {
                let places = self.fronts.places(child);
                let from = kept.len() - places.len();
                add(values, places, &kept[from..]);
                kept.truncate(from);
            }
            self.eliminate(front, own, values);
            kept.extend_from_slice(&values[front.n_eliminated()..]);
        }
    }

    /// Solves with the square of L, and subtracts from the rest.
    fn eliminate(&self, front: &Front, own: &mut [f64], values: &mut [f64]) {
        let n = front.n_eliminated();
        let (first, rest) = values.split_at_mut(n);
        if self.kind == Kind::Llt {
            own.copy_from_slice(first);
        } else {
            let exchange = &self.factor.exchange[front.steps.clone()];
            exchange.iter().zip(&mut *own).for_each(|(&from, to)| *to = first[from]);
        }
        let (square, below) = columns(front, self.factor).split_at_row(n);
        let mut own = MatMut::from_column_major_slice_mut(own, n, 1);
        match self.kind {
            Kind::Llt => solve_lower_triangular_in_place(square, own.as_mut(), Par::Seq),
            Kind::Lblt | Kind::Lu => solve_unit_lower_triangular_in_place(square, own.as_mut(), Par::Seq),
        }
        let rest = MatMut::from_column_major_slice_mut(rest, front.n_rest(), 1);
        matmul(rest, Accum::Add, below, own.as_ref(), -1.0, Par::Seq);
    }
}

impl<'a> Downward for Backward<'a> {
    type Part = &'a mut [f64];

    fn subtrees(&self, range: Range<usize>, x: &'a mut [f64], mut given: Vec<f64>) {
        self.visit(range, x, (&mut given, &mut Vec::new()));
    }

    fn front(&self, k: usize, own: &'a mut [f64], given: Vec<f64>) -> Vec<Vec<f64>> {
        let mut values = Vec::new();
        self.eliminate(&self.fronts.fronts[k], own, &given, &mut values);
        let of_child = |&child: &usize| self.fronts.places(child).iter().map(|&place| values[place]).collect();
        self.fronts.children(k).iter().map(of_child).collect()
    }
}

impl Backward<'_> {
    /// Visits the fronts of a few subtrees. `kept` holds the values of the rest of fronts that have not been visited yet,
    /// those of the next last; `values` are of one front.
    pub(super) fn visit(
        &self,
        range: Range<usize>,
        mut x: &mut [f64],
        (kept, values): (&mut Vec<f64>, &mut Vec<f64>),
    ) {
        for k in range.rev() {
            let front = &self.fronts.fronts[k];
            let (rest, own) = x.split_at_mut(x.len() - front.n_eliminated());
            x = rest;
            let from = kept.len() - front.n_rest();
            self.eliminate(front, own, &kept[from..], values);
            kept.truncate(from);
            for &child in self.fronts.children(k) {
                kept.extend(self.fronts.places(child).iter().map(|&place| values[place]));
            }
        }
    }

    /// Solves for the equations of a front; leaves them in `values`, followed by those of its rest.
    fn eliminate(&self, front: &Front, own: &mut [f64], rest: &[f64], values: &mut Vec<f64>) {
        let n = front.n_eliminated();
        let (square, below) = columns(front, self.factor).split_at_row(n);
        if self.kind == Kind::Lblt {
            divide(square, &self.factor.off_diagonal[front.steps.clone()], own);
        }
        values.clear();
        values.extend_from_slice(own);
        let mut found = MatMut::from_column_major_slice_mut(values, n, 1);
        let known = MatRef::from_column_major_slice(rest, front.n_rest(), 1);
        let right = match self.kind {
            Kind::Llt | Kind::Lblt => below.transpose(),
            Kind::Lu => {
                let right = &self.factor.numbers[front.start + front.n_columns()..front.numbers().end];
                MatRef::from_column_major_slice(right, n, front.n_rest())
            }
        };
        matmul(found.as_mut(), Accum::Add, right, known, -1.0, Par::Seq);
        match self.kind {
            Kind::Llt => solve_upper_triangular_in_place(square.transpose(), found, Par::Seq),
            Kind::Lblt => solve_unit_upper_triangular_in_place(square.transpose(), found, Par::Seq),
            Kind::Lu => solve_upper_triangular_in_place(square, found, Par::Seq),
        }
        if self.kind == Kind::Lblt {
            let exchange = &self.factor.exchange[front.steps.clone()];
            exchange.iter().zip(&*values).for_each(|(&to, &value)| own[to] = value);
            values.copy_from_slice(own);
        } else {
            own.copy_from_slice(values);
        }
        values.extend_from_slice(rest);
    }
}

/// The columns that a front eliminates.
fn columns<'a>(front: &Front, factor: &'a Factor) -> MatRef<'a, f64> {
    let numbers = &factor.numbers[front.start..front.start + front.n_columns()];
    MatRef::from_column_major_slice(numbers, front.height(), front.n_eliminated())
}

/// Divides by the pivots B: 1×1, or 2×2 where the off-diagonal is not 0.
fn divide(square: MatRef<'_, f64>, off_diagonal: &[f64], x: &mut [f64]) {
    let mut j = 0;
    while j < x.len() {
        if off_diagonal[j] == 0.0 {
            x[j] /= square[(j, j)];
            j += 1;
        } else {
            let [first, second] = pair(square[(j, j)], off_diagonal[j], square[(j + 1, j + 1)]);
            let (a, b) = (x[j], x[j + 1]);
            (x[j], x[j + 1]) = (first[0] * a + first[1] * b, second[0] * a + second[1] * b);
            j += 2;
        }
    }
}

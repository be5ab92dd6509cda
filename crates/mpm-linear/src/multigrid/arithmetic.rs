//! Vectors of nodal values: sums in fixed chunks, so that their order does not depend on threads. What is short is done
//! by one thread, because waking others takes longer.

use nalgebra::{SMatrix, SVector};
use rayon::prelude::*;

pub(crate) type Vector<const D: usize> = SVector<f64, D>;
pub(crate) type Block<const D: usize> = SMatrix<f64, D, D>;

/// Nodes of a vector above which it is worked on in parallel.
const LARGE: usize = 4096;

/// The same of the rows of a matrix.
pub(crate) const LARGE_LEVEL: usize = 2000;

/// Rows of a matrix per task.
const ROWS: usize = 256;

/// `sum − block · x`.
#[inline(always)]
pub(crate) fn without<const D: usize>(sum: Vector<D>, block: &Block<D>, x: &Vector<D>) -> Vector<D> {
    let (mut sum, [x], block) = (sum, &x.data.0, &block.data.0);
    let [entries] = &mut sum.data.0;
    for (column, x) in block.iter().zip(x) {
        for (entry, coefficient) in entries.iter_mut().zip(column) {
            *entry -= coefficient * x;
        }
    }
    sum
}

/// Nodes per partial sum and per task.
pub(crate) const CHUNK: usize = 1024;

/// `Σ_v x_v · y_v`.
pub(crate) fn dot<const D: usize>(x: &[Vector<D>], y: &[Vector<D>]) -> f64 {
    let part = |(x, y): (&[Vector<D>], &[Vector<D>])| x.iter().zip(y).map(|(x, y)| x.dot(y)).sum::<f64>();
    if x.len() <= LARGE {
        return x.chunks(CHUNK).zip(y.chunks(CHUNK)).map(part).sum();
    }
    let parts: Vec<f64> = x.par_chunks(CHUNK).zip(y.par_chunks(CHUNK)).map(part).collect();
    parts.into_iter().sum()
}

/// `y ← y + a x`.
pub(crate) fn add<const D: usize>(y: &mut [Vector<D>], a: f64, x: &[Vector<D>]) {
    for_each_node(y, |node, y| *y += x[node] * a);
}

/// `y ← x + a y`.
pub(crate) fn add_to_multiple<const D: usize>(y: &mut [Vector<D>], a: f64, x: &[Vector<D>]) {
    for_each_node(y, |node, y| *y = x[node] + *y * a);
}

/// Calls `work` with each node's number and what is stored for it.
pub(crate) fn for_each_node<T: Send>(data: &mut [T], work: impl Fn(usize, &mut T) + Sync) {
    for_each(LARGE, CHUNK, data, work);
}

/// The same for work on the rows of a matrix.
pub(crate) fn for_each_row<T: Send>(data: &mut [T], work: impl Fn(usize, &mut T) + Sync) {
    for_each(LARGE_LEVEL, ROWS, data, work);
}

fn for_each<T: Send>(large: usize, chunk: usize, data: &mut [T], work: impl Fn(usize, &mut T) + Sync) {
    if data.len() <= large {
        return data.iter_mut().enumerate().for_each(|(node, it)| work(node, it));
    }
    data.par_chunks_mut(chunk).enumerate().for_each(|(place, data)| {
        data.iter_mut().enumerate().for_each(|(node, it)| work(place * chunk + node, it));
    });
}

/// What can be cut in two.
pub(crate) trait Cut: Send + Sized {
    /// What stands before a place, and the rest.
    fn cut(self, at: usize) -> (Self, Self);
}

impl<T: Send> Cut for &mut [T] {
    fn cut(self, at: usize) -> (Self, Self) {
        self.split_at_mut(at)
    }
}

impl<A: Cut, B: Cut> Cut for (A, B) {
    fn cut(self, at: usize) -> (Self, Self) {
        let ((low_a, high_a), (low_b, high_b)) = (self.0.cut(at), self.1.cut(at));
        ((low_a, low_b), (high_a, high_b))
    }
}

/// Calls `work` with each part of `data` between two of the `bounds` (the first of them is where `data`
/// begins), in parallel where asked.
pub(crate) fn for_each_part<T: Cut>(
    in_parallel: bool,
    bounds: &[usize],
    data: T,
    work: &(impl Fn(usize, T) + Sync),
) {
    if in_parallel {
        return for_each_part_from(0, bounds, data, work);
    }
    let mut data = data;
    for (part, bounds) in bounds.windows(2).enumerate() {
        let (here, rest) = data.cut(bounds[1] - bounds[0]);
        work(part, here);
        data = rest;
    }
}

fn for_each_part_from<T: Cut>(first: usize, bounds: &[usize], data: T, work: &(impl Fn(usize, T) + Sync)) {
    match bounds.len() {
        0 | 1 => {}
        2 => work(first, data),
        n => {
            let middle = n / 2;
            let (low, high) = data.cut(bounds[middle] - bounds[0]);
            rayon::join(
                || for_each_part_from(first, &bounds[..=middle], low, work),
                || for_each_part_from(first + middle, &bounds[middle..], high, work),
            );
        }
    }
}

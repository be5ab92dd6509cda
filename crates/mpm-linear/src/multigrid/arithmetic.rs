//! Vectors of nodal values: sums in fixed chunks, so that their order does not depend on threads.

use nalgebra::{SMatrix, SVector};
use rayon::prelude::*;

pub(crate) type Vector<const D: usize> = SVector<f64, D>;
pub(crate) type Block<const D: usize> = SMatrix<f64, D, D>;

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
pub(crate) const CHUNK: usize = 2048;

/// `Σ_v x_v · y_v`.
pub(crate) fn dot<const D: usize>(x: &[Vector<D>], y: &[Vector<D>]) -> f64 {
    let parts = x.par_chunks(CHUNK).zip(y.par_chunks(CHUNK));
    let parts: Vec<f64> = parts.map(|(x, y)| x.iter().zip(y).map(|(x, y)| x.dot(y)).sum()).collect();
    parts.into_iter().sum()
}

/// `y ← y + a x`.
pub(crate) fn add<const D: usize>(y: &mut [Vector<D>], a: f64, x: &[Vector<D>]) {
    y.par_chunks_mut(CHUNK).zip(x.par_chunks(CHUNK)).for_each(|(y, x)| {
        for (y, x) in y.iter_mut().zip(x) {
            *y += x * a;
        }
    });
}

/// `y ← x + a y`.
pub(crate) fn add_to_multiple<const D: usize>(y: &mut [Vector<D>], a: f64, x: &[Vector<D>]) {
    y.par_chunks_mut(CHUNK).zip(x.par_chunks(CHUNK)).for_each(|(y, x)| {
        for (y, x) in y.iter_mut().zip(x) {
            *y = x + *y * a;
        }
    });
}

/// Calls `work` with each part of `data` between two of the `bounds` (the first of them is where `data`
/// begins), in parallel.
pub(crate) fn for_each_part<T: Send>(
    bounds: &[usize],
    data: &mut [T],
    work: &(impl Fn(usize, &mut [T]) + Sync),
) {
    for_each_part_from(0, bounds, data, work);
}

fn for_each_part_from<T: Send>(
    first: usize,
    bounds: &[usize],
    data: &mut [T],
    work: &(impl Fn(usize, &mut [T]) + Sync),
) {
    match bounds.len() {
        0 | 1 => {}
        2 => work(first, data),
        n => {
            let middle = n / 2;
            let (low, high) = data.split_at_mut(bounds[middle] - bounds[0]);
            rayon::join(
                || for_each_part_from(first, &bounds[..=middle], low, work),
                || for_each_part_from(first + middle, &bounds[middle..], high, work),
            );
        }
    }
}

//! Sweeps of Gauss–Seidel over the nodes of this rank, in single precision.
//!
//! They are a part of a preconditioner, so that the rounding of their numbers changes how fast an iteration converges and not
//! where to. Within a rank a sweep takes what it has found; of other ranks it takes what was there before. So that this cannot
//! diverge, half of the absolute values of what couples a row with other ranks is added to its diagonal (A. H. Baker, R. D.
//! Falgout, T. V. Kolev and U. M. Yang, *Multigrid smoothers for ultraparallel computing*, SIAM J. Sci. Comput. 33, 2011):
//! a sweep forwards and its transpose backwards make a symmetric, positive definite preconditioner.

use crate::ffi::PetscInt;
use crate::rows::{Parts, Rows};

/// Components of a node, and zeros that fill a register.
pub(crate) type Short<const L: usize> = [f32; L];

/// The rows of a matrix that this rank has, by blocks of D columns with L rows each, L ≥ D, and the vectors of a cycle.
///
/// Matrix and inverse are multiplied by a power of two that brings the largest diagonal entry near 1, and by its inverse.
pub(crate) struct Sweeps<const D: usize, const L: usize> {
    start: Vec<usize>,
    column: Vec<u32>,
    /// Of every row its diagonal block.
    diagonal: Vec<usize>,
    block: Vec<[Short<L>; D]>,
    inverse: Vec<[Short<L>; D]>,
    others: Others,
    /// Of the rows that are coupled with other ranks: row, and what is added to its diagonal.
    raised: Vec<(u32, Short<L>)>,
    scale: f64,
    b: Vec<Short<L>>,
    x: Vec<Short<L>>,
    r: Vec<Short<L>>,
}

/// What couples own equations with those of other ranks.
#[derive(Default)]
struct Others {
    /// Equations that have any, and the end of their entries.
    row: Vec<(u32, u32)>,
    column: Vec<u32>,
    value: Vec<f32>,
    /// What other ranks have found there.
    x: Vec<f32>,
}

/// `sum − block · x`.
#[inline(always)]
fn without<const D: usize, const L: usize>(mut sum: Short<L>, block: &[Short<L>; D], x: &Short<L>) -> Short<L> {
    let product = times(block, x);
    for (sum, product) in sum.iter_mut().zip(&product) {
        *sum -= product;
    }
    sum
}

/// `block · x`.
#[inline(always)]
fn times<const D: usize, const L: usize>(block: &[Short<L>; D], x: &Short<L>) -> Short<L> {
    let mut product = [0.0; L];
    for (column, x) in block.iter().zip(x) {
        for (product, coefficient) in product.iter_mut().zip(column) {
            *product += coefficient * x;
        }
    }
    product
}

impl<const D: usize, const L: usize> Sweeps<D, L> {
    /// Zeros for a matrix of this structure.
    pub(crate) fn of(parts: &Parts<'_>) -> Self {
        let n = parts.own.rows() / D;
        let (mut start, mut column, mut diagonal) = (vec![0], Vec::new(), Vec::with_capacity(n));
        for row in 0..n {
            for found in parts.own.nodes(row, D) {
                if found == row {
                    diagonal.push(column.len());
                }
                column.push(found as u32);
            }
            start.push(column.len());
        }
        let nothing = vec![[0.0; L]; n];
        Self {
            block: vec![[[0.0; L]; D]; column.len()],
            inverse: vec![[[0.0; L]; D]; n],
            others: Others::of(parts.others.as_ref()),
            raised: Vec::new(),
            scale: 1.0,
            b: nothing.clone(),
            x: nothing.clone(),
            r: nothing,
            start,
            column,
            diagonal,
        }
    }

    /// Takes the values of a matrix of the structure. False where a block of its diagonal has no inverse.
    pub(crate) fn take(&mut self, parts: &Parts<'_>) -> bool {
        let mut largest = 0.0_f64;
        for row in 0..parts.own.rows() {
            let (column, value) = parts.own.row(row);
            if let Ok(place) = column.binary_search(&(row as PetscInt)) {
                largest = largest.max(value[place].abs());
            }
        }
        self.scale = power_of_two_near(largest.recip());
        let raised = self.others.take(parts.others.as_ref(), self.scale);
        self.raised = by_rows::<D, L>(&raised);
        let mut raised = self.raised.iter().peekable();
        let mut is_well = true;
        for row in 0..self.diagonal.len() {
            let mut of_diagonal = [[0.0; D]; D];
            for (block, (found, values)) in self.block[self.start[row]..].iter_mut().zip(parts.own.blocks(row))
            {
                if found == row {
                    of_diagonal = values.map(|it| *it);
                }
                for (i, values) in values.iter().enumerate() {
                    values.iter().enumerate().for_each(|(j, value)| block[j][i] = (value * self.scale) as f32);
                }
            }
            if let Some((_, more)) = raised.next_if(|it| it.0 as usize == row) {
                (0..D).for_each(|i| of_diagonal[i][i] += f64::from(more[i]) / self.scale);
            }
            let inverse = inverted(of_diagonal);
            for (j, column) in self.inverse[row].iter_mut().enumerate() {
                for i in 0..D {
                    column[i] = (inverse[i][j] / self.scale) as f32;
                    is_well &= column[i].is_finite();
                }
            }
        }
        is_well
    }

    /// Takes a right-hand side times `up`, which brings it near 1.
    pub(crate) fn take_rhs(&mut self, b: &[f64], up: f64) {
        for (to, from) in self.b.iter_mut().zip(b.as_chunks::<D>().0) {
            (0..D).for_each(|i| to[i] = (from[i] * up) as f32);
        }
    }

    /// Hands out what was found for a right-hand side that was taken times `up`.
    pub(crate) fn give(&self, x: &mut [f64], up: f64) {
        let down = self.scale / up;
        for (to, from) in x.as_chunks_mut::<D>().0.iter_mut().zip(&self.x) {
            (0..D).for_each(|i| to[i] = f64::from(from[i]) * down);
        }
    }

    /// Takes what other ranks have found.
    pub(crate) fn take_others(&mut self, x: &[f64], up: f64) {
        let up = up / self.scale;
        self.others.x.clear();
        self.others.x.extend(x.iter().map(|x| (x * up) as f32));
    }

    /// Adds a correction.
    pub(crate) fn correct(&mut self, by: &[f64], up: f64) {
        let up = up / self.scale;
        for (to, from) in self.x.iter_mut().zip(by.as_chunks::<D>().0) {
            (0..D).for_each(|i| to[i] += (from[i] * up) as f32);
        }
    }

    /// One sweep forwards from x = 0 on all ranks.
    pub(crate) fn sweep_from_zero(&mut self) {
        let Self { start, column, diagonal, block, inverse, b, x, .. } = self;
        for row in 0..x.len() {
            let entries = start[row]..diagonal[row];
            let pairs = block[entries.clone()].iter().zip(&column[entries]);
            let sum = pairs.fold(b[row], |sum, (block, &column)| without(sum, block, &x[column as usize]));
            x[row] = times(&inverse[row], &sum);
        }
    }

    /// `b − A x` after [`Self::sweep_from_zero`], times `1 / up`: what later rows and other ranks have added.
    pub(crate) fn residual_after_sweep(&mut self, residual: &mut [f64], up: f64) {
        let Self { start, column, diagonal, block, others, raised, x, r, .. } = self;
        for (row, r) in r.iter_mut().enumerate() {
            let entries = diagonal[row] + 1..start[row + 1];
            let pairs = block[entries.clone()].iter().zip(&column[entries]);
            *r = pairs.fold([0.0; L], |sum, (block, &column)| without(sum, block, &x[column as usize]));
        }
        for (row, more) in &*raised {
            let row = *row as usize;
            (0..D).for_each(|i| r[row][i] += more[i] * x[row][i]);
        }
        others.for_each_product(|equation, product| r[equation / D][equation % D] -= product);
        let down = up.recip();
        for (to, from) in residual.as_chunks_mut::<D>().0.iter_mut().zip(&*r) {
            (0..D).for_each(|i| to[i] = f64::from(from[i]) * down);
        }
    }

    /// One sweep backwards, the transpose of a forward one.
    pub(crate) fn sweep_back(&mut self) {
        let Self { start, column, diagonal, block, inverse, others, raised, b, x, .. } = self;
        others.for_each_product(|equation, product| b[equation / D][equation % D] -= product);
        for (row, more) in &*raised {
            let row = *row as usize;
            (0..D).for_each(|i| b[row][i] += more[i] * x[row][i]);
        }
        for row in (0..x.len()).rev() {
            let (before, behind) = (start[row]..diagonal[row], diagonal[row] + 1..start[row + 1]);
            let add = |sum, entries: std::ops::Range<usize>| {
                let pairs = block[entries.clone()].iter().zip(&column[entries]);
                pairs.fold(sum, |sum, (block, &column)| without(sum, block, &x[column as usize]))
            };
            let sum = add(add(b[row], before), behind);
            x[row] = times(&inverse[row], &sum);
        }
    }
}

impl Others {
    fn of(rows: Option<&Rows<'_>>) -> Self {
        let mut it = Self::default();
        let Some(rows) = rows else { return it };
        for row in 0..rows.rows() {
            let (column, _) = rows.row(row);
            if !column.is_empty() {
                it.column.extend(column.iter().map(|&it| it as u32));
                it.row.push((row as u32, it.column.len() as u32));
            }
        }
        it.value = vec![0.0; it.column.len()];
        it
    }

    /// Takes values times a factor; returns of every equation half the sum of their sizes.
    fn take(&mut self, rows: Option<&Rows<'_>>, scale: f64) -> Vec<(u32, f32)> {
        let Some(rows) = rows else { return Vec::new() };
        let mut raised = Vec::with_capacity(self.row.len());
        let mut to = self.value.iter_mut();
        for &(row, _) in &self.row {
            let mut sum = 0.0;
            for (value, to) in rows.row(row as usize).1.iter().zip(to.by_ref()) {
                *to = (value * scale) as f32;
                sum += 0.5 * to.abs();
            }
            raised.push((row, sum));
        }
        raised
    }

    /// Of every equation that has any, the product with what other ranks have found.
    fn for_each_product(&self, mut see: impl FnMut(usize, f32)) {
        let mut begin = 0;
        for &(row, end) in &self.row {
            let entries = begin as usize..end as usize;
            let pairs = self.value[entries.clone()].iter().zip(&self.column[entries]);
            see(row as usize, pairs.map(|(value, &column)| value * self.x[column as usize]).sum());
            begin = end;
        }
    }
}

/// The same by nodes.
fn by_rows<const D: usize, const L: usize>(of_equations: &[(u32, f32)]) -> Vec<(u32, Short<L>)> {
    let mut rows: Vec<(u32, Short<L>)> = Vec::new();
    for &(equation, value) in of_equations {
        let (row, i) = (equation / D as u32, equation as usize % D);
        if rows.last().is_none_or(|it| it.0 != row) {
            rows.push((row, [0.0; L]));
        }
        if let Some(last) = rows.last_mut() {
            last.1[i] = value;
        }
    }
    rows
}

/// The inverse of a small matrix by elimination with pivots; infinite where there is none.
fn inverted<const D: usize>(mut a: [[f64; D]; D]) -> [[f64; D]; D] {
    let mut inverse: [[f64; D]; D] =
        std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    for k in 0..D {
        let pivot = (k..D).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs())).unwrap_or(k);
        a.swap(k, pivot);
        inverse.swap(k, pivot);
        let factor = a[k][k].recip();
        a[k].iter_mut().chain(&mut inverse[k]).for_each(|it| *it *= factor);
        for i in (0..D).filter(|&i| i != k) {
            let (of_a, of_inverse, times) = (a[k], inverse[k], a[i][k]);
            a[i].iter_mut().zip(of_a).for_each(|(it, of)| *it -= times * of);
            inverse[i].iter_mut().zip(of_inverse).for_each(|(it, of)| *it -= times * of);
        }
    }
    inverse
}

/// A power of two near a positive number; 1 for others.
pub(crate) fn power_of_two_near(number: f64) -> f64 {
    if number.is_normal() && number > 0.0 { number.log2().round().clamp(-1000.0, 1000.0).exp2() } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_matrices_are_inverted() {
        let inverse = inverted([[0.0, 2.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 4.0]]);
        assert_eq!(inverse, [[0.0, 1.0, 0.0], [0.5, 0.0, 0.0], [-0.125, 0.0, 0.25]]);
        assert!(!inverted([[1.0, 1.0], [1.0, 1.0]])[0][0].is_finite());
    }

    /// Two nodes of two equations each.
    #[test]
    fn blocks_are_read_and_swept() {
        let (start, column) = ([0, 4, 8, 12, 16], [0, 1, 2, 3].repeat(4));
        let value = [4.0, 1.0, -1.0, 0.0, 1.0, 4.0, 0.0, 0.0, -1.0, 0.0, 4.0, 0.0, 0.0, 0.0, 0.0, 2.0];
        let parts = Parts { own: Rows { start: &start, column: &column, value: &value }, others: None };
        let mut sweeps = Sweeps::<2, 2>::of(&parts);
        assert!(sweeps.take(&parts));
        let b = [1.0, 2.0, 3.0, 4.0];
        let (mut x, mut r) = ([0.0; 4], [0.0; 4]);
        sweeps.take_rhs(&b, 1.0);
        sweeps.sweep_from_zero();
        sweeps.residual_after_sweep(&mut r, 1.0);
        sweeps.give(&mut x, 1.0);
        let dense = [[4.0, 1.0, -1.0, 0.0], [1.0, 4.0, 0.0, 0.0], [-1.0, 0.0, 4.0, 0.0], [0.0, 0.0, 0.0, 2.0]];
        let left = |x: &[f64; 4], i: usize| b[i] - dense[i].iter().zip(x).map(|(a, x)| a * x).sum::<f64>();
        assert!((0..4).all(|i| (left(&x, i) - r[i]).abs() < 1e-6), "{r:?}");
        for _ in 0..20 {
            sweeps.take_rhs(&b, 1.0);
            sweeps.sweep_back();
        }
        sweeps.give(&mut x, 1.0);
        assert!((0..4).all(|i| left(&x, i).abs() < 1e-5), "{x:?}");
    }
}

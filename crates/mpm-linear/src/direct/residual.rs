//! The check of a solution: r = b − K x and what it amounts to.

use crate::matrix::SymmetricPattern;

/// Solution, residual and the sizes that the residual is measured by; n numbers each.
#[derive(Default)]
pub(super) struct Residual {
    /// x.
    pub(super) solution: Vec<f64>,
    /// r = b − K x; a correction of x while refining.
    pub(super) residual: Vec<f64>,
    /// Equation with the largest backward error.
    pub(super) worst: usize,
    before: Vec<f64>,
    /// |K| |x| + |b|.
    size: Vec<f64>,
    /// Σ_j |K_ij|.
    row_sum: Vec<f64>,
}

impl Residual {
    /// Computes r and the componentwise backward error of x,
    /// max_i |r_i| / (|K| |x| + |b|)_i (W. Oettli and W. Prager, Numer. Math. 6, 1964).
    ///
    /// Where the denominator is rounding error itself it is enlarged by Σ_j |K_ij| max |x|
    /// (M. Arioli, J. W. Demmel and I. S. Duff, SIAM J. Matrix Anal. Appl. 10, 1989, section 2).
    /// Infinite if x is not finite.
    pub(super) fn backward_error(&mut self, pattern: SymmetricPattern<'_>, values: &[f64], b: &[f64]) -> f64 {
        let n = b.len();
        let x = &self.solution;
        if let Some(equation) = x.iter().position(|x| !x.is_finite()) {
            self.worst = equation;
            return f64::INFINITY;
        }
        self.residual.clear();
        self.residual.extend_from_slice(b);
        self.size.clear();
        self.size.extend(b.iter().map(|b| b.abs()));
        self.row_sum.clear();
        self.row_sum.resize(n, 0.0);
        let (r, size, row_sum) = (&mut self.residual, &mut self.size, &mut self.row_sum);
        for j in 0..n {
            let first = pattern.column_start[j];
            let entries = first + 1..pattern.column_start[j + 1];
            let x_j = x[j];
            let k_jj = values[first];
            let (mut kx, mut kx_size, mut k_size) = (k_jj * x_j, (k_jj * x_j).abs(), k_jj.abs());
            for (&i, &k) in pattern.row[entries.clone()].iter().zip(&values[entries]) {
                r[i] -= k * x_j;
                size[i] += (k * x_j).abs();
                row_sum[i] += k.abs();
                kx += k * x[i];
                kx_size += (k * x[i]).abs();
                k_size += k.abs();
            }
            r[j] -= kx;
            size[j] += kx_size;
            row_sum[j] += k_size;
        }

        let largest = x.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let rounding = 1000.0 * n as f64 * f64::EPSILON;
        let mut error = 0.0;
        for i in 0..n {
            let bound = row_sum[i] * largest;
            let mut denominator = size[i];
            if denominator <= rounding * (bound + b[i].abs()) {
                denominator += bound;
            }
            let quotient = if r[i] == 0.0 { 0.0 } else { r[i].abs() / denominator };
            if quotient > error || quotient.is_nan() {
                error = if quotient.is_nan() { f64::INFINITY } else { quotient };
                self.worst = i;
            }
        }
        error
    }

    /// Adds the correction, which took the place of the residual, to the solution.
    pub(super) fn correct(&mut self) {
        self.before.clear();
        self.before.extend_from_slice(&self.solution);
        for (x, d) in self.solution.iter_mut().zip(&self.residual) {
            *x += d;
        }
    }

    /// Undoes the last correction.
    pub(super) fn take_back(&mut self) {
        self.solution.copy_from_slice(&self.before);
    }
}

/// The first equation whose row is zero.
pub(super) fn holds_nothing(pattern: SymmetricPattern<'_>, values: &[f64]) -> Option<usize> {
    let mut held = vec![false; pattern.column_start.len() - 1];
    for j in 0..held.len() {
        for entry in pattern.column_start[j]..pattern.column_start[j + 1] {
            if values[entry] != 0.0 {
                held[j] = true;
                held[pattern.row[entry]] = true;
            }
        }
    }
    held.iter().position(|held| !held)
}

/// K w for a w without zeros or regularity: w_i = 1 + (fractional part of 0.618… i).
pub(super) fn image_of_known(pattern: SymmetricPattern<'_>, values: &[f64]) -> Vec<f64> {
    let known = |i: usize| 1.0 + (i as f64 * 0.618_033_988_749_894_9).fract();
    let known: Vec<f64> = (0..pattern.column_start.len() - 1).map(known).collect();
    product(pattern, values, &known)
}

/// K w.
pub(super) fn product(pattern: SymmetricPattern<'_>, values: &[f64], w: &[f64]) -> Vec<f64> {
    let mut image = vec![0.0; w.len()];
    for j in 0..image.len() {
        let entries = pattern.column_start[j]..pattern.column_start[j + 1];
        for (&i, &k) in pattern.row[entries.clone()].iter().zip(&values[entries]) {
            image[i] += k * w[j];
            if i != j {
                image[j] += k * w[i];
            }
        }
    }
    image
}

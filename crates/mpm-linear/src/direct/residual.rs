//! The check of a solution: r = b − K x and what it amounts to.

use crate::matrix::Matrix;

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
    pub(super) fn backward_error(&mut self, matrix: Matrix<'_>, b: &[f64]) -> f64 {
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
        if matrix.pattern.is_symmetric() {
            self.add_symmetric(matrix);
        } else {
            self.add_unsymmetric(matrix);
        }

        let (x, r, size, row_sum) = (&self.solution, &self.residual, &self.size, &self.row_sum);
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

    /// Subtracts K x from r; adds |K| |x| to the sizes and |K| to the row sums. Only the lower triangle of K is stored.
    fn add_symmetric(&mut self, Matrix { pattern, values }: Matrix<'_>) {
        let Self { solution: x, residual: r, size, row_sum, .. } = self;
        for j in 0..x.len() {
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
    }

    /// The same with both triangles stored.
    fn add_unsymmetric(&mut self, Matrix { pattern, values }: Matrix<'_>) {
        let Self { solution: x, residual: r, size, row_sum, .. } = self;
        for (j, &x_j) in x.iter().enumerate() {
            let entries = pattern.column_start[j]..pattern.column_start[j + 1];
            for (&i, &k) in pattern.row[entries.clone()].iter().zip(&values[entries]) {
                r[i] -= k * x_j;
                size[i] += (k * x_j).abs();
                row_sum[i] += k.abs();
            }
        }
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

/// K w for a w without zeros or regularity: w_i = 1 + (fractional part of 0.618… i).
pub(super) fn image_of_known(matrix: Matrix<'_>) -> Vec<f64> {
    let known = |i: usize| 1.0 + (i as f64 * 0.618_033_988_749_894_9).fract();
    let known: Vec<f64> = (0..matrix.pattern.n_equations()).map(known).collect();
    matrix.times(&known)
}

//! Null spaces of small dense systems, and how their vectors are written.

/// Sweeps of Jacobi's method at most; it converges quadratically.
const SWEEPS: usize = 40;

/// Rows reduced to a triangle: it has the singular values of the rows.
pub(super) struct Triangle {
    n: usize,
    /// Row k has its first entry in column k.
    rows: Vec<Vec<f64>>,
}

impl Triangle {
    /// No rows yet, with `n` columns.
    pub(super) fn new(n: usize) -> Self {
        Self { n, rows: vec![vec![0.0; n]; n] }
    }

    /// Number of columns.
    pub(super) fn n(&self) -> usize {
        self.n
    }

    /// Its entries, row by row.
    pub(super) fn into_numbers(self) -> Vec<f64> {
        self.rows.concat()
    }

    /// Takes up a row by Givens rotations.
    pub(super) fn add(&mut self, row: &mut [f64]) {
        for k in 0..self.n {
            if row[k] == 0.0 {
                continue;
            }
            let pivot = &mut self.rows[k];
            let r = pivot[k].hypot(row[k]);
            let (c, s) = (pivot[k] / r, row[k] / r);
            for (above, below) in pivot[k..].iter_mut().zip(&mut row[k..]) {
                (*above, *below) = (c * *above + s * *below, c * *below - s * *above);
            }
            row[k] = 0.0;
        }
    }

    /// Vectors (of length 1, normal to each other) that all rows map to `tolerance` at most.
    ///
    /// Jacobi's method from one side finds small singular values to their own relative accuracy (J. Demmel and
    /// K. Veselić, SIAM J. Matrix Anal. Appl. 13, 1992).
    pub(super) fn null_space(&self, tolerance: f64) -> Vec<Vec<f64>> {
        let n = self.n;
        let unit = |j: usize| (0..n).map(|i| f64::from(u8::from(i == j))).collect::<Vec<f64>>();
        let mut images: Vec<Vec<f64>> = (0..n).map(|j| (0..n).map(|i| self.rows[i][j]).collect()).collect();
        let mut vectors: Vec<Vec<f64>> = (0..n).map(unit).collect();
        for _ in 0..SWEEPS {
            let mut rotated = false;
            for j in 1..n {
                for i in 0..j {
                    let (a, b) = (dot(&images[i], &images[i]), dot(&images[j], &images[j]));
                    let c = dot(&images[i], &images[j]);
                    if c.abs() <= f64::EPSILON * (a * b).sqrt() {
                        continue;
                    }
                    rotated = true;
                    let zeta = (b - a) / (2.0 * c);
                    let t = zeta.signum() / (zeta.abs() + 1.0_f64.hypot(zeta));
                    let cosine = 1.0 / 1.0_f64.hypot(t);
                    rotate(&mut images, (i, j), (cosine, cosine * t));
                    rotate(&mut vectors, (i, j), (cosine, cosine * t));
                }
            }
            if !rotated {
                break;
            }
        }
        let is_null = |image: &Vec<f64>| dot(image, image).sqrt() <= tolerance;
        vectors.into_iter().zip(&images).filter(|(_, image)| is_null(image)).map(|it| it.0).collect()
    }
}

fn rotate(columns: &mut [Vec<f64>], (i, j): (usize, usize), (c, s): (f64, f64)) {
    let (low, high) = columns.split_at_mut(j);
    for (x, y) in low[i].iter_mut().zip(&mut high[0]) {
        (*x, *y) = (c * *x - s * *y, s * *x + c * *y);
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Writes the span of vectors by vectors of which each alone has one of the leading entries, which is 1 (the reduced
/// row echelon form); entries of `tolerance` or less become 0.
pub(super) fn reduce(vectors: &mut Vec<Vec<f64>>, tolerance: f64) {
    let n = vectors.first().map_or(0, Vec::len);
    let mut done = 0;
    for column in 0..n {
        let size = |row: &usize| vectors[*row][column].abs();
        let Some(best) = (done..vectors.len()).max_by(|a, b| size(a).total_cmp(&size(b))) else { break };
        if size(&best) <= tolerance {
            continue;
        }
        vectors.swap(done, best);
        let pivot = vectors[done][column];
        vectors[done].iter_mut().for_each(|it| *it /= pivot);
        let lead = vectors[done].clone();
        for (row, vector) in vectors.iter_mut().enumerate() {
            let factor = vector[column];
            if row != done && factor != 0.0 {
                vector.iter_mut().zip(&lead).for_each(|(it, lead)| *it -= factor * lead);
            }
        }
        done += 1;
    }
    vectors.truncate(done);
    for entry in vectors.iter_mut().flatten().filter(|it| it.abs() <= tolerance) {
        *entry = 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn null_vectors_are_mapped_to_nothing_and_weak_rows_count() {
        let rows = [[1.0, 2.0, 3.0, 4.0], [2.0, 4.0, 6.0, 8.0], [0.0, 1.0, 0.0, -1.0]];
        let mut triangle = Triangle::new(4);
        rows.iter().for_each(|row| triangle.add(&mut row.clone()));
        let null = triangle.null_space(1e-12);
        assert_eq!(null.len(), 2);
        for (row, vector) in rows.iter().flat_map(|row| null.iter().map(move |it| (row, it))) {
            assert!(dot(row, vector).abs() < 1e-14);
        }
        triangle.add(&mut [1e-9, 0.0, 0.0, 0.0]);
        assert_eq!((triangle.null_space(1e-12).len(), triangle.null_space(1e-8).len()), (1, 2));
    }

    #[test]
    fn vectors_are_written_by_their_leading_entries() {
        let mut vectors = vec![vec![1.0, 1.0, 2.0], vec![1.0, -1.0, 2.0], vec![2.0, 0.0, 4.0]];
        reduce(&mut vectors, 1e-12);
        assert_eq!(vectors, [[1.0, 0.0, 2.0], [0.0, 1.0, 0.0]]);
    }
}

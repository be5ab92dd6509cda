//! Generalised minimal residuals, restarted and preconditioned from the right (Y. Saad and M. H. Schultz, SIAM J. Sci.
//! Stat. Comput. 7, 1986), for matrices that are not symmetric.
//!
//! With the preconditioner M⁻¹ on the right, A M⁻¹ u = b and x = M⁻¹ u, so that the residual that is minimised is that
//! of A x = b. M⁻¹ rounds to single precision and is not quite linear. x is therefore a sum of the vectors that were
//! multiplied by A, which are kept (Y. Saad, SIAM J. Sci. Comput. 14, 1993): in single precision, from which they come.

use super::arithmetic::{Vector, add, add_to_multiple, dot, for_each_node};
use super::blocks::BlockMatrix;
use super::outcome::{Converged, Stop};
use nalgebra::SVector;

/// Vectors of a Krylov space, after which the iteration begins anew from the residual.
pub(crate) const RESTART: usize = 60;

/// Vectors held at most, of which those in single precision count half.
pub(crate) const VECTORS: usize = RESTART + RESTART / 2 + 6;

/// Part of its residual that a whole Krylov space may leave before the iteration is given up.
const STAGNATION: f64 = 0.9;

/// Vectors of the iteration, kept from one system to the next.
#[derive(Clone, Debug)]
pub(crate) struct Iterates<const D: usize> {
    pub b: Vec<Vector<D>>,
    pub x: Vec<Vector<D>>,
    r: Vec<Vector<D>>,
    z: Vec<Vector<D>>,
    w: Vec<Vector<D>>,
    /// Orthonormal, as many as were needed so far.
    basis: Vec<Vec<Vector<D>>>,
    /// M⁻¹ times these, but for a power of two.
    preconditioned: Vec<Vec<SVector<f32, D>>>,
}

impl<const D: usize> Iterates<D> {
    pub(crate) fn zeros(n: usize) -> Self {
        let zeros = vec![Vector::zeros(); n];
        Self {
            b: zeros.clone(),
            x: zeros.clone(),
            r: zeros.clone(),
            z: zeros.clone(),
            w: zeros,
            basis: Vec::new(),
            preconditioned: Vec::new(),
        }
    }

    /// Makes `from · factor` a vector of the basis.
    fn set_basis(&mut self, place: usize, factor: f64, from: impl Fn(&Self) -> &[Vector<D>]) {
        if self.basis.len() == place {
            self.basis.push(vec![Vector::zeros(); self.b.len()]);
        }
        let mut vector = std::mem::take(&mut self.basis[place]);
        vector.fill(Vector::zeros());
        add(&mut vector, factor, from(self));
        self.basis[place] = vector;
    }

    /// Keeps z/unit as M⁻¹ times a vector of the basis.
    fn keep_preconditioned(&mut self, place: usize, unit: f64) {
        if self.preconditioned.len() == place {
            self.preconditioned.push(vec![SVector::zeros(); self.b.len()]);
        }
        let z = &self.z;
        for_each_node(&mut self.preconditioned[place], |node, kept| *kept = z[node].map(|z| (z / unit) as f32));
    }
}

/// Iterates from x = 0 until `|b − A x| ≤ tolerance · |b|`. The preconditioner is given vectors with their norms; for
/// vectors of norm 1 it returns `unit`, a power of two, times numbers in single precision.
pub(crate) fn solve<const D: usize>(
    matrix: &BlockMatrix<D>,
    iterates: &mut Iterates<D>,
    mut precondition: impl FnMut(&[Vector<D>], f64, &mut [Vector<D>]),
    unit: f64,
    (tolerance, most): (f64, u32),
) -> Stop {
    iterates.x.fill(Vector::zeros());
    let size = dot(&iterates.b, &iterates.b).sqrt();
    if size == 0.0 {
        return Stop::Solved(Converged { iterations: 0, residual: 0.0 });
    }
    iterates.r.copy_from_slice(&iterates.b);
    let (mut iterations, mut left) = (0, size);
    loop {
        let limits = (tolerance * size, most - iterations);
        let small = Small::of(matrix, iterates, (&mut precondition, unit), left, limits);
        iterations += small.columns.len() as u32;
        let Iterates { b, x, r, preconditioned, .. } = iterates;
        for (vector, factor) in preconditioned.iter().zip(small.minimise()) {
            let factor = factor * unit;
            for_each_node(x, |node, x| *x += vector[node].map(f64::from) * factor);
        }
        // The residual is computed from x, whatever the small problem says.
        matrix.multiply(x, r);
        add_to_multiple(r, -1.0, b);
        let before = std::mem::replace(&mut left, dot(r, r).sqrt());
        let reached = Converged { iterations, residual: left / size };
        if reached.residual <= tolerance {
            return Stop::Solved(reached);
        }
        // NaN is no progress either.
        let progresses = left <= STAGNATION * before;
        if iterations >= most || !progresses {
            return Stop::NotConverged(reached);
        }
    }
}

/// The small least-squares problem `min |β e₁ − H y|` of one Krylov space, with H brought to triangular form by
/// rotations as it grows.
struct Small {
    /// Columns of the triangle.
    columns: Vec<Vec<f64>>,
    /// Right-hand side, rotated; its last entry is what is left of the residual.
    rhs: Vec<f64>,
}

impl Small {
    /// Builds a Krylov space from the residual, whose norm is `beta`, until `wanted` or `most` is reached.
    fn of<const D: usize>(
        matrix: &BlockMatrix<D>,
        iterates: &mut Iterates<D>,
        (precondition, unit): (&mut impl FnMut(&[Vector<D>], f64, &mut [Vector<D>]), f64),
        beta: f64,
        (wanted, most): (f64, u32),
    ) -> Self {
        let mut small = Self { columns: Vec::new(), rhs: vec![beta] };
        let mut rotations: Vec<[f64; 2]> = Vec::new();
        iterates.set_basis(0, beta.recip(), |it| &it.r);
        for k in 0..RESTART.min(most as usize) {
            let Iterates { z, w, basis, .. } = &mut *iterates;
            precondition(&basis[k], 1.0, z);
            matrix.multiply(z, w);
            // Modified Gram–Schmidt.
            let mut column = Vec::with_capacity(k + 2);
            for vector in &basis[..=k] {
                let along = dot(w, vector);
                add(w, -along, vector);
                column.push(along);
            }
            let beyond = dot(w, w).sqrt();
            iterates.keep_preconditioned(k, unit);
            for (i, [c, s]) in rotations.iter().enumerate() {
                let (above, below) = (column[i], column[i + 1]);
                column[i] = c * above + s * below;
                column[i + 1] = c * below - s * above;
            }
            let length = column[k].hypot(beyond);
            if length == 0.0 || !length.is_finite() {
                // A M⁻¹ maps the space into itself and is singular there, or overflows.
                break;
            }
            let [c, s] = [column[k] / length, beyond / length];
            column[k] = length;
            rotations.push([c, s]);
            small.columns.push(column);
            let last = small.rhs[k];
            small.rhs[k] = c * last;
            small.rhs.push(-s * last);
            if beyond == 0.0 || (s * last).abs() <= wanted {
                break;
            }
            iterates.set_basis(k + 1, beyond.recip(), |it| &it.w);
        }
        small
    }

    /// y, by substitution backwards.
    fn minimise(&self) -> Vec<f64> {
        let n = self.columns.len();
        let mut y = self.rhs[..n].to_vec();
        for i in (0..n).rev() {
            for j in i + 1..n {
                y[i] -= self.columns[j][i] * y[j];
            }
            y[i] /= self.columns[i][i];
        }
        y
    }
}

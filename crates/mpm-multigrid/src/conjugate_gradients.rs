//! Preconditioned conjugate gradients (M. R. Hestenes and E. Stiefel, 1952).

use crate::Solved;
use crate::arithmetic::{Vector, add, add_to_multiple, dot};
use crate::blocks::BlockMatrix;

/// How the iteration ended.
pub(crate) enum Stop {
    Solved(Solved),
    NotConverged(Solved),
    /// A search direction along which the matrix is not positive; the row that it moves most.
    Indefinite {
        row: usize,
    },
}

/// Recomputed residuals that may still be too large before the iteration is given up.
const RESTARTS: u32 = 2;

/// Iterates from x = 0 until `|b − A x| ≤ tolerance · |b|`.
pub(crate) fn solve<const D: usize>(
    matrix: &BlockMatrix<D>,
    b: &[Vector<D>],
    mut precondition: impl FnMut(&[Vector<D>], &mut [Vector<D>]),
    tolerance: f64,
    most: u32,
) -> (Vec<Vector<D>>, Stop) {
    let n = b.len();
    let mut x = vec![Vector::zeros(); n];
    let size = dot(b, b).sqrt();
    if size == 0.0 {
        return (x, Stop::Solved(Solved { iterations: 0, residual: 0.0 }));
    }
    let mut r = b.to_vec();
    let (mut z, mut ap) = (vec![Vector::zeros(); n], vec![Vector::zeros(); n]);
    let mut p: Vec<Vector<D>> = Vec::new();
    let (mut rz, mut iterations, mut restarts) = (0.0, 0, 0);
    loop {
        let mut residual = dot(&r, &r).sqrt() / size;
        if residual <= tolerance {
            // What the recurrence says is checked.
            matrix.multiply(&x, &mut r);
            add_to_multiple(&mut r, -1.0, b);
            residual = dot(&r, &r).sqrt() / size;
            let solved = Solved { iterations, residual };
            if residual <= tolerance {
                return (x, Stop::Solved(solved));
            }
            restarts += 1;
            if restarts > RESTARTS {
                return (x, Stop::NotConverged(solved));
            }
            p.clear();
        }
        if iterations == most || !residual.is_finite() {
            return (x, Stop::NotConverged(Solved { iterations, residual }));
        }
        precondition(&r, &mut z);
        let before = std::mem::replace(&mut rz, dot(&r, &z));
        if p.is_empty() {
            p.extend_from_slice(&z);
        } else {
            add_to_multiple(&mut p, rz / before, &z);
        }
        matrix.multiply(&p, &mut ap);
        let curvature = dot(&p, &ap);
        if curvature <= 0.0 || rz <= 0.0 {
            let row = (0..n).fold(0, |most, row| if p[row].amax() > p[most].amax() { row } else { most });
            return (x, Stop::Indefinite { row });
        }
        let length = rz / curvature;
        add(&mut x, length, &p);
        add(&mut r, -length, &ap);
        iterations += 1;
    }
}

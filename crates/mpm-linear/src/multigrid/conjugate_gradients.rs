//! Preconditioned conjugate gradients (M. R. Hestenes and E. Stiefel, 1952).

use super::arithmetic::{Vector, add, add_to_multiple, dot};
use super::blocks::BlockMatrix;
use super::outcome::{Converged, Stop};

/// Recomputed residuals that may still be too large before the iteration is given up.
const RESTARTS: u32 = 2;

/// Vectors of the iteration, kept from one system to the next.
#[derive(Clone, Debug)]
pub(crate) struct Iterates<const D: usize> {
    pub b: Vec<Vector<D>>,
    pub x: Vec<Vector<D>>,
    r: Vec<Vector<D>>,
    z: Vec<Vector<D>>,
    p: Vec<Vector<D>>,
    ap: Vec<Vector<D>>,
}

impl<const D: usize> Iterates<D> {
    pub(crate) fn zeros(n: usize) -> Self {
        let zeros = vec![Vector::zeros(); n];
        Self {
            b: zeros.clone(),
            x: zeros.clone(),
            r: zeros.clone(),
            z: zeros.clone(),
            p: zeros.clone(),
            ap: zeros,
        }
    }
}

/// Iterates from x = 0 until `|b − A x| ≤ tolerance · |b|`. The preconditioner is given vectors with their norms.
pub(crate) fn solve<const D: usize>(
    matrix: &BlockMatrix<D>,
    iterates: &mut Iterates<D>,
    mut precondition: impl FnMut(&[Vector<D>], f64, &mut [Vector<D>]),
    tolerance: f64,
    most: u32,
) -> Stop {
    let Iterates { b, x, r, z, p, ap } = iterates;
    x.fill(Vector::zeros());
    let size = dot(b, b).sqrt();
    if size == 0.0 {
        return Stop::Solved(Converged { iterations: 0, residual: 0.0 });
    }
    r.copy_from_slice(b);
    let (mut rz, mut iterations, mut restarts, mut begins) = (0.0, 0, 0, true);
    loop {
        let mut residual = dot(r, r).sqrt() / size;
        if residual <= tolerance {
            // What the recurrence says is checked.
            matrix.multiply(x, r);
            add_to_multiple(r, -1.0, b);
            residual = dot(r, r).sqrt() / size;
            let solved = Converged { iterations, residual };
            if residual <= tolerance {
                return Stop::Solved(solved);
            }
            restarts += 1;
            if restarts > RESTARTS {
                return Stop::NotConverged(solved);
            }
            begins = true;
        }
        if iterations == most || !residual.is_finite() {
            return Stop::NotConverged(Converged { iterations, residual });
        }
        precondition(r, residual * size, z);
        let before = std::mem::replace(&mut rz, dot(r, z));
        if std::mem::take(&mut begins) {
            p.copy_from_slice(z);
        } else {
            add_to_multiple(p, rz / before, z);
        }
        matrix.multiply(p, ap);
        let curvature = dot(p, ap);
        if curvature <= 0.0 || rz <= 0.0 {
            let row = (0..p.len()).fold(0, |most, row| if p[row].amax() > p[most].amax() { row } else { most });
            return Stop::Indefinite { row };
        }
        let length = rz / curvature;
        add(x, length, p);
        add(r, -length, ap);
        iterations += 1;
    }
}

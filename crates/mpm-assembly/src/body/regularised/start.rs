//! The nodal field that follows given drivers: a linear system, from whose solution Newton's method begins.
//!
//! ```text
//! Σ_w Σ_p V⁰_p [h S_vp S_wp + A Grad S_vp · Grad S_wp] k_w = Σ_p V⁰_p h d_p S_vp
//! ```
//!
//! This is Helmholtz's equation k − l² ∇²k = d with no flux across the boundary. It is solved by conjugate gradients with
//! the diagonal as preconditioner, in the order of the nodes, so that threads change nothing.

use super::plan::FieldPlan;
use super::trial::at_rest;
use crate::body::assembly_plan::AssemblyPlan;
use crate::unknowns::SparsityPattern;
use mpm_grid::{Block, Vector};
use mpm_material::Regularisation;

/// Part of the right-hand side that is left; Newton's method removes the rest.
const LEFT: f64 = 1e-12;

/// Iterations at most.
const ITERATIONS: usize = 2000;

/// A point of a regularised body as the field sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldPoint<const D: usize> {
    /// V⁰ `[L^D]`.
    pub volume: f64,
    /// F `[-]`.
    pub deformation_gradient: Block<D>,
    /// d `[-]`.
    pub driver: f64,
    /// By how much the last load step changed d.
    pub driver_step: f64,
}

/// The nodal field at the start of a load step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FieldStart {
    /// The field that follows the drivers of the points `[-]`.
    pub field: Vec<f64>,
    /// The field that follows the changes of the drivers in the last load step `[-]`.
    pub change: Vec<f64>,
    /// `Σ_p V⁰_p h S_vp` of every node `[F L^(D−2)]`.
    pub weight: Vec<f64>,
}

/// A regularised body with its plan, its field, and its points by number.
pub type FollowedBody<'a, const D: usize> =
    (&'a AssemblyPlan<D>, Regularisation, &'a dyn Fn(usize) -> FieldPoint<D>);

/// The field that follows the drivers of the points of regularised bodies.
pub fn follow<const D: usize>(pattern: &SparsityPattern<D>, bodies: &[FollowedBody<'_, D>]) -> FieldStart {
    let Some((first, ..)) = bodies.first() else { return FieldStart::default() };
    let n = first.field().nodes.len();
    let first = first.field().nodes.unknown(0).equation();
    let mut system = System { pattern, first, values: vec![0.0; pattern.column_range(first..first + n).len()] };
    let (mut field, mut change, mut weight) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    let mut gradients: Vec<Vector<D>> = Vec::new();
    for &(plan, regularisation, point) in bodies {
        let connectivity = plan.connectivity();
        let FieldPlan { nodes, .. } = plan.field();
        for set in 0..connectivity.n_node_sets() {
            let at = connectivity.node_set(set);
            let mut dense = vec![0.0; at.len() * (at.len() + 1) / 2];
            for &group in connectivity.node_set_groups(set) {
                let group = connectivity.group(group as usize);
                for k in 0..group.points {
                    let of = point(group.first_point + k);
                    let (values, slopes) = group.point(k);
                    let modulus = of.volume * regularisation.modulus();
                    let gradient_modulus = of.volume * regularisation.gradient_modulus();
                    gradients.clear();
                    gradients.extend(slopes.iter().map(|slope| at_rest(&of.deformation_gradient, slope)));
                    let mut sums = dense.iter_mut();
                    for (w, &node) in at.iter().enumerate() {
                        let entry = nodes.entry(node as usize);
                        let share = modulus * values[w];
                        field[entry] += share * of.driver;
                        change[entry] += share * of.driver_step;
                        weight[entry] += share;
                        let gradient = gradients[w] * gradient_modulus;
                        for (v, sum) in (w..at.len()).zip(&mut sums) {
                            *sum += share * values[v] + gradient.dot(&gradients[v]);
                        }
                    }
                }
            }
            system.add(at, plan.field(), set, &dense);
        }
    }
    FieldStart { field: system.solve(field), change: system.solve(change), weight }
}

/// The columns of the field in the tangent, from the diagonal down.
struct System<'a, const D: usize> {
    pattern: &'a SparsityPattern<D>,
    /// The first equation of the field.
    first: usize,
    /// One for each entry of these columns, 0 where it is not of the field or above the diagonal.
    values: Vec<f64>,
}

impl<const D: usize> System<'_, D> {
    fn add(&mut self, nodes: &[u32], field: &FieldPlan<D>, set: usize, dense: &[f64]) {
        let (starts, n) = (self.pattern.column_start(), nodes.len());
        let symmetry = self.pattern.symmetry();
        let offsets = field.offsets(set, n, symmetry);
        let mut dense = dense.iter();
        for (w, &node) in nodes.iter().enumerate() {
            let start = starts[self.first + field.nodes.entry(node as usize)] - starts[self.first];
            for (v, value) in (w..n).zip(&mut dense) {
                self.values[start + offsets.below(w, v, n, symmetry)] += value;
            }
        }
    }

    /// Calls `see` with row, column (from 0 on) and value of every entry from the diagonal down.
    fn for_each(&self, mut see: impl FnMut(usize, usize, f64)) {
        let starts = self.pattern.column_start();
        let base = starts[self.first];
        for column in 0.. {
            let equation = self.first + column;
            if equation + 1 >= starts.len() || starts[equation] - base >= self.values.len() {
                return;
            }
            for entry in starts[equation]..starts[equation + 1] {
                let row = self.pattern.row()[entry];
                // Rows of other unknowns, and of an unsymmetric tangent those above the diagonal, hold nothing.
                if row >= equation && self.values[entry - base] != 0.0 {
                    see(row - self.first, column, self.values[entry - base]);
                }
            }
        }
    }

    /// Conjugate gradients; what they have found after [`ITERATIONS`] is a start, too.
    fn solve(&self, rhs: Vec<f64>) -> Vec<f64> {
        let n = rhs.len();
        let mut x = vec![0.0; n];
        if rhs.iter().all(|b| *b == 0.0) {
            return x;
        }
        let mut diagonal = vec![0.0; n];
        self.for_each(|row, column, value| {
            if row == column {
                diagonal[row] = value;
            }
        });
        let precondition = |r: &[f64]| -> Vec<f64> { r.iter().zip(&diagonal).map(|(r, d)| r / d).collect() };
        let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let mut r = rhs;
        let mut z = precondition(&r);
        let (mut p, mut rz) = (z.clone(), dot(&r, &z));
        let goal = LEFT * LEFT * rz;
        let mut image = vec![0.0; n];
        for _ in 0..ITERATIONS {
            image.fill(0.0);
            self.for_each(|row, column, value| {
                image[row] += value * p[column];
                if row != column {
                    image[column] += value * p[row];
                }
            });
            let step = rz / dot(&p, &image);
            for k in 0..n {
                x[k] += step * p[k];
                r[k] -= step * image[k];
            }
            z = precondition(&r);
            let next = dot(&r, &z);
            if next <= goal || next.is_nan() {
                break;
            }
            let turn = next / rz;
            rz = next;
            p.iter_mut().zip(&z).for_each(|(p, z)| *p = z + turn * *p);
        }
        x
    }
}

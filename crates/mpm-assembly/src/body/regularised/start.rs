//! The nodal field that follows given drivers: a linear system, from whose solution Newton's method begins.
//!
//! ```text
//! Σ_w Σ_p V⁰_p [h S_vp S_wp + A Grad S_vp · Grad S_wp] k_w = Σ_p V⁰_p h d_p S_vp
//! ```
//!
//! This is Helmholtz's equation k − l² ∇²k = d with no flux across the boundary. It is solved by conjugate gradients with
//! the diagonal as preconditioner, in the order of the nodes, so that threads change nothing. They begin with the mean of the
//! drivers around each node, which is the solution where the drivers are uniform.

use super::plan::{FieldPlan, FieldPoint};
use crate::body::assembly_plan::AssemblyPlan;
use crate::sharing::Unshared;
use crate::unknowns::SparsityPattern;
use mpm_material::Regularisation;

/// Part of the right-hand side that is left; Newton's method removes the rest.
const LEFT: f64 = 1e-6;

/// Iterations at most.
const ITERATIONS: usize = 2000;

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

/// Who else has points of the same regularised bodies. Every method has the body of one who has all; all who share the field
/// call it together.
pub trait SharedField {
    /// Adds to one number for each node of the field what others have of the same nodes.
    fn complete(&self, field: &mut [f64]) {
        let _ = field;
    }

    /// Scalar product over the nodes that anybody has, each once.
    fn dot(&self, a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }
}

impl SharedField for Unshared {}

/// The field that follows the drivers of the points of regularised bodies.
pub fn follow<const D: usize>(
    pattern: &SparsityPattern<D>,
    bodies: &[FollowedBody<'_, D>],
    shared: &dyn SharedField,
) -> FieldStart {
    let Some((first, ..)) = bodies.first() else { return FieldStart::default() };
    let n = first.field().nodes.len();
    let first = first.field().nodes.unknown(0).equation();
    let values = vec![0.0; pattern.column_range(first..first + n).len()];
    let mut system = System { pattern, first, n, values };
    let (mut field, mut change, mut weight) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    for &(plan, regularisation, point) in bodies {
        let connectivity = plan.connectivity();
        let FieldPlan { nodes, .. } = plan.field();
        for group in (0..connectivity.n_groups()).map(|group| connectivity.group(group)) {
            for k in 0..group.points {
                let FieldPoint { volume, driver, driver_step, .. } = point(group.first_point + k);
                for (&node, value) in group.nodes.iter().zip(group.point(k).0) {
                    let (entry, share) =
                        (nodes.entry(node as usize), volume * regularisation.modulus() * value);
                    field[entry] += share * driver;
                    change[entry] += share * driver_step;
                    weight[entry] += share;
                }
            }
        }
        for set in 0..connectivity.n_node_sets() {
            system.add(connectivity.node_set(set), plan.field(), set);
        }
    }
    [&mut field, &mut change, &mut weight].into_iter().for_each(|sums| shared.complete(sums));
    let diagonal = system.diagonal(shared);
    let [field, change] = [field, change].map(|rhs| system.solve(rhs, (&weight, &diagonal), shared));
    FieldStart { field, change, weight }
}

/// The columns of the field in the tangent, from the diagonal down.
struct System<'a, const D: usize> {
    pattern: &'a SparsityPattern<D>,
    /// The first equation of the field, and how many it has.
    first: usize,
    n: usize,
    /// One for each entry of these columns, 0 where it is not of the field or above the diagonal.
    values: Vec<f64>,
}

impl<const D: usize> System<'_, D> {
    fn add(&mut self, nodes: &[u32], field: &FieldPlan<D>, set: usize) {
        let (starts, n) = (self.pattern.column_start(), nodes.len());
        let symmetry = self.pattern.symmetry();
        let offsets = field.offsets(set, n, symmetry);
        let mut dense = field.helmholtz(set).iter();
        for (w, &node) in nodes.iter().enumerate() {
            let start = starts[self.first + field.nodes.entry(node as usize)] - starts[self.first];
            for (v, value) in (w..n).zip(&mut dense) {
                self.values[start + offsets.below(w, v, n, symmetry)] += value;
            }
        }
    }

    /// Adds the product of the matrix and a vector to its image.
    fn add_product(&self, vector: &[f64], image: &mut [f64]) {
        let starts = &self.pattern.column_start()[self.first..];
        for (column, entries) in starts.windows(2).take(vector.len()).enumerate() {
            let values = &self.values[entries[0] - starts[0]..entries[1] - starts[0]];
            for (&row, &value) in self.pattern.row()[entries[0]..entries[1]].iter().zip(values) {
                // Rows of other unknowns, and of an unsymmetric tangent those above the diagonal, hold nothing.
                if value == 0.0 {
                    continue;
                }
                let row = row - self.first;
                image[row] += value * vector[column];
                if row != column {
                    image[column] += value * vector[row];
                }
            }
        }
    }

    /// The product of the matrix of all who share the field and a vector.
    fn product(&self, vector: &[f64], image: &mut [f64], shared: &dyn SharedField) {
        image.fill(0.0);
        self.add_product(vector, image);
        shared.complete(image);
    }

    fn diagonal(&self, shared: &dyn SharedField) -> Vec<f64> {
        let starts = self.pattern.column_start();
        let n = self.n;
        let diagonal = (0..n).map(|k| self.values[self.pattern.diagonal(self.first + k) - starts[self.first]]);
        let mut diagonal: Vec<f64> = diagonal.collect();
        shared.complete(&mut diagonal);
        diagonal
    }

    /// Conjugate gradients from `rhs` over `weight` on; what they have found after [`ITERATIONS`] is a start, too.
    fn solve(&self, rhs: Vec<f64>, (weight, diagonal): (&[f64], &[f64]), shared: &dyn SharedField) -> Vec<f64> {
        let n = rhs.len();
        let dot = |a: &[f64], b: &[f64]| shared.dot(a, b);
        let is_something: Vec<f64> = rhs.iter().map(|b| f64::from(u8::from(*b != 0.0))).collect();
        if dot(&is_something, &is_something) == 0.0 {
            return rhs;
        }
        let precondition = |r: &[f64]| -> Vec<f64> { r.iter().zip(diagonal).map(|(r, d)| r / d).collect() };
        let mean = |(b, weight): (&f64, &f64)| if *weight > 0.0 { b / weight } else { 0.0 };
        let mut x: Vec<f64> = rhs.iter().zip(weight).map(mean).collect();
        let goal = LEFT * LEFT * dot(&rhs, &precondition(&rhs));
        let mut image = vec![0.0; n];
        self.product(&x, &mut image, shared);
        let mut r: Vec<f64> = rhs.iter().zip(&image).map(|(b, image)| b - image).collect();
        let mut z = precondition(&r);
        let (mut p, mut rz) = (z.clone(), dot(&r, &z));
        for _ in 0..ITERATIONS {
            if rz <= goal || rz.is_nan() {
                break;
            }
            self.product(&p, &mut image, shared);
            let step = rz / dot(&p, &image);
            for k in 0..n {
                x[k] += step * p[k];
                r[k] -= step * image[k];
            }
            z = precondition(&r);
            let next = dot(&r, &z);
            let turn = next / rz;
            rz = next;
            p.iter_mut().zip(&z).for_each(|(p, z)| *p = z + turn * *p);
        }
        x
    }
}

//! Who computes a model together: ranks, each with some of the points of every body.
//!
//! A rank sums the forces and the tangent of **its** points into **its** arrays; a node that several ranks reach has one
//! owner, and what they have of it is added there. What the solver decides by is a completed or a gathered number, so that
//! all ranks decide alike. [`Alone`] nothing is exchanged, and every sum is the plain one.

use crate::failure::StepFailure;
use crate::model::Model;
use mpm_assembly::{Constraints, Scale, Sharing, SparsityPattern, leave_to_owners};
use mpm_basis::{ActiveNodes, Stencils};
use mpm_grid::{LoadFraction, Mesh, Vector};
use mpm_linear::LinearSolver;
use std::rc::Rc;

/// Ranks that share a model, as one of them sees them.
///
/// Every method is called by all ranks, in the same order: it may exchange. Each has the body of one rank that is alone.
pub trait Ranks<const D: usize>: Sharing<D> {
    /// Number of ranks.
    fn size(&self) -> usize {
        1
    }

    /// Called once, before the first load step, with a model that is the same and whole on every rank, or of which every rank has
    /// a [share](Model::share): leaves every rank with what it shall hold. `at` is the load fraction whose mesh the points stand in.
    ///
    /// # Errors
    /// What in the model cannot be shared, in a sentence that says what was expected; the same on all ranks.
    fn divide(&self, model: &mut Model<D>, at: LoadFraction) -> Result<(), String> {
        let _ = (model, at);
        Ok(())
    }

    /// The active nodes of this rank: those that its points influence, and those that it owns. All fields that are completed
    /// from here on are of these nodes.
    fn activate(&self, model: &Model<D>, mesh: &Mesh<D>, stencils: &[Stencils<D>]) -> ActiveNodes<D> {
        let _ = mesh;
        ActiveNodes::of(&model.nodes, stencils)
    }

    /// Of every node that was activated last, whether this rank counts it: every node is counted by one. None where all are.
    fn owned(&self) -> Option<Rc<[bool]>> {
        None
    }

    /// Adds to a field of the active nodes what other ranks have of the same nodes.
    fn complete(&self, field: &mut [Vector<D>]) {
        let _ = field;
    }

    /// The same of one number per node.
    fn complete_numbers(&self, field: &mut [f64]) {
        let _ = field;
    }

    /// Sums over all ranks, number by number, in the order of the ranks.
    fn sum(&self, values: &mut [f64]) {
        let _ = values;
    }

    /// The least of all ranks, number by number.
    fn least(&self, values: &mut [f64]) {
        let _ = values;
    }

    /// The bits that are set on any rank, byte by byte.
    fn unite(&self, bits: &mut [u8]) {
        let _ = bits;
    }

    /// The failure of the lowest rank that has one, on all ranks, see [`StepFailure::to_bytes`].
    fn tell(&self, failure: Option<StepFailure>) -> Option<StepFailure> {
        failure
    }

    /// Called between two load steps: takes points to the ranks on which they shall be, with what names them in the model.
    /// `at` is the load fraction whose mesh they meet next.
    fn settle(&self, model: &mut Model<D>, at: LoadFraction) {
        let _ = (model, at);
    }

    /// Points of a body were split: `parts` tells for every point of now its point of before, and its share of that; it is
    /// empty where none was split on this rank.
    fn split(&self, body: usize, parts: &[(usize, f64)]) {
        let _ = (body, parts);
    }

    /// Whether this rank has the whole model. Where it has not, nothing is said of what only the whole can tell: rigid
    /// motions that nothing holds, and remedies against failures.
    fn sees_all(&self) -> bool {
        true
    }

    /// Number among all points of a body, in the order in which one rank has them, of a point of this rank.
    fn number_of_point(&self, body: usize, point: usize) -> usize {
        let _ = body;
        point
    }

    /// The linear solver of the ranks, in place of the model's. It is given the patterns, matrices and equations of this
    /// rank, where the matrices of all ranks add up to the matrix of the system, and right-hand sides that are complete. Its
    /// solutions are complete, too; what it reports is the same on all ranks. A failure may be reported by one of them.
    fn solver(&self, model: &Model<D>) -> Option<Box<dyn LinearSolver>> {
        let _ = model;
        None
    }
}

/// One process that has the whole model.
#[derive(Clone, Copy, Debug, Default)]
pub struct Alone;

impl<const D: usize> Sharing<D> for Alone {}

impl<const D: usize> Ranks<D> for Alone {}

/// The sum over all ranks.
pub(crate) fn total<const D: usize>(ranks: &dyn Ranks<D>, here: f64) -> f64 {
    let mut sum = [here];
    ranks.sum(&mut sum);
    sum[0]
}

/// The sum of counts over all ranks; exact below 2⁵³.
pub(crate) fn count<const D: usize>(ranks: &dyn Ranks<D>, here: u64) -> u64 {
    total(ranks, here as f64) as u64
}

/// The least of all ranks.
pub(crate) fn least<const D: usize>(ranks: &dyn Ranks<D>, here: f64) -> f64 {
    let mut least = [here];
    ranks.least(&mut least);
    least[0]
}

/// The largest of all ranks.
pub(crate) fn largest<const D: usize>(ranks: &dyn Ranks<D>, here: f64) -> f64 {
    -least(ranks, -here)
}

/// Whether it is so on any rank.
pub(crate) fn any<const D: usize>(ranks: &dyn Ranks<D>, here: bool) -> bool {
    total(ranks, f64::from(u8::from(here))) > 0.0
}

/// Whether it is so on all ranks.
pub(crate) fn all<const D: usize>(ranks: &dyn Ranks<D>, here: bool) -> bool {
    !any(ranks, !here)
}

/// What has failed on one rank has failed on all, for the same reason.
///
/// # Errors
/// The failure of the lowest rank that has one.
pub(crate) fn agreed<const D: usize, T>(
    ranks: &dyn Ranks<D>,
    here: Result<T, StepFailure>,
) -> Result<T, StepFailure> {
    match here {
        Ok(value) => ranks.tell(None).map_or(Ok(value), Err),
        Err(failure) => Err(ranks.tell(Some(failure)).expect("a failure that was told is heard")),
    }
}

/// The nodes of a rank, and with whom it shares them.
#[derive(Clone)]
pub(crate) struct Shared<const D: usize> {
    pub ranks: Rc<dyn Ranks<D>>,
    owned: Option<Rc<[bool]>>,
}

impl<const D: usize> Shared<D> {
    /// Of the nodes that were activated last.
    pub(crate) fn of(ranks: &Rc<dyn Ranks<D>>) -> Self {
        Self { ranks: ranks.clone(), owned: ranks.owned() }
    }

    /// Whether this rank counts a node.
    #[inline]
    pub(crate) fn counts(&self, node: usize) -> bool {
        self.owned.as_ref().is_none_or(|owned| owned[node])
    }

    /// Leaves the diagonal of prescribed components to the owners of their nodes.
    pub(crate) fn leave_to_owners(
        &self,
        pattern: &SparsityPattern<D>,
        constraints: &Constraints<D>,
        values: &mut [f64],
    ) {
        if let Some(owned) = &self.owned {
            leave_to_owners(pattern, constraints, values, owned);
        }
    }

    /// Those of the nodes that this rank counts, with what they have.
    pub(crate) fn counted<'a, T>(
        &'a self,
        of_nodes: impl Iterator<Item = T> + Clone + 'a,
    ) -> impl Iterator<Item = (usize, T)> + Clone + 'a {
        of_nodes.enumerate().filter(|it| self.counts(it.0))
    }

    /// Scalar product over the nodes of all ranks, summed node by node.
    pub(crate) fn dot_nodes(&self, a: &[Vector<D>], b: &[Vector<D>]) -> f64 {
        total(&*self.ranks, self.counted(a.iter().zip(b)).map(|(_, (a, b))| a.dot(b)).sum())
    }

    /// Those of some nodes that this rank counts: what they have.
    pub(crate) fn counted_at<'a, T>(
        &'a self,
        nodes: &'a [usize],
        of_nodes: impl Iterator<Item = T> + Clone + 'a,
    ) -> impl Iterator<Item = T> + Clone + 'a {
        nodes.iter().zip(of_nodes).filter(|it| self.counts(*it.0)).map(|it| it.1)
    }

    /// Adds to one number for each of some nodes, of so many, what other ranks have of the same nodes.
    pub(crate) fn complete_at(&self, nodes: &[usize], field: &mut [f64], n_nodes: usize) {
        if self.owned.is_none() {
            return;
        }
        let mut of_all = vec![0.0; n_nodes];
        nodes.iter().zip(&*field).for_each(|(&node, value)| of_all[node] = *value);
        self.ranks.complete_numbers(&mut of_all);
        nodes.iter().zip(field).for_each(|(&node, value)| *value = of_all[node]);
    }

    /// Euclidean norm of a complete field of the nodes, see [`norm`].
    pub(crate) fn norm(&self, field: &[Vector<D>]) -> f64 {
        norm(&*self.ranks, self.counted(field.iter()).map(|(_, x)| *x))
    }

    /// The size that a contribution tells `[F]`.
    pub(crate) fn scale(&self, scale: Scale<D>) -> f64 {
        match scale {
            Scale::Size(size) => size,
            Scale::OfNodes(mut forces) => {
                self.ranks.complete(&mut forces);
                self.norm(&forces)
            }
        }
    }

    /// The same of one number per node.
    pub(crate) fn norm_of(&self, field: &[f64]) -> f64 {
        norm(&*self.ranks, self.counted(field.iter()).map(|(_, x)| Vector::<1>::new(*x)))
    }

    /// The same of one number for each of some nodes.
    pub(crate) fn norm_at(&self, nodes: &[usize], field: &[f64]) -> f64 {
        norm(&*self.ranks, self.counted_at(nodes, field.iter()).map(|x| Vector::<1>::new(*x)))
    }
}

/// Euclidean norm of the forces of all ranks, whatever their size: squares that would overflow or vanish are scaled.
pub(crate) fn norm<const D: usize, const E: usize>(
    ranks: &dyn Ranks<D>,
    forces: impl Iterator<Item = Vector<E>> + Clone,
) -> f64 {
    let sum = total(ranks, forces.clone().map(|x| x.norm_squared()).sum());
    if sum.is_nan() || (sum.is_finite() && sum > f64::MIN_POSITIVE / f64::EPSILON) {
        return sum.sqrt();
    }
    let largest = largest(ranks, forces.clone().map(|x| x.amax()).fold(0.0, f64::max));
    if largest == 0.0 || largest.is_infinite() {
        return largest;
    }
    largest * total(ranks, forces.map(|x| (x / largest).norm_squared()).sum()).sqrt()
}

/// The same of single numbers that one rank has.
pub(crate) fn norm_of(numbers: &[f64]) -> f64 {
    norm::<1, 1>(&Alone, numbers.iter().map(|&x| Vector::<1>::new(x)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn norms_neither_overflow_nor_vanish() {
        for size in [1.0, 1e-320, 1e-250, 1e160, 1e307] {
            let norm = norm_of(&[3.0 * size, -4.0 * size]);
            assert!((norm / (5.0 * size) - 1.0).abs() < 1e-3, "{norm:e} of {size:e}");
        }
        assert_eq!((norm_of(&[]), norm_of(&[0.0])), (0.0, 0.0));
        assert!(norm_of(&[f64::NAN, 1e200]).is_nan() && norm_of(&[1e200, f64::NAN]).is_nan());
        assert!(norm_of(&[f64::INFINITY, 1.0]).is_infinite());
    }
}

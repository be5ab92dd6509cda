//! How much of a correction is taken.

use super::problem::{Iterate, Problem, Wanted};
use super::system::Solver;
use crate::failure::StepFailure;
use mpm_assembly::UnknownVector;
use mpm_grid::Vector;

/// A correction overshoots where the work at its end is minus this, or less, times that at its start.
const OVERSHOT: f64 = 0.9;

/// Evaluations in the search for a shorter correction at most.
const SEARCHES: usize = 5;

/// A correction of the displacement and what is known of it.
pub(crate) struct Correction<'a, const D: usize> {
    /// The increment before it `[L]`.
    pub start: &'a UnknownVector<D>,
    /// The correction, zero on prescribed components `[L]`.
    pub free: &'a UnknownVector<D>,
    /// Prescribed increments that it brings along, whole whatever part of it is taken; only the first
    /// correction has them `[L]`.
    pub lift: &'a [Vector<D>],
    /// Work along it of the out-of-balance force that it answers `[F L]`.
    pub work: f64,
    /// Smallest part that is tried where it inverts a point.
    pub least_part: f64,
    /// Whether it is taken whole or not at all.
    pub whole: bool,
}

/// How much of a correction was taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Taken {
    Whole,
    /// Less, because it overshot; all of it where it must be whole.
    Overshot,
    /// Less, because it inverted a point.
    Inverted,
}

impl<const D: usize> Correction<'_, D> {
    fn apply(&self, part: f64, increment: &mut UnknownVector<D>) {
        let Self { start, free, lift, .. } = self;
        for ((increment, start), free) in increment.nodes.iter_mut().zip(&start.nodes).zip(&free.nodes) {
            *increment = start + free * part;
        }
        for (increment, lift) in increment.nodes.iter_mut().zip(*lift) {
            *increment += lift;
        }
        for ((increment, start), free) in increment.own.iter_mut().zip(&start.own).zip(&free.own) {
            *increment = start + free * part;
        }
    }

    /// Adds the correction, or a part of it: a half, a quarter, … until no point is inverted, and where
    /// the whole would overshoot (the work of the out-of-balance force along it changes sign and is not
    /// smaller than at the start) about as much of it as makes that work vanish.
    ///
    /// # Errors
    /// Even the smallest part inverts a point, or a correction does that must be whole.
    pub(crate) fn add_to(
        &self,
        problem: &Problem<'_, D>,
        iterate: &mut Iterate<D>,
        wanted: Wanted,
        solver: &mut Solver<D>,
    ) -> Result<Taken, StepFailure> {
        let mut part = 1.0;
        loop {
            self.apply(part, &mut iterate.increment);
            match solver.evaluate(problem, iterate, wanted, None) {
                Err(failure) if failure.is_of_trial() && part > self.least_part && !self.whole => {
                    part *= 0.5;
                    iterate.effort.shortened += 1;
                }
                result => break result?,
            }
        }

        let at_start = self.work;
        let connected = problem.connected;
        let at_end = connected.dot(self.free, &iterate.out_of_balance);
        if part < 1.0 {
            return Ok(Taken::Inverted);
        }
        if at_start <= 0.0 || at_end > -OVERSHOT * at_start {
            return Ok(Taken::Whole);
        }
        iterate.effort.shortened += 1;
        if self.whole {
            return Ok(Taken::Overshot);
        }
        // Illinois variant of the false position method, on the sign change between none and all of it.
        let (mut low, mut low_work, mut high, mut high_work) = (0.0, at_start, 1.0, at_end);
        for _ in 0..SEARCHES {
            part = (low * high_work - high * low_work) / (high_work - low_work);
            self.apply(part, &mut iterate.increment);
            solver.evaluate(problem, iterate, Wanted::Force, None)?;
            let here = connected.dot(self.free, &iterate.out_of_balance);
            if here.abs() <= 0.5 * at_start {
                break;
            }
            if here > 0.0 {
                (low, low_work, high_work) = (part, here, 0.5 * high_work);
            } else {
                (high, high_work, low_work) = (part, here, 0.5 * low_work);
            }
        }
        if wanted == Wanted::ForceAndTangent {
            solver.evaluate(problem, iterate, wanted, None)?;
        }
        Ok(Taken::Overshot)
    }
}

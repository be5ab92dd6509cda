//! A run in a few numbers.

use super::{Balanced, StepResult};
use crate::equilibrium::problem::larger;
use crate::model::Model;
use crate::progress::Totals;
use crate::ranks::{Ranks, count};
use crate::remedy::{crowding_over_shear, pressure_over_shear};
use crate::timing::{Timing, Timings};
use mpm_grid::LoadFraction;

/// A run in a few numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Converged load steps.
    pub steps: usize,
    /// Number of linear solves that led to an equilibrium.
    pub iterations: u64,
    /// Number of linear solves spent on predictors that were discarded.
    pub dropped_iterations: u64,
    /// Times a step was halved.
    pub cuts: u64,
    /// Number of Newton corrections of which only a part was taken.
    pub shortened: u64,
    /// Steps that had to be balanced with relaxation.
    pub relaxed_steps: u64,
    /// Steps in which the tangent was not positive definite.
    pub indefinite_steps: u64,
    /// Smallest `det ΔF` of any point in any step `[-]`.
    pub smallest_determinant: f64,
    /// Largest relative out-of-balance force that a step was left with `[-]`.
    pub residual: f64,
    /// Largest componentwise backward error of a linear solution, of those whose backward error is known `[-]`.
    pub backward_error: Option<f64>,
    /// Steps of iterative refinement of linear solutions.
    pub refinements: u64,
    /// Largest ratio of the pivots of one factorisation, where pivots are known: the condition number was that large or
    /// larger `[-]`.
    pub pivot_spread: Option<f64>,
    /// Largest estimate of the condition number (by power and inverse iteration, from below), where it was asked
    /// for `[-]`.
    pub condition: Option<f64>,
    /// Times a domain was shortened to the size of its cell.
    pub domains_capped: u64,
    /// Times a point was split because its domain had outgrown its cell.
    pub domains_split: u64,
    /// Pressure over the shear stress of points that yield at the end, where volume changes are averaged over points and
    /// it is so large that the result is to be doubted `[-]`.
    pub pressure_over_shear: Option<f64>,
    /// Pressure that cells misjudge at the end over the shear stress of their points that yield, where volume changes are
    /// those of cells, points have crowded or left them, and it is so large that the result is to be doubted `[-]`.
    pub crowding_over_shear: Option<f64>,
    /// Material points at the end.
    pub points: usize,
    /// Seconds and counts per phase.
    pub timings: Vec<Timing>,
    /// What the scene did not need and the run did not do: a name and a count.
    pub skipped: Vec<(&'static str, u64)>,
}

impl Summary {
    /// Of a run that has taken `steps` load steps and ends with `model` at a load fraction.
    pub(crate) fn of<const D: usize>(
        (steps, at): (usize, LoadFraction),
        totals: &Totals,
        model: &Model<D>,
        timings: &Timings,
        ranks: &dyn Ranks<D>,
    ) -> Self {
        let points = model.bodies.iter().map(|named| named.body.n_points()).sum::<usize>();
        Self {
            steps,
            iterations: totals.iterations,
            dropped_iterations: totals.dropped,
            cuts: totals.cuts,
            shortened: totals.shortened,
            relaxed_steps: totals.relaxed_steps,
            indefinite_steps: totals.indefinite_steps,
            domains_capped: totals.domains.capped,
            domains_split: totals.domains.split,
            smallest_determinant: totals.smallest_determinant.unwrap_or(1.0),
            residual: totals.residual,
            backward_error: totals.backward_error,
            refinements: totals.refinements,
            pivot_spread: totals.pivot_spread,
            condition: totals.condition,
            pressure_over_shear: pressure_over_shear(model, ranks),
            crowding_over_shear: crowding_over_shear(model, at, ranks),
            points: count(ranks, points as u64) as usize,
            timings: timings.phases().to_vec(),
            skipped: timings.skipped.list().to_vec(),
        }
    }
}

impl Totals {
    /// Adds a converged load step; energies and halvings are added where they are known.
    pub(crate) fn add<const D: usize>(&mut self, result: &StepResult<D>) {
        let StepResult { balanced: Balanced { equilibrium, condition, .. }, domains, .. } = result;
        let effort = &equilibrium.effort;
        self.iterations += effort.residuals.len() as u64;
        self.dropped += effort.dropped;
        self.shortened += u64::from(effort.shortened);
        self.relaxed_steps += u64::from(effort.relaxations > 0);
        self.domains.capped += domains.capped;
        self.domains.split += domains.split;
        self.indefinite_steps += u64::from(effort.is_unstable);
        let smallest = self.smallest_determinant.unwrap_or(f64::INFINITY);
        self.smallest_determinant = Some(smallest.min(equilibrium.smallest_determinant));
        self.residual = self.residual.max(effort.residual);
        self.backward_error = larger(self.backward_error, effort.backward_error);
        self.refinements += u64::from(effort.refinements);
        self.pivot_spread = larger(self.pivot_spread, effort.pivot_spread);
        self.condition = larger(self.condition, *condition);
    }
}

//! How the load fraction goes from 0 to 1 in a stage: equal steps, halved where one does not converge.

use super::plan::{Before, Plan, StepKind};
use super::stations::Stations;
use crate::error::Error;
use crate::failure::StepFailure;
use crate::model::{PredictorKind, Stage};
use crate::predictor::Predictor;
use crate::progress::{Progress, StepsProgress};
use crate::record::StepResult;
use crate::state::StoredPredictor;
use mpm_grid::LoadFraction;
use std::sync::Arc;

/// Walks through equal load steps.
///
/// A nominal step may be halved up to [`Stage::cuts`] times. After a success the next step is
/// twice as long where it can be, so that every nominal step ends exactly where it would have.
pub(crate) struct LoadSteps<const D: usize> {
    /// Number of the stage, from 0.
    stage: u32,
    /// Halvings of a nominal step at most.
    most_cuts: u8,
    kind: PredictorKind,
    stations: Stations,
    /// Load steps taken, those of earlier stages too.
    taken: usize,
    /// Nominal steps completed.
    done: u64,
    /// Position inside the present nominal step, in units of its smallest part.
    position: u64,
    /// Times that the next step is halved.
    level: u8,
    cuts: u64,
    /// The last step, where the next one is predicted from it.
    predictor: Option<Arc<Predictor<D>>>,
    /// Why the shortest step failed, where it is to be tried again with relaxation.
    failure: Option<StepFailure>,
}

impl<const D: usize> LoadSteps<D> {
    /// At the start of a stage.
    pub(crate) fn new(stage: &Stage, stations: Stations, before: Before) -> Self {
        Self {
            stage: before.stage,
            most_cuts: stage.cuts,
            kind: stage.predictor,
            stations,
            taken: before.taken,
            done: 0,
            position: 0,
            level: 0,
            cuts: before.cuts,
            predictor: None,
            failure: None,
        }
    }

    fn parts(&self) -> u64 {
        1 << self.most_cuts
    }

    /// Load fraction at `position` of the present nominal step.
    fn fraction(&self, position: u64) -> LoadFraction {
        let fraction = match position {
            0 => self.stations.fraction(self.done),
            _ if position == self.parts() => self.stations.fraction(self.done + 1),
            _ => self.stations.between(self.done, position as f64 / self.parts() as f64),
        };
        LoadFraction::in_stage(self.stage, fraction.min(1.0)).expect("between 0 and 1")
    }

    /// See [`super::Steps::next`].
    pub(crate) fn next(&self) -> Option<Plan<D>> {
        if self.done == self.stations.steps() {
            return None;
        }
        let end = self.fraction(self.position + (self.parts() >> self.level));
        let kind = match self.failure {
            None => StepKind::Load(self.predictor.clone()),
            Some(_) => StepKind::Relaxed,
        };
        Some(Plan { start: self.at(), end, kind })
    }

    /// See [`super::Steps::accept`].
    pub(crate) fn accept(&mut self, plan: &Plan<D>, done: &StepResult<D>) {
        self.failure = None;
        self.go_on();
        let is_last = self.done == self.stations.steps();
        let predicts = self.kind == PredictorKind::LastStep && !is_last;
        self.predictor = predicts.then(|| {
            let increment = done.balanced.equilibrium.increment.nodes.iter().copied();
            let change = plan.end.get() - plan.start.get();
            Arc::new(Predictor::of(&done.connected.active, increment, change, 0.0))
        });
    }

    /// The step ends where the next one begins.
    fn go_on(&mut self) {
        self.taken += 1;
        self.position += self.parts() >> self.level;
        if self.position == self.parts() {
            self.position = 0;
            self.done += 1;
        }
        // Grow where the longer step starts on its own raster.
        if self.level > 0 && self.position.is_multiple_of(self.parts() >> (self.level - 1)) {
            self.level -= 1;
        }
    }

    /// See [`super::Steps::reject`].
    ///
    /// A step is halved as long as it may be. At the shortest step length it is tried again with relaxation
    /// (unbalanced forces released in parts). If that fails too, the first failure is reported.
    pub(crate) fn reject(&mut self, plan: &Plan<D>, failure: StepFailure) -> Result<(), Error> {
        let first = self.failure.take();
        if failure == StepFailure::Cancelled {
            return Err(Error::Cancelled { steps: self.taken, fraction: self.at().total() });
        }
        let was_relaxed = first.is_some();
        let reason = first.unwrap_or(failure);
        // Cutting the step cannot help where the failure does not depend on the step length, and neither can relaxation.
        if !was_relaxed && !reason.is_at_start() {
            if !self.cut() {
                self.failure = Some(reason);
            }
            return Ok(());
        }
        let (from, to, level) = (plan.start.total(), plan.end.total(), self.level);
        Err(Error::Step { step: self.taken + 1, from, to, level, reason, remedy: None })
    }

    /// Halves the next step; `false` where it may not be halved again.
    fn cut(&mut self) -> bool {
        if self.level == self.most_cuts {
            return false;
        }
        self.level += 1;
        self.cuts += 1;
        true
    }

    /// Load fraction reached.
    pub(crate) fn at(&self) -> LoadFraction {
        self.fraction(self.position)
    }

    /// Times that a step was halved so far.
    pub(crate) fn cuts(&self) -> u64 {
        self.cuts
    }

    /// See [`super::Steps::save`].
    pub(crate) fn save(&self) -> (StepsProgress, StoredPredictor) {
        let Self { done, position, level, cuts, .. } = *self;
        let last = self.predictor.as_ref().map(|predictor| predictor.fraction);
        let stored = self.predictor.as_ref().map(|predictor| predictor.save()).unwrap_or_default();
        (StepsProgress::Load { done, position, level, cuts, last }, stored)
    }

    /// Where a walk through these steps can have come to from its start, on a grid of `n_nodes`.
    ///
    /// # Errors
    /// What in the progress cannot be that of such a walk.
    pub(crate) fn restore(
        self,
        progress: &Progress,
        stored: &StoredPredictor,
        n_nodes: usize,
    ) -> Result<Self, String> {
        let StepsProgress::Load { done, position, level, cuts, last } = progress.control else {
            return Err("is that of path control, expected equal load steps".into());
        };
        let (most_cuts, steps) = (self.most_cuts, self.stations.steps());
        if done > steps || (done == steps && position > 0) {
            return Err(format!("has {done} nominal steps done, expected at most {steps}"));
        }
        if level > most_cuts {
            return Err(format!("has halved a step {level} times, expected at most {most_cuts}"));
        }
        if let Some(wrong) = last.filter(|it| !(*it > 0.0 && *it <= 1.0)) {
            return Err(format!("has a last step over {wrong} of the load, expected above 0 to 1"));
        }
        let parts = 1 << most_cuts;
        if position >= parts || !position.is_multiple_of(parts >> level) {
            return Err(format!("stands at part {position} of a step halved {level} times, of {parts}"));
        }
        let predictor = Predictor::restore(last.map(|fraction| (fraction, 0.0)), stored, n_nodes)?;
        let (taken, predictor) = (progress.rows() - 1, predictor.map(Arc::new));
        Ok(Self { taken, done, position, level, cuts, predictor, failure: None, ..self })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(cuts: u8, equal: u32) -> LoadSteps<2> {
        let stage = Stage { cuts, ..Stage::equal(equal) };
        LoadSteps::new(&stage, Stations::new(equal, &[]), Before::default())
    }

    #[test]
    fn equal_steps_end_on_their_stations() {
        let mut steps = steps(4, 3);
        let mut ends = Vec::new();
        while let Some(step) = steps.next() {
            ends.push(step.end.get());
            steps.go_on();
        }
        assert_eq!(ends, [1.0 / 3.0, 2.0 / 3.0, 1.0]);
    }

    #[test]
    fn a_cut_step_grows_again_and_meets_every_station() {
        let mut steps = steps(3, 2);
        assert!(steps.cut() && steps.cut());
        let mut ends = Vec::new();
        while let Some(step) = steps.next() {
            ends.push(step.end.get());
            steps.go_on();
        }
        // A quarter, a quarter, then a half of the first step, and the whole second.
        assert_eq!(ends, [0.125, 0.25, 0.5, 1.0]);
        assert_eq!(steps.cuts(), 2);
    }

    #[test]
    fn the_floor_is_reached_after_the_stated_cuts() {
        let mut steps = steps(2, 1);
        assert!(steps.cut() && steps.cut() && !steps.cut());
        assert_eq!(steps.next().unwrap().end.get(), 0.25);
    }
}

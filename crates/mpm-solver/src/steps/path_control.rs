//! How far the next step along the path goes.

use super::plan::{Before, Plan, StepKind};
use crate::equilibrium::path::{FirstGuess, Length, PathStep};
use crate::error::Error;
use crate::failure::{PathFailure, StepFailure};
use crate::model::{PathControl, PathMeasure, Stage};
use crate::predictor::Predictor;
use crate::progress::{Progress, StepsProgress};
use crate::record::StepResult;
use crate::state::StoredPredictor;
use mpm_grid::{LoadFraction, Vector};
use std::sync::Arc;

/// Chooses steps along the path.
///
/// Arc length: every step is one along the path. Dissipation: load steps while nothing dissipates;
/// from the first step that dissipates, or cannot be solved, steps of given dissipation.
pub(crate) struct PathSteps<const D: usize> {
    control: PathControl,
    /// Most halvings in a row.
    floor: u8,
    /// Most steps.
    most: u32,
    /// Number of the stage, from 0.
    stage: u32,
    /// Load steps taken in earlier stages.
    before: usize,
    /// Load steps taken in this stage.
    taken: u32,
    /// Load fraction reached in the stage.
    at: f64,
    /// Change of the load fraction of the next load step.
    span: f64,
    /// Length of the next step along the path, once one is known.
    aim: Option<f64>,
    /// Whether the next step is one along the path.
    along: bool,
    /// Whether the end lies within the next step.
    landing: bool,
    /// The last step that had a length.
    predictor: Option<Arc<Predictor<D>>>,
    level: u8,
    cuts: u64,
}

impl<const D: usize> PathSteps<D> {
    /// At the start of a stage.
    pub(crate) fn new(control: PathControl, stage: &Stage, before: Before) -> Self {
        Self {
            control,
            floor: stage.cuts,
            most: stage.steps,
            stage: before.stage,
            before: before.taken,
            taken: 0,
            at: 0.0,
            span: control.first,
            aim: None,
            along: matches!(control.measure, PathMeasure::ArcLength { .. }),
            landing: false,
            predictor: None,
            level: 0,
            cuts: before.cuts,
        }
    }

    /// See [`super::Steps::save`].
    pub(crate) fn save(&self) -> (StepsProgress, StoredPredictor) {
        let Self { at, span, aim, along, landing, level, cuts, .. } = *self;
        let last = self.predictor.as_ref().map(|it| (it.fraction, it.length));
        let stored = self.predictor.as_ref().map(|it| it.save()).unwrap_or_default();
        (StepsProgress::Path { at, span, aim, along, landing, level, cuts, last }, stored)
    }

    /// Where the choice of steps can have come to from its start, on a grid of `n_nodes`.
    ///
    /// # Errors
    /// What in the progress cannot be that of such steps.
    pub(crate) fn restore(
        self,
        progress: &Progress,
        stored: &StoredPredictor,
        n_nodes: usize,
    ) -> Result<Self, String> {
        let rows = progress.rows();
        let taken = rows - 1 - self.before;
        if taken > self.most as usize {
            return Err(format!("has {rows} rows of history, expected at most one more than steps"));
        }
        let StepsProgress::Path { at, span, aim, along, landing, level, cuts, last } = progress.control else {
            return Err("is that of equal load steps, expected path control".into());
        };
        if !(0.0..=1.0).contains(&at) {
            return Err(format!("is at load fraction {at}, expected 0 to 1"));
        }
        let length = last.map(|(_, length)| length);
        if let Some(wrong) =
            [Some(span), aim, length].into_iter().flatten().find(|it| !(*it > 0.0 && it.is_finite()))
        {
            return Err(format!("has a step of length {wrong}, expected a finite number above 0"));
        }
        if level > self.floor {
            return Err(format!("has halved a step {level} times, expected at most {}", self.floor));
        }
        let predictor = Predictor::restore(last, stored, n_nodes)?.map(Arc::new);
        let taken = taken as u32;
        Ok(Self { taken, at, span, aim, along, landing, predictor, level, cuts, ..self })
    }

    /// Load fraction reached.
    pub(crate) fn at(&self) -> LoadFraction {
        LoadFraction::start_of(self.stage).with_value(self.at)
    }

    /// Times that a step was halved so far.
    pub(crate) fn cuts(&self) -> u64 {
        self.cuts
    }

    /// See [`super::Steps::next`].
    pub(crate) fn next(&self) -> Result<Option<Plan<D>>, Error> {
        if self.at >= 1.0 {
            return Ok(None);
        }
        if self.taken == self.most {
            return Err(Error::StepLimit { steps: self.taken, fraction: self.at().total() });
        }
        let (start, step) = (self.at(), self.path_step());
        Ok(Some(if self.landing {
            Plan { start, end: LoadFraction::end_of(self.stage), kind: StepKind::Measured(step) }
        } else if self.along {
            Plan { start, end: start, kind: StepKind::Along(step) }
        } else {
            let end = start.with_value(self.at + self.span);
            Plan { start, end, kind: StepKind::Measured(step) }
        }))
    }

    fn path_step(&self) -> PathStep<D> {
        // Where the last step is a bad guess the tangent may be a better one.
        let guess = if self.level.is_multiple_of(2) { FirstGuess::LastStep } else { FirstGuess::Tangent };
        PathStep {
            origin: Vec::new(),
            start: self.at,
            measure: self.measure(),
            aim: self.aim,
            seed: self.span,
            reach: 2.0 * self.control.longest,
            predictor: self.predictor.clone(),
            guess,
            end: self.at,
            length: 0.0,
        }
    }

    fn measure(&self) -> Length {
        match self.control.measure {
            PathMeasure::ArcLength { .. } => Length::Displacement,
            PathMeasure::Dissipation { .. } => Length::Dissipation,
        }
    }

    /// See [`super::Steps::accept`].
    pub(crate) fn accept(&mut self, plan: &Plan<D>, done: &StepResult<D>) {
        let (StepKind::Measured(step) | StepKind::Along(step)) = &plan.kind else {
            unreachable!("path control plans no other steps");
        };
        let increment = done.balanced.equilibrium.increment.nodes.iter().enumerate();
        let increment = increment.map(|(v, u)| u - step.origin.get(v).copied().unwrap_or_else(Vector::zeros));
        let change = step.end - plan.start.get();
        let last = Predictor::of(&done.connected.active, increment, change, step.length);
        self.go_on(last, step.end, done.balanced.equilibrium.effort.residuals.len());
    }

    /// See [`super::Steps::reject`].
    pub(crate) fn reject(&mut self, plan: &Plan<D>, failure: StepFailure) -> Result<(), Error> {
        let (StepKind::Measured(step) | StepKind::Along(step)) = &plan.kind else {
            unreachable!("path control plans no other steps");
        };
        match failure {
            StepFailure::Cancelled => {
                let steps = self.before + self.taken as usize;
                return Err(Error::Cancelled { steps, fraction: self.at().total() });
            }
            StepFailure::Path(PathFailure::Leaves { fraction }) if fraction > 1.0 => self.land(step.aim),
            reason => {
                let (from, level) = (plan.start.total(), self.level);
                let to = f64::from(self.stage) + step.end;
                let no_length = matches!(reason, StepFailure::Path(PathFailure::NoLength));
                let is_hopeless = matches!(reason, StepFailure::Unsuitable(_));
                if is_hopeless || !self.cut(step.aim, no_length) {
                    let step = self.before + self.taken as usize + 1;
                    return Err(Error::Step { step, from, to, level, reason, remedy: None });
                }
            }
        }
        Ok(())
    }

    /// A step has been taken to load fraction `end`.
    fn go_on(&mut self, last: Predictor<D>, end: f64, iterations: usize) {
        let (PathMeasure::ArcLength { most } | PathMeasure::Dissipation { most }) = self.control.measure;
        let ease = f64::from(self.control.iterations) / iterations.max(1) as f64;
        let change = last.fraction.abs().max(f64::MIN_POSITIVE);
        let growth = ease.sqrt().clamp(0.5, 2.0).min(self.control.longest / change);
        self.taken += 1;
        self.level = self.level.saturating_sub(1);
        self.landing = false;
        self.at = end;
        if !self.along {
            self.span = (self.span * growth.max(0.5)).min(self.control.longest);
        }
        self.along |= last.length > 0.0;
        if last.length > 0.0 {
            self.aim = Some((last.length * growth).min(most.unwrap_or(f64::INFINITY)));
            self.predictor = Some(Arc::new(last));
        }
    }

    /// A step along the path, `aim` long, would end beyond load fraction 1.
    fn land(&mut self, aim: Option<f64>) {
        self.aim = aim;
        self.landing = true;
    }

    /// A step could not be solved; `aim` is the length that it was to have. `false` at the floor.
    fn cut(&mut self, aim: Option<f64>, no_length: bool) -> bool {
        if self.level == self.floor {
            return false;
        }
        self.level += 1;
        self.cuts += 1;
        if self.landing {
            self.landing = false;
            self.aim = self.aim.map(|aim| 0.5 * aim);
        } else if !self.along {
            self.along = true;
            self.aim = None;
        } else if no_length && self.measure() == Length::Dissipation {
            // Elastic again: load steps until something dissipates.
            self.along = false;
            self.predictor = None;
            self.span *= 0.5;
        } else if let Some(aim) = aim {
            self.aim = Some(0.5 * aim);
        } else {
            self.span *= 0.5;
        }
        true
    }
}

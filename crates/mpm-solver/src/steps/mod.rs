//! Which load steps a run takes: stage by stage equal ones, or steps along the path.

mod load_control;
mod path_control;
pub(crate) mod plan;
pub(crate) mod stations;

use crate::error::Error;
use crate::failure::StepFailure;
use crate::model::Model;
use crate::progress::{Progress, StageProgress, StepsProgress};
use crate::record::StepResult;
use crate::state::StoredPredictor;
use load_control::LoadSteps;
use mpm_grid::LoadFraction;
use path_control::PathSteps;
use plan::{Before, Plan};
use stations::Stations;

/// Chooses the load steps of a run, stage by stage. At the start of a stage nothing is predicted from the last step of the
/// stage before.
pub(crate) struct Steps<const D: usize> {
    before: Before,
    walk: Walk<D>,
}

/// Chooses the load steps of a stage.
enum Walk<const D: usize> {
    /// Equal steps of the load fraction, and steps that end at the knots of ramps.
    Load(LoadSteps<D>),
    /// Steps of given length along the path.
    Path(PathSteps<D>),
}

impl<const D: usize> Walk<D> {
    fn new(model: &Model<D>, before: Before) -> Self {
        let stage = &model.stages[before.stage as usize];
        match stage.path {
            None => Self::Load(LoadSteps::new(stage, stations(model, before.stage), before)),
            Some(control) => Self::Path(PathSteps::new(control, stage, before)),
        }
    }
}

impl<const D: usize> Steps<D> {
    /// Before the first load step.
    pub(crate) fn new(model: &Model<D>) -> Self {
        let before = Before::default();
        Self { before, walk: Walk::new(model, before) }
    }

    /// Where the choice of steps can have come to.
    ///
    /// # Errors
    /// What in the progress cannot be that of a run of this model.
    pub(crate) fn restore(
        model: &Model<D>,
        progress: &Progress,
        predictor: &StoredPredictor,
    ) -> Result<Self, String> {
        let n_nodes = model.nodes.lattice().n_nodes();
        let StageProgress { number, taken } = progress.stage;
        let (stages, steps) = (model.stages.len(), progress.rows().saturating_sub(1));
        if number as usize >= stages {
            return Err(format!("is in stage {}, expected at most {stages}", u64::from(number) + 1));
        }
        if taken > steps as u64 {
            return Err(format!("has taken {taken} load steps before its stage, expected at most {steps}"));
        }
        // Halvings are restored with those of the stage.
        let before = Before { stage: number, taken: taken as usize, cuts: 0 };
        let walk = match Walk::new(model, before) {
            Walk::Load(start) => Walk::Load(start.restore(progress, predictor, n_nodes)?),
            Walk::Path(start) => Walk::Path(start.restore(progress, predictor, n_nodes)?),
        };
        Ok(Self { before, walk })
    }

    /// How far the choice of steps has come, and the displacement of the last one.
    pub(crate) fn save(&self) -> (StageProgress, StepsProgress, StoredPredictor) {
        let (control, predictor) = match &self.walk {
            Walk::Load(steps) => steps.save(),
            Walk::Path(steps) => steps.save(),
        };
        let Before { stage, taken, .. } = self.before;
        (StageProgress { number: stage, taken: taken as u64 }, control, predictor)
    }

    /// The step to be tried next; none at the end of the stage.
    ///
    /// # Errors
    /// [`Error::StepLimit`] where all steps are used up before the end.
    pub(crate) fn next(&self) -> Result<Option<Plan<D>>, Error> {
        match &self.walk {
            Walk::Load(steps) => Ok(steps.next()),
            Walk::Path(steps) => steps.next(),
        }
    }

    /// Number of the stage after the present one, if there is one.
    pub(crate) fn next_stage(&self, model: &Model<D>) -> Option<u32> {
        let stage = self.before.stage + 1;
        ((stage as usize) < model.stages.len()).then_some(stage)
    }

    /// Begins a stage, after so many load steps in all.
    pub(crate) fn begin_stage(&mut self, model: &Model<D>, stage: u32, taken: usize) {
        self.before = Before { stage, taken, cuts: self.cuts() };
        self.walk = Walk::new(model, self.before);
    }

    /// A step has been taken.
    pub(crate) fn accept(&mut self, plan: &Plan<D>, done: &StepResult<D>) {
        match &mut self.walk {
            Walk::Load(steps) => steps.accept(plan, done),
            Walk::Path(steps) => steps.accept(plan, done),
        }
    }

    /// A step has failed: another one will be tried, where there is one.
    ///
    /// # Errors
    /// The run ends: nothing else can be tried, or it was asked to stop.
    pub(crate) fn reject(&mut self, plan: &Plan<D>, failure: StepFailure) -> Result<(), Error> {
        match &mut self.walk {
            Walk::Load(steps) => steps.reject(plan, failure),
            Walk::Path(steps) => steps.reject(plan, failure),
        }
    }

    /// Load fraction reached.
    pub(crate) fn at(&self) -> LoadFraction {
        match &self.walk {
            Walk::Load(steps) => steps.at(),
            Walk::Path(steps) => steps.at(),
        }
    }

    /// Times that a step was halved so far.
    pub(crate) fn cuts(&self) -> u64 {
        match &self.walk {
            Walk::Load(steps) => steps.cuts(),
            Walk::Path(steps) => steps.cuts(),
        }
    }
}

/// Where the load steps of a stage end, unless they are halved.
pub(crate) fn stations<const D: usize>(model: &Model<D>, stage: u32) -> Stations {
    Stations::new(model.stages[stage as usize].steps, &model.knots_in(stage))
}

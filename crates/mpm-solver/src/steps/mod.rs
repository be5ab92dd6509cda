//! Which load steps a run takes: equal ones, or steps along the path.

mod load_control;
mod path_control;
pub(crate) mod plan;
pub(crate) mod stations;

use crate::error::{Error, StepFailure};
use crate::model::Model;
use crate::progress::{Progress, StepsProgress};
use crate::record::StepResult;
use crate::state::StoredPredictor;
use load_control::LoadSteps;
use mpm_grid::LoadFraction;
use path_control::PathSteps;
use plan::Plan;
use stations::Stations;

/// Chooses the load steps of a run.
pub(crate) enum Steps<const D: usize> {
    /// Equal steps of the load fraction, and steps that end at the knots of ramps.
    Load(LoadSteps<D>),
    /// Steps of given length along the path.
    Path(PathSteps<D>),
}

impl<const D: usize> Steps<D> {
    /// Before the first load step.
    pub(crate) fn new(model: &Model<D>) -> Self {
        match model.path {
            None => Self::Load(LoadSteps::new(model.schedule, stations(model))),
            Some(control) => Self::Path(PathSteps::new(control, model.schedule)),
        }
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
        Ok(match model.path {
            None => {
                let start = LoadSteps::new(model.schedule, stations(model));
                Self::Load(start.restore(progress, predictor, n_nodes)?)
            }
            Some(control) => {
                let start = PathSteps::new(control, model.schedule);
                Self::Path(start.restore(progress, predictor, n_nodes)?)
            }
        })
    }

    /// How far the choice of steps has come, and the displacement of the last one.
    pub(crate) fn save(&self) -> (StepsProgress, StoredPredictor) {
        match self {
            Self::Load(steps) => steps.save(),
            Self::Path(steps) => steps.save(),
        }
    }

    /// The step to be tried next; none at the end of the run.
    ///
    /// # Errors
    /// [`Error::StepLimit`] where all steps are used up before the end.
    pub(crate) fn next(&self) -> Result<Option<Plan<D>>, Error> {
        match self {
            Self::Load(steps) => Ok(steps.next()),
            Self::Path(steps) => steps.next(),
        }
    }

    /// A step has been taken.
    pub(crate) fn accept(&mut self, plan: &Plan<D>, done: &StepResult<D>) {
        match self {
            Self::Load(steps) => steps.accept(plan, done),
            Self::Path(steps) => steps.accept(plan, done),
        }
    }

    /// A step has failed: another one will be tried, where there is one.
    ///
    /// # Errors
    /// The run ends: nothing else can be tried, or it was asked to stop.
    pub(crate) fn reject(&mut self, plan: &Plan<D>, failure: StepFailure) -> Result<(), Error> {
        match self {
            Self::Load(steps) => steps.reject(plan, failure),
            Self::Path(steps) => steps.reject(plan, failure),
        }
    }

    /// Load fraction reached.
    pub(crate) fn at(&self) -> LoadFraction {
        match self {
            Self::Load(steps) => steps.at(),
            Self::Path(steps) => steps.at(),
        }
    }

    /// Times that a step was halved so far.
    pub(crate) fn cuts(&self) -> u64 {
        match self {
            Self::Load(steps) => steps.cuts(),
            Self::Path(steps) => steps.cuts(),
        }
    }
}

/// Where the load steps of a model end, unless they are halved.
pub(crate) fn stations<const D: usize>(model: &Model<D>) -> Stations {
    Stations::new(model.schedule.steps, &model.knots())
}

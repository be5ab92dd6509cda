//! What is tried next.

use crate::equilibrium::path::PathStep;
use crate::predictor::Predictor;
use mpm_grid::LoadFraction;
use std::sync::Arc;

/// What lies before a stage.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Before {
    /// Number of the stage, from 0.
    pub stage: u32,
    /// Load steps taken.
    pub taken: usize,
    /// Times that a step was halved.
    pub cuts: u64,
}

/// A load step to be tried.
pub(crate) struct Plan<const D: usize> {
    /// Load fraction at its start.
    pub start: LoadFraction,
    /// Load fraction at its end; that of its start where the step has to find it ([`StepKind::Along`]).
    pub end: LoadFraction,
    pub kind: StepKind<D>,
}

/// How the equilibrium of a load step is found.
pub(crate) enum StepKind<const D: usize> {
    /// At a given load fraction, by Newton's method from the displacement of the last step, where there is one.
    Load(Option<Arc<Predictor<D>>>),
    /// At a given load fraction, with the unbalanced forces released in parts.
    Relaxed,
    /// At a given load fraction, under path control: the length of the step is measured.
    Measured(PathStep<D>),
    /// At a load fraction that the length of the step decides.
    Along(PathStep<D>),
}

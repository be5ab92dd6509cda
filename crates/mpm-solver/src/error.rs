//! Why a run did not start or did not finish.

use crate::failure::StepFailure;
use crate::observe::ObserverError;
use mpm_grid::six_digits;

/// Why a run did not start or did not finish.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The first load step cannot begin: the mesh cannot be placed, or does not cover the points.
    #[error("the first load step cannot begin: {0}")]
    Start(StepFailure),
    /// The model cannot be run.
    #[error(transparent)]
    Model(#[from] crate::check::ModelError),
    /// A load step could not be solved, however short.
    #[error(
        "load step {step} (load fraction {from} to {to}, nominal step halved {level} times): {reason}{}",
        remedy.as_ref().map_or(String::new(), |remedy| format!("; {remedy}"))
    )]
    Step {
        /// Row of the history that the step would have become.
        step: usize,
        /// Load fraction at its start.
        from: f64,
        /// Load fraction at the end of the last try.
        to: f64,
        /// How often the nominal step was halved.
        level: u8,
        /// What went wrong in the last try.
        reason: StepFailure,
        /// What the scene can have against it.
        remedy: Option<Remedy>,
    },
    /// Splitting domains that have outgrown their cells would make too many points.
    #[error(
        "after load step {step}: splitting long domains of body `{body}` would make of {points} points more than \
        the {most} that `domains.control` allows"
    )]
    TooManyPoints {
        /// Row of the history that shows the points as they were.
        step: usize,
        /// Name of the body.
        body: String,
        /// Points of all bodies before.
        points: usize,
        /// Points of all bodies at most.
        most: usize,
    },
    /// The body has left the nodes that drive it.
    #[error(
        "after load step {step} (load fraction {fraction}): the nodes of support `{support}` have lost the body: it is \
        {} cells away from them, {} at the start; nodes keep it that move as their mesh does",
        six_digits(*gap), six_digits(*start)
    )]
    LostBody {
        /// Row of the history that shows the points as they are.
        step: usize,
        /// Load fraction there.
        fraction: f64,
        /// Name of the support.
        support: String,
        /// Gap of the support, see the column `driven_gap` `[cells]`.
        gap: f64,
        /// The gap at the start `[cells]`.
        start: f64,
    },
    /// A stage begins with a support that would move nodes without material.
    #[error(
        "stage `{stage}` cannot begin: support `{support}` drives nodes, but none of them carries material"
    )]
    EmptySupport {
        /// Name of the stage.
        stage: String,
        /// Name of the support.
        support: String,
    },
    /// Path control took all its steps before the load fraction reached 1.
    #[error("the limit of {steps} load steps is reached at load fraction {fraction}")]
    StepLimit {
        /// Load steps taken.
        steps: u32,
        /// Load fraction reached; it counts stages.
        fraction: f64,
    },
    /// Several ranks cannot share the model.
    #[error("several ranks cannot share the model: {0}")]
    Ranks(String),
    /// The run was asked to stop, see [`crate::observe::Cancellation`].
    #[error("interrupted at load fraction {fraction}, after {steps} load steps")]
    Cancelled {
        /// Load steps taken.
        steps: usize,
        /// Load fraction reached; it counts stages.
        fraction: f64,
    },
    /// A state is not one of this scene.
    #[error(transparent)]
    State(#[from] crate::state::StateError),
    /// The model does not fit into this machine's memory.
    #[error("{0}")]
    TooLarge(String),
    /// An observer (the results file, say) could not go on.
    #[error("the run's record could not be written: {0}")]
    Observer(ObserverError),
}

/// What a scene can have against failures of load steps.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Remedy {
    /// Stiffness for the cells that bodies barely reach.
    #[error(
        "bodies barely reach some nodes (the least has {part:.0e} of the stiffness of the others), which makes steps \
        fail: the scene can have `stabilisation: Ghost()`"
    )]
    Stabilisation {
        /// Smallest stiffness of a node over the median.
        part: f64,
    },
    /// Volume changes of cells in place of those of their points.
    #[error(
        "where points yield, pressure is up to {ratio:.0} times their shear stress, and with `mean_dilatation: Points` \
        such a pressure moves nodes amid a body: where cells are full, `mean_dilatation: Cell` does not let it"
    )]
    CellVolumes {
        /// Largest pressure over the shear stress `√J₂` of points that yield.
        ratio: f64,
    },
}

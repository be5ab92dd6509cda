//! Why load steps fail.

use mpm_assembly::AdvanceError;
use mpm_material::NoReturn;

/// Why one load step failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StepFailure {
    /// A point, or a part of its domain, lies outside the mesh.
    #[error("body `{body}` ({basis}): {reason}")]
    Outside {
        /// Name of the body.
        body: String,
        /// Name of its basis.
        basis: &'static str,
        /// Which point, where.
        reason: String,
    },
    /// The mesh itself cannot be placed.
    #[error("the mesh: {0}")]
    Mesh(String),
    /// A trial displacement inverted a point, and shorter corrections did so too.
    #[error(
        "body `{body}` ({basis}): material point {point} at {position:?} would be inverted (det ΔF = {determinant:e})"
    )]
    Inverted {
        /// Name of the body.
        body: String,
        /// Name of its basis.
        basis: &'static str,
        /// Index of the point in its body.
        point: usize,
        /// Where it is at the start of the step `[L]`.
        position: Vec<f64>,
        /// `det ΔF`.
        determinant: f64,
    },
    /// A trial displacement took a point of a body of revolution across its axis, and shorter corrections did so too.
    #[error(
        "body `{body}` ({basis}): material point {point} at {position:?} would reach the axis (hoop stretch {hoop:e})"
    )]
    ReachesAxis {
        /// Name of the body.
        body: String,
        /// Name of its basis.
        basis: &'static str,
        /// Index of the point in its body.
        point: usize,
        /// Where it is at the start of the step, (r, z) `[L]`.
        position: Vec<f64>,
        /// `ΔF_θθ`.
        hoop: f64,
    },
    /// A law found no stress for a trial displacement, nor for shorter corrections.
    #[error("body `{body}`: the law of material point {point} at {position:?} finds no stress: {reason}")]
    NoReturn {
        /// Name of the body.
        body: String,
        /// Index of the point in its body.
        point: usize,
        /// Where it is at the start of the step `[L]`.
        position: Vec<f64>,
        /// What its law could not do.
        reason: NoReturn,
    },
    /// A trial is not admissible for a contribution, nor are shorter corrections.
    #[error("contribution `{contribution}`: {reason}")]
    Inadmissible {
        /// Its name.
        contribution: String,
        /// Why not.
        reason: String,
    },
    /// A contribution cannot begin the load step.
    #[error("contribution `{contribution}` cannot begin the load step: {reason}")]
    Refused {
        /// Its name.
        contribution: String,
        /// Why not.
        reason: String,
        /// Whether a shorter step may be begun.
        is_step_too_long: bool,
    },
    /// The out-of-balance force did not become small enough.
    #[error("no equilibrium after {} Newton iterations (relative out-of-balance force {:e})",
        residuals.len(), residuals.last().copied().unwrap_or(f64::NAN))]
    NotConverged {
        /// Relative out-of-balance force of every iterate.
        residuals: Vec<f64>,
    },
    /// The tangent is singular.
    #[error(
        "the tangent is singular at node {node} at {position:?}, along {} ({cause}): \
        material there is not held, or barely reaches the node's cells{}{}",
        axis,
        if !*can_be_stabilised { "" } else { ", for which the scene can have `stabilisation: Ghost()`" },
        if !*has_apex { "" } else { "; or its points have come apart, and their law can have an `apex_stiffness`" }
    )]
    Singular {
        /// Number of the node in the grid.
        node: usize,
        /// Where it stands at the start of the step `[L]`.
        position: Vec<f64>,
        /// Component of displacement, from 0.
        component: usize,
        /// Name of its direction.
        axis: &'static str,
        /// How it showed.
        cause: String,
        /// Whether the cells at the edge of the bodies could be stabilised and are not.
        can_be_stabilised: bool,
        /// Whether a law has an apex, at which points have no stiffness.
        has_apex: bool,
    },
    /// A rigid motion is held by nothing.
    #[error(
        "nothing holds {motion}: no support and no stiffness resists this rigid motion, so that its size is \
        arbitrary; hold it, or keep it at zero with `unheld_motion: Zero`, if no load acts along it"
    )]
    Unheld {
        /// What moves, and how.
        motion: String,
    },
    /// A rigid motion that is to be kept at zero has a load along it.
    #[error(
        "nothing holds {motion}, and the loads act along this rigid motion, so that \
        `unheld_motion: Zero` cannot keep it at zero: hold it"
    )]
    UnheldLoaded {
        /// What moves, and how.
        motion: String,
    },
    /// The tangent is singular in an unknown that belongs to no node's displacement.
    #[error(
        "nothing resists {unknown} of contribution `{contribution}`: the tangent is singular in it ({cause})"
    )]
    SingularContribution {
        /// What the unknown is.
        unknown: String,
        /// Name of the contribution.
        contribution: String,
        /// How it showed.
        cause: String,
    },
    /// Nothing determines the field that regularises a law.
    #[error(
        "nothing determines the regularising field at node {node} at {position:?}: the tangent is singular in it ({cause})"
    )]
    SingularField {
        /// Index of the node.
        node: usize,
        /// Where it stands `[L]`.
        position: Vec<f64>,
        /// How it showed.
        cause: String,
    },
    /// The linear solution is not finite or not accurate.
    #[error("the linear system could not be solved: {0}")]
    Linear(String),
    /// The linear solver takes no matrices of this kind.
    #[error("the linear solver does not take this system: {0}")]
    Unsuitable(&'static str),
    /// The run was asked to stop.
    #[error("interrupted")]
    Cancelled,
    /// A step along the path could not be made.
    #[error("path control: {0}")]
    Path(PathFailure),
    /// Equilibrium was found but a point cannot be carried on from it.
    #[error("body `{body}` ({basis}): {reason}")]
    Advance {
        /// Name of the body.
        body: String,
        /// Name of its basis.
        basis: &'static str,
        /// Which point, and what is wrong with it.
        reason: AdvanceError,
    },
    /// What one of several [ranks](crate::Ranks) has told.
    #[error("{}", .0.message)]
    Told(Told),
}

impl StepFailure {
    /// Whether nodes that bodies barely reach can be the cause, and its message does not say so.
    pub(crate) fn may_need_stabilisation(&self) -> bool {
        match self {
            StepFailure::Told(told) => told.has(Told::STABILISATION),
            StepFailure::NotConverged { .. }
            | StepFailure::Inverted { .. }
            | StepFailure::ReachesAxis { .. }
            | StepFailure::NoReturn { .. }
            | StepFailure::Linear(_)
            | StepFailure::Advance { reason: AdvanceError::TooFar { .. }, .. } => true,
            _ => false,
        }
    }

    /// Whether motions of nodes amid a body, which pressure drives, may be behind the failure.
    pub(crate) fn may_be_of_motions(&self) -> bool {
        match self {
            StepFailure::Told(told) => told.has(Told::MOTIONS),
            StepFailure::Outside { .. } | StepFailure::Singular { .. } | StepFailure::Advance { .. } => true,
            _ => self.may_need_stabilisation(),
        }
    }

    /// Whether a shorter correction of the displacement can be admissible where a trial was not.
    pub(crate) fn is_of_trial(&self) -> bool {
        match self {
            StepFailure::Told(told) => told.has(Told::TRIAL),
            StepFailure::Inverted { .. } | StepFailure::ReachesAxis { .. } | StepFailure::NoReturn { .. } => {
                true
            }
            _ => false,
        }
    }

    /// Whether the step failed for a reason on which its length has no influence.
    pub(crate) fn is_at_start(&self) -> bool {
        match self {
            StepFailure::Outside { .. }
            | StepFailure::Mesh(_)
            | StepFailure::Unheld { .. }
            | StepFailure::UnheldLoaded { .. }
            | StepFailure::Unsuitable(_) => true,
            StepFailure::Refused { is_step_too_long, .. } => !is_step_too_long,
            StepFailure::Told(told) => told.has(Told::START),
            _ => false,
        }
    }
}

/// A failure of a load step that was told: what it says, and what a run decides by.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Told {
    pub(crate) message: String,
    pub(crate) traits: u8,
}

impl Told {
    /// See [`StepFailure::is_of_trial`].
    pub(crate) const TRIAL: u8 = 1;
    /// See [`StepFailure::is_at_start`].
    pub(crate) const START: u8 = 2;
    /// See [`StepFailure::may_need_stabilisation`].
    pub(crate) const STABILISATION: u8 = 4;
    /// See [`StepFailure::may_be_of_motions`].
    pub(crate) const MOTIONS: u8 = 8;
    /// The run was asked to stop.
    pub(crate) const CANCELLED: u8 = 16;

    /// Whether the failure has a trait.
    pub(crate) fn has(&self, one: u8) -> bool {
        self.traits & one != 0
    }
}

/// Why a step along the path could not be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PathFailure {
    /// The path leaves the load fractions that a run knows.
    #[error("the path leads to load fraction {fraction}, outside 0 to 1")]
    Leaves {
        /// Load fraction of the step's end.
        fraction: f64,
    },
    /// A load step met an indefinite tangent: a limit point lies inside, and beyond it the step would
    /// have jumped to some other part of the path.
    #[error("a limit point of the load fraction lies in the step")]
    LimitPoint,
    /// The step found an equilibrium so far away that it cannot be the path's next one.
    #[error("the equilibrium found is {change} in load fraction away: on another part of the path")]
    Jump {
        /// Change of the load fraction.
        change: f64,
    },
    /// Neither more nor less load makes the step longer or shorter.
    #[error("nothing in the step changes its length (by dissipation control: nothing yields)")]
    NoLength,
}

//! How far a run has come: the part of a state that is kept as text.

use crate::record::grip::Grip;
use crate::timing::Spent;
use serde::{Deserialize, Serialize};

/// How far a run has come.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Progress {
    pub(crate) rows: u64,
    #[serde(default, skip_serializing_if = "StageProgress::is_first")]
    pub(crate) stage: StageProgress,
    pub(crate) control: StepsProgress,
    pub(crate) displacement: Vec<Vec<f64>>,
    /// Where the displacements of probes count from, in a schedule that resets them `[L]`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) probes: Vec<Vec<f64>>,
    pub(crate) grips: Vec<Grip>,
    pub(crate) cuts_before: u64,
    pub(crate) totals: Totals,
    pub(crate) spent: Spent,
}

impl Progress {
    /// Rows of the history that were shown: the initial state and the load steps taken.
    pub fn rows(&self) -> usize {
        self.rows as usize
    }
}

/// The stage that a run is in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct StageProgress {
    /// Its number, from 0.
    pub number: u32,
    /// Load steps taken in earlier stages.
    pub taken: u64,
}

impl StageProgress {
    fn is_first(&self) -> bool {
        *self == Self::default()
    }
}

/// How far the choice of load steps of a stage has come.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum StepsProgress {
    /// Equal load steps.
    Load {
        /// Nominal steps completed: those between one station of the run and the next.
        done: u64,
        /// Position inside the present one, in its smallest parts.
        position: u64,
        /// Times that it is halved.
        level: u8,
        /// Halvings so far.
        cuts: u64,
        /// Change of the load fraction in the last step, where the next one is predicted from it.
        last: Option<f64>,
    },
    /// Steps along the path.
    Path {
        /// Load fraction reached.
        at: f64,
        /// Change of the load fraction of the next load step.
        span: f64,
        /// Length of the next step along the path.
        aim: Option<f64>,
        /// Whether the next step is one along the path.
        along: bool,
        /// Whether the end lies within the next step.
        landing: bool,
        /// Times that the next step is halved.
        level: u8,
        /// Halvings so far.
        cuts: u64,
        /// Change of the load fraction in the last step, and its length.
        #[serde(rename = "secant")]
        last: Option<(f64, f64)>,
    },
}

impl StepsProgress {
    /// Halvings so far.
    pub(crate) fn cuts(&self) -> u64 {
        match *self {
            Self::Load { cuts, .. } | Self::Path { cuts, .. } => cuts,
        }
    }
}

impl Default for StepsProgress {
    fn default() -> Self {
        Self::Load { done: 0, position: 0, level: 0, cuts: 0, last: None }
    }
}

/// Running totals of the summary, and what the next row needs of the rows before.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Totals {
    pub iterations: u64,
    pub dropped: u64,
    pub cuts: u64,
    pub shortened: u64,
    #[serde(rename = "staged_steps")]
    pub relaxed_steps: u64,
    pub indefinite_steps: u64,
    pub domains: DomainCounts,
    pub smallest_determinant: Option<f64>,
    /// Energy dissipated, and work done from outside `[F L]`.
    #[serde(default)]
    pub dissipated: f64,
    #[serde(default)]
    pub external_work: f64,
    /// Energy that the points store before the first load step `[F L]`.
    #[serde(default)]
    pub stored_before: f64,
    pub residual: f64,
    pub backward_error: Option<f64>,
    pub refinements: u64,
    pub pivot_spread: Option<f64>,
    pub condition: Option<f64>,
}

/// How many domains have been dealt with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) struct DomainCounts {
    pub capped: u64,
    pub split: u64,
}

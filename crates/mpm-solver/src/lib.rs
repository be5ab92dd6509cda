#![doc = include_str!("../README.md")]
//!
//! # In more detail
//!
//! Load steps and Newton iterations of the implicit Material Point Method.
//!
//! In a [`Model`] nothing is left to look up; [`run`] takes it through its load steps and shows each converged one to
//! an [`observe::Observer`]. Start reading at `load_step.rs`, then `run.rs`.

mod cancellation;
mod check;
mod clock;
mod compiled;
mod connection;
mod domain_control;
mod equilibrium;
mod error;
mod estimate;
mod extension;
mod failure;
mod history_notes;
mod load_step;
mod loading;
mod model;
mod nodal_field;
mod nodes;
pub mod observe;
mod predictor;
mod progress;
mod ranks;
mod record;
mod release;
mod remedy;
mod rigid;
mod run;
mod skipped;
mod state;
mod steps;
mod timing;
mod told;

pub use check::ModelError;
pub use compiled::{estimate, resume, resume_on, run, run_on};
pub use error::{Error, Remedy};
pub use estimate::{BodyVolume, Estimate, Memory, Seconds, StageSteps, doubts};
pub use extension::{Kept, extended};
pub use failure::{PathFailure, StepFailure, Told};
pub use history_notes::HistoryNotes;
pub use model::{
    Active, BodyForce, DomainLimit, Loads, Model, NamedBody, NamedContribution, PathControl, PathMeasure,
    PointLoad, PredictorKind, Prescribed, Probe, Release, Share, Side, SideLoad, SolverChoice, SolverFactory,
    Stage, Support, Tolerance, Turn, UnheldMotion, across,
};
/// The points of a [`State`].
pub use mpm_assembly::{StoredColumn, StoredPoints};
pub use nodes::NodeMismatch;
pub use progress::{Progress, StepsProgress};
pub use ranks::{Alone, Ranks};
pub use record::fields::look_at_points;
pub use record::summary::Summary;
pub use state::{BodyLayout, State, StateError, StateLayout, StoredContribution, StoredPredictor, StoredShare};

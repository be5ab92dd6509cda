#![doc = include_str!("../README.md")]
//!
//! # In more detail
//!
//! Scenes, load steps and Newton iterations of the implicit Material Point Method.
//!
//! A [`scene::Scene`] is read from RON and [`compile`]d into a [`Model`], in which nothing is left to
//! look up; [`run`] takes it through its load steps and shows each converged one to an
//! [`observe::Observer`]. Start reading at `load_step.rs`, then `run.rs`.

mod cancellation;
mod clock;
mod compile;
mod connection;
mod domain_control;
mod equilibrium;
mod error;
mod estimate;
pub mod files;
mod fill;
mod limits;
mod load_step;
mod loading;
mod model;
pub mod observe;
mod predictor;
mod progress;
mod record;
mod run;
pub mod scene;
mod skipped;
mod state;
mod steps;
mod timing;
pub mod vortex;

pub use compile::{Compiled, compile, compile_with, compile_within};
pub use error::{Error, PathFailure, SceneError, StepFailure};
pub use estimate::{BodyVolume, Estimate, Memory, Seconds, estimate};
pub use model::{
    DomainLimit, Loads, Model, NamedBody, PathControl, PathMeasure, PointLoad, PredictorKind, Prescribed,
    Probe, Schedule, SolverChoice, SolverFactory, Support, Tolerance, Turn,
};
/// The points of a [`State`].
pub use mpm_assembly::{StoredColumn, StoredPoints};
pub use progress::{Progress, StepsProgress};
pub use record::summary::Summary;
pub use run::{resume, run};
pub use state::{BodyLayout, State, StateError, StateLayout, StoredPredictor};

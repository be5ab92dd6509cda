#![doc = include_str!("../README.md")]
//!
//! # In more detail
//!
//! Scenes, load steps and Newton iterations of the implicit Material Point Method.
//!
//! A [`scene::Scene`] is read from RON and [`compile`]d into a [`Model`], in which nothing is left to
//! look up; [`run`] takes it through its load steps and shows each converged one to an
//! [`observe::Observer`]. Start reading at `load_step.rs`.

mod clock;
mod compile;
mod course;
mod domains;
mod energy;
mod error;
mod estimate;
pub mod files;
mod fill;
mod limits;
mod load_step;
mod model;
mod newton;
pub mod observe;
mod path;
mod probe;
mod record;
mod rehearsal;
pub mod scene;
mod schedule;
mod secant;
mod state;
mod timing;
pub mod vortex;

pub use compile::{Compiled, compile, compile_with, compile_within};
pub use domains::DomainLimit;
pub use error::{Error, PathFailure, SceneError, StepFailure};
pub use estimate::{BodyVolume, Estimate, Memory};
pub use load_step::{resume, run};
pub use model::{
    Loads, Model, NamedBody, PathControl, PathMeasure, PointLoad, Predictor, Prescribed, Probe, Schedule,
    Support, Tolerance, Turn,
};
/// The points of a [`State`].
pub use mpm_assembly::{StoredColumn, StoredPoints};
pub use record::Summary;
pub use rehearsal::Seconds;
pub use schedule::{Pace, Step};
pub use state::{BodyLayout, ControlProgress, Progress, State, StateError, StateLayout, StoredSecant};

#![doc = include_str!("../README.md")]
//!
//! # In more detail
//!
//! Load steps and Newton iterations of the implicit Material Point Method.
//!
//! In a [`Model`] nothing is left to look up; [`run`] takes it through its load steps and shows each converged one to
//! an [`observe::Observer`]. Start reading at `load_step.rs`.

mod clock;
mod course;
mod domains;
mod energy;
mod error;
mod estimate;
mod load_step;
mod model;
mod newton;
mod nodes;
pub mod observe;
mod path;
mod probe;
mod record;
mod rehearsal;
mod schedule;
mod secant;
mod state;
mod timing;

pub use domains::DomainLimit;
pub use error::{Error, PathFailure, StepFailure};
pub use estimate::{BodyVolume, Estimate, Memory, estimate};
pub use load_step::{resume, run};
pub use model::{
    BodyForce, Loads, Model, NamedBody, PathControl, PathMeasure, PointLoad, Predictor, Prescribed, Probe,
    Schedule, Support, Tolerance, Turn,
};
/// The points of a [`State`].
pub use mpm_assembly::{StoredColumn, StoredPoints};
pub use nodes::NodeMismatch;
pub use record::Summary;
pub use rehearsal::Seconds;
pub use schedule::{Pace, Step};
pub use state::{BodyLayout, ControlProgress, Progress, State, StateError, StateLayout, StoredSecant};

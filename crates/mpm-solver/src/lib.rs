//! Scenes, load steps and Newton iterations of the implicit Material Point Method.
//!
//! A [`scene::Scene`] is read from RON and [`compile`]d into a [`Model`], in which nothing is left to
//! look up; [`run`] takes it through its load steps and shows each converged one to an
//! [`observe::Observer`]. Start reading at `load_step.rs`.
//!
//! ```
//! use mpm_solver::observe::{Entry, LoadStep, Observer, ObserverError};
//! use mpm_solver::{compile, scene::Scene};
//!
//! // A unit square of Hencky material, pulled to one and a half times its length.
//! let scene = Scene::from_ron(
//!     r#"PlaneStrain(
//!         mesh: Box(axes: [Uniform(from: 0, to: 1, cells: 2), Uniform(from: 0, to: 1, cells: 2)]),
//!         motion: Stretch([(axis: X, anchor: 0, driven: 1, displacement: 0.5)]),
//!         basis: Smpm,
//!         materials: { "rubber": Hencky(young: 1000, poisson: 0) },
//!         bodies: [(name: "square", material: "rubber", shape: Box(from: (0, 0), to: (1, 1)), points_per_cell: 2)],
//!         supports: [
//!             (name: "left", region: Plane(axis: X, at: 0), fix: [X]),
//!             (name: "bottom", region: Plane(axis: Y, at: 0), fix: [Y]),
//!             (name: "pulled", region: Plane(axis: X, at: 1), follow_mesh: [X]),
//!         ],
//!         schedule: (steps: 5),
//!     )"#,
//! )?;
//!
//! /// Keeps the reaction of the last support.
//! struct Reaction(f64);
//! impl Observer for Reaction {
//!     fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
//!         if let [.., Entry::Real(reaction), Entry::Real(_displacement)] = step.row {
//!             self.0 = reaction[0];
//!         }
//!         Ok(())
//!     }
//! }
//!
//! let mut reaction = Reaction(0.0);
//! let summary = compile(&scene)?.run(&mut reaction)?;
//! assert_eq!(summary.steps, 5);
//! // σ = E ln λ / λ on a height of one.
//! assert!((reaction.0 - 1000.0 * 1.5_f64.ln() / 1.5).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod compile;
mod course;
mod domains;
mod energy;
mod error;
mod estimate;
pub mod files;
mod fill;
pub mod linear;
mod load_step;
mod model;
mod newton;
pub mod observe;
mod ordering;
mod path;
mod probe;
mod record;
mod rehearsal;
mod room;
pub mod scene;
mod schedule;
mod state;
mod surface;
mod timing;
pub mod vortex;

pub use compile::{Compiled, compile, compile_with, compile_within};
pub use domains::DomainLimit;
pub use error::{Error, PathFailure, SceneError, StepFailure};
pub use estimate::{BodyVolume, Estimate, Memory};
pub use load_step::{resume, run};
pub use model::{
    Loads, Model, NamedBody, PathControl, PathMeasure, PointLoad, Prescribed, Probe, Schedule, Support,
    Tolerance, Turn,
};
/// The points of a [`State`].
pub use mpm_assembly::{StoredColumn, StoredPoints};
pub use record::Summary;
pub use rehearsal::Seconds;
pub use schedule::{Pace, Step};
pub use state::{BodyLayout, ControlProgress, Progress, State, StateError, StateLayout, StoredSecant};

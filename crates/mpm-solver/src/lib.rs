//! Scenes, load steps and Newton iterations of the implicit Material Point Method.

mod compile;
mod domains;
mod error;
mod estimate;
mod fill;
pub mod linear;
mod load_step;
mod model;
mod newton;
pub mod observe;
mod ordering;
mod record;
pub mod scene;
mod schedule;
mod timing;

pub use compile::{Compiled, compile};
pub use domains::DomainLimit;
pub use error::{Error, SceneError, StepFailure};
pub use estimate::{Estimate, Memory};
pub use load_step::run;
pub use model::{Loads, Model, NamedBody, PointLoad, Prescribed, Schedule, Support, Tolerance};
pub use record::Summary;
pub use schedule::{Pace, Step};

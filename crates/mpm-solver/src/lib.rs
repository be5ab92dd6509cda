//! Scenes, load steps and Newton iterations of the implicit Material Point Method.

mod compile;
mod course;
mod error;
mod estimate;
mod fill;
pub mod linear;
mod load_step;
mod model;
mod newton;
pub mod observe;
mod ordering;
mod path;
mod record;
pub mod scene;
mod schedule;
mod timing;

pub use compile::{Compiled, compile};
pub use error::{Error, PathFailure, SceneError, StepFailure};
pub use estimate::{Estimate, Memory};
pub use load_step::run;
pub use model::{Loads, Model, NamedBody, PathControl, PathMeasure, PointLoad, Prescribed, Schedule, Support, Tolerance};
pub use record::Summary;
pub use schedule::{Pace, Step};

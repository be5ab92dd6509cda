#![doc = include_str!("../README.md")]
//!
//! # In more detail
//!
//! A [`Drawing`] is what a results file gives to draw: panels of numbers, which [`mpm_plot`] turns into SVG, PNG or PDF. Shapes of bodies
//! and tools are made anew from the scene in the file; files that the scene names are looked for beside the results.

mod acting;
mod body;
mod colour;
mod columns;
mod drawn;
mod error;
mod histories;
mod picture;
mod seen;
mod tools;
mod view;

pub use columns::Wanted;
pub use drawn::scene_of;
pub use error::PictureError;
pub use picture::{Drawing, Frames, Show, compared, picture};
pub use view::{BodyView, View, plane};

#![doc = include_str!("../README.md")]
//!
//! # In more detail
//!
//! A [`Shape`] tells the signed distance from a point to its surface, with normal and Hessian. A [`Tool`] is a union of
//! shapes in one frame; a [`ToolMotion`] is its [`Pose`] as a pure function of the load fraction, and an [`Increment`]
//! a small rigid motion that a balance of forces decides. [`respond`] and [`tangent`] are the law of the interface for
//! one corner of a point's domain and one part of a tool. The crate knows neither points, nodes, laws, nor solvers.

mod bounds;
mod error;
mod helix;
mod helix_surface;
mod law;
mod layer;
mod motion;
mod plane;
mod polygon;
mod pose;
mod revolution;
mod shape;
mod sheet;
mod sphere;
mod surface;
mod tool;
mod tree;
mod triangle;

pub use bounds::Bounds;
pub use error::ContactError;
pub use helix::{Helix, HelixSize};
pub use law::{
    CornerLaw, CornerState, Interface, Mode, Response, Tangent, Trial, force_by_motion, respond, tangent,
};
pub use layer::InLayer;
pub use motion::ToolMotion;
pub use plane::Plane;
pub use polygon::Polygon;
pub use pose::{Increment, Pose, cross, moment};
pub use revolution::Revolution;
pub use shape::{Near, Outline, Sample, Shape};
pub use sphere::Sphere;
pub use surface::Surface;
pub use tool::Tool;

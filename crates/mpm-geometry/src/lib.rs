#![doc = include_str!("../README.md")]
//!
//! # In more detail
//!
//! [`Surface::new`] takes triangles only if they enclose a body: every edge joins two facets that face the same way,
//! no facets cross or touch, and the outside is outside; the signs that decide are exact. [`parts`] cuts what a
//! [`Solid`] encloses along the lines of a mesh by the divergence theorem, exactly up to rounding: no ray is cast,
//! and no point is asked whether it is inside. Where a direction is open, what reaches beyond the mesh is left out: half and
//! quarters of symmetric bodies. [`rest`] cuts solids out of a box.

mod ball;
mod crossing;
mod grid;
mod memory;
mod mend;
mod moments;
mod part;
mod parts;
mod prism;
mod round;
mod solid;
mod surface;
mod triangles;

pub use ball::Ball;
pub use memory::MemoryLimit;
pub use part::{Face, Part, Parts, Share};
pub use parts::{parts, rest};
pub use prism::{Prism, PrismError};
pub use round::Round;
pub use solid::Solid;
pub use surface::{Surface, SurfaceError};

#[cfg(test)]
mod tests;

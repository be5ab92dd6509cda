#![doc = include_str!("../README.md")]
//!
//! # In more detail
//!
//! Background grids of the Material Point Method: lattices of linear cells, their motion, and the
//! location of points in them. Knows nothing of points' state or of materials.
//!
//! A [`Layout`] says where nodes sit at rest, a [`MeshMotion`] how they move with the load, and
//! the two together make the [`Mesh`] of one load step:
//!
//! ```text
//!   Layout::Box          MeshMotion::Stretch         MeshMotion::Corners
//!   6----7----8          6-------7-------8           ,8
//!   |    |    |          |       |       |       6--7' |
//!   3----4----5          3-------4-------5       |  |  |     the same lattice:
//!   |    |    |          |       |       |       3--4--5     the same node numbers
//!   0----1----2          0-------1-------2       |  |  |
//!                                                0--1--2
//! ```
//!
//! A mesh finds the cell of a position ([`Mesh::locate`]) and hands out the nodes' shape functions
//! there ([`Mesh::values`], [`Mesh::values_and_gradients`]). A [`NodeSpace`] numbers the nodes on which
//! functions live, vertices or control points; a [`Region`] names sets of them.

mod affine;
mod axis;
mod cell;
mod index;
mod lattice;
mod layer;
mod layout;
mod location;
mod mesh;
mod motion;
mod node_space;
mod numerals;
mod placed;
mod ramp;
mod region;
mod ring;
mod splines;

pub use axis::{Axis, AxisError};
pub use cell::{LinearCell, inverse};
pub use index::{CellId, NodeId};
pub use lattice::{Lattice, LatticeError};
pub use layer::{flattened, flattened_block, raised};
pub use layout::{Layout, LayoutError, Span};
pub use location::{OutsideMesh, Place, Position};
pub use mesh::Mesh;
pub use motion::{AffineMotion, DrivenPlane, MeshMotion, MotionError, Reindexing};
pub use node_space::{NodeSpace, NodeSpaceError};
pub use numerals::{rounded, six_digits};
pub use ramp::{LoadFraction, Ramp, RampError};
pub use region::Region;
pub use splines::{HighestDerivatives, NodeKind, SplineProduct};

/// A vector or position `[L]` in D dimensions.
pub type Vector<const D: usize> = nalgebra::SVector<f64, D>;

/// A D×D tensor.
pub type Block<const D: usize> = nalgebra::SMatrix<f64, D, D>;

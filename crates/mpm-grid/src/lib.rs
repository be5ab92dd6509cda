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
//! there ([`Mesh::values`], [`Mesh::values_and_gradients`]). A [`Region`] names sets of nodes.
//!
//! ```
//! use mpm_grid::{Axis, DrivenPlane, Layout, LoadFraction, MeshMotion, Ramp, Region, Vector};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // Four by two cells on [0, 4]×[0, 2]; the right side is pulled from x = 4 to x = 6.
//! let axes = [Axis::uniform(0.0, 4.0, 4)?, Axis::uniform(0.0, 2.0, 2)?];
//! let layout = Layout::on_axes(axes)?;
//! let pulled = DrivenPlane { anchor: 0.0, driven: 4.0, displacement: Ramp::linear(2.0) };
//! let motion = MeshMotion::stretch([Some(pulled), None])?;
//! let mesh = motion.mesh_at(&layout, LoadFraction::new(0.5)?)?;
//!
//! // Shape functions reproduce the position they are evaluated at.
//! let x = Vector::<2>::new(3.3, 0.4);
//! let place = mesh.locate(&x, 0.0)?;
//! assert_eq!(place.cell, [2, 0]);
//! let mut sum = Vector::<2>::zeros();
//! mesh.values(&place, |node, value| sum += value * mesh.position(node));
//! assert!((sum - x).norm() < 1e-14);
//!
//! // The driven side is at x = 5 now and keeps its node numbers.
//! for node in (Region::Plane { axis: 0, at: 4.0 }).nodes(&layout) {
//!     assert_eq!(mesh.position(node)[0], 5.0);
//! }
//! # Ok(())
//! # }
//! ```

mod affine;
mod axis;
mod cell;
mod index;
mod lattice;
mod layout;
mod mesh;
mod motion;
mod placed;
mod ramp;
mod region;
mod ring;

pub use axis::{Axis, AxisError};
pub use cell::LinearCell;
pub use index::{CellId, NodeId};
pub use lattice::{Lattice, LatticeError};
pub use layout::{Layout, LayoutError, Span};
pub use mesh::{Mesh, OutsideMesh, Place};
pub use motion::{AffineMotion, DrivenPlane, MeshMotion, MotionError, Reindexing};
pub use ramp::{LoadFraction, Ramp, RampError};
pub use region::Region;

/// A vector or position `[L]` in D dimensions.
pub type Vector<const D: usize> = nalgebra::SVector<f64, D>;

/// A D×D tensor.
pub type Block<const D: usize> = nalgebra::SMatrix<f64, D, D>;

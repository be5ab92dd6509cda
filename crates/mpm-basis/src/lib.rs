#![doc = include_str!("../README.md")]
//!
//! # In more detail
//!
//! How a material point influences the nodes of a background grid.
//!
//! A [`Basis`] turns a point, with the domain it carries, into influences `S_vp` and `∇S_vp` on
//! nodes. [`Stencils`], [`ActiveNodes`] and [`Connectivity`] hold these as data, from which everything else
//! (active equations, sparsity pattern, order of sums) is derived.
//!
//! | basis | domain of a point | D | source |
//! |---|---|---|---|
//! | [`Smpm`] | none | any | Sulsky, Chen & Schreyer 1994 |
//! | [`Gimp`] | a box along the axes; rectilinear meshes only | any | Bardenhagen & Kober 2004; updates: Charlton, Coombs & Augarde 2017, Coombs et al. 2020 |
//! | [`Cpdi1`] | a parallelogram or parallelepiped that deforms with F | any | Sadeghirad, Brannon & Burghardt 2011 |
//! | [`Cpdi2q`] | a quadrilateral with convected corners | 2 | Sadeghirad, Brannon & Guilkey 2013 |
//! | [`Cpdi2Hexahedron`] | a hexahedron with convected corners | 3 | Sadeghirad, Brannon & Guilkey 2013 |
//! | [`Cpdi2t`] | a triangle with convected corners | 2 | Nguyen et al. 2017; Wang et al. 2019 |
//! | [`Cpdi2Tetrahedron`] | a tetrahedron with convected corners | 3 | Leavy et al. 2019 |
//! | [`Fallback`] | another basis' domain, CPDI1's where that has degenerated | as that | here |
//!
//! Wang et al. 2019, *On the use of domain-based material point methods for problems involving large
//! distortion* (Computer Methods in Applied Mechanics and Engineering), compare them under rotation
//! and distortion. All reproduce linear fields on every mesh they suit: `Σ S = 1`, `Σ ∇S = 0`,
//! `Σ x_v ⊗ ∇S = I`, and `Σ S x_v` is the point's position. Parts of a domain up to half a cell outside
//! the mesh see the boundary cell's functions continued.

mod active;
mod basis;
mod cells;
mod completeness;
mod connectivity;
mod corner;
mod cpdi1;
mod cpdi2_hexahedron;
mod cpdi2_tetrahedron;
mod cpdi2q;
mod cpdi2t;
mod domain;
pub mod domain_control;
mod evaluation;
mod fallback;
mod gimp;
mod influence;
mod layer;
pub mod parallel;
mod ring;
mod sampled;
mod seeding;
mod simplex;
mod smpm;
mod stencils;
mod tensor;

pub use active::ActiveNodes;
pub use basis::{Basis, Convection, ConvectionError, DomainPart, DomainReport, RingSide, Seed};
pub use cells::{CellPart, Cells};
pub use completeness::Completeness;
pub use connectivity::{Connectivity, Group};
pub use corner::{Corner, CornerPoint};
pub use cpdi1::{Cpdi1, Parallelepiped};
pub use cpdi2_hexahedron::{Cpdi2Hexahedron, Hexahedron};
pub use cpdi2_tetrahedron::Cpdi2Tetrahedron;
pub use cpdi2q::{CornerWeights, Cpdi2q, Quadrilateral};
pub use cpdi2t::{Cpdi2t, TriangleSplit};
pub use domain::Domain;
/// See [`domain_control`].
pub use domain_control::DomainControl;
pub use fallback::{Fallback, FallbackDomain};
pub use gimp::{Gimp, GimpUpdate, HalfLengths};
pub use influence::{Influence, Stencil};
pub use layer::outside_of_layer;
pub use seeding::seed_cells;
pub use simplex::Simplex;
pub use smpm::Smpm;
pub use stencils::{ACTIVE, Stencils, UnconnectedPoint};

//! From material points and their connectivity to the residual and the sparse tangent.
//!
//! ```text
//! fⁱⁿᵗ_v = Σ_p V⁰_p τ_p g_vp          g_vp = ΔF_p⁻ᵀ ∇S_vp
//! K_vw   = Σ_p V⁰_p g_vp · a_p · g_wp     (a includes the geometric term)
//! ```
//!
//! (Charlton, Coombs & Augarde 2017; Wang et al. 2018). A [`Body`] holds the committed [`Points`];
//! [`assemble`] sums their forces and tangent under a trial displacement, a pure function of the
//! committed state; [`Body::prepare`], [`Body::commit`] and, between steps, [`Body::control`]
//! are the only writers. [`GhostFaces`] add stiffness to cells that a body barely reaches into. The symmetric
//! tangent is stored as the lower triangle of a [`Pattern`] that is derived from connectivity.
//!
//! ```
//! use mpm_assembly::{Body, Connection, Constraints, MaterialBody, PassInput, Pattern, Points, Sums};
//! use mpm_basis::{ActiveNodes, Basis, Links, Smpm};
//! use mpm_grid::{Axis, Layout, LoadFraction, MeshMotion, Vector};
//! use mpm_material::{Elasticity, Hencky};
//!
//! // One cell with one point, stretched by 10 % in x.
//! let axis = Axis::uniform(0.0, 1.0, 1)?;
//! let layout = Layout::on_axes([axis.clone(), axis])?;
//! let mesh = MeshMotion::Fixed.mesh_at(&layout, LoadFraction::START)?;
//! let mut points = Points::<2, Smpm, Hencky>::default();
//! Smpm.seed(&mesh.linear_cell([0, 0]), &mut |seed| points.push(seed));
//! let body = MaterialBody::new(Smpm, Hencky(Elasticity::from_young_poisson(1000.0, 0.0)?), points);
//!
//! let stencils = body.stencils(&mesh)?;
//! let active = ActiveNodes::of(mesh.lattice(), std::slice::from_ref(&stencils));
//! let links = vec![Links::of(stencils, &active)];
//! let pattern = Pattern::of(active.len(), &links);
//! let connection = Connection::new(links[0].clone(), &pattern);
//! let constraints = Constraints::none(active.len());
//! let increment: Vec<Vector<2>> =
//!     active.nodes().iter().map(|&v| Vector::<2>::new(0.1 * mesh.position(v).x, 0.0)).collect();
//! let mut internal = vec![Vector::zeros(); active.len()];
//! body.assemble(
//!     &connection,
//!     PassInput { pattern: &pattern, constraints: &constraints, increment: &increment },
//!     Sums { internal: &mut internal, tangent: None },
//! )?;
//! // τ = E ln λ acts on the current width 1, as σ J: the pulled face carries τ/λ.
//! let pulled: f64 = (0..4).filter(|&v| mesh.position(active.nodes()[v]).x > 0.5).map(|v| internal[v].x).sum();
//! assert!((pulled - 1000.0 * 1.1_f64.ln() / 1.1).abs() < 1e-10);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod advance;
mod body;
mod constraints;
mod control;
mod couplings;
mod dilatation;
mod dissipation;
mod ghost;
mod kinematics;
mod pass;
mod pattern;
mod points;
mod stored;
mod strips;

pub use advance::{AdvanceError, Converged, Prepared};
pub use body::{Body, BodyLoads, MaterialBody, PointView, views};
pub use constraints::Constraints;
pub use control::{Controlled, TooManyPoints};
pub use couplings::{Couplings, Linked};
pub use dilatation::{Dilatation, MeanDilatation};
pub use dissipation::dissipation;
pub use ghost::{GhostFaces, OccupiedCell};
pub use kinematics::determinant;
pub use pass::{Connection, InvertedPoint, PassInput, Sums, TangentSums, assemble, finish_tangent};
pub use pattern::Pattern;
pub use points::Points;
pub use stored::{COLUMNS, ForeignPoints, StoredColumn, StoredPoints};

//! Bodies whose law a nodal field k regularises: one further unknown for each node, which follows a driver d of the points.
//!
//! Energy per reference volume besides that of the law, with A = h l²:
//!
//! ```text
//! W = ½ h (d − k)² + ½ A |Grad k|²       d = κ (plastic strain), or d = m(F) (shear measure, `measure.rs`)
//! residual of k at node v:   Σ_p V⁰_p [ −h (d_p − k_p) S_vp + A Grad k · Grad S_vp ],     Grad S_vp = F_nᵀ ∇S_vp
//! ```
//!
//! F_n is the deformation gradient at the start of the load step: Grad k is a gradient at rest, constant in the step but
//! for k itself. The field has no boundary conditions and no history: every load step solves for it anew.
//!
//! The pass over points is compiled once for all laws, which are asked point by point (`by_point.rs`).

mod law;
mod measure;
mod nodes;
mod pass;
mod plan;
mod scatter;
mod start;
mod trial;

pub use nodes::{FieldNodes, reached};
pub use plan::FieldPoint;
pub use start::{FieldStart, FollowedBody, SharedField, follow};

pub(crate) use plan::FieldPlan;

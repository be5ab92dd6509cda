#![doc = include_str!("../README.md")]
//!
//! # In more detail
//!
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

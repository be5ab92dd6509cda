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
//! (Charlton, Coombs & Augarde 2017; Wang et al. 2018). A [`Body`] holds the committed points;
//! [`Body::assemble`] sums their forces and tangent under a trial displacement, a pure function of the
//! committed state; [`Body::prepare`], [`Body::commit`] and, between steps, [`Body::control`]
//! are the only writers. [`GhostFaces`] add stiffness to cells that a body barely reaches into. The symmetric
//! tangent is stored as the lower triangle of a [`Pattern`] that is derived from connectivity.

mod body;
mod constraints;
mod couplings;
mod ghost;
mod pattern;

pub use body::{
    AdvanceError, Body, BodyLoads, COLUMNS, Connection, Controlled, Converged, Dilatation, ForeignPoints,
    InvertedPoint, MaterialBody, MeanDilatation, PassInput, PointView, StoredColumn, StoredPoints, Sums,
    TangentSums, TooManyPoints, determinant, finish_tangent, views,
};
pub use constraints::Constraints;
pub use couplings::{Couplings, Linked};
pub use ghost::{GhostFaces, OccupiedCell};
pub use pattern::Pattern;

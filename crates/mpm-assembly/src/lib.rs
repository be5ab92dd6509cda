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
//! are the only writers. In a load step bodies are [`Contribution`]s, as are [`GhostStabilisation`] (which adds stiffness
//! to cells that a body barely reaches into) and whatever else acts on nodes. The tangent is stored in a [`SparsityPattern`]
//! that is derived from what contributions couple.

mod body;
mod compiled;
pub mod contact;
mod contribution;
mod differences;
mod ghost;
mod markers;
mod sharing;
mod trial;
mod unknowns;

pub use body::{
    AdvanceError, AssemblyPlan, Body, BodyConnectivity, BodyLoads, COLUMNS, Controlled, Converged, Dilatation,
    DomainsOfBody, FieldNodes, FieldPoint, FieldStart, FollowedBody, ForeignPoints, InSpace, InadmissiblePoint,
    InadmissibleState, LawOfBody, MaterialBody, MeanDilatation, OccupiedCell, PassInput, PointExtent,
    PointForce, PointStart, PointView, RefusedStart, SharedField, ShippedBasis, ShippedLaw, SideForce,
    SideForces, Space, StoredColumn, StoredPoints, Sums, TangentSums, TooManyPoints, crowding_over_shear,
    determinant, finish_tangent, follow, leave_to_owners, of_points, pressure_over_shear, reached, views,
};
pub use contact::{RigidTool, ToolContact, ToolLoad};
pub use contribution::{
    Begun, BodyAtStart, ConnectedBody, Contribution, ContributionEnergy, Inadmissible, Joined, OfParts,
    PointField, Recorded, RecordedValues, Refused, StepStart,
};
pub use differences::{NotCompared, body_stiffness_error, stiffness_error};
pub use ghost::{GhostFaces, GhostStabilisation};
pub use markers::{BodySide, Hold, MarkerForce, MarkerLoad, Wall, WallContact};
pub use sharing::{OfPoint, SavedByPoint, Scale, Sharing, TakenApart, Unshared};
pub use trial::{SystemSums, SystemTangent, Trial};
pub use unknowns::{
    Block, Constraints, CoupledPlaces, Couplings, Place, SparsityPattern, UnknownId, UnknownVector, Unknowns,
};

//! A body: points of one law under one basis, behind an interface that knows neither.
//!
//! A pass is compiled for its law (`law_of_body.rs`), stencils and convection for their basis (`body_domains.rs`); a
//! [`Body`] is asked once per pass, so that the solver needs to know only the dimension, and bodies of several laws can
//! share a grid.

mod advance;
mod advance_points;
mod assembly_plan;
mod batch;
mod batch_law;
mod batch_steps;
mod batch_trial;
mod body_connectivity;
mod body_domains;
mod body_law;
mod by_point;
mod crowded;
mod dilatation;
mod dissipation;
mod domain_control;
mod interface;
mod kinematics;
mod law_of_body;
mod layer_domains;
mod material_body;
mod nodal_sums;
mod node_blocks;
mod node_sums;
mod occupied;
mod pass;
mod point_tangent;
mod point_view;
mod points;
mod pressed;
mod regularised;
mod rings;
mod scatter;
mod shipped;
mod space;
mod start;
mod stored;
mod strips;
mod trial;
mod turning_law;
mod turning_tangent;

pub use advance::{AdvanceError, Converged};
pub use assembly_plan::AssemblyPlan;
pub use body_connectivity::BodyConnectivity;
pub use body_domains::DomainsOfBody;
pub use crowded::crowding_over_shear;
pub use dilatation::{Dilatation, MeanDilatation};
pub use domain_control::{Controlled, TooManyPoints};
pub use interface::{Body, BodyLoads, PointExtent, PointForce, SideForce, SideForces, of_points, views};
pub use kinematics::determinant;
pub use law_of_body::LawOfBody;
pub use material_body::MaterialBody;
pub use occupied::OccupiedCell;
pub use point_view::PointView;
pub use pressed::pressure_over_shear;
pub use regularised::{FieldNodes, FieldPoint, FieldStart, FollowedBody, SharedField, follow, reached};
pub use scatter::{PassInput, Sums, TangentSums, finish_tangent, leave_to_owners};
pub use shipped::{InSpace, ShippedBasis, ShippedLaw};
pub use space::Space;
pub use start::{PointStart, RefusedStart};
pub use stored::{COLUMNS, ForeignPoints, StoredColumn, StoredPoints};
pub use trial::{InadmissiblePoint, InadmissibleState};

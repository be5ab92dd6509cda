#![doc = include_str!("../README.md")]
//!
//! # In more detail
//!
//! Finite-strain constitutive laws: what stress, and what stiffness, a material point answers
//! to a trial deformation.
//!
//! A law is isotropic, so it is a function of three principal strains and nothing else: a
//! [`Material`] maps the elastic trial strains εᵗʳ (logarithmic, principal) to the Kirchhoff
//! stresses τ, and to the derivative ∂τ_a/∂ε_bᵗʳ. It knows neither the space dimension nor the
//! axes. [`respond`] supplies both ends: it finds the principal axes of the trial state, asks the
//! law, and returns tensors; [`PrincipalTangent::spatial_tangent`] turns the principal derivative into the
//! moduli that a stiffness matrix is built from, in the plane or in space.
//!
//! States enter and leave as the *excess* c = b_e − I of the elastic left Cauchy–Green tensor.
//! Near the undeformed state b_e = I + O(ε), and storing b_e itself would round every strain to
//! 1e-16 absolutely; the excess keeps sixteen digits of strains of any size.
//!
//! What a point remembers is a [`History`]: it says which numbers it is stored as and under which names it is shown.
//!
//! The laws are [`Hencky`] and [`NeoHooke`] (elastic); [`VonMises`] and [`Tresca`] with an [`UndrainedStrength`] that may
//! soften; [`MohrCoulomb`] and [`DruckerPrager`] with a dilatancy of their own and a tension cut-off; [`CamClay`]; and
//! [`Undrained`] pore fluid on top of any of them. [`VolumeCorrected`] makes points that have come apart close before they
//! bear anything, and [`PerPoint`] lets the parameters differ from point to point.

mod cam_clay;
mod deviator;
mod differences;
mod driver;
mod drucker_prager;
mod elasticity;
pub mod elementary;
mod field;
mod hencky;
mod history;
pub mod lanes;
mod law;
mod mohr_coulomb;
mod neo_hooke;
mod ordered;
mod parameters;
mod per_point;
mod response;
mod spectral;
mod strength;
mod tangent;
mod tensor;
mod tresca;
mod undrained;
mod varied;
mod volume_corrected;
mod von_mises;

pub use cam_clay::{CamClay, CamClayParameters, Preconsolidation};
pub use differences::{DerivativeError, derivative_error};
pub use driver::{Control, DrivenPoint, NotDriven, StepControl, invariants};
pub use drucker_prager::{ConeMatch, DruckerPrager};
pub use elasticity::Elasticity;
pub use field::{
    FieldCoupling, FieldDriver, FieldResponse, FieldUpdate, Regularisable, Regularisation, respond_with_field,
};
pub use hencky::Hencky;
pub use history::{FieldInfo, History};
pub use law::{Apex, LaneUpdate, Material, NoReturn, PrincipalUpdate, Update};
pub use mohr_coulomb::MohrCoulomb;
pub use neo_hooke::NeoHooke;
pub use parameters::{Consolidation, MOST_OWN, OwnParameters, ParameterError, PointParameters};
pub use per_point::{MOST_NUMBERS, Numbers, PerPoint, PointHistory, Varied};
pub use response::{
    PrincipalTrial, Response, is_at_apex, largest_log_stretch, log_strain, respond, start_under, stored_energy,
};
pub use strength::{PlasticShear, UndrainedStrength};
pub use tangent::{HoopTangent, PrincipalTangent};
pub use tensor::SymmetricTensor;
pub use tresca::Tresca;
pub use undrained::{PoreFluid, Undrained};
pub use volume_corrected::{Opened, VolumeCorrected};
pub use von_mises::{PlasticStrain, VonMises};

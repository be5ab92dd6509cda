//! Contributions with unknowns of their own (a nodal field, a rigid punch that is driven by forces), contributions that
//! hold bodies, one whose residual is not a number, and models that are refused.

#[path = "contributions/field.rs"]
mod field;
#[path = "contributions/holding.rs"]
mod holding;
#[path = "contributions/punch.rs"]
mod punch;
#[path = "contributions/refusals.rs"]
mod refusals;
#[path = "contributions/scale.rs"]
mod scale;
#[path = "contributions/setup.rs"]
mod setup;

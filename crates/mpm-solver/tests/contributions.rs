//! Contributions with unknowns of their own: a nodal field, and a rigid punch that is driven by forces.

#[path = "contributions/field.rs"]
mod field;
#[path = "contributions/punch.rs"]
mod punch;
#[path = "contributions/setup.rs"]
mod setup;

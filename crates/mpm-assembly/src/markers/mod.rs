//! Boundary markers: places on a body's boundary that no line of nodes follows, where walls hold and loads pull.
//!
//! A marker at `x_b` moves with `x_b + Σ_v N_v(x_b) Δu_v`, and stands for its part `L_b` of the boundary at rest. Markers stand
//! at the corners of the domains where a body is cut into domains along its shape: loads and walls enter the balance of
//! forces at these corners. They do not depend on the basis of the points.

mod carriers;
mod frame;
mod held;
mod load;
mod load_contributes;
mod moving;
mod side;
mod summary;
mod wall;
mod wall_contributes;

pub use load::{MarkerForce, MarkerLoad};
pub use side::BodySide;
pub use wall::{Hold, Wall, WallContact};

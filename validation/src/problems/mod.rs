//! Problems whose answer is known: the scene for a basis and a mesh, and the error of a run.

pub mod column;
pub mod doughnut;
pub mod held_circles;
pub mod vortex;

//! Boundaries that cut the mesh: walls and loads on boundary markers.

mod column;
mod cylinder;
mod plate;
mod space;
mod strip;

pub(super) use column::COLUMN;
pub(super) use cylinder::CYLINDER;
pub(super) use plate::PLATE;
pub(super) use space::SPACE;
pub(super) use strip::STRIP;

/// Functions of a mesh, as a scene says it.
fn functions(degree: u32) -> String {
    if degree == 1 { "Linear".into() } else { format!("Splines(degree: {degree})") }
}

/// Equal cells, as a scene says it.
fn axis(from: f64, to: f64, cells: f64) -> String {
    format!("Uniform(from: {from:?}, to: {to:?}, cells: {cells})")
}

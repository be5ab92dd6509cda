//! The elastic doughnut twist (Wang, Coombs, Augarde & Cortis 2018): torque of the one-dimensional
//! solution.

use crate::Broken;
use crate::history::History;
use crate::scenes::{load, load_own};
use crate::variants::{Method, PlaneScene, plane, refined};

/// Torque at the end, 20°: the converged one-dimensional solution (`reference/doughnut_elastic_torque.csv`)
/// `[F L]`.
pub const EXACT_AT_20: f64 = 6.764_336_5e7;

/// The ring on `5·factor` × `32·factor` cells; on splines between circles, in a mesh that stays.
///
/// # Errors
/// The scene cannot be read.
pub fn ring(method: &Method, factor: u32) -> Result<PlaneScene, Broken> {
    let scene = if method.degree > 1 { load_own("ring_splines")? } else { load("doughnut_elastic")? };
    Ok(refined(method.of(plane(scene)?), factor))
}

/// Torque of every load step `[F L]`.
pub fn torque(history: &History) -> Vec<f64> {
    // In space a moment has three components; the ring turns about z.
    let column = history.columns().iter().find(|column| column.name == "reaction_moment/inner");
    let about_z = column.map_or(0, |column| column.width - 1);
    history.series("reaction_moment/inner", about_z)[1..].to_vec()
}

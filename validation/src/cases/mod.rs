//! The cases, in the order of the table.

mod axisymmetry;
mod bar;
mod boundaries;
mod cantilever;
mod collapse;
mod column;
mod contact;
mod corner_stretch;
mod determinism;
mod domain_control;
mod domains;
mod doughnut;
mod faults;
mod footing;
mod newton_rate;
mod patch;
mod path;
mod regularised;
mod remedies;
mod rotation;
mod shapes;
pub(crate) mod simple_stretch;
mod soil;
mod space;
mod splines;
mod step_control;
mod tangent;
mod view;
mod vortex;

use crate::history::{Frame, History};
use crate::picture::{Panel, Patch, Shapes};
use crate::probe::plane;
use crate::{Broken, Case};
use mpm_grid::LoadFraction;
use mpm_scene::Scene;
use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};

/// All cases.
pub const CASES: &[Case] = &[
    simple_stretch::FREE,
    simple_stretch::ROLLERS,
    corner_stretch::KITE,
    corner_stretch::RECTILINEAR,
    doughnut::ELASTIC,
    doughnut::REFINEMENT,
    doughnut::RUBBER,
    doughnut::SLIDES,
    doughnut::TURNS,
    doughnut::LIMIT,
    doughnut::CARRIED,
    doughnut::EXTRUDED,
    vortex::CASE,
    vortex::RUBBER,
    remedies::CASE,
    domains::HEALTH,
    domains::INVERSION,
    column::CASE,
    column::SOLID,
    splines::COLUMN,
    splines::RING,
    splines::PATCH,
    splines::VORTEX,
    boundaries::COLUMN,
    boundaries::CYLINDER,
    boundaries::PLATE,
    boundaries::SPACE,
    boundaries::STRIP,
    regularised::STRAIN,
    regularised::SOFTENING,
    regularised::STRIP,
    cantilever::CASE,
    collapse::CASE,
    space::CANTILEVER,
    space::COLLAPSE,
    bar::CASE,
    shapes::CASE,
    newton_rate::CASE,
    tangent::CASE,
    rotation::CASE,
    patch::CASE,
    step_control::FAILURE,
    step_control::CUTS,
    path::SNAP_THROUGH,
    path::SNAP_BACK,
    domain_control::CASE,
    footing::CASE,
    axisymmetry::WALLS,
    axisymmetry::CAVITY,
    axisymmetry::PUNCH,
    axisymmetry::FOOTING,
    axisymmetry::PILE,
    axisymmetry::TWISTED,
    axisymmetry::TURNED_PILE,
    axisymmetry::CONE,
    axisymmetry::CONE_IN_SAND,
    soil::AT_REST,
    soil::COLUMN,
    soil::RING,
    soil::INFINITE,
    soil::CLAY,
    soil::SAND,
    soil::HEAVY,
    soil::CIRCLE,
    soil::WALL,
    soil::CUT,
    soil::SLOPE,
    contact::BLOCKS,
    contact::CIRCLE,
    contact::HERTZ,
    contact::FRICTION,
    contact::RATE,
    contact::CYLINDER,
    contact::TURNED,
    contact::VANE,
    contact::SPHERE,
    contact::SPACE,
    contact::PLOUGH,
    contact::PILE,
    contact::INSTALLED_PILE,
    contact::PILE_IN_SAND,
    contact::MOTIONS,
    contact::EDGES,
    determinism::CASE,
    faults::CASE,
];

/// Largest of some errors; not a number if one of them is not.
pub(crate) fn largest(errors: impl IntoIterator<Item = f64>) -> f64 {
    errors.into_iter().fold(0.0, |a, b| if b.is_nan() || b > a { b } else { a })
}

/// Largest difference between two lists that should be equal, against the size of `expected`;
/// not a number where their lengths differ.
fn relative(found: &[f64], expected: &[f64]) -> f64 {
    if found.len() != expected.len() {
        return f64::NAN;
    }
    let scale = largest(expected.iter().map(|x| x.abs()));
    largest(found.iter().zip(expected).map(|(a, b)| (a - b).abs())) / scale
}

/// A number with so many decimals.
pub(crate) fn fixed(x: f64, decimals: usize) -> String {
    format!("{x:.decimals$}")
}

/// A number with so many significant digits and an exponent.
pub(crate) fn scientific(x: f64, digits: usize) -> String {
    format!("{x:.*e}", digits - 1)
}

/// The same work on several things at once, results in their order.
pub(crate) fn sweep<T: Sync, R: Send>(
    items: &[T],
    work: impl Fn(&T) -> Result<R, Broken> + Send + Sync,
) -> Result<Vec<R>, Broken> {
    items.par_iter().map(work).collect()
}

/// The last load step of a run as a picture: domains and the mesh; points where there are no domains.
fn shapes(title: String, scene: &Scene, history: &History, range: [(f64, f64); 2]) -> Result<Panel, Broken> {
    framed(title, scene, &history.last_frame(), range, |_| 0.0)
}

/// A frame of a run as a picture; `shade` colours a domain from 0 to 1.
fn framed(
    title: String,
    scene: &Scene,
    frame: &Frame,
    range: [(f64, f64); 2],
    shade: impl Fn(&[[f64; 3]]) -> f64,
) -> Result<Panel, Broken> {
    let outlines = frame.outlines.iter().filter(|corners| !corners.is_empty());
    let patches: Vec<_> = outlines
        .map(|corners| Patch::new(corners.iter().map(|x| (x[0], x[1])).collect(), shade(corners)))
        .collect();
    let points = if patches.is_empty() {
        frame.positions.chunks_exact(3).map(|x| (x[0], x[1])).collect()
    } else {
        Vec::new()
    };
    let lines = mesh_lines(scene, frame.fraction)?;
    Ok(Panel::Shapes(Shapes { title, range, patches, points, lines, ..Shapes::default() }))
}

/// Edges of the mesh of a scene at a load fraction.
fn mesh_lines(scene: &Scene, fraction: f64) -> Result<Vec<[(f64, f64); 2]>, Broken> {
    let model = plane(scene)?;
    let at = LoadFraction::of_total(fraction)?;
    let mesh = model.motion.mesh_at(&model.layout, at)?;
    let place = |node| {
        let x = mesh.position(node);
        (x[0], x[1])
    };
    Ok(mesh.lattice().edges().map(|edge| edge.map(place)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_that_is_no_number_is_not_lost() {
        assert!(largest([1.0, f64::NAN, 2.0]).is_nan());
        assert_eq!(largest([1.0, 3.0, 2.0]), 3.0);
        assert!(relative(&[1.0], &[1.0, 2.0]).is_nan());
        assert_eq!(relative(&[1.0, 2.5], &[1.0, 2.0]), 0.25);
    }
}

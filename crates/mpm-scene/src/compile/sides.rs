//! Sides of bodies by their names, and the loads on them.

use super::loads::{body_named, whole_force};
use super::outlines::{Outline, outlines};
use super::stages::Stages;
use super::tiling::{anticlockwise, cell};
use crate::boundary::{Boundary, chain};
use crate::error::SceneError;
use crate::language::{BodyInput, LoadInput, SceneIn, ShapeInput, TilingInput};
use mpm_assembly::{BodySide, MarkerForce, MarkerLoad};
use mpm_grid::{Layout, Mesh, NodeId, Vector};
use mpm_linear::Symmetry;
use mpm_solver::Model;
use std::collections::BTreeMap;

/// Values of functions below this are those of rounding at the edge of a cell.
const NOTHING: f64 = 1e-12;

/// Part of an edge's length by which its ends may lie off a plane in which it counts as lying.
const IN_PLANE: f64 = 1e-9;

/// What the boundaries of bodies are known by, in the order of the bodies.
pub(super) struct Sides<'a, const D: usize> {
    pub inputs: &'a [BodyInput<D>],
    /// The sides of the pieces of each body that needs them.
    pub boundaries: &'a [Boundary<D>],
}

/// Where a side is.
enum Place {
    /// At the low or the high end of a direction of the pieces.
    End(usize, bool),
    /// On an outline that pieces do not follow.
    Outline(Outline),
}

type NamedPlace = (String, Place);

/// Whether a scene names a side of a body.
pub(super) fn are_named<const D: usize, B>(scene: &SceneIn<D, B>, name: &str) -> bool {
    let in_loads = scene.loads.iter().any(|load| match load {
        LoadInput::Pressure { body, .. } | LoadInput::Traction { body, side: Some(_), .. } => body == name,
        _ => false,
    });
    in_loads || scene.walls.iter().any(|wall| wall.body == name)
}

impl<const D: usize> Sides<'_, D> {
    /// A side of a body by their names; with the path of what names them.
    ///
    /// # Errors
    /// There is no such body or side, or the side follows no pieces and a wall would hold it.
    pub(super) fn find(
        &self,
        model: &Model<D>,
        (body, side): (&str, &str),
        is_wall: bool,
        path: &str,
    ) -> Result<BodySide<D>, SceneError> {
        let number = body_named(&model.bodies, body, path)?;
        let refuse = |reason: String| Err(SceneError::new(format!("{path}.side"), reason));
        let mut places = places(&self.inputs[number], &model.layout);
        let Some(found) = places.iter().position(|place| place.0 == side) else {
            let names: Vec<&str> = places.iter().map(|place| &place.0[..]).collect();
            return refuse(match names[..] {
                [] => format!("body `{body}` has no sides by name"),
                _ => format!("body `{body}` has no side `{side}`; it has: {}", names.join(", ")),
            });
        };
        match places.swap_remove(found).1 {
            Place::End(direction, is_high) => {
                let made = self.boundaries[number].side((direction, is_high), body, side);
                made.map_or_else(|| refuse(format!("no piece of body `{body}` has this side")), Ok)
            }
            Place::Outline(_) if is_wall => refuse(format!(
                "body `{body}` is cut by cells, which do not follow this side: expected one of a shape with `tiling: Shape`"
            )),
            Place::Outline(outline) => Ok(chain(&outline.points, outline.is_closed, (body, side))),
        }
    }
}

/// The sides of a body.
fn places<const D: usize>(input: &BodyInput<D>, layout: &Layout<D>) -> Vec<NamedPlace> {
    let is_tiled = input.tiling == TilingInput::Shape;
    let mut places = Vec::new();
    let mut ends = |direction: usize, names: [&str; 2]| {
        let end = |k: usize| (names[k].to_owned(), Place::End(direction, k == 1));
        places.extend([end(0), end(1)]);
    };
    match (&input.shape, layout) {
        (ShapeInput::Box { without, cutouts, .. }, _) if without.is_empty() && cutouts.is_empty() => {
            ends(0, ["left", "right"]);
            if D == 3 {
                ends(1, ["front", "back"]);
            }
            ends(D - 1, ["bottom", "top"]);
        }
        (ShapeInput::Ring { .. }, _) | (ShapeInput::Tube { .. }, Layout::Ring { .. }) => {
            if let Layout::Ring { span, .. } = layout
                && !span.is_full()
            {
                ends(0, ["start", "end"]);
            }
            ends(1, ["inner", "outer"]);
            if D == 3 {
                ends(2, ["bottom", "top"]);
            }
        }
        (ShapeInput::Tube { .. }, _) if is_tiled => {
            ends(1, ["inner", "outer"]);
            if D == 3 {
                ends(2, ["bottom", "top"]);
            }
        }
        (ShapeInput::Cylinder { .. }, _) if is_tiled => {
            places.push(("outer".into(), Place::End(1, true)));
            if D == 3 {
                let end = |k: usize| Place::End(2, k == 1);
                places.extend([("bottom".into(), end(0)), ("top".into(), end(1))]);
            }
        }
        (ShapeInput::Polygon { vertices, .. }, _) if is_tiled => {
            let (_, is_anticlockwise) = anticlockwise(vertices);
            let ends = [(1, false), (0, true), (1, true), (0, false)];
            places.extend((0..4).map(|k| {
                let (direction, is_high) = ends[if is_anticlockwise { k } else { 3 - k }];
                (format!("edge {k}"), Place::End(direction, is_high))
            }));
        }
        (_, Layout::Box { axes, .. }) => {
            let size = cell(axes) / input.points_per_cell.as_ref().map_or(1.0, |count| f64::from(count.0));
            let named = outlines(input, size).into_iter();
            places.extend(named.map(|it| (it.name.clone(), Place::Outline(it))));
        }
        _ => {}
    }
    places
}

/// The loads on sides, with the numbers under which the scene has them.
pub(super) fn side_loads<const D: usize, B>(
    scene: &SceneIn<D, B>,
    sides: &Sides<'_, D>,
    (model, start): (&Model<D>, &Mesh<D>),
) -> Result<Vec<(usize, MarkerLoad<D>)>, SceneError> {
    let stages = Stages::of(&scene.schedule);
    let mut loads = Vec::new();
    for (k, input) in scene.loads.iter().enumerate() {
        let path = format!("loads[{k}]");
        let (side, force, ramp, active) = match input {
            LoadInput::Pressure { body, side, value, ramp, active } => {
                let side = sides.find(model, (body, side), false, &path)?;
                (side, MarkerForce::Pressure(value.0), ramp, active)
            }
            LoadInput::Traction { body, side: Some(side), resultant, value, moment, ramp, active, .. } => {
                if moment.is_some() {
                    return Err(SceneError::new(format!("{path}.moment"), super::loads::NO_MOMENT));
                }
                let side = sides.find(model, (body, side), false, &path)?;
                let measure = side.measures().iter().sum::<f64>();
                let traction = whole_force(resultant, value, measure, &path)? / measure;
                let force = MarkerForce::traction(&side, &traction);
                (side, force, ramp, active)
            }
            _ => continue,
        };
        let ramp = stages.load_ramp(ramp, 1.0, active, &path)?;
        let symmetry = symmetry(&side, &force, model, start);
        loads.push((k, MarkerLoad::new(side, force, ramp, symmetry)));
    }
    Ok(loads)
}

/// Whether a load on a side has a symmetric tangent: a pressure does where the side is closed, or supports hold its edges across
/// the planes they lie in, on which nothing flows through the side.
fn symmetry<const D: usize>(
    side: &BodySide<D>,
    force: &MarkerForce<D>,
    model: &Model<D>,
    start: &Mesh<D>,
) -> Symmetry {
    if matches!(force, MarkerForce::Dead(_)) {
        return Symmetry::Symmetric;
    }
    let holds = |node: &NodeId, d: usize| {
        let mut of_node = model.supports.iter().filter(|support| support.nodes.binary_search(node).is_ok());
        of_node.any(|support| support.components[d].is_some())
    };
    let held = |marker: &Vector<D>| -> [bool; D] {
        let Ok(place) = start.locate(marker, 0.0) else { return [false; D] };
        let mut nodes = Vec::new();
        start.values(&place, |node, value| {
            if value.abs() > NOTHING {
                nodes.push(node);
            }
        });
        std::array::from_fn(|d| nodes.iter().all(|node| holds(node, d)))
    };
    let edges = side.edges();
    let mut at_edges: BTreeMap<usize, [bool; D]> = BTreeMap::new();
    edges.iter().flatten().for_each(|&marker| {
        at_edges.entry(marker).or_insert_with(|| held(&side.markers[marker]));
    });
    let is_held = |edge: &Vec<usize>| {
        let along = side.markers[edge[edge.len() - 1]] - side.markers[edge[0]];
        let lies_in_plane = |d: usize| along[d].abs() <= IN_PLANE * along.norm();
        (0..D).any(|d| lies_in_plane(d) && edge.iter().all(|marker| at_edges[marker][d]))
    };
    if edges.iter().all(is_held) { Symmetry::Symmetric } else { Symmetry::Unsymmetric }
}

//! Outlines of shapes in the plane that are cut by cells, in edges about as long as their points are wide.

use super::mesh::plane_point;
use super::tiling::anticlockwise;
use crate::language::{BodyInput, PlanePoint, ShapeInput};
use std::f64::consts::TAU;

/// Edges of an outline at most.
const MOST: f64 = 1e6;

/// Places along an outline, with the body on its left.
pub(super) struct Outline {
    pub name: String,
    /// `[L]`.
    pub points: Vec<[f64; 2]>,
    pub is_closed: bool,
}

/// The outlines of a body in the plane, in edges of at most `size` `[L]`; none of bodies that the mesh cuts.
pub(super) fn outlines<const D: usize>(input: &BodyInput<D>, size: f64) -> Vec<Outline> {
    if D != 2 || !input.symmetry.is_empty() {
        return Vec::new();
    }
    match &input.shape {
        ShapeInput::Cylinder { centre, radius, .. } => {
            vec![circle("outer", (plane_point(centre), radius.0), size, false)]
        }
        ShapeInput::Tube { centre, inner, outer, .. } => {
            let centre = plane_point(centre);
            vec![
                circle("inner", (centre, inner.0), size, true),
                circle("outer", (centre, outer.0), size, false),
            ]
        }
        ShapeInput::Polygon { vertices, holes, .. } => {
            let (corners, is_anticlockwise) = anticlockwise(vertices);
            let n = corners.len();
            let edge = |k: usize| {
                let from = if is_anticlockwise { k } else { n - 1 - k };
                let points = divided(&[corners[from], corners[(from + 1) % n]], size);
                Outline { name: format!("edge {k}"), points, is_closed: false }
            };
            let hole = |(k, hole): (usize, &Vec<PlanePoint>)| {
                let (mut corners, _) = anticlockwise(hole);
                corners.reverse();
                corners.push(corners[0]);
                let mut points = divided(&corners, size);
                points.pop();
                Outline { name: format!("hole {k}"), points, is_closed: true }
            };
            (0..n).map(edge).chain(holes.iter().enumerate().map(hole)).collect()
        }
        _ => Vec::new(),
    }
}

/// A circle, anticlockwise or, round a hole, clockwise.
fn circle(name: &str, (centre, radius): ([f64; 2], f64), size: f64, is_hole: bool) -> Outline {
    let n = 4 * (0.25 * TAU * radius / size).ceil().clamp(2.0, MOST) as u32;
    let at = |k: u32| {
        let (sine, cosine) = (TAU * f64::from(if is_hole { n - k } else { k }) / f64::from(n)).sin_cos();
        [centre[0] + radius * cosine, centre[1] + radius * sine]
    };
    Outline { name: name.into(), points: (0..n).map(at).collect(), is_closed: true }
}

/// A line through corners, with its edges divided into equal ones of at most `size` `[L]`.
fn divided(corners: &[[f64; 2]], size: f64) -> Vec<[f64; 2]> {
    let mut points = vec![corners[0]];
    for ends in corners.windows(2) {
        let along = [0, 1].map(|d| ends[1][d] - ends[0][d]);
        let n = (along[0].hypot(along[1]) / size).ceil().clamp(1.0, MOST) as u32;
        let at = |k: u32| [0, 1].map(|d| ends[0][d] + along[d] * (f64::from(k) / f64::from(n)));
        points.extend((1..n).map(at));
        points.push(ends[1]);
    }
    points
}

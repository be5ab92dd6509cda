//! Polygons in the plane with rounded corners.

use crate::bounds::Bounds;
use crate::error::{ContactError, VERTEX};
use crate::plane::parts;
use crate::shape::{Near, Outline, SMOOTH, Sample, Shape, keep_distinct};
use mpm_grid::Vector;

type Vec2 = Vector<2>;

/// A polygon whose convex corners are rounded by the radius ρ; concave corners stay sharp.
///
/// The distance is the one to the polygon shrunk by ρ, less ρ: edges between arcs about the shrunk corners.
#[derive(Clone, Debug, PartialEq)]
pub struct Polygon {
    sides: Vec<Side>,
    rounding: f64,
}

/// An edge from one vertex to the next, the solid on its left, and the corner at its end.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Side {
    start: Vec2,
    tangent: Vec2,
    normal: Vec2,
    length: f64,
    /// Where its straight part begins and ends, from its start.
    straight: (f64, f64),
    /// Turn of the direction at its end `[rad]`; positive where the corner is convex.
    turn: f64,
    /// Centre of the arc at its end; the vertex itself where the corner is concave or sharp.
    centre: Vec2,
}

/// A local minimum of the distance to the boundary of the shrunk polygon.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Foot {
    /// Signed distance `[L]` to the rounded polygon.
    pub distance: f64,
    pub normal: Vec2,
    /// Centre of the arc, or the corner, that is nearest; `None` on an edge.
    pub centre: Option<Vec2>,
    /// κ of `H = κ (I - n⊗n)` `[1/L]`.
    pub curvature: f64,
    pub feature: u32,
}

impl Polygon {
    /// The polygon through its vertices `[L]` in their order round it, either way, with corners rounded by `rounding`
    /// `[L]`.
    ///
    /// # Errors
    /// `number of vertices`: fewer than three; `vertices`: not finite; `vertex`, with its number from 1: two at one place, or
    /// edges that cross or touch; `rounding`: negative, or larger than the polygon permits.
    pub fn new(mut vertices: Vec<Vec2>, rounding: f64) -> Result<Self, ContactError> {
        let numbers: u32 = u32::try_from(vertices.len()).unwrap_or(u32::MAX);
        let enough = (3..1 << 20).contains(&numbers);
        ContactError::unless(enough, "number of vertices", f64::from(numbers), "at least 3 and at most 2^20")?;
        vertices.iter().try_for_each(|x| ContactError::unless_finite("vertices", x.as_slice()))?;
        ContactError::unless_not_negative("rounding", rounding)?;
        check_edges(&vertices)?;
        if doubled_area(&vertices) < 0.0 {
            vertices.reverse();
        }
        let sides = Self::sides(&vertices, rounding);
        let polygon = Self { sides, rounding };
        polygon.check_rounding()?;
        Ok(polygon)
    }

    fn sides(vertices: &[Vec2], rounding: f64) -> Vec<Side> {
        let n = vertices.len();
        let mut sides: Vec<Side> = (0..n)
            .map(|i| {
                let along = vertices[(i + 1) % n] - vertices[i];
                let length = along.norm();
                let tangent = along / length;
                let normal = Vec2::new(tangent[1], -tangent[0]);
                let straight = (0.0, length);
                Side {
                    start: vertices[i],
                    tangent,
                    normal,
                    length,
                    straight,
                    turn: 0.0,
                    centre: vertices[(i + 1) % n],
                }
            })
            .collect();
        for i in 0..n {
            let next = (i + 1) % n;
            let (a, b) = (sides[i].tangent, sides[next].tangent);
            let turn = a.perp(&b).atan2(a.dot(&b));
            sides[i].turn = turn;
            if turn > 0.0 {
                let cut = rounding * (0.5 * turn).tan();
                sides[i].straight.1 = sides[i].length - cut;
                sides[next].straight.0 = cut;
                let inwards = sides[i].tangent * cut + sides[i].normal * rounding;
                sides[i].centre -= inwards;
            }
        }
        sides
    }

    /// The shrunk polygon must keep all its edges, and none may come close to another's arc.
    fn check_rounding(&self) -> Result<(), ContactError> {
        let expected = "less than what the edges and the thickness of the polygon permit";
        let refuse = || Err(ContactError { name: "rounding", value: self.rounding, expected });
        if self.rounding == 0.0 {
            return Ok(());
        }
        if self.sides.iter().any(|side| side.straight.1 - side.straight.0 <= 1e-9 * side.length) {
            return refuse();
        }
        for (i, corner) in self.sides.iter().enumerate().filter(|(_, side)| side.turn > 0.0) {
            let own = [i, (i + 1) % self.sides.len()];
            let others = self.sides.iter().enumerate().filter(|(j, _)| !own.contains(j));
            for (_, side) in others {
                let along = side.tangent.dot(&(corner.centre - side.start)).clamp(0.0, side.length);
                let nearest = side.start + side.tangent * along;
                if (corner.centre - nearest).norm() < self.rounding * (1.0 - 1e-9) {
                    return refuse();
                }
            }
        }
        Ok(())
    }

    /// All local minima of the distance from `x` to the shrunk polygon's boundary, by their distance to it.
    fn minima(&self, x: &Vec2) -> Vec<(f64, Foot)> {
        let rho = self.rounding;
        let mut found = Vec::with_capacity(8);
        for (i, side) in self.sides.iter().enumerate() {
            let next = &self.sides[(i + 1) % self.sides.len()];
            let numbered = |k: usize| u32::try_from(k).unwrap_or(u32::MAX);
            let r = x - side.start;
            let along = side.tangent.dot(&r);
            if side.straight.0 <= along && along <= side.straight.1 {
                let distance = side.normal.dot(&r);
                let foot =
                    Foot { distance, normal: side.normal, centre: None, curvature: 0.0, feature: numbered(i) };
                found.push((distance + rho, foot));
            }
            // The corner at its end is near where neither edge is.
            let past = along > side.straight.1 && next.tangent.dot(&(x - next.start)) < next.straight.0;
            let from = x - side.centre;
            let apart = from.norm();
            if past && apart > 0.0 {
                let outward = if side.turn > 0.0 { 1.0 } else { -1.0 };
                let to_shrunk = if side.turn > 0.0 { apart } else { rho - apart };
                let foot = Foot {
                    distance: to_shrunk - rho,
                    normal: from * (outward / apart),
                    centre: Some(side.centre),
                    curvature: outward / apart,
                    feature: numbered(self.sides.len() + i),
                };
                found.push((to_shrunk, foot));
            }
        }
        found.sort_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
        found
    }

    /// What [`Shape::near`] tells, as feet.
    pub(crate) fn feet(&self, x: &Vec2, reach: f64) -> Vec<Foot> {
        let minima = self.minima(x);
        let Some(&(nearest, foot)) = minima.first() else { return Vec::new() };
        // Deeper than the rounding the nearest feature counts alone: the others may be on the far side.
        let kept: Vec<Foot> = if nearest < 0.0 {
            vec![foot]
        } else {
            let seen = |&&(to_shrunk, foot): &&(f64, Foot)| {
                let there = x - foot.normal * (to_shrunk * (1.0 - 1e-9));
                to_shrunk >= 0.0 && (to_shrunk == nearest || self.sees(x, &there))
            };
            minima.iter().filter(seen).map(|it| it.1).collect()
        };
        kept.into_iter().filter(|foot| foot.distance < reach).collect()
    }

    /// Whether no edge of the shrunk polygon crosses the line from `x` to one of its places.
    fn sees(&self, x: &Vec2, foot: &Vec2) -> bool {
        !self.sides.iter().any(|side| {
            let at = |s: f64| side.start + side.tangent * s - side.normal * self.rounding;
            crosses(x, foot, &at(side.straight.0), &at(side.straight.1))
        })
    }

    /// The rounded boundary in parts no longer than `spacing`; arcs in an even number of parts, at least
    /// `least_arcs`.
    pub(crate) fn pieces(&self, spacing: f64, least_arcs: u32) -> Vec<Piece> {
        let mut pieces = Vec::new();
        for (i, side) in self.sides.iter().enumerate() {
            let length = side.straight.1 - side.straight.0;
            let n = parts(length, spacing);
            let step = length / f64::from(n);
            for k in 0..n {
                let at = |s: f64| side.start + side.tangent * (side.straight.0 + step * (f64::from(k) + s));
                let ends = [at(0.0), at(1.0)];
                pieces.push(Piece { ends, middle: at(0.5), mean: at(0.5), normal: side.normal, length: step });
            }
            if side.turn > 0.0 && self.rounding > 0.0 {
                let next = &self.sides[(i + 1) % self.sides.len()];
                self.arc_pieces(
                    side,
                    next,
                    parts(self.rounding * side.turn, spacing).max(least_arcs),
                    &mut pieces,
                );
            }
        }
        pieces
    }

    fn arc_pieces(&self, side: &Side, next: &Side, number: u32, pieces: &mut Vec<Piece>) {
        let n = number.next_multiple_of(2);
        let step = side.turn / f64::from(n);
        let normal = |k: f64| {
            let (sine, cosine) = (step * k).sin_cos();
            let from = side.normal;
            let turned = Vec2::new(cosine * from[0] - sine * from[1], sine * from[0] + cosine * from[1]);
            if k == f64::from(n) { next.normal } else { turned }
        };
        // The centroid of an arc lies a little within it.
        let inwards = (0.5 * step).sin() / (0.5 * step);
        for k in (0..n).map(f64::from) {
            let at = |s: f64| side.centre + normal(k + s) * self.rounding;
            pieces.push(Piece {
                ends: [at(0.0), at(1.0)],
                middle: at(0.5),
                mean: side.centre + normal(k + 0.5) * (self.rounding * inwards),
                normal: normal(k + 0.5),
                length: self.rounding * step,
            });
        }
    }

    /// The corners `[L]`, before they are rounded.
    pub(crate) fn vertices(&self) -> impl Iterator<Item = Vec2> + '_ {
        self.sides.iter().map(|side| side.start)
    }

    /// ρ `[L]`.
    pub fn rounding(&self) -> f64 {
        self.rounding
    }
}

/// A part of the boundary, straight or an arc.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    pub ends: [Vec2; 2],
    pub middle: Vec2,
    /// Centroid.
    pub mean: Vec2,
    pub normal: Vec2,
    pub length: f64,
}

fn doubled_area(vertices: &[Vec2]) -> f64 {
    let n = vertices.len();
    (0..n).map(|i| (vertices[i] - vertices[0]).perp(&(vertices[(i + 1) % n] - vertices[0]))).sum()
}

/// Whether the segments a-b and c-d have more than an end in common; touching does not count.
fn crosses(a: &Vec2, b: &Vec2, c: &Vec2, d: &Vec2) -> bool {
    let side = |p: &Vec2, q: &Vec2, r: &Vec2| (q - p).perp(&(r - p));
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}

/// Edges have a length, no edge runs back over the one before, and no two cross or touch.
fn check_edges(vertices: &[Vec2]) -> Result<(), ContactError> {
    let n = vertices.len();
    let refuse = |vertex: usize, expected| {
        let value = f64::from(u32::try_from(vertex + 1).unwrap_or(u32::MAX));
        Err(ContactError { name: VERTEX, value, expected })
    };
    let end = |i: usize| vertices[(i + 1) % n];
    for i in 0..n {
        let (a, b) = (vertices[i], end(i));
        if a == b {
            return refuse(i, "no two vertices at one place");
        }
        let (along, next) = (b - a, end((i + 1) % n) - b);
        if along.perp(&next) == 0.0 && along.dot(&next) <= 0.0 {
            return refuse((i + 1) % n, "no edge that runs back over the one before");
        }
        for (j, start) in vertices.iter().enumerate().skip(i + 2) {
            let neighbours = i == 0 && j == n - 1;
            if !neighbours && touches(&a, &b, start, &end(j)) {
                return refuse(j, "no edge that crosses or touches another");
            }
        }
    }
    Ok(())
}

/// Whether two closed segments have a point in common.
fn touches(a: &Vec2, b: &Vec2, c: &Vec2, d: &Vec2) -> bool {
    let side = |p: &Vec2, q: &Vec2, r: &Vec2| (q - p).perp(&(r - p));
    let on = |p: &Vec2, q: &Vec2, r: &Vec2| side(p, q, r) == 0.0 && (r - p).dot(&(r - q)) <= 0.0;
    crosses(a, b, c, d) || on(a, b, c) || on(a, b, d) || on(c, d, a) || on(c, d, b)
}

impl Shape<2> for Polygon {
    fn near(&self, x: &Vec2, reach: f64, out: &mut Vec<Near<2>>) {
        let from = out.len();
        let feet = self.feet(x, reach);
        out.extend(feet.iter().map(|it| Near::round(it.distance, it.normal, it.curvature, it.feature)));
        keep_distinct(out, from);
    }

    fn kind(&self) -> &'static str {
        "polygon"
    }

    fn facet_turn(&self) -> f64 {
        self.sides.iter().map(|side| side.turn.abs()).filter(|turn| *turn < SMOOTH).fold(0.0, f64::max)
    }

    fn bounds(&self) -> Bounds<2> {
        Bounds::around(self.sides.iter().map(|side| &side.start))
    }

    fn samples(&self, spacing: f64, _within: &Bounds<2>, out: &mut Vec<Sample<2>>) {
        let sample = |it: &Piece| Sample { position: it.middle, normal: it.normal, area: it.length };
        out.extend(self.pieces(spacing, 1).iter().map(sample));
    }

    fn outline(&self, _spacing: f64, _within: &Bounds<2>) -> Outline<2> {
        let mut outline = Outline::default();
        let pieces = self.pieces(f64::INFINITY, 6);
        let numbers: Vec<u32> = pieces.iter().map(|piece| outline.add(piece.ends[0])).collect();
        let n = numbers.len();
        outline.facets.extend((0..n).map(|i| [numbers[i], numbers[(i + 1) % n]]));
        outline
    }

    fn thickness(&self) -> f64 {
        // From the middle of every edge straight through to the other side.
        let mut least = f64::INFINITY;
        for side in &self.sides {
            let middle = side.start + side.tangent * (0.5 * side.length);
            for other in &self.sides {
                let falling = other.normal.dot(&side.normal);
                if falling < 0.0 {
                    let through = -other.normal.dot(&(other.start - middle)) / falling;
                    let along = other.tangent.dot(&(middle - side.normal * through - other.start));
                    if through > 0.0 && (0.0..=other.length).contains(&along) {
                        least = least.min(through);
                    }
                }
            }
        }
        least
    }
}

//! The points of a body as they are seen: what each stands for, or a disc.

use crate::drawn::{Drawn, complain};
use crate::error::PictureError;
use crate::view::{BodyView, View};
use mpm_io::{FolderFiles, Table};
use mpm_plot::{Shares, normal};
use mpm_scene::{BodyShares, Scene, shares_at_rest};
use mpm_solver::observe::Field;

/// What is seen of the points of a recorded step; the nearest are last.
#[derive(Default)]
pub(crate) struct Seen {
    /// What points stand for, and in space the facets of tools.
    pub(crate) pieces: Vec<Piece>,
    /// Points of which no more is known than where they are.
    pub(crate) discs: Vec<(usize, (f64, f64))>,
    /// Radius of the discs `[L]`.
    pub(crate) radius: f64,
}

/// What is seen of what a point stands for, or of a tool.
pub(crate) struct Piece {
    /// Number of the point; none of a tool.
    pub(crate) point: Option<usize>,
    pub(crate) corners: Vec<(f64, f64)>,
    /// How much light falls on it, from 0 to 1.
    pub(crate) light: f64,
}

/// The points of a results file, and how they are looked at.
pub(crate) struct Points<'a> {
    file: &'a Drawn,
    view: View,
    slice: Option<(usize, f64)>,
    cut: Option<(usize, f64)>,
    /// What the points of every body stand for, and the number of its first point; none where the scene cannot be filled
    /// again.
    bodies: Vec<Part>,
    /// The body that is drawn, if not all are.
    only: Option<String>,
    /// Whether domains are drawn in place of shares.
    domains: bool,
    solid: bool,
}

/// A body of a scene.
struct Part {
    name: String,
    first: usize,
    shares: Shares,
    /// What its points stand for at rest.
    rest: BodyShares,
}

impl Part {
    /// Where its points are, of those of all bodies.
    fn positions(&self, all: &Table) -> Vec<[f64; 3]> {
        let at = |share: usize| std::array::from_fn(|d| all.row(self.first + share)[d]);
        (0..self.shares.len()).map(at).collect()
    }

    /// The share whose point was nearest to a place at rest.
    fn nearest(&self, place: [f64; 2]) -> Option<usize> {
        let apart = |x: &[f64; 3]| (x[0] - place[0]).hypot(x[1] - place[1]);
        let nearest = self.rest.centres.iter().enumerate().min_by(|a, b| apart(a.1).total_cmp(&apart(b.1)));
        nearest.map(|it| it.0)
    }
}

/// Light on faces that look away from the lamp.
const SHADOW: f64 = 0.45;

impl<'a> Points<'a> {
    /// The points of a file; bodies are filled again as the scene says, which is beside the results or where it names
    /// its files.
    pub(crate) fn of(file: &'a Drawn, of: &BodyView) -> Result<Self, PictureError> {
        let solid = matches!(file.scene, Scene::Solid(_));
        // A slice is seen along its normal.
        let view = match of.slice {
            Some((0, _)) => View::X,
            Some((1, _)) => View::Y,
            Some(_) => View::Z,
            None => of.view,
        };
        let bodies = shares_at_rest(&file.scene, &FolderFiles::beside(&file.path)).unwrap_or_default();
        let bodies = where_recorded(bodies, file)?;
        let mut first = 0;
        let bodies: Vec<Part> = bodies
            .into_iter()
            .map(|rest| {
                let shares = Shares::new(&rest.centres, &rest.corners);
                first += shares.len();
                Part { name: rest.name.clone(), first: first - shares.len(), shares, rest }
            })
            .collect();
        if let Some(name) = of.body.as_ref().filter(|name| !bodies.iter().any(|body| body.name == **name)) {
            let known: Vec<&str> = bodies.iter().map(|body| &body.name[..]).collect();
            let known =
                if known.is_empty() { "none that can be filled again".into() } else { known.join(", ") };
            return Err(PictureError::of("body", format!("no body `{name}`; the scene has {known}")));
        }
        let (slice, cut) = (of.slice, of.cut);
        Ok(Self { file, view, slice, cut, bodies, only: of.body.clone(), domains: of.domains, solid })
    }

    /// Directions of space as they are seen, by name; none where axes are drawn.
    pub(crate) fn triad(&self) -> Vec<(&'static str, (f64, f64))> {
        if self.axes().is_some() {
            return Vec::new();
        }
        let names = ["x", "y", "z"];
        let unit = |d: usize| std::array::from_fn::<f64, 3, _>(|k| f64::from(u8::from(k == d)));
        (0..3).map(|d| (names[d], self.place(&unit(d)).0)).collect()
    }

    /// What names of axes say of the picture; nothing where it is seen from a corner.
    pub(crate) fn axes(&self) -> Option<[String; 2]> {
        let names = match (self.solid, self.view, &self.file.scene) {
            (false, _, Scene::Axisymmetric(_)) => ["r", "z"],
            (false, ..) | (true, View::Z, _) => ["x", "y"],
            (true, View::X, _) => ["y", "z"],
            (true, View::Y, _) => ["x", "z"],
            (true, View::Corner | View::From { .. }, _) => return None,
        };
        Some(names.map(|name| format!("{name} [L]")))
    }

    /// The points of a step, in space with the facets of tools.
    pub(crate) fn seen(&self, step: usize, tools: Vec<Vec<[f64; 3]>>) -> Result<Seen, PictureError> {
        let results = &self.file.results;
        let positions = results.points(step).map_err(complain)?;
        let all = || (0..positions.len()).map(|point| positions.row(point));
        let spacing = spacing(all(), if self.solid { 3 } else { 2 });
        // More than half: a plane of the mesh lies halfway between points.
        let is_near = |x: &[f64]| self.slice.is_none_or(|(axis, at)| (x[axis] - at).abs() <= 0.75 * spacing);
        let [_, _, towards] = self.view.frame();
        let is_behind =
            |x: &[f64]| self.cut.is_none_or(|(axis, at)| (x[axis] - at) * towards[axis].signum() <= 0.0);
        let shown = |point: usize| {
            let x = positions.row(point);
            is_near(x) && is_behind(x) && self.is_of_body(point)
        };
        let is_filled = !self.bodies.is_empty() && self.n_shares() == positions.len();
        if let Some(outlines) = self.outlines(step, is_filled)? {
            return Ok(outlined(&positions, &outlines, shown, 0.5 * spacing));
        }
        if !is_filled {
            let mut points: Vec<_> = (0..positions.len())
                .filter(|&point| shown(point))
                .map(|point| (point, self.place(positions.row(point))))
                .collect();
            points.sort_by(|a, b| a.1.1.total_cmp(&b.1.1));
            let discs = points.into_iter().map(|(point, (at, _))| (point, at)).collect();
            return Ok(Seen { discs, radius: 0.5 * spacing, ..Seen::default() });
        }
        let mut faces = Vec::new();
        for body in &self.bodies {
            let moved = self.moved(body, &positions);
            if self.solid {
                let outside = body.shares.outside(&moved, |share| shown(body.first + share));
                faces.extend(outside.into_iter().map(|face| (Some(body.first + face.share), face.corners)));
            } else {
                let shares = moved.into_iter().enumerate();
                let shares = shares.filter(|(share, _)| shown(body.first + share));
                faces.extend(shares.map(|(share, corners)| (Some(body.first + share), corners)));
            }
        }
        if self.solid && self.slice.is_none() {
            let tools = tools.iter().flat_map(|facet| pieces(facet, 0.8 * spacing));
            faces.extend(tools.map(|corners| (None, corners)));
        }
        Ok(Seen { pieces: if self.solid { self.lit(faces) } else { flat(faces) }, ..Seen::default() })
    }

    /// Number of the points that bodies have at rest.
    fn n_shares(&self) -> usize {
        self.bodies.iter().map(|body| body.shares.len()).sum()
    }

    /// Where the corners of a body's shares are.
    fn moved(&self, body: &Part, positions: &Table) -> Vec<Vec<[f64; 3]>> {
        body.shares.moved(&body.positions(positions))
    }

    /// Where places of a body at rest are: each goes with the point that was nearest to it.
    pub(crate) fn carried(
        &self,
        step: usize,
        body: &str,
        places: &[[f64; 2]],
    ) -> Result<Vec<(f64, f64)>, PictureError> {
        let positions = self.file.results.points(step).map_err(complain)?;
        let Some(body) = self.bodies.iter().find(|it| it.name == body) else { return Ok(Vec::new()) };
        if self.n_shares() != positions.len() {
            return Ok(Vec::new());
        }
        let positions = body.positions(&positions);
        let carried = |place: &[f64; 2]| {
            let x = body.shares.carried(body.nearest(*place)?, &[place[0], place[1], 0.0], &positions);
            Some((x[0], x[1]))
        };
        Ok(places.iter().filter_map(carried).collect())
    }

    /// For every edge of a body's shares that lies on a line at rest: the middle of where it is.
    pub(crate) fn on_boundary(
        &self,
        step: usize,
        body: &str,
        is_on: impl Fn(&[f64; 3]) -> bool,
    ) -> Result<Vec<(f64, f64)>, PictureError> {
        let positions = self.file.results.points(step).map_err(complain)?;
        let Some(body) = self.bodies.iter().find(|it| it.name == body) else { return Ok(Vec::new()) };
        if self.n_shares() != positions.len() {
            return Ok(Vec::new());
        }
        let mut middles = Vec::new();
        for (rest, now) in body.rest.corners.iter().zip(self.moved(body, &positions)) {
            for k in 0..rest.len() {
                let next = (k + 1) % rest.len();
                if is_on(&rest[k]) && is_on(&rest[next]) {
                    middles.push((0.5 * (now[k][0] + now[next][0]), 0.5 * (now[k][1] + now[next][1])));
                }
            }
        }
        Ok(middles)
    }

    /// Where the point of a body is that was nearest to a position at rest.
    pub(crate) fn nearest(
        &self,
        step: usize,
        body: &str,
        near: [f64; 2],
    ) -> Result<Option<(f64, f64)>, PictureError> {
        let positions = self.file.results.points(step).map_err(complain)?;
        let Some(body) = self.bodies.iter().find(|it| it.name == body) else { return Ok(None) };
        let place = |share: usize| {
            let at = body.first + share;
            (at < positions.len()).then(|| (positions.row(at)[0], positions.row(at)[1]))
        };
        Ok(body.nearest(near).and_then(place))
    }

    fn is_of_body(&self, point: usize) -> bool {
        let Some(only) = &self.only else { return true };
        let body = self.bodies.iter().find(|body| body.name == *only);
        body.is_some_and(|body| (body.first..body.first + body.shares.len()).contains(&point))
    }

    /// Corners of the domains, where they are recorded and either asked for or all that is known of what points fill.
    fn outlines(&self, step: usize, is_filled: bool) -> Result<Option<Table>, PictureError> {
        let results = &self.file.results;
        let outline = Field::OUTLINE.name();
        if self.solid || is_filled && !self.domains {
            return Ok(None);
        }
        if !results.fields().map_err(complain)?.iter().any(|name| name == outline) {
            return match self.domains {
                true => Err(PictureError::of("domains", "the scene has no `Outline` in `output.fields`")),
                false => Ok(None),
            };
        }
        let table = results.field(outline, step).map_err(complain)?;
        match table.width() == Field::OUTLINE.components() {
            true => Ok(Some(table)),
            false => {
                let width = table.width();
                Err(PictureError::new(format!("field outline has {width} numbers per point, expected 8")))
            }
        }
    }

    /// Faces in space as they are seen: those that look this way, the nearest last, under a lamp.
    fn lit(&self, faces: Vec<(Option<usize>, Vec<[f64; 3]>)>) -> Vec<Piece> {
        let [right, up, towards] = self.view.frame();
        // Above the left shoulder of who looks.
        let lamp: [f64; 3] = std::array::from_fn(|d| towards[d] - 0.25 * right[d] + 0.7 * up[d]);
        let size = lamp.iter().map(|x| x * x).sum::<f64>().sqrt();
        let mut seen = Vec::new();
        for (point, corners) in faces {
            let normal = normal(&corners);
            let norm = normal.norm();
            let along = |way: [f64; 3]| (0..3).map(|d| normal[d] * way[d]).sum::<f64>() / norm;
            // What is seen from its edge, or has no area, is not drawn.
            let is_seen = along(towards) > 1e-9;
            if !is_seen {
                continue;
            }
            let light = SHADOW + (1.0 - SHADOW) * (along(lamp) / size).max(0.0);
            let placed: Vec<_> = corners.iter().map(|x| self.place(x)).collect();
            let depth = placed.iter().map(|it| it.1).sum::<f64>() / placed.len() as f64;
            let corners = placed.into_iter().map(|it| it.0).collect();
            seen.push((depth, Piece { point, corners, light }));
        }
        seen.sort_by(|a, b| a.0.total_cmp(&b.0));
        seen.into_iter().map(|it| it.1).collect()
    }

    /// Where a point appears, and how near it is.
    pub(crate) fn place(&self, x: &[f64]) -> ((f64, f64), f64) {
        if !self.solid {
            return ((x[0], x[1]), 0.0);
        }
        let [right, up, towards] = self.view.frame().map(|way| (0..3).map(|d| way[d] * x[d]).sum::<f64>());
        ((right, up), towards)
    }
}

/// The bodies with their points where the first recorded step has them, if that is the start: bases place them differently
/// in a piece. None of them if it has them elsewhere: a file that the scene names may have changed since.
fn where_recorded(mut bodies: Vec<BodyShares>, file: &Drawn) -> Result<Vec<BodyShares>, PictureError> {
    if file.results.fractions().first() != Some(&0.0) {
        return Ok(bodies);
    }
    let positions = file.results.points(0).map_err(complain)?;
    let mut rows = (0..positions.len()).map(|point| positions.row(point));
    for body in &mut bodies {
        for (centre, corners) in body.centres.iter_mut().zip(&body.corners) {
            let inside = |x: &[f64]| {
                (0..3).all(|d| {
                    let along = corners.iter().map(|corner| corner[d]);
                    let (from, to) =
                        along.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
                    from <= x[d] && x[d] <= to
                })
            };
            let Some(x) = rows.next().filter(|x| inside(x)) else { return Ok(Vec::new()) };
            centre.copy_from_slice(x);
        }
    }
    Ok(if rows.next().is_none() { bodies } else { Vec::new() })
}

/// Domains whose corners are recorded.
fn outlined(positions: &Table, outlines: &Table, shown: impl Fn(usize) -> bool, radius: f64) -> Seen {
    let mut seen = Seen { radius, ..Seen::default() };
    for point in (0..positions.len()).filter(|&point| shown(point)) {
        let at = (positions.row(point)[0], positions.row(point)[1]);
        let corners: Vec<(f64, f64)> = outlines.row(point).chunks_exact(2).map(|x| (x[0], x[1])).collect();
        // Points without a domain record their position as all of its corners.
        match corners.iter().all(|corner| *corner == at) {
            true => seen.discs.push((point, at)),
            false => seen.pieces.push(Piece { point: Some(point), corners, light: 1.0 }),
        }
    }
    seen
}

/// A triangle in pieces whose sides are no longer than `longest`: what is sorted by depth has to be small.
fn pieces(triangle: &[[f64; 3]], longest: f64) -> Vec<Vec<[f64; 3]>> {
    const MOST: usize = 1 << 14;
    let mut open = vec![triangle.to_vec()];
    let mut done = Vec::new();
    while let Some(corners) = open.pop() {
        let length = |k: usize| {
            let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
            (0..3).map(|d| (a[d] - b[d]).powi(2)).sum::<f64>().sqrt()
        };
        let side = (0..corners.len()).max_by(|&a, &b| length(a).total_cmp(&length(b))).unwrap_or(0);
        if length(side) <= longest || done.len() + open.len() >= MOST || corners.len() != 3 {
            done.push(corners);
            continue;
        }
        let [a, b, c] = [0, 1, 2].map(|k| corners[(side + k) % 3]);
        let middle = std::array::from_fn(|d| 0.5 * (a[d] + b[d]));
        open.extend([vec![a, middle, c], vec![middle, b, c]]);
    }
    done
}

/// Shares in the plane.
fn flat(shares: Vec<(Option<usize>, Vec<[f64; 3]>)>) -> Vec<Piece> {
    let seen = |(point, corners): (Option<usize>, Vec<[f64; 3]>)| {
        let corners = corners.into_iter().map(|x| (x[0], x[1])).collect();
        Piece { point, corners, light: 1.0 }
    };
    shares.into_iter().map(seen).collect()
}

/// Distance between neighbours if the points filled their cloud evenly: from occupied squares or cubes of a
/// coarse grid.
fn spacing<'a>(points: impl Iterator<Item = &'a [f64]> + Clone, dimensions: usize) -> f64 {
    let mut ends = [(f64::INFINITY, f64::NEG_INFINITY); 3];
    let mut n = 0;
    for x in points.clone() {
        n += 1;
        for (end, x) in ends.iter_mut().zip(x) {
            *end = (end.0.min(*x), end.1.max(*x));
        }
    }
    let longest = ends[..dimensions].iter().map(|end| end.1 - end.0).fold(0.0, f64::max);
    if n < 2 || longest <= 0.0 {
        return 1.0;
    }
    // About eight points to a box, if the cloud were full.
    let volume: f64 = ends[..dimensions].iter().map(|end| (end.1 - end.0).max(1e-3 * longest)).product();
    let side = (8.0 * volume / f64::from(n)).powf(1.0 / dimensions as f64);
    let mut boxes: Vec<[i64; 3]> = points
        .map(|x| {
            std::array::from_fn(|d| if d < dimensions { ((x[d] - ends[d].0) / side).floor() as i64 } else { 0 })
        })
        .collect();
    boxes.sort_unstable();
    boxes.dedup();
    (boxes.len() as f64 / f64::from(n)).powf(1.0 / dimensions as f64) * side
}

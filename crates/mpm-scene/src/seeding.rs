//! Points of shapes that are cut into pieces, layers of cells at once.

use crate::boundary::Boundary;
use crate::pieces::{Outer, Pieces};
use crate::places::{FaceShare, Points, face_share};
use crate::share::ShareOfPoints;
use mpm_basis::{Basis, Seed};
use mpm_contact::Pose;
use mpm_geometry::Face;
use mpm_grid::{LinearCell, Vector};
use rayon::prelude::*;
use std::ops::Range;

/// Points that are worth a task, about.
const POINTS_OF_TASK: f64 = 8192.0;

/// Pieces of a shape, and what is wanted of them.
pub(crate) struct Seeding<'a, const D: usize> {
    pub pieces: Pieces<'a, D>,
    /// Where the pieces are moved to.
    pub pose: Option<&'a Pose<D>>,
    /// Parts of the boundary that carry tractions.
    pub faces: &'a [Face<D>],
    pub needs_sides: bool,
    pub share: ShareOfPoints,
}

/// Points of pieces, what they carry of every face, and the sides of the pieces.
pub(crate) struct SeededPieces<S, const D: usize> {
    pub points: Points<S, D>,
    pub faces: Vec<Vec<FaceShare<D>>>,
    pub boundary: Boundary<D>,
}

impl<const D: usize> Seeding<'_, D> {
    /// The points of all pieces, `count` in number, in their order.
    ///
    /// # Errors
    /// A corner of the first piece whose volume cannot be computed.
    pub(crate) fn seed<B: Basis<D>>(
        &self,
        basis: &B,
        count: f64,
    ) -> Result<SeededPieces<Seed<D, B::Domain>, D>, Vector<D>> {
        let layers = self.pieces.layers();
        let tasks = ((count / POINTS_OF_TASK) as usize).min(layers);
        if tasks < 2 {
            return self.seed_layers(basis, count, 0..layers);
        }
        let of_task = |task: usize| layers * task / tasks..layers * (task + 1) / tasks;
        let parts: Vec<_> =
            (0..tasks).into_par_iter().map(|task| self.seed_layers(basis, count, of_task(task))).collect();
        let mut all = self.seed_layers(basis, count, 0..0)?;
        all.points.reserve(count);
        for part in parts {
            let SeededPieces { points, faces, boundary } = part?;
            let before = all.points.places.len();
            for (all, part) in all.faces.iter_mut().zip(faces) {
                all.extend(part.into_iter().map(|share| FaceShare { point: before + share.point, ..share }));
            }
            all.points.append(points);
            all.boundary.append(boundary);
        }
        Ok(all)
    }

    /// The same of some layers; faces number the points from the first of these.
    fn seed_layers<B: Basis<D>>(
        &self,
        basis: &B,
        count: f64,
        layers: Range<usize>,
    ) -> Result<SeededPieces<Seed<D, B::Domain>, D>, Vector<D>> {
        let pieces = self.pieces.below(self.pieces.layers());
        let of_piece = count as usize / pieces.max(1);
        let first = self.pieces.below(layers.start) * of_piece;
        let mut points = Points::of(self.share, count, first);
        let (mut faces, mut boundary) = (vec![Vec::new(); self.faces.len()], Boundary::default());
        let (mut seeds, mut flat) = (Vec::new(), None);
        self.pieces.for_each(layers, |piece, outer| {
            if flat.is_some() {
                return;
            }
            let corner = piece.corners()[0];
            let moved =
                self.pose.map(|pose| LinearCell::new(piece.corners().map(|corner| pose.place(&corner))));
            let piece = moved.as_ref().unwrap_or(piece);
            basis.seed(piece, &mut |seed| seeds.push(seed));
            // Ends can be so close together, or so far apart, that their numbers do not tell how far.
            let volume: f64 = seeds.iter().map(|seed| seed.volume).sum();
            if !(volume > 0.0 && volume.is_finite()) {
                flat = Some(corner);
                return;
            }
            let of_piece = points.take(&mut seeds);
            if self.needs_sides {
                boundary.add(piece, outer);
            }
            for (face, shares) in self.faces.iter().zip(&mut faces) {
                if let Some((area, centre)) = area_on(face, piece, outer) {
                    shares.extend(face_share(&points.places, of_piece.clone(), area, &centre));
                }
            }
        });
        match flat {
            Some(corner) => Err(corner),
            None => Ok(SeededPieces { points, faces, boundary }),
        }
    }
}

/// Area and centre of the side of a piece that lies on a face, if one does; only sides of the body count.
fn area_on<const D: usize>(
    face: &Face<D>,
    piece: &LinearCell<D>,
    outer: &Outer<D>,
) -> Option<(f64, Vector<D>)> {
    let corners = &piece.corners()[..1 << D];
    let size = (corners[0] - corners[corners.len() - 1]).norm();
    let sides = (0..D).flat_map(|d| [(d, 0), (d, 1)]).filter(|&(d, bit)| outer[d][bit]);
    for (direction, bit) in sides {
        let mut side = corners.iter().enumerate().filter(|(c, _)| c >> direction & 1 == bit).map(|(_, x)| x);
        if !side.clone().all(|x| (x[face.axis] - face.at).abs() <= 1e-9 * size) {
            continue;
        }
        let count = side.clone().count() as f64;
        let centre = side.clone().sum::<Vector<D>>() / count;
        if let Some(within) = &face.within {
            let low = side.clone().fold(centre, |low, x| low.inf(x));
            let high = side.clone().fold(centre, |high, x| high.sup(x));
            if side.clone().all(|x| (0..D).all(|d| x[d] == low[d] || x[d] == high[d])) {
                return part_within(face.axis, (low, high), within);
            }
            if (0..D).any(|d| d != face.axis && !(within.0[d]..=within.1[d]).contains(&centre[d])) {
                return None;
            }
        }
        let mut next = || *side.next().expect("a side has 2^(D-1) corners");
        let area = match D {
            2 => (next() - next()).norm(),
            _ => {
                let (a, b, c, d) = (next(), next(), next(), next());
                triangle_area(&(b - a), &(c - a)) + triangle_area(&(b - d), &(c - d))
            }
        };
        return Some((area, centre));
    }
    None
}

/// Size and centre of what of a side along the axes lies between two corners, if anything does.
fn part_within<const D: usize>(
    axis: usize,
    (mut low, mut high): (Vector<D>, Vector<D>),
    (from, to): &([f64; D], [f64; D]),
) -> Option<(f64, Vector<D>)> {
    let mut area = 1.0;
    for d in (0..D).filter(|&d| d != axis) {
        let size = high[d] - low[d];
        (low[d], high[d]) = (low[d].max(from[d]), high[d].min(to[d]));
        if high[d] - low[d] <= 1e-9 * size {
            return None;
        }
        area *= high[d] - low[d];
    }
    Some((area, (low + high) * 0.5))
}

fn triangle_area<const D: usize>(a: &Vector<D>, b: &Vector<D>) -> f64 {
    0.5 * (a.norm_squared() * b.norm_squared() - a.dot(b).powi(2)).max(0.0).sqrt()
}

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pieces::Shape;
    use mpm_basis::Cpdi1;
    use mpm_grid::{Axis, Layout, Mesh};

    /// Layers at once give the points, numbers, loaded faces and sides of one layer after the other, of all points and of a share.
    #[test]
    fn layers_at_once_are_those_one_after_the_other() {
        let axis = || Axis::uniform(0.0, 100.0, 100).unwrap();
        let mesh = Mesh::at_rest(&Layout::on_axes([axis(), axis()]).unwrap());
        let shape = Shape::Box { from: [0.0, 0.0], to: [90.0, 100.0] };
        let faces = [Face { axis: 0, at: 90.0, within: None }, Face { axis: 1, at: 100.0, within: None }];
        let count = 4.0 * 9000.0;
        for share in [ShareOfPoints::ALL, ShareOfPoints { rank: 1, ranks: 3, on_machine: 1 }] {
            let pieces = Pieces::of(&mesh, &shape, (2, ["x", "y", "z"])).unwrap();
            let layers = pieces.layers();
            let seeding = Seeding { pieces, pose: None, faces: &faces, needs_sides: true, share };
            let at_once = seeding.seed(&Cpdi1, count).unwrap();
            let in_turn = seeding.seed_layers(&Cpdi1, count, 0..layers).unwrap();
            let places = |it: &SeededPieces<_, 2>| -> Vec<_> {
                it.points.places.iter().map(|place| (place.position, place.size)).collect()
            };
            assert_eq!(places(&at_once), places(&in_turn));
            assert_eq!(at_once.points.places.len(), 36_000);
            assert_eq!(at_once.points.numbers, in_turn.points.numbers);
            let seeds = |it: &SeededPieces<Seed<2, _>, 2>| -> Vec<_> {
                it.points.seeds.iter().map(|seed| (seed.position, seed.volume)).collect()
            };
            assert_eq!(seeds(&at_once), seeds(&in_turn));
            assert_eq!(at_once.points.seeds.len(), if share.is_all() { 36_000 } else { 12_000 });
            assert_eq!(at_once.faces, in_turn.faces);
            assert_eq!(at_once.faces.iter().map(Vec::len).collect::<Vec<_>>(), [200, 180]);
            let side = |it: &SeededPieces<_, 2>| it.boundary.side((0, true), "b", "right").map(|it| it.markers);
            assert_eq!(side(&at_once), side(&in_turn));
            assert_eq!(side(&at_once).map(|it| it.len()), Some(201));
        }
    }
}

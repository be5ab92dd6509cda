//! Parts of a body that material points stand for, drawn without gaps after they have moved.

use nalgebra::{Matrix3, Rotation3, SymmetricEigen, Vector3};

/// Parts of a body at rest, each with the point that stands for it.
#[derive(Clone, Debug)]
pub struct Shares {
    centres: Vec<Vector3<f64>>,
    /// For every share the numbers of its corners.
    corners: Vec<Vec<u32>>,
    /// Corners at rest; shares that meet have theirs in common.
    vertices: Vec<Vector3<f64>>,
    /// For every vertex the shares that meet there.
    around: Vec<Vec<u32>>,
}

/// A side of a share on the outside of the body, in space.
#[derive(Clone, Debug, PartialEq)]
pub struct Face {
    /// Number of the share.
    pub share: usize,
    /// Its corners, seen from outside against the clock.
    pub corners: Vec<[f64; 3]>,
}

/// Corners that are closer than this part of a share's size are one.
const SAME: f64 = 1e-5;

/// Cosine of an angle at rest beyond which a neighbour is on the other side.
const OPPOSITE: f64 = -0.9;

/// A neighbour has gone that is so many times as far as that on the other side.
const TORN: f64 = 3.0;

/// Directions in which neighbours spread less than this part of their spread in others say nothing of the deformation.
const FLAT: f64 = 1e-6;

impl Shares {
    /// Shares by the positions of their points and their corners: round the outline in the plane; in space eight of a
    /// hexahedron, the first axis fastest, or four of a tetrahedron.
    pub fn new(centres: &[[f64; 3]], corners: &[Vec<[f64; 3]>]) -> Self {
        let size = corners.iter().map(|it| extent(it)).filter(|it| *it > 0.0).fold(f64::INFINITY, f64::min);
        let width = if size.is_finite() { SAME * size } else { 1.0 };
        // Round coordinates fall into the middle of a box, not on the border between two.
        let key = |x: &[f64; 3]| x.map(|x| (x / width + 0.3137).floor() as i64);
        let all =
            corners.iter().enumerate().flat_map(|(s, of)| of.iter().enumerate().map(move |(k, x)| (s, k, x)));
        let mut sorted: Vec<_> = all.map(|(s, k, x)| (key(x), s, k, x)).collect();
        sorted.sort_by_key(|it| (it.0, it.1, it.2));
        let mut numbered: Vec<Vec<u32>> = corners.iter().map(|of| vec![0; of.len()]).collect();
        let (mut vertices, mut around): (Vec<Vector3<f64>>, Vec<Vec<u32>>) = Default::default();
        let mut before = None;
        for (key, share, k, x) in sorted {
            if before != Some(key) {
                vertices.push(Vector3::from(*x));
                around.push(Vec::new());
                before = Some(key);
            }
            numbered[share][k] = (vertices.len() - 1) as u32;
            if let Some(shares) = around.last_mut().filter(|shares| shares.last() != Some(&(share as u32))) {
                shares.push(share as u32);
            }
        }
        let centres = centres.iter().map(|x| Vector3::from(*x)).collect();
        Self { centres, corners: numbered, vertices, around }
    }

    /// Number of shares.
    pub fn len(&self) -> usize {
        self.centres.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.centres.is_empty()
    }

    /// Corners at rest of a share.
    pub fn at_rest(&self, share: usize) -> impl Iterator<Item = [f64; 3]> {
        self.corners[share].iter().map(|&vertex| self.vertices[vertex as usize].into())
    }

    /// Where the corners are when the points are at `positions`.
    ///
    /// A corner follows the shares that meet in it, each of which deforms as the points around it move (the affine map
    /// nearest to their motion). Shares that meet at rest still do, unless the body has come apart between them: where they would
    /// take their corner to places farther apart than the two are wide.
    pub fn moved(&self, positions: &[[f64; 3]]) -> Vec<Vec<[f64; 3]>> {
        let maps: Vec<Matrix3<f64>> = (0..self.len()).map(|share| self.deformation(share, positions)).collect();
        let at_rest = |of: &Vec<u32>| of.iter().map(|&vertex| self.vertices[vertex as usize].into()).collect();
        let mut moved: Vec<Vec<[f64; 3]>> = self.corners.iter().map(at_rest).collect();
        for (number, (vertex, shares)) in self.vertices.iter().zip(&self.around).enumerate() {
            let of = |&share: &u32| {
                let share = share as usize;
                let arm = maps[share] * (vertex - self.centres[share]);
                (Vector3::from(positions[share]) + arm, arm.norm())
            };
            let wished: Vec<(Vector3<f64>, f64)> = shares.iter().map(of).collect();
            for (place, &share) in together(&wished).into_iter().zip(shares) {
                let corners = self.corners[share as usize].iter().zip(&mut moved[share as usize]);
                corners
                    .filter(|(it, _)| **it as usize == number)
                    .for_each(|(_, corner)| *corner = place.into());
            }
        }
        moved
    }

    /// Where a share takes a place of the body at rest when the points are at `positions`.
    pub fn carried(&self, share: usize, place: &[f64; 3], positions: &[[f64; 3]]) -> [f64; 3] {
        let arm = Vector3::from(*place) - self.centres[share];
        (Vector3::from(positions[share]) + self.deformation(share, positions) * arm).into()
    }

    /// The deformation gradient around a share by least squares over its neighbours; directions in which it has none
    /// turn with the others, and do not stretch.
    fn deformation(&self, share: usize, positions: &[[f64; 3]]) -> Matrix3<f64> {
        let mut near: Vec<u32> =
            self.corners[share].iter().flat_map(|&vertex| &self.around[vertex as usize]).copied().collect();
        near.sort_unstable();
        near.dedup();
        let pair = |other: usize| {
            let rest = self.centres[other] - self.centres[share];
            (rest, Vector3::from(positions[other]) - Vector3::from(positions[share]))
        };
        let others = near.into_iter().map(|it| it as usize).filter(|&it| it != share);
        let pairs: Vec<(Vector3<f64>, Vector3<f64>)> = others.map(pair).collect();
        let (mut spread, mut motion) = (Matrix3::zeros(), Matrix3::zeros());
        for (rest, now) in pairs.iter().filter(|it| !is_torn_off(it, &pairs)) {
            spread += rest * rest.transpose();
            motion += now * rest.transpose();
        }
        let eigen = SymmetricEigen::new(spread);
        let largest = eigen.eigenvalues.max();
        let known = |k: usize| largest > 0.0 && eigen.eigenvalues[k] > FLAT * largest;
        let mut map = Matrix3::zeros();
        for k in (0..3).filter(|&k| known(k)) {
            let along = eigen.eigenvectors.column(k);
            map += motion * along / eigen.eigenvalues[k] * along.transpose();
        }
        map + turned_rest(
            &map,
            (0..3).filter(|&k| !known(k)).map(|k| eigen.eigenvectors.column(k).into_owned()),
        )
    }

    /// Sides of the shares that no other share has, when the corners are at `moved`; only of the shares that `shown`
    /// names.
    pub fn outside(&self, moved: &[Vec<[f64; 3]>], shown: impl Fn(usize) -> bool) -> Vec<Face> {
        let mut sides: Vec<([u32; 4], usize, &[usize])> = Vec::new();
        for (share, of) in self.corners.iter().enumerate().filter(|(share, _)| shown(*share)) {
            for side in sides_of(of.len()) {
                let mut key = [u32::MAX; 4];
                key.iter_mut().zip(*side).for_each(|(key, &corner)| *key = of[corner]);
                key.sort_unstable();
                sides.push((key, share, side));
            }
        }
        sides.sort_unstable_by_key(|it| (it.0, it.1));
        // Where the body has come apart, a side of two shares is two.
        let place = |&(_, share, side): &([u32; 4], usize, &[usize])| {
            let mut places: Vec<(u32, [f64; 3])> =
                side.iter().map(|&corner| (self.corners[share][corner], moved[share][corner])).collect();
            places.sort_unstable_by_key(|it| it.0);
            places
        };
        let alone = |same: &&[([u32; 4], usize, &[usize])]| match same {
            [_] => true,
            [a, b] => place(a) != place(b),
            _ => false,
        };
        let face = |&(_, share, side): &([u32; 4], usize, &[usize])| {
            let corners = side.iter().map(|&corner| moved[share][corner]).collect();
            Face { share, corners: outwards(corners, &moved[share]) }
        };
        sides.chunk_by(|a, b| a.0 == b.0).filter(alone).flatten().map(face).collect()
    }
}

/// Where shares take a corner that they have in common, from where each of them would take it and how far that is from its
/// middle: the mean of those that are near each other, or near a third.
fn together(wished: &[(Vector3<f64>, f64)]) -> Vec<Vector3<f64>> {
    let mut group: Vec<usize> = (0..wished.len()).collect();
    for (k, (place, reach)) in wished.iter().enumerate() {
        for (other, (there, far)) in wished[..k].iter().enumerate() {
            if group[other] != group[k] && (place - there).norm() <= reach + far {
                let (from, to) = (group[k].max(group[other]), group[k].min(group[other]));
                group.iter_mut().filter(|it| **it == from).for_each(|it| *it = to);
            }
        }
    }
    let mean = |of: usize| {
        let places = wished.iter().zip(&group).filter(|(_, it)| **it == of).map(|(it, _)| it.0);
        let (sum, count) = places.fold((Vector3::zeros(), 0.0), |(sum, count), it| (sum + it, count + 1.0));
        sum / count
    };
    group.iter().map(|&of| mean(of)).collect()
}

/// Whether a neighbour has gone: its distance has grown far more than that of the neighbour on the other side. Neighbours are
/// told by where they are from the middle, at rest and now.
fn is_torn_off((rest, now): &(Vector3<f64>, Vector3<f64>), all: &[(Vector3<f64>, Vector3<f64>)]) -> bool {
    let angle = |other: &Vector3<f64>| rest.dot(other) / (rest.norm() * other.norm());
    let opposite = all.iter().filter(|it| angle(&it.0) < OPPOSITE);
    let opposite = opposite.min_by(|a, b| angle(&a.0).total_cmp(&angle(&b.0)));
    opposite.is_some_and(|(other, there)| now.norm() * other.norm() > TORN * there.norm() * rest.norm())
}

/// What a map of which only a part is known does with the other directions: they turn, and do not stretch.
fn turned_rest(map: &Matrix3<f64>, unknown: impl Iterator<Item = Vector3<f64>>) -> Matrix3<f64> {
    match &unknown.collect::<Vec<_>>()[..] {
        [] => Matrix3::zeros(),
        // In the plane, and in a sheet in space: across what the two others have become.
        [along] => {
            let [a, b] = across(along);
            let normal = (map * a).cross(&(map * b)).try_normalize(f64::MIN_POSITIVE);
            normal.map_or(Matrix3::zeros(), |normal| normal * along.transpose())
        }
        // In a row: by the shortest turn that the row has made.
        [a, b] => {
            let row = a.cross(b);
            let turn = Rotation3::rotation_between(&row, &(map * row)).unwrap_or_else(Rotation3::identity);
            turn.matrix() * (a * a.transpose() + b * b.transpose())
        }
        _ => Matrix3::identity(),
    }
}

/// Two directions that make a right-handed system with a third one behind them.
fn across(along: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let least = along.iamin();
    let a = along.cross(&Vector3::ith(least, 1.0)).normalize();
    [a, along.cross(&a)]
}

/// Corners of the sides of a share of so many corners.
fn sides_of(corners: usize) -> &'static [&'static [usize]] {
    const HEXAHEDRON: &[&[usize]] =
        &[&[0, 2, 6, 4], &[1, 3, 7, 5], &[0, 1, 5, 4], &[2, 3, 7, 6], &[0, 1, 3, 2], &[4, 5, 7, 6]];
    const TETRAHEDRON: &[&[usize]] = &[&[0, 1, 2], &[0, 1, 3], &[0, 2, 3], &[1, 2, 3]];
    match corners {
        8 => HEXAHEDRON,
        4 => TETRAHEDRON,
        _ => &[],
    }
}

/// A side with its corners in the order in which its normal points away from the middle of its share.
fn outwards(mut side: Vec<[f64; 3]>, share: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let middle = |of: &[[f64; 3]]| of.iter().map(|x| Vector3::from(*x)).sum::<Vector3<f64>>() / of.len() as f64;
    if normal(&side).dot(&(middle(&side) - middle(share))) < 0.0 {
        side.reverse();
    }
    side
}

/// Twice the area of a polygon, along its normal.
pub fn normal(corners: &[[f64; 3]]) -> Vector3<f64> {
    let pairs = corners.iter().zip(corners.iter().cycle().skip(1));
    pairs.map(|(a, b)| Vector3::from(*a).cross(&Vector3::from(*b))).sum()
}

/// Longest side of the box round some positions.
fn extent(of: &[[f64; 3]]) -> f64 {
    let along = |d: usize| {
        let ends = of.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x[d]), b.max(x[d])));
        ends.1 - ends.0
    };
    (0..3).map(along).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cells of a row of boxes, 1 by 1 by 1.
    fn boxes(n: usize) -> Shares {
        let corner = |s: usize, c: usize| [s + (c & 1), c >> 1 & 1, c >> 2].map(|x| x as f64);
        let corners: Vec<Vec<[f64; 3]>> = (0..n).map(|s| (0..8).map(|c| corner(s, c)).collect()).collect();
        let centres: Vec<[f64; 3]> = (0..n).map(|s| [s as f64 + 0.5, 0.5, 0.5]).collect();
        Shares::new(&centres, &corners)
    }

    /// Squares of a sheet in the plane.
    fn squares(n: usize) -> (Shares, Vec<[f64; 3]>) {
        let at = |k: usize| ((k % n) as f64, (k / n) as f64);
        let square = |k: usize| {
            let (x, y) = at(k);
            [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(a, b)| [x + a, y + b, 0.0]).to_vec()
        };
        let centres: Vec<[f64; 3]> = (0..n * n).map(at).map(|(x, y)| [x + 0.5, y + 0.5, 0.0]).collect();
        (Shares::new(&centres, &(0..n * n).map(square).collect::<Vec<_>>()), centres)
    }

    #[test]
    fn corners_follow_an_affine_motion_exactly() {
        let (shares, centres) = squares(3);
        assert_eq!(shares.vertices.len(), 16, "corners that meet are one");
        let map = |x: [f64; 3]| [2.0 - x[1] + 0.3 * x[0], 1.2 * x[0] + 0.1 * x[1], 0.0];
        let positions: Vec<[f64; 3]> = centres.iter().map(|x| map(*x)).collect();
        for (share, corners) in shares.moved(&positions).iter().enumerate() {
            for (corner, rest) in corners.iter().zip(shares.at_rest(share)) {
                let expected = map(rest);
                assert!((0..3).all(|d| (corner[d] - expected[d]).abs() < 1e-13), "{corner:?} {expected:?}");
            }
        }
    }

    #[test]
    fn a_row_of_boxes_turns_with_its_points() {
        let shares = boxes(4);
        // A quarter turn about z, and a stretch along the row.
        let positions: Vec<[f64; 3]> = (0..4).map(|s| [0.0, 2.0 * (s as f64 + 0.5), 0.5]).collect();
        let moved = shares.moved(&positions);
        let volume = |of: &Vec<[f64; 3]>| {
            let x = of.iter().map(|x| Vector3::from(*x)).collect::<Vec<_>>();
            (x[1] - x[0]).dot(&(x[2] - x[0]).cross(&(x[4] - x[0])))
        };
        assert!((volume(&moved[1]) - 2.0).abs() < 1e-12, "{}", volume(&moved[1]));
        let sides = shares.outside(&moved, |_| true);
        assert_eq!(sides.len(), 4 * 4 + 2);
        let area: f64 = sides.iter().map(|face| 0.5 * normal(&face.corners).norm()).sum();
        assert!((area - (4.0 * 8.0 + 2.0)).abs() < 1e-12, "{area}");
        // Normals that point outwards add up to nothing, and their flux is three times the volume.
        let flux: f64 = sides
            .iter()
            .map(|face| {
                let middle: Vector3<f64> =
                    face.corners.iter().map(|x| Vector3::from(*x)).sum::<Vector3<f64>>() / 4.0;
                0.5 * normal(&face.corners).dot(&middle)
            })
            .sum();
        assert!((flux - 3.0 * 8.0).abs() < 1e-11, "{flux}");
        assert_eq!(shares.outside(&moved, |share| share < 2).len(), 10, "a slice has sides of its own");
    }

    #[test]
    fn a_body_that_has_come_apart_is_drawn_apart() {
        let shares = boxes(4);
        let positions = [0.5, 1.5, 5.5, 6.5].map(|x| [x, 0.5, 0.5]);
        let moved = shares.moved(&positions);
        let reach = |share: usize| moved[share].iter().map(|x| x[0]).fold(f64::NEG_INFINITY, f64::max);
        assert!(
            reach(1) < 3.5,
            "the second box ends where the body has parted, not at the third: {}",
            reach(1)
        );
        assert_eq!(shares.outside(&moved, |_| true).len(), 4 * 4 + 4, "both faces of the gap are seen");
    }
}

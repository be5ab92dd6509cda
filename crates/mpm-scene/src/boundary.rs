//! Boundaries of bodies at rest, as the sides of the pieces that points are made of.

use crate::pieces::Outer;
use mpm_assembly::BodySide;
use mpm_grid::{LinearCell, Vector};

/// Part of a facet's size within which two corners are one.
const SAME: f64 = 1e-9;

/// A direction, no longer than one, along no line of a mesh.
const SKEW: [f64; 3] = [0.779_2, 0.481_7, 0.397_1];

/// Facets of the boundary of a body, in the order of its pieces.
#[derive(Clone, Debug, Default)]
pub(crate) struct Boundary<const D: usize> {
    facets: Vec<PieceSide<D>>,
}

/// A side of a piece that is a side of the body.
#[derive(Clone, Copy, Debug)]
struct PieceSide<const D: usize> {
    /// Direction of the piece, and whether the side is at its high end.
    direction: usize,
    is_high: bool,
    /// Corners `[L]`: in the plane two, the body on the left on the way from the first to the second, in space four, round
    /// it anticlockwise as seen from outside.
    corners: [Vector<D>; 4],
}

impl<const D: usize> Boundary<D> {
    /// Adds the outer sides of a piece.
    pub(crate) fn add(&mut self, piece: &LinearCell<D>, outer: &Outer<D>) {
        for (direction, is_high) in (0..D).flat_map(|d| [(d, false), (d, true)]) {
            if !outer[direction][usize::from(is_high)] {
                continue;
            }
            let corner = |along: [usize; 2]| {
                let others = (0..D).filter(|&d| d != direction).zip(along);
                let low = usize::from(is_high) << direction;
                piece.corners()[others.fold(low, |corner, (d, bit)| corner | bit << d)]
            };
            let mut corners = match D {
                2 => [corner([0, 0]), corner([1, 0]), corner([0, 0]), corner([1, 0])],
                _ => [corner([0, 0]), corner([1, 0]), corner([1, 1]), corner([0, 1])],
            };
            // Outwards of a right-handed piece: along x, y and z in turn the other directions are (y, z), (x, z), (x, y).
            let hand = piece.determinant(&Vector::zeros()) < 0.0;
            let is_outward = match D {
                2 => (direction == 0) == is_high,
                _ => (direction == 1) != is_high,
            };
            if hand == is_outward {
                match D {
                    2 => corners.swap(0, 1),
                    _ => corners.swap(1, 3),
                }
            }
            self.facets.push(PieceSide { direction, is_high, corners });
        }
    }

    /// Adds those of pieces that come next.
    pub(crate) fn append(&mut self, next: Self) {
        self.facets.extend(next.facets);
    }

    /// The side at one end of a direction; none if no piece has one there.
    pub(crate) fn side(
        &self,
        (direction, is_high): (usize, bool),
        body: &str,
        name: &str,
    ) -> Option<BodySide<D>> {
        let of = self.facets.iter().filter(|it| (it.direction, it.is_high) == (direction, is_high));
        let corners: Vec<Vector<D>> = of.flat_map(|it| it.corners[..1 << (D - 1)].to_vec()).collect();
        if corners.is_empty() {
            return None;
        }
        let (markers, number) = joined(&corners, 1 << (D - 1));
        let facets = number.chunks_exact(1 << (D - 1)).flat_map(|corner| -> Vec<[u32; D]> {
            let of = |numbers: [usize; 3]| std::array::from_fn(|k| corner[numbers[k]]);
            match D {
                2 => vec![of([0, 1, 0])],
                _ => [[0, 1, 2], [0, 2, 3], [0, 1, 3], [1, 2, 3]].map(of).to_vec(),
            }
        });
        let layers = if D == 2 { 1 } else { 2 };
        let (body, name, facets) = (body.to_owned(), name.to_owned(), facets.collect());
        Some(BodySide { body, name, markers, facets, layers })
    }
}

/// The closed line, or the line, through points in the plane, with the body on its left.
pub(crate) fn chain<const D: usize>(
    points: &[[f64; 2]],
    is_closed: bool,
    (body, name): (&str, &str),
) -> BodySide<D> {
    let markers: Vec<Vector<D>> = points.iter().map(|x| Vector::from_fn(|d, _| x[d])).collect();
    let n = markers.len() as u32;
    let edges = if is_closed { n } else { n - 1 };
    let facets = (0..edges).map(|k| std::array::from_fn(|end| (k + end as u32) % n)).collect();
    BodySide { body: body.to_owned(), name: name.to_owned(), markers, facets, layers: 1 }
}

/// Places that are apart, and the number of each of `corners` among them, where `of_facet` of them in turn belong to a facet.
/// Corners of two facets that are the same place differ by rounding.
fn joined<const D: usize>(corners: &[Vector<D>], of_facet: usize) -> (Vec<Vector<D>>, Vec<u32>) {
    let pairs = corners.chunks_exact(of_facet).flat_map(|facet| facet.windows(2));
    let sizes = pairs.map(|pair| (pair[1] - pair[0]).norm()).filter(|it| *it > 0.0);
    let same = SAME * sizes.reduce(f64::min).unwrap_or(0.0);
    // Places within rounding of each other are neighbours along any direction; few others are along a skew one.
    let along: Vec<f64> = corners.iter().map(|x| (0..D).map(|d| x[d] * SKEW[d]).sum()).collect();
    let mut order: Vec<usize> = (0..corners.len()).collect();
    order.sort_by(|&a, &b| along[a].total_cmp(&along[b]).then(a.cmp(&b)));
    let mut first_of: Vec<usize> = (0..corners.len()).collect();
    for (at, &k) in order.iter().enumerate() {
        let near = order[..at].iter().rev().take_while(|&&other| along[k] - along[other] <= same);
        let equal = near.copied().filter(|&other| (corners[k] - corners[other]).norm() <= same);
        if let Some(other) = equal.map(|other| first_of[other]).min() {
            first_of[k] = other;
        }
    }
    let (mut markers, mut numbers): (Vec<Vector<D>>, Vec<u32>) = (Vec::new(), vec![u32::MAX; corners.len()]);
    for k in 0..corners.len() {
        let first = first_of[k];
        if numbers[first] == u32::MAX {
            numbers[first] = markers.len() as u32;
            markers.push(corners[first]);
        }
        numbers[k] = numbers[first];
    }
    (markers, numbers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pieces::box_piece;

    /// Boundary of a block of 2^D pieces.
    fn block<const D: usize>() -> Boundary<D> {
        let mut boundary = Boundary::default();
        for piece in 0..1 << D {
            let low = Vector::<D>::from_fn(|d, _| f64::from(piece >> d & 1));
            let outer = std::array::from_fn(|d| [piece >> d & 1 == 0, piece >> d & 1 == 1]);
            boundary.add(&box_piece(&low, &low.add_scalar(1.0)), &outer);
        }
        boundary
    }

    /// Sum of all sides' area vectors, and of the volume under them.
    fn sums<const D: usize>(boundary: &Boundary<D>) -> (Vector<D>, f64) {
        let (mut whole, mut volume) = (Vector::zeros(), 0.0);
        for (d, is_high) in (0..D).flat_map(|d| [(d, false), (d, true)]) {
            let side = boundary.side((d, is_high), "b", "s").unwrap();
            assert_eq!(side.markers.len(), 3_usize.pow(D as u32 - 1));
            for (marker, area) in side.markers.iter().zip(side.areas(&side.markers)) {
                whole += area;
                volume += area.dot(marker) / D as f64;
            }
        }
        (whole, volume)
    }

    #[test]
    fn sides_of_a_block_face_outwards_and_close() {
        let (whole, volume) = sums(&block::<2>());
        assert!(whole.norm() < 1e-14 && (volume - 4.0).abs() < 1e-14);
        let (whole, volume) = sums(&block::<3>());
        assert!(whole.norm() < 1e-14 && (volume - 8.0).abs() < 1e-14);
    }
}

//! A part of a body's boundary at rest, cut into straight facets.

use mpm_grid::{Block, Vector};
use std::collections::BTreeMap;

/// A part of a body's boundary at rest: markers and the facets between them, segments in the plane with the body on their
/// left, triangles in space whose corners run anticlockwise as seen from outside.
#[derive(Clone, Debug, PartialEq)]
pub struct BodySide<const D: usize> {
    /// Name of the body.
    pub body: String,
    /// Name of the part.
    pub name: String,
    /// Markers at rest `[L]`.
    pub markers: Vec<Vector<D>>,
    /// Markers at the corners of every facet.
    pub facets: Vec<[u32; D]>,
    /// How often facets cover the part: quadrilaterals are covered by triangles along both their diagonals, so that their
    /// corners are alike.
    pub layers: u32,
}

impl<const D: usize> BodySide<D> {
    /// Length or area that belongs to every marker `[L^(D-1)]`.
    pub fn measures(&self) -> Vec<f64> {
        let mut measures = vec![0.0; self.markers.len()];
        for facet in &self.facets {
            let part = area(facet, &self.markers).norm() / (D as f64 * f64::from(self.layers));
            facet.iter().for_each(|&marker| measures[marker as usize] += part);
        }
        measures
    }

    /// Area vectors of the facets, outward normal times length or area, in equal parts at their markers, where these stand at
    /// `positions` `[L]`; one for each marker `[L^(D-1)]`.
    pub fn areas(&self, positions: &[Vector<D>]) -> Vec<Vector<D>> {
        self.areas_of(&self.facets, positions)
    }

    /// The same of some of the facets.
    pub(super) fn areas_of(&self, facets: &[[u32; D]], positions: &[Vector<D>]) -> Vec<Vector<D>> {
        let mut areas = vec![Vector::zeros(); positions.len()];
        for facet in facets {
            let part = area(facet, positions) / (D as f64 * f64::from(self.layers));
            facet.iter().for_each(|&marker| areas[marker as usize] += part);
        }
        areas
    }

    /// The edge of the part, where no facet goes on: in the plane the markers at which a chain ends, in space pairs of markers.
    /// None where the part is closed.
    pub fn edges(&self) -> Vec<Vec<usize>> {
        let mut met: BTreeMap<Vec<u32>, i32> = BTreeMap::new();
        for (facet, k) in self.facets.iter().flat_map(|facet| (0..D).map(move |k| (facet, k))) {
            let mut side: Vec<u32> = (1..D).map(|i| facet[(k + i) % D]).collect();
            let is_forward = if D == 2 { k == 0 } else { side[0] < side[D - 2] };
            side.sort_unstable();
            // Facets beside each other run along their common side in opposite directions.
            *met.entry(side).or_default() += if is_forward { 1 } else { -1 };
        }
        let open = met.into_iter().filter(|(_, count)| *count != 0);
        open.map(|(side, _)| side.into_iter().map(|marker| marker as usize).collect()).collect()
    }
}

/// The outward normal of a facet times its length or area `[L^(D-1)]`.
pub(super) fn area<const D: usize>(facet: &[u32; D], positions: &[Vector<D>]) -> Vector<D> {
    let at = |k: usize| positions[facet[k] as usize];
    let along = at(1) - at(0);
    match D {
        2 => Vector::from_fn(|d, _| if d == 0 { along[1] } else { -along[0] }),
        _ => cross_matrix(&along) * (at(D - 1) - at(0)) * 0.5,
    }
}

/// The derivative of a facet's [`area`] by the position of its `k`-th corner `[L^(D-2)]`.
pub(super) fn area_by_corner<const D: usize>(facet: &[u32; D], k: usize, positions: &[Vector<D>]) -> Block<D> {
    let at = |k: usize| positions[facet[k % D] as usize];
    match D {
        2 => {
            let sign = if k == 1 { 1.0 } else { -1.0 };
            Block::from_fn(|i, j| sign * (j as f64 - i as f64))
        }
        // ½ (a × b + b × c + c × a) by a: ½ δ × (b − c).
        _ => cross_matrix(&(at(k + 2) - at(k + 1))) * 0.5,
    }
}

/// `[v]×` in space, nothing in the plane.
fn cross_matrix<const D: usize>(v: &Vector<D>) -> Block<D> {
    Block::from_fn(|i, j| match (j + 3 - i) % 3 {
        1 if D == 3 => -v[3 - i - j],
        2 if D == 3 => v[3 - i - j],
        _ => 0.0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_and_their_derivatives() {
        let plane = [Vector::<2>::new(1.0, 2.0), Vector::<2>::new(3.0, 3.0)];
        assert_eq!(area(&[0, 1], &plane), Vector::<2>::new(1.0, -2.0));
        let space =
            [Vector::<3>::new(0.0, 0.0, 1.0), Vector::<3>::new(2.0, 0.1, 1.2), Vector::<3>::new(0.3, 3.0, 0.8)];
        let whole = area(&[0, 1, 2], &space);
        assert!((whole - (space[1] - space[0]).cross(&(space[2] - space[0])) * 0.5).norm() < 1e-15);
        assert_eq!(differences(&[0, 1], &plane), 0.0);
        assert!(differences(&[0, 1, 2], &space) < 1e-13);
    }

    /// The area is linear in the position of each corner.
    fn differences<const D: usize>(facet: &[u32; D], positions: &[Vector<D>]) -> f64 {
        let mut worst: f64 = 0.0;
        for (k, d) in (0..D).flat_map(|k| (0..D).map(move |d| (k, d))) {
            let mut moved = positions.to_vec();
            moved[facet[k] as usize][d] += 1.0;
            let change = area(facet, &moved) - area(facet, positions);
            let column = area_by_corner(facet, k, positions).column(d).into_owned();
            worst = worst.max((change - column).norm());
        }
        worst
    }

    #[test]
    fn markers_share_the_length_of_a_chain() {
        let markers = [0.0, 1.0, 3.0].map(|x| Vector::<2>::new(x, 0.0)).to_vec();
        let (body, name) = ("b".to_owned(), "s".to_owned());
        let side = BodySide { body, name, markers, facets: vec![[0, 1], [1, 2]], layers: 1 };
        assert_eq!((side.measures(), side.edges()), (vec![0.5, 1.5, 1.0], vec![vec![0], vec![2]]));
    }

    #[test]
    fn edges_of_open_and_closed_parts() {
        let marker = |k: u32| Vector::<3>::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2));
        let quad = |q: [u32; 4]| [[0, 1, 2], [0, 2, 3], [0, 1, 3], [1, 2, 3]].map(|it| it.map(|k| q[k]));
        let cube = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let part = |quads: &[[u32; 4]]| {
            let facets = quads.iter().flat_map(|q| quad(*q)).collect();
            let (body, name) = ("b".to_owned(), "s".to_owned());
            BodySide { body, name, markers: (0..8).map(marker).collect(), facets, layers: 2 }
        };
        assert!(part(&cube).edges().is_empty());
        // Without the top and the bottom.
        let open: Vec<[usize; 2]> = vec![[0, 1], [0, 2], [1, 3], [2, 3], [4, 5], [4, 6], [5, 7], [6, 7]];
        assert_eq!(part(&cube[2..]).edges(), open);
        assert_eq!(part(&cube[..1]).edges(), open[..4]);
    }
}

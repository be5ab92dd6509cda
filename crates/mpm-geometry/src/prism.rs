//! Polygons with holes, drawn out along an axis.

use crate::triangles::Triangles;
use robust::{Coord, orient2d};

/// A polygon with holes, drawn out along an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Prism {
    axis: usize,
    /// Corners of the outline, then of the holes, by the coordinates across the axis in their order; the body lies on the
    /// left of every edge `[L]`.
    rings: Vec<Vec<[f64; 2]>>,
    ends: (f64, f64),
}

/// Why corners are no polygon. Corners are counted from 1, in their own order.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PrismError {
    /// Fewer than three corners.
    #[error("{} has {corners} corners, expected at least 3", ring(*hole))]
    Corners {
        /// Number of the hole, from 1; 0 is the outline.
        hole: usize,
        /// Its corners.
        corners: usize,
    },
    /// Edges cross or touch.
    #[error(
        "edge {} of {} and edge {} of {} cross or touch, near ({}, {})",
        edges[0].1, ring(edges[0].0), edges[1].1, ring(edges[1].0), near[0], near[1]
    )]
    Crossing {
        /// Numbers of their ring (0 is the outline) and of the edge in it, from 1.
        edges: [(usize, usize); 2],
        /// A corner of the first one `[L]`.
        near: [f64; 2],
    },
    /// A hole that is not in the polygon, or in another hole.
    #[error("hole {0} does not lie in the polygon, beside the other holes")]
    Outside(usize),
    /// Ends that do not ascend.
    #[error("expected ends that ascend, got {0} and {1}")]
    Ends(f64, f64),
    /// The polygon could not be cut into triangles.
    #[error("the polygon cannot be cut into triangles: parts of it are too thin")]
    Thin,
}

fn ring(number: usize) -> String {
    if number == 0 { "the outline".into() } else { format!("hole {number}") }
}

impl Prism {
    /// A polygon by its corners in order, either way round, with holes; along `axis` between two ends `[L]`.
    ///
    /// # Errors
    /// Why the corners are no polygon with holes, or the ends enclose nothing.
    pub fn new(
        outline: &[[f64; 2]],
        holes: &[Vec<[f64; 2]>],
        axis: usize,
        ends: (f64, f64),
    ) -> Result<Self, PrismError> {
        if ends.0 >= ends.1 {
            return Err(PrismError::Ends(ends.0, ends.1));
        }
        let mut rings: Vec<Vec<[f64; 2]>> = vec![outline.to_vec()];
        rings.extend(holes.iter().cloned());
        if let Some(hole) = rings.iter().position(|ring| ring.len() < 3) {
            return Err(PrismError::Corners { hole, corners: rings[hole].len() });
        }
        check_edges(&rings)?;
        for k in 1..rings.len() {
            let corner = rings[k][0];
            let in_others =
                (1..rings.len()).filter(|&other| other != k).any(|other| holds(&rings[other], corner));
            if !holds(&rings[0], corner) || in_others {
                return Err(PrismError::Outside(k));
            }
        }
        for (k, ring) in rings.iter_mut().enumerate() {
            if (area(ring) > 0.0) != (k == 0) {
                ring.reverse();
            }
        }
        let prism = Self { axis, rings, ends };
        let covered: f64 = prism.triangulated().iter().map(|corners| area(corners)).sum();
        let wanted = prism.area();
        if (covered - wanted).abs() > 1e-9 * area(&prism.rings[0]) {
            return Err(PrismError::Thin);
        }
        Ok(prism)
    }

    /// Area of the polygon without its holes `[L²]`.
    pub fn area(&self) -> f64 {
        self.rings.iter().map(|ring| area(ring)).sum()
    }

    /// What it encloses `[L³]`.
    pub fn volume(&self) -> f64 {
        self.area() * (self.ends.1 - self.ends.0)
    }

    /// Lowest and highest coordinate in one direction `[L]`.
    pub fn ends(&self, d: usize) -> (f64, f64) {
        if d == self.axis {
            return self.ends;
        }
        let c = usize::from(self.across()[1] == d);
        self.rings[0].iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x[c]), b.max(x[c])))
    }

    /// The two directions across the axis.
    fn across(&self) -> [usize; 2] {
        match self.axis {
            0 => [1, 2],
            1 => [0, 2],
            _ => [0, 1],
        }
    }

    /// The polygon in triangles that run against the clock.
    fn triangulated(&self) -> Vec<[[f64; 2]; 3]> {
        let mut holes = Vec::with_capacity(self.rings.len());
        let mut corners = 0;
        for ring in &self.rings {
            corners += ring.len();
            holes.push(corners);
        }
        holes.pop();
        let all: Vec<[f64; 2]> = self.rings.iter().flatten().copied().collect();
        let mut numbers: Vec<usize> = Vec::new();
        earcut::Earcut::new().earcut(all.iter().copied(), &holes, &mut numbers);
        let triangles = numbers.chunks_exact(3).map(|it| [all[it[0]], all[it[1]], all[it[2]]]);
        triangles.map(|[a, b, c]| if area(&[a, b, c]) < 0.0 { [a, c, b] } else { [a, b, c] }).collect()
    }

    /// Its walls and both ends. Triangles of the ends may meet in the middle of an edge, which matters to nothing that
    /// adds up over facets.
    pub(crate) fn surface(&self) -> Triangles {
        let [d, e] = self.across();
        let place = |[x, y]: [f64; 2], end: f64| {
            let mut at = [0.0; 3];
            (at[d], at[e], at[self.axis]) = (x, y, end);
            at
        };
        let (low, high) = self.ends;
        let mut facets: Vec<[[f64; 3]; 3]> = Vec::new();
        for ring in &self.rings {
            for (&a, &b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                let [p, q, r, s] = [place(a, low), place(b, low), place(b, high), place(a, high)];
                facets.extend([[p, q, r], [p, r, s]]);
            }
        }
        for [a, b, c] in self.triangulated() {
            facets.push([place(a, high), place(b, high), place(c, high)]);
            facets.push([place(a, low), place(c, low), place(b, low)]);
        }
        if self.axis == 1 {
            // x, z, y is a left-handed order.
            facets.iter_mut().for_each(|facet| facet.swap(1, 2));
        }
        Triangles::weld(&facets)
    }

    /// Whether it and another one along the same axis share more than what rounding can make them share.
    pub fn overlaps(&self, other: &Self) -> bool {
        let (from, to) = (self.ends.0.max(other.ends.0), self.ends.1.min(other.ends.1));
        let long = (self.ends.1 - self.ends.0).min(other.ends.1 - other.ends.0);
        if self.axis != other.axis || to - from <= 1e-9 * long {
            return false;
        }
        let (own, others) = (self.triangulated(), other.triangulated());
        let common: f64 = own.iter().flat_map(|a| others.iter().map(move |b| area_of_common(a, b))).sum();
        common > 1e-9 * self.area().min(other.area())
    }

    /// How much of it lies in a box `[L³]`.
    pub fn volume_in(&self, from: &[f64; 3], to: &[f64; 3]) -> f64 {
        crate::moments::volume_in(&self.surface(), from, to)
    }
}

/// Area of a polygon, positive against the clock `[L²]`.
fn area(ring: &[[f64; 2]]) -> f64 {
    // From a corner rather than the origin, which may be far away.
    let from = ring[0];
    let pairs = ring.iter().zip(ring.iter().skip(1));
    let cross = |(a, b): (&[f64; 2], &[f64; 2])| {
        (a[0] - from[0]) * (b[1] - from[1]) - (a[1] - from[1]) * (b[0] - from[0])
    };
    0.5 * pairs.map(cross).sum::<f64>()
}

/// Area that two triangles share, both against the clock (Sutherland & Hodgman 1974) `[L²]`.
fn area_of_common(one: &[[f64; 2]; 3], other: &[[f64; 2]; 3]) -> f64 {
    let mut left = one.to_vec();
    for k in 0..3 {
        let (a, b) = (other[k], other[(k + 1) % 3]);
        let inside = |x: &[f64; 2]| (b[0] - a[0]) * (x[1] - a[1]) - (b[1] - a[1]) * (x[0] - a[0]);
        let mut kept = Vec::with_capacity(left.len() + 1);
        for (p, q) in left.iter().zip(left.iter().cycle().skip(1)) {
            let (of_p, of_q) = (inside(p), inside(q));
            if of_p >= 0.0 {
                kept.push(*p);
            }
            if (of_p < 0.0) != (of_q < 0.0) {
                let part = of_p / (of_p - of_q);
                kept.push([p[0] + part * (q[0] - p[0]), p[1] + part * (q[1] - p[1])]);
            }
        }
        left = kept;
        if left.is_empty() {
            return 0.0;
        }
    }
    area(&left)
}

/// On which side of an edge a point lies; the sign is exact.
fn side(a: [f64; 2], b: [f64; 2], x: [f64; 2]) -> f64 {
    let [a, b, x] = [a, b, x].map(|[x, y]| Coord { x, y });
    orient2d(a, b, x)
}

/// Whether a point lies in a ring, by the edges that a ray from it crosses.
fn holds(ring: &[[f64; 2]], x: [f64; 2]) -> bool {
    let edges = ring.iter().zip(ring.iter().cycle().skip(1));
    let crossed = edges.filter(|(a, b)| {
        let (low, high) = if a[1] <= b[1] { (a, b) } else { (b, a) };
        low[1] <= x[1] && x[1] < high[1] && side(**low, **high, x) > 0.0
    });
    crossed.count() % 2 == 1
}

/// Refuses edges that have more in common than the corner of neighbours.
fn check_edges(rings: &[Vec<[f64; 2]>]) -> Result<(), PrismError> {
    let mut edges = Vec::new();
    for (r, ring) in rings.iter().enumerate() {
        for (k, (&a, &b)) in ring.iter().zip(ring.iter().cycle().skip(1)).enumerate() {
            edges.push((a, b, (r, k + 1), ring.len()));
        }
    }
    // From left to right, so that only edges above each other are compared.
    edges.sort_by(|a, b| a.0[0].min(a.1[0]).total_cmp(&b.0[0].min(b.1[0])).then(a.2.cmp(&b.2)));
    for (k, &(a, b, first, n)) in edges.iter().enumerate() {
        let last = a[0].max(b[0]);
        for &(c, d, second, _) in edges[k + 1..].iter().take_while(|it| it.0[0].min(it.1[0]) <= last) {
            let is_next =
                |one: (usize, usize), other: (usize, usize)| one.0 == other.0 && one.1 % n + 1 == other.1;
            let meet = if is_next(first, second) {
                folds_back(a, b, d)
            } else if is_next(second, first) {
                folds_back(c, d, b)
            } else {
                touch((a, b), (c, d))
            };
            if meet || a == b {
                return Err(PrismError::Crossing { edges: [first, second], near: a });
            }
        }
    }
    Ok(())
}

/// Whether the edge from `b` to `c` lies on that from `a` to `b`.
fn folds_back(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> bool {
    let ahead = (a[0] - b[0]) * (c[0] - b[0]) + (a[1] - b[1]) * (c[1] - b[1]);
    b == c || (side(a, b, c) == 0.0 && ahead > 0.0)
}

/// Whether two edges have a point in common.
fn touch((a, b): ([f64; 2], [f64; 2]), (c, d): ([f64; 2], [f64; 2])) -> bool {
    let apart = |k: usize| a[k].max(b[k]) < c[k].min(d[k]) || c[k].max(d[k]) < a[k].min(b[k]);
    let parted = |p: f64, q: f64| (p > 0.0 && q > 0.0) || (p < 0.0 && q < 0.0);
    !(apart(0) || apart(1) || parted(side(a, b, c), side(a, b, d)) || parted(side(c, d, a), side(c, d, b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MemoryLimit, Solid, parts};
    use mpm_grid::Axis;

    const MEMORY: MemoryLimit = MemoryLimit { bytes: 1 << 32 };

    /// An L with a square hole.
    fn angle() -> (Vec<[f64; 2]>, Vec<Vec<[f64; 2]>>) {
        let outline = vec![[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
        (outline, vec![vec![[0.25, 0.25], [0.25, 0.75], [0.75, 0.75], [0.75, 0.25]]])
    }

    #[test]
    fn volumes_are_those_of_polygons_along_every_axis() {
        let (outline, holes) = angle();
        for axis in 0..3 {
            for reversed in [false, true] {
                let mut outline = outline.clone();
                if reversed {
                    outline.reverse();
                }
                let prism = Prism::new(&outline, &holes, axis, (1.0, 3.0)).unwrap();
                assert!((prism.volume() - 2.0 * 4.75).abs() < 1e-14);
                assert!((prism.surface().volume() - 2.0 * 4.75).abs() < 1e-13, "axis {axis}");
                assert_eq!(prism.ends(axis), (1.0, 3.0));
                assert!((prism.volume_in(&[0.0; 3], &[9.0; 3]) - 9.5).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_slope_is_cut_exactly_along_the_cells() {
        // A triangle across cells that its edge cuts at every angle.
        let outline = [[0.1, 0.0], [3.7, 0.0], [0.1, 2.9]];
        let prism = Prism::new(&outline, &[], 2, (0.0, 1.0)).unwrap();
        let axis = Axis::uniform(0.0, 4.0, 7).unwrap();
        let made =
            parts::<2>(&Solid::Prism(&prism), [false; 2], &[axis.clone(), axis], 2, &[], MEMORY).unwrap();
        let volume: f64 = made.parts.iter().map(|part| part.volume).sum();
        let expected = 0.5 * 3.6 * 2.9;
        assert!((volume - expected).abs() < 1e-12, "{volume}");
        // The first moment, too: its centre is a third of the way from the right angle.
        let moment: f64 = made.parts.iter().map(|part| part.volume * (part.centre[0] - 0.1)).sum();
        assert!((moment - expected * 1.2).abs() < 1e-12, "{moment}");
    }

    #[test]
    fn polygons_that_share_an_edge_do_not_overlap() {
        let prism = |outline: &[[f64; 2]], ends| Prism::new(outline, &[], 2, ends).unwrap();
        let [lower, upper, shifted] = [
            [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0]],
            [[0.0, 0.0], [2.0, 2.0], [0.0, 2.0]],
            [[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]],
        ];
        let unit = (0.0, 1.0);
        assert!(!prism(&lower, unit).overlaps(&prism(&upper, unit)));
        assert!(prism(&lower, unit).overlaps(&prism(&shifted, unit)));
        assert!(prism(&lower, unit).overlaps(&prism(&lower, unit)), "itself");
        assert!(!prism(&lower, unit).overlaps(&prism(&lower, (1.0, 2.0))), "one on the other");
        // In the hole of another one.
        let (outline, holes) = angle();
        let frame = Prism::new(&outline, &holes, 2, unit).unwrap();
        assert!(!frame.overlaps(&prism(&holes[0], unit)));
        assert!(frame.overlaps(&prism(&[[0.2, 0.2], [0.75, 0.25], [0.75, 0.75]], unit)));
    }

    #[test]
    fn corners_that_are_no_polygon_are_refused() {
        let error = |outline: &[[f64; 2]], holes: &[Vec<[f64; 2]>]| {
            Prism::new(outline, holes, 2, (0.0, 1.0)).unwrap_err().to_string()
        };
        let square = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        let small = |x: f64| vec![[x, 0.5], [x + 0.5, 0.5], [x + 0.5, 1.0], [x, 1.0]];
        assert!(Prism::new(&square, &[small(0.5), small(1.25)], 2, (0.0, 1.0)).is_ok());
        assert!(error(&square[..2], &[]).contains("the outline has 2 corners, expected at least 3"));
        let bow = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]];
        assert!(error(&bow, &[]).contains("edge 1 of the outline and edge 3 of the outline cross or touch"));
        let twice = [[0.0, 0.0], [2.0, 0.0], [2.0, 0.0], [0.0, 2.0]];
        assert!(error(&twice, &[]).contains("cross or touch"));
        let spike = [[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [0.0, 2.0]];
        assert!(error(&spike, &[]).contains("cross or touch"));
        assert_eq!(error(&square, &[small(3.0)]), "hole 1 does not lie in the polygon, beside the other holes");
        assert!(error(&square, &[small(1.75)]).contains("cross or touch"));
        let inner = vec![[0.6, 0.6], [0.8, 0.6], [0.8, 0.8]];
        assert!(error(&square, &[small(0.5), inner]).contains("hole 2 does not lie"));
        assert!(Prism::new(&square, &[], 2, (1.0, 1.0)).is_err());
    }
}

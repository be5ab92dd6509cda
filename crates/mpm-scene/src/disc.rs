//! Discs, and in space cylinders along z, cut into pieces along themselves.

use mpm_grid::{LinearCell, Vector};
use std::f64::consts::{FRAC_PI_4, PI};
use std::ops::Range;

/// Half the edge of the square amid a disc over its radius.
pub(crate) const SQUARE: f64 = 0.5;

/// A disc in tiles: a square amid it, and a fan from each edge of that to the circle.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Disc {
    pub centre: [f64; 2],
    /// `[L]`.
    pub radius: f64,
    /// Tiles along an edge of the square, from there to the circle, and along z.
    pub tiles: [u32; 3],
    /// First and last coordinate along z; in the plane of thickness 1 `[L]`.
    pub ends: (f64, f64),
}

impl Disc {
    /// Volume of the round shape, in the plane per thickness `[L^D]`.
    pub(crate) fn volume(&self) -> f64 {
        PI * self.radius * self.radius * (self.ends.1 - self.ends.0)
    }

    /// Pieces of tiles that are cut into so many along each direction.
    pub(crate) fn count<const D: usize>(&self, per_tile: u32) -> f64 {
        let [n, m, layers] = self.lines::<D>(per_tile).map(f64::from);
        (n * n + 4.0 * n * m) * layers
    }

    /// Layers of pieces.
    pub(crate) fn layers<const D: usize>(&self, per_tile: u32) -> usize {
        self.lines::<D>(per_tile)[2] as usize
    }

    /// Calls `each` with the pieces of some layers and which of their sides, low and high in every direction, are outer ones: of a piece of a fan the second direction goes outwards.
    pub(crate) fn for_each_piece<const D: usize>(
        &self,
        per_tile: u32,
        within: Range<usize>,
        mut each: impl FnMut(&LinearCell<D>, &[[bool; 2]; D]),
    ) {
        let [n, m, layers] = self.lines::<D>(per_tile);
        for layer in within.start as u32..within.end as u32 {
            let mut piece = |at: &dyn Fn(u32, u32) -> [f64; 2], [i, j]: [u32; 2], is_outer: bool| {
                let corner = |c: usize| {
                    let [x, y] = at(i + (c & 1) as u32, j + (c >> 1 & 1) as u32);
                    let z = self.height(layer + (c >> 2) as u32, layers);
                    Vector::from_fn(|d, _| [self.centre[0] + x, self.centre[1] + y, z][d])
                };
                let ends = [layer == 0, layer + 1 == layers];
                let outer = std::array::from_fn(|d| [[false; 2], [false, is_outer], ends][d]);
                each(&LinearCell::new(std::array::from_fn(|c| corner(c % (1 << D)))), &outer);
            };
            for (j, i) in pairs(0..n, 0..n) {
                piece(&|i, j| self.in_square(i, j, n), [i, j], false);
            }
            for quarter in 0..4 {
                for (j, i) in pairs(0..m, 0..n) {
                    piece(&|i, j| self.in_fan(quarter, (i, n), (j, m)), [i, j], j + 1 == m);
                }
            }
        }
    }

    fn lines<const D: usize>(&self, per_tile: u32) -> [u32; 3] {
        let [n, m, layers] = self.tiles.map(|tiles| tiles.saturating_mul(per_tile));
        [n, m, if D == 3 { layers } else { 1 }]
    }

    fn height(&self, line: u32, lines: u32) -> f64 {
        let (from, to) = self.ends;
        from + (to - from) * (f64::from(line) / f64::from(lines))
    }

    /// From the centre to a corner of the pieces of the square `[L]`.
    fn in_square(&self, i: u32, j: u32, n: u32) -> [f64; 2] {
        [i, j].map(|k| SQUARE * self.radius * (2.0 * f64::from(k) / f64::from(n) - 1.0))
    }

    /// From the centre to a corner of the pieces of a fan, clockwise along it and outwards `[L]`.
    fn in_fan(&self, quarter: u32, (i, n): (u32, u32), (j, m): (u32, u32)) -> [f64; 2] {
        let along = 1.0 - 2.0 * f64::from(i) / f64::from(n);
        let inner = [SQUARE, SQUARE * along];
        let (sine, cosine) = (FRAC_PI_4 * along).sin_cos();
        let part = f64::from(j) / f64::from(m);
        let at = |inner: f64, outer: f64| self.radius * (inner * (1.0 - part) + outer * part);
        let [x, y] = [at(inner[0], cosine), at(inner[1], sine)];
        (0..quarter).fold([x, y], |[x, y], _| [-y, x])
    }
}

/// All pairs, the second index fastest.
fn pairs(first: Range<u32>, second: Range<u32>) -> impl Iterator<Item = (u32, u32)> {
    first.flat_map(move |a| second.clone().map(move |b| (a, b)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pieces overlap nowhere and leave no gap: each is right-handed, and all have the area of the polygon on the circle.
    #[test]
    fn pieces_fill_the_polygon_on_the_circle() {
        let disc = Disc { centre: [3.0, -1.0], radius: 2.0, tiles: [4, 2, 3], ends: (0.0, 3.0) };
        let sides = f64::from(4 * 4 * 2);
        let polygon = 0.5 * sides * (2.0 * PI / sides).sin() * 4.0;
        let (mut area, mut outer, mut count) = (0.0, 0, 0.0);
        disc.for_each_piece::<2>(2, 0..1, |piece, sides| {
            assert!(piece.determinant(&Vector::zeros()) > 0.0);
            area += piece.volume();
            outer += usize::from(sides[1][1]);
            count += 1.0;
        });
        assert!((area / polygon - 1.0).abs() < 1e-14 && outer == 32 && count == disc.count::<2>(2));
        let mut volume = 0.0;
        disc.for_each_piece::<3>(2, 0..disc.layers::<3>(2), |piece, _| volume += piece.volume());
        assert!((volume / (3.0 * polygon) - 1.0).abs() < 1e-14);
    }
}

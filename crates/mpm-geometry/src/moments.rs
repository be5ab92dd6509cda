//! Moments of what a surface encloses in each piece of a grid, by the divergence theorem.
//!
//! With the outward normal n, `∫_Ω f dV = -∮ n_x (∫_x^∞ f dx') dA`: each facet, cut along the planes of the
//! grid, takes away (or gives) all that lies behind it in the direction of x. The part in its own piece is
//! the integral of a cubic over a flat polygon; pieces behind it see the polygon's shadow alone, which is
//! summed along the row. Neither a point nor a line is ever asked whether it is inside, so that no tie
//! can go wrong: the result depends continuously on the surface, and is exact up to rounding.

use crate::triangles::Triangles;
use nalgebra::Vector3;

type Point = Vector3<f64>;

/// `∫ dV`, `∫ x dV` and `∫ x_d² dV` over what a piece holds, about the middle of the piece.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Moments {
    /// `[L³]`.
    pub volume: f64,
    /// `[L⁴]`.
    pub first: Vector3<f64>,
    /// `[L⁵]`.
    pub second: Vector3<f64>,
}

/// `∫ (1, y, z, y², z²) dA` of shadows, about the middle of the row.
type Shadow = [f64; 5];

/// A convex polygon: a triangle cut by at most two planes per direction.
#[derive(Clone, Copy)]
struct Polygon {
    corner: [Point; 10],
    len: usize,
}

impl Polygon {
    fn of(triangle: [Point; 3]) -> Self {
        let mut corner = [Point::zeros(); 10];
        corner[..3].copy_from_slice(&triangle);
        Self { corner, len: 3 }
    }

    fn corners(&self) -> &[Point] {
        &self.corner[..self.len]
    }

    fn range(&self, d: usize) -> (f64, f64) {
        let xs = self.corners().iter().map(|x| x[d]);
        xs.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
    }

    fn push(&mut self, x: Point) {
        self.corner[self.len] = x;
        self.len += 1;
    }

    /// The parts below and above a plane; what lies in the plane is above.
    fn cut(&self, d: usize, at: f64) -> (Option<Self>, Option<Self>) {
        let (low, high) = self.range(d);
        if low >= at {
            return (None, Some(*self));
        }
        if high <= at {
            return (Some(*self), None);
        }
        let mut parts = [Self { len: 0, ..*self }; 2];
        for (k, x) in self.corners().iter().enumerate() {
            let next = &self.corners()[(k + 1) % self.len];
            if x[d] <= at {
                parts[0].push(*x);
            }
            if x[d] >= at {
                parts[1].push(*x);
            }
            if (x[d] < at) != (next[d] < at) && x[d] != at && next[d] != at {
                // From the lower end, so that neighbours cut their common edge alike.
                let (a, b) = if x[d] < next[d] { (x, next) } else { (next, x) };
                let mut middle = a + (b - a) * ((at - a[d]) / (b[d] - a[d]));
                middle[d] = at;
                parts[0].push(middle);
                parts[1].push(middle);
            }
        }
        (Some(parts[0]), Some(parts[1]))
    }
}

/// Cuts a polygon along lines `lines[1..]` but the last, and hands each part on with the number of its piece.
fn slice(polygon: Polygon, d: usize, lines: &[f64], each: &mut dyn FnMut(usize, &Polygon)) {
    let last = lines.len() - 2;
    let (low, high) = polygon.range(d);
    let mut k = lines.partition_point(|&line| line <= low).saturating_sub(1).min(last);
    let mut rest = Some(polygon);
    while let Some(polygon) = rest {
        if k == last || high <= lines[k + 1] {
            each(k, &polygon);
            return;
        }
        let (below, above) = polygon.cut(d, lines[k + 1]);
        if let Some(below) = below {
            each(k, &below);
        }
        (rest, k) = (above, k + 1);
    }
}

/// What a piece of the layer that is cut takes `[bytes]`.
pub(crate) const BYTES_IN_LAYER: usize = size_of::<Moments>() + size_of::<Shadow>();

/// Calls `each` for every piece `[x, y, z]` in which the surface encloses anything at all (or seems to, by
/// rounding), z slowest and x fastest. The lines of the pieces ascend and span the surface.
pub(crate) fn for_each(surface: &Triangles, lines: &[Vec<f64>; 3], mut each: impl FnMut([usize; 3], &Moments)) {
    let [nx, ny, nz] = [0, 1, 2].map(|d| lines[d].len() - 1);
    let lowest = |k: usize| surface.corners(k).iter().map(|x| x.z).fold(f64::INFINITY, f64::min);
    let mut order: Vec<usize> = (0..surface.n_facets()).collect();
    order.sort_by(|&a, &b| lowest(a).total_cmp(&lowest(b)).then(a.cmp(&b)));
    let mut coming = order.into_iter().peekable();
    let mut active: Vec<Polygon> = Vec::new();
    let mut rest: Vec<Polygon> = Vec::new();
    let mut own = vec![Moments::default(); nx * ny];
    let mut behind = vec![[0.0; 5]; nx * ny];
    let middle = |d: usize, k: usize| 0.5 * (lines[d][k] + lines[d][k + 1]);

    for k in 0..nz {
        while let Some(facet) = coming.next_if(|&facet| k + 1 == nz || lowest(facet) < lines[2][k + 1]) {
            active.push(Polygon::of(surface.corners(facet)));
        }
        if active.is_empty() {
            continue;
        }
        own.fill(Moments::default());
        behind.fill([0.0; 5]);
        for polygon in active.drain(..) {
            let (here, above) =
                if k + 1 == nz { (Some(polygon), None) } else { polygon.cut(2, lines[2][k + 1]) };
            rest.extend(above);
            let Some(here) = here else { continue };
            slice(here, 1, &lines[1], &mut |j, row| {
                slice(*row, 0, &lines[0], &mut |i, part| {
                    let centre = Point::new(middle(0, i), middle(1, j), middle(2, k));
                    let half = 0.5 * (lines[0][i + 1] - lines[0][i]);
                    let at = j * nx + i;
                    take(part, &centre, half, &mut own[at], &mut behind[at]);
                });
            });
        }
        std::mem::swap(&mut active, &mut rest);
        for j in 0..ny {
            let mut shadow = [0.0; 5];
            for i in 0..nx {
                let at = j * nx + i;
                let moments = add_shadow(&own[at], &shadow, 0.5 * (lines[0][i + 1] - lines[0][i]));
                if moments.volume != 0.0 {
                    each([i, j, k], &moments);
                }
                shadow.iter_mut().zip(&behind[at]).for_each(|(sum, part)| *sum += part);
            }
        }
    }
}

/// What a part of a facet takes from its own piece, and its shadow on those behind.
fn take(part: &Polygon, centre: &Point, half: f64, own: &mut Moments, behind: &mut Shadow) {
    let first = part.corner[0] - centre;
    for pair in part.corners()[1..].windows(2) {
        let triangle = [first, pair[0] - centre, pair[1] - centre];
        let (a, b) = (triangle[1] - first, triangle[2] - first);
        // n_x dA.
        let area = 0.5 * (a.y * b.z - b.y * a.z);
        if area == 0.0 {
            continue;
        }
        for (weight, x) in cubic_rule(&triangle) {
            let w = -area * weight;
            let depth = half - x.x;
            own.volume += w * depth;
            own.first += Vector3::new(0.5 * (half * half - x.x * x.x), x.y * depth, x.z * depth) * w;
            let cubed = (half * half * half - x.x * x.x * x.x) / 3.0;
            own.second += Vector3::new(cubed, x.y * x.y * depth, x.z * x.z * depth) * w;
            let shadow = [1.0, x.y, x.z, x.y * x.y, x.z * x.z];
            behind.iter_mut().zip(shadow).for_each(|(sum, part)| *sum += w * part);
        }
    }
}

/// Points and weights that integrate cubics over a triangle exactly (Zienkiewicz & Taylor).
fn cubic_rule([a, b, c]: &[Point; 3]) -> [(f64, Point); 7] {
    let (corner, side, middle) = (0.05, 2.0 / 15.0, 0.45);
    [
        (corner, *a),
        (corner, *b),
        (corner, *c),
        (side, (a + b) * 0.5),
        (side, (b + c) * 0.5),
        (side, (c + a) * 0.5),
        (middle, (a + b + c) / 3.0),
    ]
}

/// The moments of a piece, of half length `half`, in the shadow of what lies before it.
fn add_shadow(own: &Moments, [area, y, z, yy, zz]: &Shadow, half: f64) -> Moments {
    let length = 2.0 * half;
    Moments {
        volume: own.volume + area * length,
        first: own.first + Vector3::new(0.0, y * length, z * length),
        second: own.second + Vector3::new(area * length * half * half / 3.0, yy * length, zz * length),
    }
}

/// Area and centre of what lies in each cell of a grid of pieces across `axis`, of the facets in the plane
/// at `at` of that axis (up to `near`) that face as `upwards` says; the piece's coordinate along the axis is
/// left at 0. In the order of facets.
pub(crate) fn for_each_on_plane(
    surface: &Triangles,
    lines: &[Vec<f64>; 3],
    (axis, at, near): (usize, f64, f64),
    mut each: impl FnMut([usize; 3], f64, Point, bool),
) {
    let (d, e) = ((axis + 1) % 3, (axis + 2) % 3);
    for k in 0..surface.n_facets() {
        let corners = surface.corners(k);
        if corners.iter().any(|x| (x[axis] - at).abs() > near) {
            continue;
        }
        slice(Polygon::of(corners), e, &lines[e], &mut |row, strip| {
            slice(*strip, d, &lines[d], &mut |column, part| {
                let first = part.corner[0];
                for pair in part.corners()[1..].windows(2) {
                    let (a, b) = (pair[0] - first, pair[1] - first);
                    let area = 0.5 * (a[d] * b[e] - b[d] * a[e]);
                    if area != 0.0 {
                        let mut piece = [0; 3];
                        (piece[d], piece[e]) = (column, row);
                        each(piece, area.abs(), (first + pair[0] + pair[1]) / 3.0, area > 0.0);
                    }
                }
            });
        });
    }
}

/// How much of what it encloses lies in a box `[L³]`.
pub(crate) fn volume_in(surface: &Triangles, from: &[f64; 3], to: &[f64; 3]) -> f64 {
    let (low, high) = surface.bounds();
    if (0..3).any(|d| to[d] <= low[d] || from[d] >= high[d] || from[d] >= to[d]) {
        return 0.0;
    }
    let mut inside = [0; 3];
    let lines = [0, 1, 2].map(|d| {
        let before = Some(low[d]).filter(|&low| low < from[d]);
        inside[d] = usize::from(before.is_some());
        let behind = Some(high[d]).filter(|&high| high > to[d]);
        before.into_iter().chain([from[d], to[d]]).chain(behind).collect()
    });
    let mut volume = 0.0;
    for_each(surface, &lines, |piece, moments| {
        if piece == inside {
            volume = moments.volume;
        }
    });
    volume
}

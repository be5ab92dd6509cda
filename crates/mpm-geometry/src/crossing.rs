//! Whether a surface meets itself: exact signs of determinants, and a tree of boxes so that only
//! neighbours in space are compared.

use crate::triangles::Triangles;
use nalgebra::Vector3;
use robust::{Coord, Coord3D, orient2d, orient3d};

type Point = Vector3<f64>;

/// Facets in a leaf of the tree at most.
const LEAF: usize = 4;

/// A box around the facets `first..last` of an order.
struct Node {
    low: Point,
    high: Point,
    first: usize,
    last: usize,
    /// Number of the first of two children; 0 for a leaf.
    children: usize,
}

/// The first two facets found that have more in common than a vertex or an edge.
pub(crate) fn first(surface: &Triangles) -> Option<[usize; 2]> {
    let (order, tree) = tree(surface);
    let mut pairs = vec![(0, 0)];
    while let Some((a, b)) = pairs.pop() {
        let (one, other) = (&tree[a], &tree[b]);
        if a == b {
            if one.children > 0 {
                let child = one.children;
                pairs.extend([(child, child), (child + 1, child + 1), (child, child + 1)]);
                continue;
            }
        } else if (0..3).any(|d| one.low[d] > other.high[d] || other.low[d] > one.high[d]) {
            continue;
        } else if one.children > 0 || other.children > 0 {
            let larger = one.last - one.first >= other.last - other.first;
            if one.children > 0 && (larger || other.children == 0) {
                pairs.extend([(one.children, b), (one.children + 1, b)]);
            } else {
                pairs.extend([(a, other.children), (a, other.children + 1)]);
            }
            continue;
        }
        for (k, &p) in order[one.first..one.last].iter().enumerate() {
            let others =
                if a == b { &order[one.first + k + 1..one.last] } else { &order[other.first..other.last] };
            for &q in others {
                if meet(surface, p, q) {
                    return Some([p.min(q), p.max(q)]);
                }
            }
        }
    }
    None
}

fn tree(surface: &Triangles) -> (Vec<usize>, Vec<Node>) {
    let n = surface.n_facets();
    let mut order: Vec<usize> = (0..n).collect();
    let leaf = |order: &[usize], first: usize, last: usize| {
        let start = surface.corners(order[first])[0];
        let corners = order[first..last].iter().flat_map(|&k| surface.corners(k));
        let (low, high) = corners.fold((start, start), |(low, high), x| (low.inf(&x), high.sup(&x)));
        Node { low, high, first, last, children: 0 }
    };
    let mut tree = vec![leaf(&order, 0, n)];
    let mut at = 0;
    while at < tree.len() {
        let Node { low, high, first, last, .. } = tree[at];
        if last - first > LEAF {
            let axis = (high - low).imax();
            let key = |k: usize| surface.corners(k).iter().map(|x| x[axis]).sum::<f64>();
            let middle = (last - first) / 2;
            order[first..last]
                .select_nth_unstable_by(middle, |&a, &b| key(a).total_cmp(&key(b)).then(a.cmp(&b)));
            tree[at].children = tree.len();
            tree.push(leaf(&order, first, first + middle));
            tree.push(leaf(&order, first + middle, last));
        }
        at += 1;
    }
    (order, tree)
}

/// Whether two facets have more in common than their common vertices and edge.
fn meet(surface: &Triangles, a: usize, b: usize) -> bool {
    let (p, q) = (surface.corners(a), surface.corners(b));
    let boxes_apart = (0..3).any(|d| {
        let range = |x: &[Point; 3]| {
            let low = x.iter().map(|x| x[d]).fold(f64::INFINITY, f64::min);
            (low, x.iter().map(|x| x[d]).fold(f64::NEG_INFINITY, f64::max))
        };
        let ((p0, p1), (q0, q1)) = (range(&p), range(&q));
        p0 > q1 || q0 > p1
    });
    if boxes_apart {
        return false;
    }
    let shared = |k: usize| surface.facets[b].iter().position(|v| *v == surface.facets[a][k]);
    let common: Vec<(usize, usize)> = (0..3).filter_map(|k| Some((k, shared(k)?))).collect();
    match common[..] {
        [] => (0..3)
            .any(|k| segment_meets(&p[k], &p[(k + 1) % 3], &q) || segment_meets(&q[k], &q[(k + 1) % 3], &p)),
        // What they have in common is convex: if it is more than the vertex, it ends on a side opposite.
        [(k, l)] => {
            let opposite = |x: &[Point; 3], k: usize| (x[(k + 1) % 3], x[(k + 2) % 3]);
            let ((p1, p2), (q1, q2)) = (opposite(&p, k), opposite(&q, l));
            segment_meets(&p1, &p2, &q) || segment_meets(&q1, &q2, &p)
        }
        // Folded onto each other.
        [(k, l), (m, n)] => {
            let apex = q[3 - l - n];
            let (ends, corner) = ((p[k], p[m]), p[3 - k - m]);
            if side(&p, &apex) != 0.0 {
                return false;
            }
            let drop = flat_view(&p);
            let of = |x: &Point| turn(&ends.0, &ends.1, x, drop);
            of(&corner).signum_or_zero() * of(&apex).signum_or_zero() > 0.0
        }
        _ => true,
    }
}

/// Whether the corners of a facet lie on a line.
pub(crate) fn is_flat(p: &[Point; 3]) -> bool {
    (0..3).all(|drop| turn(&p[0], &p[1], &p[2], drop) == 0.0)
}

/// Whether a segment, ends included, and a facet have a point in common.
fn segment_meets(from: &Point, to: &Point, facet: &[Point; 3]) -> bool {
    let (start, end) = (side(facet, from), side(facet, to));
    if start * end > 0.0 {
        return false;
    }
    let [a, b, c] = facet;
    if start == 0.0 && end == 0.0 {
        return segment_meets_in_plane(from, to, facet);
    }
    let turns = [(a, b), (b, c), (c, a)].map(|(x, y)| side(&[*from, *to, *x], y));
    turns.iter().all(|&it| it >= 0.0) || turns.iter().all(|&it| it <= 0.0)
}

/// As [`segment_meets`], of a segment in the facet's plane.
fn segment_meets_in_plane(from: &Point, to: &Point, facet: &[Point; 3]) -> bool {
    let drop = flat_view(facet);
    let hand = turn(&facet[0], &facet[1], &facet[2], drop);
    let inside = |x: &Point| (0..3).all(|k| turn(&facet[k], &facet[(k + 1) % 3], x, drop) * hand >= 0.0);
    inside(from)
        || (0..3).any(|k| {
            let (a, b) = (&facet[k], &facet[(k + 1) % 3]);
            // Neither line has the other's ends on one side of it; on one line, an end lies inside.
            let across = turn(a, b, from, drop).signum_or_zero() * turn(a, b, to, drop).signum_or_zero() <= 0.0
                && turn(from, to, a, drop).signum_or_zero() * turn(from, to, b, drop).signum_or_zero() <= 0.0;
            let on_one_line = turn(a, b, from, drop) == 0.0 && turn(a, b, to, drop) == 0.0;
            across
                && (!on_one_line || inside(to) || inside(from) || between(a, from, to) || between(b, from, to))
        })
}

/// Whether `x`, on the line through two points, lies between them.
fn between(x: &Point, from: &Point, to: &Point) -> bool {
    (0..3).all(|d| x[d] >= from[d].min(to[d]) && x[d] <= from[d].max(to[d]))
}

trait SignOrZero {
    fn signum_or_zero(self) -> f64;
}

impl SignOrZero for f64 {
    /// Products of signs cannot underflow.
    fn signum_or_zero(self) -> f64 {
        if self == 0.0 { 0.0 } else { self.signum() }
    }
}

/// The coordinate along which a facet shows the largest area.
fn flat_view(p: &[Point; 3]) -> usize {
    let seen = [0, 1, 2].map(|drop| turn(&p[0], &p[1], &p[2], drop).abs());
    Vector3::from(seen).imax()
}

/// Exact sign: on which side of a facet's plane a position is; 0 in the plane.
fn side([a, b, c]: &[Point; 3], x: &Point) -> f64 {
    let coord = |x: &Point| Coord3D { x: x.x, y: x.y, z: x.z };
    orient3d(coord(a), coord(b), coord(c), coord(x)).signum_or_zero()
}

/// Exact sign of the turn from a through b to x, seen along the coordinate `drop`.
fn turn(a: &Point, b: &Point, x: &Point, drop: usize) -> f64 {
    let coord = |x: &Point| Coord { x: x[(drop + 1) % 3], y: x[(drop + 2) % 3] };
    orient2d(coord(a), coord(b), coord(x))
}

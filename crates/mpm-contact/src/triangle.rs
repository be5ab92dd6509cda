//! The nearest place of a triangle, and which part of it that is.

use nalgebra::Vector3;

/// Part of a triangle that holds the nearest place: vertices and edges by their number in the triangle; edge k runs
/// from corner k to the next one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Region {
    Face,
    Edge(usize),
    Vertex(usize),
}

/// The nearest place of the triangle to `x`, by the regions of its corners, edges and face (Ericson, *Real-Time
/// Collision Detection*, 2005, section 5.1.5).
pub(crate) fn nearest(corners: &[Vector3<f64>; 3], x: &Vector3<f64>) -> (Region, Vector3<f64>) {
    let [a, b, c] = corners;
    let (ab, ac) = (b - a, c - a);
    let from = |corner: &Vector3<f64>| (ab.dot(&(x - corner)), ac.dot(&(x - corner)));
    let (a1, a2) = from(a);
    if a1 <= 0.0 && a2 <= 0.0 {
        return (Region::Vertex(0), *a);
    }
    let (b1, b2) = from(b);
    if b1 >= 0.0 && b2 <= b1 {
        return (Region::Vertex(1), *b);
    }
    let of_c = a1 * b2 - b1 * a2;
    if of_c <= 0.0 && a1 >= 0.0 && b1 <= 0.0 {
        return (Region::Edge(0), a + ab * (a1 / (a1 - b1)));
    }
    let (c1, c2) = from(c);
    if c2 >= 0.0 && c1 <= c2 {
        return (Region::Vertex(2), *c);
    }
    let of_b = c1 * a2 - a1 * c2;
    if of_b <= 0.0 && a2 >= 0.0 && c2 <= 0.0 {
        return (Region::Edge(2), a + ac * (a2 / (a2 - c2)));
    }
    let of_a = b1 * c2 - c1 * b2;
    if of_a <= 0.0 && b2 - b1 >= 0.0 && c1 - c2 >= 0.0 {
        let share = (b2 - b1) / ((b2 - b1) + (c1 - c2));
        return (Region::Edge(1), b + (c - b) * share);
    }
    let sum = of_a + of_b + of_c;
    (Region::Face, a + ab * (of_b / sum) + ac * (of_c / sum))
}

/// Where the segment from `x` along `by` meets the triangle's inside, as a share of `by`; `None` where it passes by or
/// runs along it.
pub(crate) fn crossed(corners: &[Vector3<f64>; 3], x: &Vector3<f64>, by: &Vector3<f64>) -> Option<f64> {
    let [a, b, c] = corners;
    let (ab, ac) = (b - a, c - a);
    let p = by.cross(&ac);
    let det = ab.dot(&p);
    if det == 0.0 {
        return None;
    }
    let from = x - a;
    let u = from.dot(&p) / det;
    let q = from.cross(&ab);
    let v = by.dot(&q) / det;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then(|| ac.dot(&q) / det)
}

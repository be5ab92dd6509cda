//! The nearest place of a triangle, and which part of it that is; and its parts.

use crate::plane::parts;
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

/// Centroids and areas of parts of the triangle, neither longer nor wider than `spacing`: rows along its longest edge, each cut across.
pub(crate) fn parts_of_triangle(
    corners: &[Vector3<f64>; 3],
    spacing: f64,
) -> impl Iterator<Item = (Vector3<f64>, f64)> + use<> {
    let length = |k: usize| (corners[(k + 1) % 3] - corners[k]).norm();
    let first = (1..3).fold(0, |longest, k| if length(k) > length(longest) { k } else { longest });
    let [from, to, apex] = [0, 1, 2].map(|k| corners[(first + k) % 3]);
    let longest = (to - from).norm();
    let height = (to - from).cross(&(apex - from)).norm() / longest;
    let rows = parts(height, spacing);
    (0..rows).flat_map(move |row| {
        // Shares of the longest edge on both sides of the row, and the height of its centroid as a share of the triangle's.
        let [wide, narrow] = [row, row + 1].map(|it| 1.0 - f64::from(it) / f64::from(rows));
        let up = (f64::from(row) + (wide + 2.0 * narrow) / (3.0 * (wide + narrow))) / f64::from(rows);
        let (start, end) = (from + (apex - from) * up, to + (apex - to) * up);
        let columns = parts(longest * wide, spacing);
        let area = 0.5 * (wide + narrow) * longest * height / f64::from(rows) / f64::from(columns);
        (0..columns)
            .map(move |column| (start + (end - start) * ((f64::from(column) + 0.5) / f64::from(columns)), area))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_as_many_as_the_area_needs_and_have_its_moments() {
        let x = [Vector3::new(0.1, 0.2, 0.3), Vector3::new(0.1, 0.21, 4.3), Vector3::new(0.12, 0.2, 2.0)];
        let whole = 0.5 * (x[1] - x[0]).cross(&(x[2] - x[0])).norm();
        for turn in 0..3 {
            let corners = [0, 1, 2].map(|k| x[(k + turn) % 3]);
            for (spacing, most) in [(10.0, 1), (0.1, 41), (0.005, 2500)] {
                let parts: Vec<_> = parts_of_triangle(&corners, spacing).collect();
                assert!(parts.len() <= most, "{} parts of {spacing}", parts.len());
                let area: f64 = parts.iter().map(|it| it.1).sum();
                let moment: Vector3<f64> = parts.iter().map(|it| it.0 * it.1).sum();
                assert!((area / whole - 1.0).abs() < 1e-12);
                assert!((moment / area - (x[0] + x[1] + x[2]) / 3.0).norm() < 1e-12);
                assert!(parts.iter().all(|it| (nearest(&corners, &it.0).1 - it.0).norm() < 1e-9));
            }
        }
    }
}

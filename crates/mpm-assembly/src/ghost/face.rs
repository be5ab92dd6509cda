//! Integration over a face between two cells.

use mpm_grid::{Block, Vector};

/// Gauss points of a face across `direction` in local coordinates, and their weights.
pub(super) fn face_points<const D: usize>(direction: usize) -> impl Iterator<Item = (Vector<D>, f64)> {
    let at = 1.0 / 3.0_f64.sqrt();
    (0..1_usize << (D - 1)).map(move |k| {
        let side = |d: usize| {
            let bit = d - usize::from(d > direction);
            if d == direction { 0.0 } else { (2.0 * f64::from((k >> bit & 1) as u32) - 1.0) * at }
        };
        (Vector::from_fn(|d, _| side(d)), 1.0)
    })
}

/// Area of the face per area in local coordinates; `jacobian` has the tangents as its columns.
pub(super) fn face_area<const D: usize>(jacobian: &Block<D>, direction: usize) -> f64 {
    let tangents: Vec<Vector<D>> =
        (0..D).filter(|&d| d != direction).map(|d| jacobian.column(d).into_owned()).collect();
    // The root of Gram's determinant.
    match tangents.as_slice() {
        [] => 1.0,
        [a] => a.norm(),
        [a, b, ..] => (a.norm_squared() * b.norm_squared() - a.dot(b).powi(2)).max(0.0).sqrt(),
    }
}

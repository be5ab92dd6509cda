//! Bodies in space as one sees them.

use crate::picture::{Patch, Shapes};

/// Faces of a box whose corners are lexicographic, round each face.
const FACES: [[usize; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

/// A face as it is drawn.
struct Face {
    nearness: f64,
    corners: Vec<(f64, f64)>,
    shade: f64,
}

/// Boxes (eight corners each, lexicographic) in parallel projection, y upwards, x to the right and z towards the
/// lower left; the farthest are drawn first. `shades` colours them from 0 to 1, nothing where there are none.
pub(super) fn view(
    title: String,
    outlines: &[Vec<[f64; 3]>],
    shades: &[f64],
    range: [(f64, f64); 2],
) -> Shapes {
    let (across, up) = (0.5, 0.35);
    let project = |x: &[f64; 3]| (x[0] - across * x[2], x[1] - up * x[2]);
    // Along the line of sight: what is drawn at one place differs by multiples of this.
    let nearness = |x: &[f64; 3]| x[2] + across * x[0] + up * x[1];
    let mut faces: Vec<Face> = Vec::new();
    for (k, corners) in outlines.iter().enumerate().filter(|(_, corners)| corners.len() == 8) {
        for face in FACES {
            let at = face.map(|c| corners[c]);
            faces.push(Face {
                nearness: at.iter().map(nearness).sum(),
                corners: at.iter().map(project).collect(),
                shade: shades.get(k).copied().unwrap_or(0.0),
            });
        }
    }
    faces.sort_by(|a, b| a.nearness.total_cmp(&b.nearness));
    let patches = faces.into_iter().map(|it| Patch::new(it.corners, it.shade)).collect();
    Shapes { title, range, patches, ..Shapes::default() }
}

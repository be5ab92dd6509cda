//! Bodies in space as one sees them.

use crate::picture::Shapes;

/// Faces of a box whose corners are lexicographic, round each face.
const FACES: [[usize; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

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
    let mut faces: Vec<(f64, Vec<(f64, f64)>, f64)> = Vec::new();
    for (k, corners) in outlines.iter().enumerate().filter(|(_, corners)| corners.len() == 8) {
        for face in FACES {
            let at = face.map(|c| corners[c]);
            let near = at.iter().map(nearness).sum::<f64>();
            faces.push((near, at.iter().map(project).collect(), shades.get(k).copied().unwrap_or(0.0)));
        }
    }
    faces.sort_by(|a, b| a.0.total_cmp(&b.0));
    let domains = faces.into_iter().map(|(_, corners, shade)| (corners, shade)).collect();
    Shapes { title, range, domains, ..Shapes::default() }
}

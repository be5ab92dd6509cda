//! The hoop of a body of revolution in the tangent.

use mpm_grid::{Block, Vector};
use mpm_material::HoopTangent;

/// Adds the columns `c e_k ⊗ e_r t_w` of the hoop to `half`, and returns the row `c' g_w + a_θθθθ t_w e_r` that all nodes
/// take by their `t_v`; `g` and `t` are those of node w, times the volume if `hoop` and `half` are per volume.
#[inline(always)]
pub(crate) fn add_hoop<const D: usize>(
    hoop: &HoopTangent,
    g: &Vector<D>,
    t: f64,
    half: &mut [Block<D>; D],
) -> Vector<D> {
    let mut row = Vector::zeros();
    for k in 0..2 {
        for i in 0..2 {
            half[k][(i, 0)] += hoop.by_hoop[(i, k)] * t;
            row[k] += hoop.of_hoop[(k, i)] * g[i];
        }
    }
    row[0] += hoop.hoop * t;
    row
}

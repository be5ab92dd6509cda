//! The tangent of one point in the dense sums of its nodes.

use crate::body::scatter::LOWER;
use mpm_grid::{Block, Vector};
use mpm_material::HoopTangent;

/// Adds a point's tangent to the dense sums of a [`LOWER`] pass, or of one for all blocks; `t` and the second part of `a`
/// are those of the hoop, where there is one.
#[inline(always)]
pub(crate) fn add_tangent_of_point<const D: usize, const TANGENT: u8, const HOOP: bool>(
    (g, t): (&[Vector<D>], &[f64]),
    (a, hoop): (&[[Block<D>; D]; D], Option<HoopTangent>),
    volume: f64,
    sums: &mut [Block<D>],
) {
    let n = g.len();
    let mut at = 0;
    for w in 0..n {
        // half[k](i, j) = V⁰ a_ikjl g_w,l
        let weighted = g[w] * volume;
        let mut half: [Block<D>; D] = std::array::from_fn(|k| {
            let mut sum = a[k][0] * weighted[0];
            for l in 1..D {
                sum += a[k][l] * weighted[l];
            }
            sum
        });
        let from = if TANGENT == LOWER { w } else { 0 };
        let mut hoop_row = Vector::<D>::zeros();
        if let Some(hoop) = &hoop {
            hoop_row = add_hoop(hoop, &weighted, t[w] * volume, &mut half);
        }
        for (v, (sum, g)) in sums[at..].iter_mut().zip(&g[from..]).enumerate() {
            for k in 0..D {
                *sum += half[k] * g[k];
            }
            if HOOP {
                for j in 0..D {
                    sum[(0, j)] += t[from + v] * hoop_row[j];
                }
            }
        }
        at += n - from;
    }
}

/// Adds the columns `c e_k ⊗ e_r t_w` of the hoop to `half`, and returns the row `c' g_w + a_θθθθ t_w e_r` that all nodes
/// take by their `t_v`; `g` and `t` are those of node w, times the volume if `hoop` and `half` are per volume.
#[inline(always)]
fn add_hoop<const D: usize>(hoop: &HoopTangent, g: &Vector<D>, t: f64, half: &mut [Block<D>; D]) -> Vector<D> {
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

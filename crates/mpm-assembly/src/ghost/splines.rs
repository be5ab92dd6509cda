//! Faces between cells of splines.
//!
//! Splines of degree p are of class C^(p-1): what jumps across a face is their p-th derivative along the direction of the
//! mesh that crosses it, and that is penalised:
//!
//! ```text
//! K_vw = γ E h^(2p−1) ∫_F [∂ᵖN_v][∂ᵖN_w] dΓ I
//! ```
//!
//! (as in Burman, Claus & Massing 2015 for elements of higher order). The derivative is taken by the coordinate of the
//! direction at rest and counts in extents of a cell, so that a mesh that is bent or round needs no other form; round a
//! ring it is the second one, because the functions there are of class C¹ whatever the degree. Position is a
//! polynomial of degree 1 in each of these coordinates, or has continuous derivatives round a ring: linear fields are free
//! of force.

use super::face::face_area;
use mpm_grid::{LinearCell, Mesh, NodeId, Place, Vector};
use std::array::from_fn;

/// Points of the rule of Gauss and Legendre with 3 and 4 points on [-1, 1], and their weights.
const THREE: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];
const FOUR: [(f64, f64); 4] = [
    (-0.861_136_311_594_052_6, 0.347_854_845_137_453_9),
    (-0.339_981_043_584_856_3, 0.652_145_154_862_546_2),
    (0.339_981_043_584_856_3, 0.652_145_154_862_546_2),
    (0.861_136_311_594_052_6, 0.347_854_845_137_453_9),
];

/// A face between two cells: its nodes, and the jumps of their functions.
pub(super) struct SplineFace {
    /// Every node once.
    pub nodes: Vec<NodeId>,
    /// Area of the face `[L^(D-1)]`.
    pub area: f64,
    /// Area of every integration point `[L^(D-1)]`.
    patch: Vec<f64>,
    /// `h^p [∂ᵖN_v]`, the nodes of every integration point in turn `[-]`.
    jump: Vec<f64>,
}

impl SplineFace {
    /// `∫ h^p [∂ᵖN_v] h^p [∂ᵖN_w] dΓ` of two nodes by their places `[L^(D-1)]`.
    pub(super) fn product(&self, v: usize, w: usize) -> f64 {
        let jumps = self.jump.chunks_exact(self.nodes.len());
        self.patch.iter().zip(jumps).map(|(patch, jump)| patch * jump[v] * jump[w]).sum()
    }
}

/// The face between two cells, the second above the first in `direction`.
///
/// # Panics
/// The functions of the mesh are not splines.
pub(super) fn face<const D: usize>(mesh: &Mesh<D>, cells: [[u32; D]; 2], direction: usize) -> SplineFace {
    let [lower, upper] = [(0, true), (1, false)].map(|(k, end)| {
        mesh.highest_derivatives(cells[k], direction, end).expect("the functions of the mesh are splines")
    });
    let scale = (0.5 * (lower.extent + upper.extent)).powi(lower.order as i32);
    // The functions of the upper cell are those of the lower one but its first, and one more.
    let mut across = vec![0.0; lower.count + 1];
    for k in 0..lower.count {
        across[k] -= scale * lower.values[k];
        across[k + 1] += scale * upper.values[k];
    }

    let first = mesh
        .spline_product(&Place { cell: cells[0], local: Vector::zeros() })
        .expect("the functions of the mesh are splines");
    let count: [usize; D] = from_fn(|d| if d == direction { across.len() } else { first.count[d] });
    let total: usize = count.iter().product();
    let along = |mut number: usize| -> [usize; D] {
        from_fn(|d| {
            let k = number % count[d];
            number /= count[d];
            k
        })
    };
    let node = |number| {
        let k = along(number);
        mesh.control_point(from_fn(|d| first.first[d] + k[d] as u32))
            .expect("the functions of the mesh are splines")
    };
    let mut made =
        SplineFace { nodes: (0..total).map(node).collect(), area: 0.0, patch: Vec::new(), jump: Vec::new() };
    let linear = mesh.linear_cell(cells[0]);
    let rule: &[(f64, f64)] = if first.count.contains(&4) { &FOUR } else { &THREE };
    for_points(rule, direction, |local: Vector<D>, weight| {
        let values = mesh
            .spline_product(&Place { cell: cells[0], local })
            .expect("the functions of the mesh are splines")
            .values;
        made.jump.extend((0..total).map(|number| {
            let k = along(number);
            (0..D).map(|d| if d == direction { across[k[d]] } else { values[d][k[d]] }).product::<f64>()
        }));
        let patch = weight * area(&linear, &local, direction);
        made.area += patch;
        made.patch.push(patch);
    });
    made
}

fn area<const D: usize>(cell: &LinearCell<D>, local: &Vector<D>, direction: usize) -> f64 {
    face_area(&cell.jacobian(local), direction)
}

/// Calls `each` with the points of a rule on the upper face of a cell across `direction`, and their weights.
fn for_points<const D: usize>(rule: &[(f64, f64)], direction: usize, mut each: impl FnMut(Vector<D>, f64)) {
    for number in 0..rule.len().pow(D as u32 - 1) {
        let (mut rest, mut weight) = (number, 1.0);
        let local = Vector::from_fn(|d, _| {
            if d == direction {
                return 1.0;
            }
            let (at, of_point) = rule[rest % rule.len()];
            rest /= rule.len();
            weight *= of_point;
            at
        });
        each(local, weight);
    }
}

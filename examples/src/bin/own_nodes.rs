//! A basis on nodes of its own: quadratic B-splines, sampled at the material points of a box.
//!
//! `S_vp = N_i(x) N_j(y)`, `∇S_vp = (N_i' N_j, N_i N_j')` with the splines N of the axes. A spline of degree 2 lives on
//! three cells, and its node is a control point: it stands at the mean of two knots, not at a vertex.

use mpm_basis::{Basis, Convection, ConvectionError, Seed, Stencil};
use mpm_examples::{Residuals, model};
use mpm_grid::{
    Axis, DrivenPlane, LinearCell, Mesh, MeshMotion, NodeKind, NodeSpace, OutsideMesh, Ramp, Region, Vector,
};
use mpm_material::{Elasticity, Hencky};
use mpm_solver::{Prescribed, run};
use std::error::Error;

struct QuadraticSplines {
    nodes: NodeSpace<2>,
}

/// `(N, N')` of the splines k, k + 1 and k + 2 at x in cell k of an axis (the triangle of Cox and de Boor).
fn splines(axis: &Axis, k: u32, x: f64) -> [(f64, f64); 3] {
    let knot = |i: u32| axis.node(i.min(axis.cells()));
    let (t0, t1, t2, t3) = (knot(k.saturating_sub(1)), knot(k), knot(k + 1), knot(k + 2));
    // The two linear splines that are not zero in the cell.
    let (falling, rising) = ((t2 - x) / (t2 - t1), (x - t1) / (t2 - t1));
    let (left, right) = ((t2 - x) / (t2 - t0), (x - t1) / (t3 - t1));
    let (left_slope, right_slope) = (2.0 * falling / (t2 - t0), 2.0 * rising / (t3 - t1));
    [
        (left * falling, -left_slope),
        ((1.0 - left) * falling + (1.0 - right) * rising, left_slope - right_slope),
        (right * rising, right_slope),
    ]
}

impl Basis<2> for QuadraticSplines {
    type Domain = ();

    fn name(&self) -> &'static str {
        "quadratic splines"
    }

    fn node_kind(&self, _mesh: &Mesh<2>) -> NodeKind {
        self.nodes.kind()
    }

    fn suits(&self, mesh: &Mesh<2>) -> Result<(), &'static str> {
        mesh.rectilinear().map(|_| ()).ok_or("splines need a box at rest or stretched along its axes")
    }

    fn seed(&self, piece: &LinearCell<2>, place: &mut dyn FnMut(Seed<2, ()>)) {
        place(Seed { position: piece.position(&Vector::zeros()), volume: piece.volume(), domain: () });
    }

    fn influences(
        &self,
        mesh: &Mesh<2>,
        x: &Vector<2>,
        _domain: &(),
        stencil: &mut Stencil<2>,
    ) -> Result<(), OutsideMesh<2>> {
        let cell = mesh.locate(x, 0.0)?.cell;
        let axes = mesh.rectilinear().expect("`suits` has refused every other mesh");
        let [along_x, along_y] = [0, 1].map(|d| splines(&axes[d], cell[d], x[d]));
        for (j, (m, dm)) in (cell[1]..).zip(along_y) {
            for (i, (n, dn)) in (cell[0]..).zip(along_x) {
                stencil.add(self.nodes.lattice().node([i, j]), n * m, Vector::<2>::new(dn * m, n * dm));
            }
        }
        Ok(())
    }

    fn convect(
        &self,
        _domain: &mut (),
        position: &mut Vector<2>,
        step: &Convection<'_, 2>,
    ) -> Result<(), ConvectionError> {
        *position += step.displacement;
        Ok(())
    }
}

/// Stretches the square by 1.5 and 0.8 along its axes, all its faces held to the mesh; returns the largest error
/// of its stress `2G ln λ_i + (K - 2G/3) ln λ_1 λ_2` over Young's modulus.
fn patch() -> Result<f64, Box<dyn Error>> {
    let elasticity = Elasticity::from_young_poisson(1000.0, 0.3)?;
    let plane = |by: f64| Some(DrivenPlane { anchor: 0.0, driven: 1.0, displacement: Ramp::linear(by) });
    let motion = MeshMotion::stretch([plane(0.5), plane(-0.2)])?;
    let rest = Mesh::at_rest(&mpm_examples::layout()?);
    let basis = QuadraticSplines { nodes: NodeSpace::of(NodeKind::ControlPoints { degree: 2 }, &rest)? };
    let mut square = model((basis, Hencky(elasticity)), motion, Vec::new(), 5)?;
    for (name, axis, at) in [("left", 0, 0.0), ("right", 0, 1.0), ("bottom", 1, 0.0), ("top", 1, 1.0)] {
        let follow = [Some(Prescribed::FollowMesh), Some(Prescribed::FollowMesh)];
        square.add_support(name, &Region::Plane { axis, at }, follow);
    }
    run(&mut square, &mut Residuals::default())?;

    let (shear, lame) = (1000.0 / 2.6, 300.0 / (1.3 * 0.4));
    let exact = [1.5_f64, 0.8].map(|stretch| 2.0 * shear * stretch.ln() + lame * (1.5_f64 * 0.8).ln());
    let body = &square.bodies[0].body;
    let stresses = (0..body.n_points()).map(|p| body.kirchhoff(p));
    let errors = stresses.map(|tau| (tau.xx - exact[0]).abs().max((tau.yy - exact[1]).abs()).max(tau.xy.abs()));
    Ok(errors.fold(0.0, f64::max) / 1000.0)
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("largest error of the stress over Young's modulus: {:e}", patch()?);
    Ok(())
}

#[cfg(test)]
#[path = "../tests/own_nodes.rs"]
mod tests;

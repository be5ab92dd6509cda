//! A basis of one's own: N_v averaged over the corners of a small square that never deforms.
//!
//! `S_vp = ¼ Σ_c N_v(x_p + c)`, `∇S_vp = ¼ Σ_c ∇N_v(x_p + c)`. Smoother than standard MPM as a point crosses
//! into the next cell, and usable on meshes that GIMP refuses.

use mpm_basis::{Basis, Convection, ConvectionError, Domain, Seed, Stencil};
use mpm_examples::{Residuals, model, support};
use mpm_grid::{DrivenPlane, LinearCell, Mesh, MeshMotion, OutsideMesh, Ramp, Region, Vector};
use mpm_material::{Elasticity, Hencky};
use mpm_solver::{Prescribed, run};
use std::error::Error;

struct Averaged;

/// Half the edge of the square `[L]`.
#[derive(Clone)]
struct HalfEdge(f64);

/// For checkpoints.
impl Domain<2> for HalfEdge {
    const NUMBERS: usize = 1;

    fn store(&self, to: &mut Vec<f64>) {
        to.push(self.0);
    }

    fn restore(from: &[f64]) -> Result<Self, String> {
        if from[0] > 0.0 { Ok(Self(from[0])) } else { Err(format!("half an edge is {}", from[0])) }
    }
}

impl Basis<2> for Averaged {
    type Domain = HalfEdge;

    fn name(&self) -> &'static str {
        "averaged"
    }

    fn seed(&self, piece: &LinearCell<2>, place: &mut dyn FnMut(Seed<2, HalfEdge>)) {
        let (position, volume) = (piece.position(&Vector::zeros()), piece.volume());
        // Half as wide as the piece: corners on faces of cells, where ∇N jumps, would fail the patch test.
        place(Seed { position, volume, domain: HalfEdge(0.25 * volume.sqrt()) });
    }

    fn influences(
        &self,
        mesh: &Mesh<2>,
        x: &Vector<2>,
        half: &HalfEdge,
        stencil: &mut Stencil<2>,
    ) -> Result<(), OutsideMesh<2>> {
        for (i, j) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
            // A corner up to half a cell outside sees the boundary cell's functions continued.
            let place = mesh.locate(&(x + Vector::<2>::new(i, j) * half.0), 0.5)?;
            mesh.values_and_gradients(&place, |node, value, gradient| {
                stencil.add(node, 0.25 * value, 0.25 * gradient);
            });
        }
        Ok(())
    }

    fn convect(
        &self,
        _half: &mut HalfEdge,
        position: &mut Vector<2>,
        step: &Convection<'_, 2>,
    ) -> Result<(), ConvectionError> {
        *position += step.displacement;
        Ok(())
    }
}

/// Pulls the square to 1.5 times its length; returns the largest error of its stress E ln λ (ν = 0).
fn pull() -> Result<f64, Box<dyn Error>> {
    let pulled = DrivenPlane { anchor: 0.0, driven: 1.0, displacement: Ramp::linear(0.5) };
    let motion = MeshMotion::stretch([Some(pulled), None])?;
    let supports = vec![
        support("left", Region::Plane { axis: 0, at: 0.0 }, [Some(Prescribed::Held), None])?,
        support("bottom", Region::Plane { axis: 1, at: 0.0 }, [None, Some(Prescribed::Held)])?,
        support("pulled", Region::Plane { axis: 0, at: 1.0 }, [Some(Prescribed::FollowMesh), None])?,
    ];
    let law = Hencky(Elasticity::from_young_poisson(1000.0, 0.0)?);
    let mut square = model((Averaged, law), motion, supports, 5)?;
    run(&mut square, &mut Residuals::default())?;
    let body = &square.bodies[0].body;
    let errors = (0..body.n_points()).map(|p| (body.kirchhoff(p).xx - 1000.0 * 1.5_f64.ln()).abs());
    Ok(errors.fold(0.0, f64::max))
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("largest error of the stress: {:e}", pull()?);
    Ok(())
}

#[cfg(test)]
#[path = "../tests/own_basis.rs"]
mod tests;

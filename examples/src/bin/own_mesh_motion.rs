//! A mesh motion of one's own: a box that shears while it turns, `x = R(φ) (I + γ e_x ⊗ e_y) X`.

use mpm_basis::Cpdi2q;
use mpm_examples::{Residuals, model, support};
use mpm_grid::{AffineMotion, Block, LoadFraction, MeshMotion, Region, Vector};
use mpm_material::{Elasticity, Hencky};
use mpm_solver::{Prescribed, run};
use std::error::Error;
use std::sync::Arc;

/// Shear `[-]` and angle `[rad]` at full load.
#[derive(Clone, Copy, Debug)]
struct ShearAndTurn {
    shear: f64,
    angle: f64,
}

impl ShearAndTurn {
    fn map(self, fraction: f64) -> Block<2> {
        let (sin, cos) = (self.angle * fraction).sin_cos();
        Block::<2>::new(cos, -sin, sin, cos) * Block::<2>::new(1.0, self.shear * fraction, 0.0, 1.0)
    }
}

impl AffineMotion<2> for ShearAndTurn {
    fn at(&self, fraction: LoadFraction) -> (Block<2>, Vector<2>) {
        (self.map(fraction.get()), Vector::zeros())
    }
}

/// Drives the boundary of the square with its mesh and returns F of its points.
fn drive(motion: ShearAndTurn, steps: u32) -> Result<Vec<Block<2>>, Box<dyn Error>> {
    let sides = [(0, 0.0), (0, 1.0), (1, 0.0), (1, 1.0)];
    let follow = || [Some(Prescribed::FollowMesh), Some(Prescribed::FollowMesh)];
    let side = |(axis, at)| support(&format!("{axis} {at}"), Region::Plane { axis, at }, follow());
    let supports = sides.map(side).into_iter().collect::<Result<_, _>>()?;
    let law = Hencky(Elasticity::from_young_poisson(1000.0, 0.3)?);
    let mesh_motion = MeshMotion::affine(Arc::new(motion))?;
    let mut square = model((Cpdi2q::default(), law), mesh_motion, supports, steps)?;
    run(&mut square, &mut Residuals::default())?;
    let body = &square.bodies[0].body;
    Ok((0..body.n_points()).map(|p| body.point(p).deformation_gradient).collect())
}

fn main() -> Result<(), Box<dyn Error>> {
    let motion = ShearAndTurn { shear: 0.5, angle: 2.0 };
    let found = drive(motion, 20)?;
    println!("F is {}and should be {}", found[0], motion.map(1.0));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// However the boundary gets there, F of a homogeneous motion is the map of the mesh.
    #[test]
    fn the_points_follow_the_mesh() -> Result<(), Box<dyn Error>> {
        let motion = ShearAndTurn { shear: 0.5, angle: 2.0 };
        for deformation_gradient in drive(motion, 20)? {
            let error = (deformation_gradient - motion.map(1.0)).norm();
            assert!(error < 1e-11, "{error:e}");
        }
        Ok(())
    }
}

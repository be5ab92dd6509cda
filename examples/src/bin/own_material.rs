//! A law of one's own: von Mises plasticity with linear isotropic hardening, ρ_y = ρ_0 + H α.

use mpm_basis::Cpdi1;
use mpm_examples::{Residuals, model, support};
use mpm_grid::{DrivenPlane, MeshMotion, Ramp, Region};
use mpm_material::{Elasticity, Material, PlasticStrain, Update};
use mpm_solver::{Prescribed, run};
use nalgebra::{Matrix3, Vector3};
use std::error::Error;

/// α = Σ|Δε_p| is what a point remembers; another history implements `StoredHistory`.
struct Hardening {
    elasticity: Elasticity,
    /// Yield radius at first ρ_0, and its growth H `[F/L²]`.
    initial: f64,
    slope: f64,
}

impl Material for Hardening {
    type History = PlasticStrain;
    const SYMMETRIC: bool = true;
    const PLASTIC: bool = true;

    /// Radial return: |s| = 2G|e| - 2G Δα = ρ_0 + H (α + Δα), along n = e/|e|.
    fn update(&self, trial: &Vector3<f64>, history: &PlasticStrain) -> Update<PlasticStrain> {
        let (k, two_g) = (self.elasticity.bulk(), 2.0 * self.elasticity.shear());
        let e = trial.add_scalar(-trial.sum() / 3.0);
        let (rho, yields_at) = (two_g * e.norm(), self.initial + self.slope * history.0);
        // The slack keeps rounding from calling points on the yield surface plastic.
        let plastic = rho > yields_at * (1.0 + 1e-12);
        let strain = if plastic { (rho - yields_at) / (two_g + self.slope) } else { 0.0 };
        let beta = if plastic { 1.0 - two_g * strain / rho } else { 1.0 };
        let n = if plastic { e.normalize() } else { Vector3::zeros() };
        let along_n = two_g * (self.slope / (two_g + self.slope) - beta);
        let deviatoric = Matrix3::identity().add_scalar(-1.0 / 3.0);
        Update {
            elastic_strain: (beta * e).add_scalar(trial.sum() / 3.0),
            kirchhoff: (two_g * beta * e).add_scalar(k * trial.sum()),
            tangent: (two_g * beta * deviatoric).add_scalar(k) + along_n * n * n.transpose(),
            secant: Vector3::repeat(two_g * beta),
            plastic,
            history: PlasticStrain(history.0 + strain),
        }
    }

    fn stiffness(&self) -> f64 {
        self.elasticity.p_wave()
    }

    fn young(&self) -> f64 {
        self.elasticity.young()
    }
}

fn law(slope: f64) -> Result<Hardening, Box<dyn Error>> {
    Ok(Hardening { elasticity: Elasticity::from_young_poisson(1000.0, 0.3)?, initial: 20.0, slope })
}

/// Pulls the square to 1.3 times its length; its top is free.
fn pull() -> Result<(f64, Residuals), Box<dyn Error>> {
    let pulled = DrivenPlane { anchor: 0.0, driven: 1.0, displacement: Ramp::linear(0.3) };
    let motion = MeshMotion::stretch([Some(pulled), None])?;
    let supports = vec![
        support("left", Region::Plane { axis: 0, at: 0.0 }, [Some(Prescribed::Held), None])?,
        support("bottom", Region::Plane { axis: 1, at: 0.0 }, [None, Some(Prescribed::Held)])?,
        support("pulled", Region::Plane { axis: 0, at: 1.0 }, [Some(Prescribed::FollowMesh), None])?,
    ];
    let mut square = model((Cpdi1, law(100.0)?), motion, supports, 10)?;
    let mut residuals = Residuals::default();
    run(&mut square, &mut residuals)?;
    Ok((square.bodies[0].body.point(0).kirchhoff.xx, residuals))
}

fn main() -> Result<(), Box<dyn Error>> {
    let (stress, residuals) = pull()?;
    println!("Kirchhoff stress at the end: {stress}; last step: {:?}", residuals.0.last());
    Ok(())
}

#[cfg(test)]
#[path = "../tests/own_material.rs"]
mod tests;

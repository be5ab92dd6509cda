//! A law of one's own: Drucker–Prager plasticity whose flow is not associated, with a cohesion that grows.

use mpm_basis::Cpdi1;
use mpm_examples::{Residuals, model, support};
use mpm_grid::{DrivenPlane, MeshMotion, Ramp, Region};
use mpm_material::{Elasticity, FieldInfo, History, Material, NoReturn, PointParameters, Update};
use mpm_solver::{Prescribed, run};
use nalgebra::{Matrix3, Vector3};
use std::error::Error;

/// `q ≤ η p + k`, with p positive in compression, `k = k_0 + H γ`, and flow along `√(3/2) n + ⅓ η̄ 1`.
struct DruckerPrager {
    elasticity: Elasticity,
    /// η and η̄ `[-]`: friction and dilation. The tangent is symmetric where they are equal.
    friction: f64,
    dilation: f64,
    /// k_0, and its growth H with γ `[F/L²]`.
    cohesion: f64,
    hardening: f64,
}

/// γ = Σ Δγ `[-]`, what a point remembers.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PlasticShear(f64);

impl History for PlasticShear {
    const NUMBERS: usize = 1;
    const FIELDS: &'static [FieldInfo] = &[FieldInfo { name: "plastic_shear", components: 1, unit: "-" }];

    fn store(&self, to: &mut Vec<f64>) {
        to.push(self.0);
    }

    fn restore(from: &[f64]) -> Result<Self, String> {
        if from[0] < 0.0 { Err(format!("γ is {}, expected 0 or more", from[0])) } else { Ok(Self(from[0])) }
    }
}

impl Material for DruckerPrager {
    type History = PlasticShear;
    const PLASTIC: bool = true;

    fn has_symmetric_tangent(&self) -> bool {
        self.friction == self.dilation
    }

    fn initial(&self, _point: &PointParameters) -> PlasticShear {
        PlasticShear(0.0)
    }

    /// With q = 3G ε_s and p = -K ε_v of the trial, `Δγ = (q - η p - k) / m`, `m = 3G + K η η̄ + H`. p_v to q_s are the
    /// derivatives of p and q with respect to ε_v and ε_s.
    fn update(&self, trial: &Vector3<f64>, history: &PlasticShear) -> Result<Update<PlasticShear>, NoReturn> {
        let (k, g) = (self.elasticity.bulk(), self.elasticity.shear());
        let (eta, eta_bar) = (self.friction, self.dilation);
        let (one, root) = (Vector3::repeat(1.0), (2.0_f64 / 3.0).sqrt());
        let e = trial.add_scalar(-trial.sum() / 3.0);
        let n = if e == Vector3::zeros() { e } else { e.normalize() };
        let (p, q) = (-k * trial.sum(), 3.0 * g * root * e.norm());
        let over = q - eta * p - (self.cohesion + self.hardening * history.0);
        // The slack keeps rounding from calling points on the yield surface plastic.
        let plastic = over > 1e-12 * (q + self.cohesion);
        let per_m = if plastic { 1.0 / (3.0 * g + k * eta * eta_bar + self.hardening) } else { 0.0 };
        let strain = over * per_m;
        let (p, q_left) = (p + k * eta_bar * strain, q - 3.0 * g * strain);
        if plastic && q_left < 0.0 {
            return Err(NoReturn { reason: "the trial stress lies beyond the apex of the cone" });
        }
        let [p_v, p_s] = [k * k * eta * eta_bar * per_m - k, 3.0 * g * k * eta_bar * per_m];
        let [q_v, q_s] = [-3.0 * g * k * eta * per_m, 3.0 * g - 9.0 * g * g * per_m];
        let secant = if plastic { 2.0 * g * q_left / q } else { 2.0 * g };
        Ok(Update {
            elastic_strain: trial - (n / root + one * (eta_bar / 3.0)) * strain,
            kirchhoff: n * (root * q_left) - one * p,
            tangent: n * (one * (root * q_v) + n * (root * root * q_s)).transpose()
                - one * (one * p_v + n * (root * p_s)).transpose()
                + (Matrix3::identity().add_scalar(-1.0 / 3.0) - n * n.transpose()) * secant,
            secant: Vector3::repeat(secant),
            plastic,
            history: PlasticShear(history.0 + strain),
        })
    }

    fn stored_energy(&self, elastic_strain: &Vector3<f64>, _history: &PlasticShear) -> f64 {
        self.elasticity.energy(elastic_strain)
    }

    fn elasticity(&self) -> Elasticity {
        self.elasticity
    }
}

fn law(dilation: f64) -> Result<DruckerPrager, Box<dyn Error>> {
    let elasticity = Elasticity::from_young_poisson(1000.0, 0.3)?;
    Ok(DruckerPrager { elasticity, friction: 0.8, dilation, cohesion: 20.0, hardening: 50.0 })
}

/// Moves a side of the square by `by` `[L]`; nodes in `held` keep their height. Returns γ of its first point.
fn drive(by: f64, held: Region<2>) -> Result<(f64, Residuals), Box<dyn Error>> {
    let plane = DrivenPlane { anchor: 0.0, driven: 1.0, displacement: Ramp::linear(by) };
    let motion = MeshMotion::stretch([Some(plane), None])?;
    let supports = vec![
        support("left", Region::Plane { axis: 0, at: 0.0 }, [Some(Prescribed::Held), None])?,
        support("held", held, [None, Some(Prescribed::Held)])?,
        support("right", Region::Plane { axis: 0, at: 1.0 }, [Some(Prescribed::FollowMesh), None])?,
    ];
    let mut square = model((Cpdi1, law(0.2)?), motion, supports, 10)?;
    let mut residuals = Residuals::default();
    run(&mut square, &mut residuals)?;
    let mut history = Vec::new();
    square.bodies[0].body.history(0, &mut history);
    Ok((history[0], residuals))
}

fn main() -> Result<(), Box<dyn Error>> {
    let (strain, residuals) = drive(-0.1, Region::Plane { axis: 1, at: 0.0 })?;
    println!("Plastic shear at the end: {strain}; last step: {:?}", residuals.0.last());
    Ok(())
}

#[cfg(test)]
#[path = "../tests/own_material.rs"]
mod tests;

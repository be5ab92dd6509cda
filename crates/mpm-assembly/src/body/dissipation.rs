//! Energy that a load step dissipates in a body, and its gradient: what dissipation control measures.

use crate::body::assembly_plan::AssemblyPlan;
use crate::body::dilatation::Dilated;
use crate::body::kinematics::{StepGradient, block};
use crate::body::trial::{Committed, InadmissiblePoint, dissipated, trial_of};
use mpm_grid::{Block, Vector};
use mpm_material::Material;

/// Energy that the trial displacement `increment` (`Δu_v` of every active node `[L]`) dissipates `[F L]`
/// (in the plane: per unit thickness),
///
/// ```text
/// D = Σ_p V⁰_p τ'_p : (ε_p,tr - ε_p,e)        ∂D/∂Δu_v = Σ_p V⁰_p s_p g_vp,   s = τ - ⅓ tr(τ) I,
/// ```
///
/// both sums over the points that yield (of a body of revolution with `s_θθ t_vp e_r` in the second); the gradient is added to `gradient_sum` `[F]`. τ' is the stress without that
/// of pore fluid, which stores all of its work. `ε_tr - ε_e` is the step's plastic strain (backward Euler in
/// logarithmic strain). The gradient is exact where flow is
/// isochoric and associated and the yield stress stays: then `s` is constant along its own direction.
/// For other laws it is an approximation (Verhoosel, Remmers & Gutiérrez 2009 control a step by the
/// energy itself, whose gradient only decides how fast the iterations arrive).
///
/// Summed point by point in order: the same bits on any number of threads.
///
/// # Errors
/// The first point that has no admissible state under the trial displacement.
pub fn dissipation<const D: usize, M: Material, const HOOP: bool>(
    committed: Committed<'_, D, M>,
    plan: &AssemblyPlan<D>,
    increment: &[Vector<D>],
    gradient_sum: &mut [Vector<D>],
) -> Result<f64, InadmissiblePoint> {
    let Committed { law, points, .. } = committed;
    let mut energy = 0.0;
    if !M::PLASTIC {
        return Ok(energy);
    }
    let connectivity = plan.connectivity();
    if let Some(dilatation) = plan.dilatation() {
        let dilated = Dilated::<D, M, HOOP> { committed, connectivity, dilatation, increment };
        return dilated.dissipation(gradient_sum);
    }
    let mut du = Vec::new();
    for view in (0..connectivity.n_groups()).map(|group| connectivity.group(group)) {
        du.clear();
        du.extend(view.nodes.iter().map(|&node| increment[node as usize]));
        for k in 0..view.points {
            let (values, gradients) = view.point(k);
            let p = view.first_point + k;
            let h = StepGradient::of::<HOOP>(&du, (values, gradients), points.position[p][0]);
            let state = trial_of::<D, M, HOOP>(committed, p, &h)?;
            if !state.response.plastic {
                continue;
            }
            let tau = state.response.kirchhoff;
            let before = h.trial_excess::<HOOP>(&points.elastic_excess[p]);
            let volume = points.reference_volume[p];
            energy += volume * dissipated(law, &before, &state.response);
            let mean = tau.trace() / 3.0;
            let deviator = block::<D>(&tau) - Block::identity() * mean;
            for (&node, gradient) in view.nodes.iter().zip(gradients) {
                let mut force = deviator * state.inverse.tr_mul(gradient) * volume;
                if HOOP && D == 3 {
                    force[D - 1] *= points.position[p][0] * state.hoop;
                }
                gradient_sum[node as usize] += force;
            }
            if HOOP {
                let per_radius = (tau.zz - mean) * volume / (points.position[p][0] * state.hoop);
                for (&node, value) in view.nodes.iter().zip(values) {
                    gradient_sum[node as usize][0] += per_radius * value;
                }
            }
        }
    }
    Ok(energy)
}

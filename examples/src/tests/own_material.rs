//! The tangent against differences, the law without hardening against `VonMises`, Newton's order.

use super::*;
use mpm_material::VonMises;

#[test]
fn the_tangent_is_the_derivative_of_the_stress() -> Result<(), Box<dyn Error>> {
    let (law, history) = (law(100.0)?, PlasticStrain(0.05));
    for trial in [Vector3::new(0.1, -0.06, 0.01), Vector3::new(0.01, 0.0, -0.005), Vector3::new(0.2, 0.2, -0.3)]
    {
        let update = law.update(&trial, &history);
        for b in 0..3 {
            let at = |by: f64| {
                let mut strain = trial;
                strain[b] += by;
                law.update(&strain, &history).kirchhoff
            };
            let difference = (at(1e-6) - at(-1e-6)) / 2e-6;
            let error = (difference - update.tangent.column(b)).norm() / law.stiffness();
            assert!(error < 1e-8, "{trial}, column {b}: {error:e}");
        }
        let pair = (update.kirchhoff[1] - update.kirchhoff[2]) / (trial[1] - trial[2]);
        assert!((pair - update.secant[1]).abs() < 1e-9 * law.stiffness());
    }
    Ok(())
}

#[test]
fn without_hardening_it_is_von_mises() -> Result<(), Box<dyn Error>> {
    let (law, trial) = (law(0.0)?, Vector3::new(0.1, -0.06, 0.01));
    let ours = law.update(&trial, &PlasticStrain(0.05));
    let theirs = VonMises::new(law.elasticity, law.initial)?.update(&trial, &PlasticStrain(0.05));
    assert!((ours.kirchhoff - theirs.kirchhoff).norm() < 1e-11);
    assert!((ours.tangent - theirs.tangent).norm() < 1e-10);
    assert!((ours.history.0 - theirs.history.0).abs() < 1e-15);
    Ok(())
}

#[test]
fn the_yield_radius_grows_and_newton_is_quadratic() -> Result<(), Box<dyn Error>> {
    let (_, residuals) = pull()?;
    let last = &residuals.0[residuals.0.len() - 1];
    let order = |k: usize| (last[k + 1] / last[k]).ln() / (last[k] / last[k - 1]).ln();
    // The last iterate may be rounding; the one before it is not.
    let k = last.len() - 3;
    assert!(order(k) > 1.8, "residuals {last:?}");
    Ok(())
}

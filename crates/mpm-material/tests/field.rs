//! Laws under a nodal field: derivatives against differences, symmetry, and what is left without the field.

use mpm_material::{
    Elasticity, FieldCoupling, FieldUpdate, Material, PlasticShear, PlasticStrain, Regularisable, Tresca,
    UndrainedStrength, VonMises,
};
use nalgebra::Vector3;

const STEP: f64 = 1e-6;
const MODULUS: f64 = 400.0;

fn elasticity() -> Elasticity {
    Elasticity::from_young_poisson(1000.0, 0.3).unwrap()
}

fn strengths() -> [UndrainedStrength; 3] {
    [
        UndrainedStrength::perfect(8.0).unwrap(),
        UndrainedStrength::linear(8.0, -40.0, 2.0).unwrap(),
        UndrainedStrength::remoulding(8.0, 0.2, 0.3).unwrap(),
    ]
}

/// A face, both edges of Tresca's surface, and an order of axes that is not descending.
fn trials() -> [Vector3<f64>; 4] {
    [
        Vector3::new(0.04, 0.001, -0.03),
        Vector3::new(0.03, 0.029, -0.05),
        Vector3::new(0.05, -0.029, -0.03),
        Vector3::new(-0.03, 0.04, 0.002),
    ]
}

/// Largest errors of ∂τ/∂ε, ∂τ/∂k, ∂κ/∂k and of the symmetry h ∂κ/∂ε = −∂τ/∂k, over the modulus of each.
fn errors<M: Regularisable>(law: &M, trial: &Vector3<f64>, history: &M::History, k: f64) -> [f64; 4] {
    let at = |strain: &Vector3<f64>, value: f64| -> FieldUpdate<M::History> {
        law.update_with_field(strain, history, FieldCoupling { modulus: MODULUS, value }).unwrap()
    };
    let here = at(trial, k);
    assert!(here.update.plastic, "{trial}");
    assert!((here.driver - law.plastic_strain(&here.update.history)).abs() < 1e-15);
    let p_wave = law.elasticity().p_wave();
    let (more, less) = (at(trial, k + STEP), at(trial, k - STEP));
    let by_field = (more.update.kirchhoff - less.update.kirchhoff) / (2.0 * STEP);
    let driver_by_field = (more.driver - less.driver) / (2.0 * STEP);
    let (mut tangent, mut asymmetry) = (0.0_f64, 0.0_f64);
    for b in 0..3 {
        let mut beside = [*trial; 2];
        beside[0][b] += STEP;
        beside[1][b] -= STEP;
        let (more, less) = (at(&beside[0], k), at(&beside[1], k));
        let column = (more.update.kirchhoff - less.update.kirchhoff) / (2.0 * STEP);
        tangent = tangent.max((column - here.update.tangent.column(b)).amax() / p_wave);
        let driver = (more.driver - less.driver) / (2.0 * STEP);
        asymmetry = asymmetry.max((MODULUS * driver + here.by_field[b]).abs() / MODULUS);
    }
    [
        tangent,
        (by_field - here.by_field).amax() / MODULUS,
        (driver_by_field - here.driver_by_field).abs(),
        asymmetry,
    ]
}

#[test]
fn derivatives_are_those_of_differences() {
    for strength in strengths() {
        for trial in trials() {
            for (kappa, k) in [(0.0, 0.0), (0.02, 0.015), (0.02, 0.03), (0.3, 0.28)] {
                let law = VonMises::with_strength(elasticity(), strength).unwrap();
                let found = errors(&law, &trial, &PlasticStrain(kappa), k);
                assert!(found.iter().all(|it| *it < 1e-7), "von Mises at {kappa}, {k}: {found:?}");
                let law = Tresca::new(elasticity(), strength).unwrap();
                let found = errors(&law, &trial, &PlasticShear(2.0_f64.sqrt() * kappa), k);
                assert!(found.iter().all(|it| *it < 1e-7), "Tresca at {kappa}, {k}, {trial}: {found:?}");
            }
        }
    }
}

/// Where k is the plastic strain after the update, the field neither adds nor takes strength.
#[test]
fn a_field_that_equals_its_driver_changes_nothing() {
    let law = VonMises::with_strength(elasticity(), strengths()[2]).unwrap();
    for trial in trials() {
        let local = law.update(&trial, &PlasticStrain(0.02)).unwrap();
        let field = FieldCoupling { modulus: MODULUS, value: local.history.0 };
        let found = law.update_with_field(&trial, &PlasticStrain(0.02), field).unwrap();
        assert!((found.update.kirchhoff - local.kirchhoff).amax() < 1e-12);
        assert!((found.driver - local.history.0).abs() < 1e-15);
    }
}

#[test]
fn a_field_far_above_its_driver_leaves_no_strength_and_is_refused() {
    let field = FieldCoupling { modulus: MODULUS, value: 1.0 };
    for trial in [Vector3::zeros(), trials()[0]] {
        let of_radius = VonMises::new(elasticity(), 10.0).unwrap();
        let refused = of_radius.update_with_field(&trial, &PlasticStrain(0.0), field).unwrap_err();
        assert_eq!(refused.to_string(), "the regularising field leaves it no strength");
        let of_strength = Tresca::new(elasticity(), strengths()[0]).unwrap();
        assert!(of_strength.update_with_field(&trial, &PlasticShear(0.0), field).is_err());
    }
}

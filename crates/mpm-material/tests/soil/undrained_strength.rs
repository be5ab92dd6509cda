//! Tresca and von Mises with a strength that changes: closed forms, work, and what is refused.

use crate::random::Numbers;
use mpm_material::{Elasticity, Material, PlasticShear, PlasticStrain, Tresca, UndrainedStrength, VonMises};
use nalgebra::Vector3;

fn elasticity() -> Elasticity {
    Elasticity::from_young_poisson(3e3, 0.49).expect("in range")
}

fn strengths() -> [UndrainedStrength; 3] {
    [
        UndrainedStrength::perfect(10.0).expect("positive"),
        UndrainedStrength::linear(10.0, -40.0, 4.0).expect("in range"),
        UndrainedStrength::remoulding(10.0, 0.25, 0.4).expect("in range"),
    ]
}

/// Steps of pure shear or of a state on an edge: the law's answers, the plastic work, ξ.
fn work<M: Material>(
    law: &M,
    step: &Vector3<f64>,
    mut history: M::History,
    n: usize,
) -> (Vector3<f64>, f64, M::History) {
    let (mut strain, mut tau, mut sum) = (Vector3::zeros(), Vector3::zeros(), 0.0);
    for _ in 0..n {
        let trial = strain + step;
        let update = law.update(&trial, &history).expect("a return");
        sum += update.kirchhoff.dot(&(trial - update.elastic_strain));
        (strain, tau, history) = (update.elastic_strain, update.kirchhoff, update.history);
    }
    (tau, sum, history)
}

/// In plane strain without change of volume, τ₁ − τ₃ = 2 s_u(ξ), and both laws are one.
#[test]
fn plane_strain_compression_bears_twice_the_strength() {
    let step = Vector3::new(1e-3, -1e-3, 0.0);
    for strength in strengths() {
        let tresca = Tresca::new(elasticity(), strength).expect("in range");
        let von_mises = VonMises::with_strength(elasticity(), strength).expect("in range");
        let (ours, _, shear) = work(&tresca, &step, PlasticShear(0.0), 300);
        let (theirs, _, strain) = work(&von_mises, &step, PlasticStrain(0.0), 300);
        let s_u = strength.at(shear.0);
        assert!((ours[0] - ours[1] - 2.0 * s_u).abs() < 1e-12 * s_u);
        assert!((ours - theirs).norm() < 1e-11 * s_u, "{ours:?} {theirs:?}");
        assert!((2.0_f64.sqrt() * strain.0 - shear.0).abs() < 1e-12);
        // What is not elastic of the shear 2 · 0.3 is plastic.
        assert!((shear.0 - (0.6 - s_u / elasticity().shear())).abs() < 1e-12);
        let q = 1.5_f64.sqrt() * theirs.norm();
        assert!((q - 3.0_f64.sqrt() * s_u).abs() < 1e-11 * s_u);
    }
}

/// dW_p = s_u dξ: a face, an edge, a smooth cylinder, step by step.
#[test]
fn shear_is_conjugate_to_the_strength() {
    let perfect = strengths()[0];
    let tresca = Tresca::new(elasticity(), perfect).expect("in range");
    let von_mises = VonMises::with_strength(elasticity(), perfect).expect("in range");
    for step in [Vector3::new(1.0, -1.0, 0.0), Vector3::new(1.0, 1.0, -2.0), Vector3::new(2.0, -1.0, -1.0)] {
        let (_, sum, shear) = work(&tresca, &(step * 1e-3), PlasticShear(0.0), 100);
        assert!((sum - 10.0 * shear.0).abs() < 1e-12 * sum, "{sum} {}", shear.0);
        let (_, sum, strain) = work(&von_mises, &(step * 1e-3), PlasticStrain(0.0), 100);
        assert!((sum - 10.0 * 2.0_f64.sqrt() * strain.0).abs() < 1e-12 * sum);
    }
    for strength in strengths() {
        let tresca = Tresca::new(elasticity(), strength).expect("in range");
        let mut numbers = Numbers(10);
        for _ in 0..1000 {
            let trial = numbers.strain(0.05);
            let update = tresca.update(&trial, &PlasticShear(0.02)).expect("a return");
            let work = update.kirchhoff.dot(&(trial - update.elastic_strain));
            let expected = strength.at(update.history.0) * (update.history.0 - 0.02);
            // The pressure does no plastic work but for rounding.
            let digits = 1e-15 * update.kirchhoff.amax() * trial.amax();
            assert!((work - expected).abs() < 1e-12 * expected + 10.0 * digits, "{trial:?}: {work} {expected}");
        }
    }
}

/// A strength of δ = 1, or one whose modulus is zero, is one that stays.
#[test]
fn no_softening_is_perfect_plasticity() {
    let [perfect, ..] = strengths();
    let mut numbers = Numbers(11);
    for same in [UndrainedStrength::linear(10.0, 0.0, 0.0), UndrainedStrength::remoulding(10.0, 1.0, 0.4)] {
        let same = same.expect("in range");
        for _ in 0..500 {
            let trial = numbers.strain(0.05);
            let [ours, theirs] = [same, perfect].map(|strength| {
                VonMises::with_strength(elasticity(), strength)
                    .expect("in range")
                    .update(&trial, &PlasticStrain(0.1))
                    .expect("a return")
            });
            assert!((ours.kirchhoff - theirs.kirchhoff).norm() <= 1e-14 * theirs.kirchhoff.norm());
            assert!((ours.tangent - theirs.tangent).norm() <= 1e-14 * theirs.tangent.norm());
            let [ours, theirs] = [same, perfect].map(|strength| {
                Tresca::new(elasticity(), strength)
                    .expect("in range")
                    .update(&trial, &PlasticShear(0.1))
                    .expect("a return")
            });
            assert!((ours.kirchhoff - theirs.kirchhoff).norm() <= 1e-14 * theirs.kirchhoff.norm());
            assert!((ours.tangent - theirs.tangent).norm() <= 1e-14 * theirs.tangent.norm());
        }
    }
}

/// Long steps of fast softening end where the scalar equation holds, also beyond the residual strength.
#[test]
fn long_steps_solve_the_equation() {
    let g = elasticity().shear();
    let strengths = [
        UndrainedStrength::linear(10.0, -0.7 * g, 0.1),
        UndrainedStrength::remoulding(10.0, 0.01, 3.0 * 10.0 * 0.99 / (0.74 * g)),
        UndrainedStrength::linear(10.0, 200.0, 0.0),
    ];
    for strength in strengths {
        let strength = strength.expect("in range");
        let tresca = Tresca::new(elasticity(), strength).expect("in range");
        for size in [0.01, 0.03, 0.3, 3.0] {
            for shape in
                [Vector3::new(1.0, 0.0, -1.0), Vector3::new(1.0, 0.9, -2.0), Vector3::new(2.0, -0.9, -1.0)]
            {
                let update = tresca.update(&(shape * size), &PlasticShear(0.0)).expect("a return");
                let reach = update.kirchhoff.max() - update.kirchhoff.min();
                let s_u = strength.at(update.history.0);
                assert!(
                    (reach - 2.0 * s_u).abs() < 1e-12 * reach.max(g * size * 1e-2),
                    "{shape:?} {size}: {reach} {s_u}"
                );
            }
        }
    }
}

#[test]
fn what_snaps_back_or_is_out_of_range_is_refused() {
    let g = elasticity().shear();
    let fast = UndrainedStrength::remoulding(10.0, 0.25, 3.0 * 10.0 * 0.75 / (0.8 * g)).expect("in range");
    assert!(VonMises::with_strength(elasticity(), fast).is_ok());
    let error = Tresca::new(elasticity(), fast).expect_err("snaps back");
    assert!(error.to_string().contains("snaps back"), "{error}");
    let faster = UndrainedStrength::linear(10.0, -1.01 * g, 1.0).expect("in range");
    assert!(VonMises::with_strength(elasticity(), faster).is_err());
    for (strength, name) in [
        (UndrainedStrength::perfect(0.0), "undrained_strength"),
        (UndrainedStrength::perfect(f64::NAN), "undrained_strength"),
        (UndrainedStrength::linear(10.0, -1.0, 0.0), "residual"),
        (UndrainedStrength::linear(10.0, -1.0, 11.0), "residual"),
        (UndrainedStrength::linear(10.0, f64::INFINITY, 1.0), "modulus"),
        (UndrainedStrength::remoulding(10.0, 0.0, 1.0), "remoulded"),
        (UndrainedStrength::remoulding(10.0, 1.1, 1.0), "remoulded"),
        (UndrainedStrength::remoulding(10.0, 0.5, 0.0), "shear_95"),
    ] {
        let error = strength.expect_err("out of range");
        assert_eq!(error.name, name);
    }
}

//! Pore fluid on top of a law: its pressure, its moduli, and the volume that it counts.

use mpm_material::{
    CamClay, CamClayParameters, Elasticity, Hencky, History, Material, MohrCoulomb, PlasticStrain, PoreFluid,
    Preconsolidation, SymmetricTensor, Undrained, respond,
};
use nalgebra::{Matrix3, Vector3};

const FLUID: f64 = 1e5;

fn clay() -> CamClay {
    CamClay::new(CamClayParameters {
        critical_ratio: 0.9,
        compression: 0.15,
        swelling: 0.03,
        shear: 1500.0,
        shear_ratio: 0.0,
        reference_pressure: 20.0,
        preconsolidation: 80.0,
    })
    .expect("in range")
}

#[test]
fn it_adds_a_volumetric_stiffness() {
    let elasticity = Elasticity::from_young_poisson(1000.0, 0.3).expect("in range");
    let law = Undrained::new(Hencky(elasticity), FLUID).expect("positive");
    let strain = Vector3::new(0.02, -0.03, 0.004);
    let (ours, dry) = (
        law.update(&strain, &PoreFluid::default()).expect("a return"),
        Hencky(elasticity).update(&strain, &()).expect("a return"),
    );
    assert_eq!(ours.kirchhoff, dry.kirchhoff.add_scalar(FLUID * strain.sum()));
    assert_eq!(ours.tangent, dry.tangent.add_scalar(FLUID));
    assert_eq!((ours.secant, ours.elastic_strain, ours.plastic), (dry.secant, dry.elastic_strain, false));
    let pressure = -FLUID * strain.sum() / strain.sum().exp();
    assert!((ours.history.excess_pressure - pressure).abs() < 1e-14 * pressure);
    assert_eq!(law.elasticity().p_wave(), elasticity.p_wave() + FLUID);
}

#[test]
fn fields_are_those_of_the_skeleton_and_the_pressure() {
    let law = Undrained::new(clay(), FLUID).expect("positive");
    let names: Vec<_> = law.history_fields().iter().map(|field| field.name).collect();
    assert_eq!(names, ["preconsolidation_pressure", "excess_pore_pressure"]);
    let history = PoreFluid { skeleton: Preconsolidation(80.0), inelastic_volume: 0.1, excess_pressure: 7.0 };
    let (mut stored, mut shown) = (Vec::new(), Vec::new());
    history.store(&mut stored);
    law.show(&history, &mut shown);
    assert_eq!((stored.len(), shown), (PoreFluid::<Preconsolidation>::NUMBERS, vec![80.0, 7.0]));
    assert_eq!(PoreFluid::restore(&stored), Ok(history));
    assert!(PoreFluid::<Preconsolidation>::restore(&[-1.0, 0.0, 0.0]).is_err());
}

/// However much of the deformation is plastic, J is that of the total deformation.
fn check_volume<M: Material>(skeleton: M, history: M::History, initial: Vector3<f64>) {
    let law = Undrained::new(skeleton, FLUID).expect("positive");
    // The fluid is shut in at the initial strain.
    let mut history = PoreFluid { skeleton: history, inelastic_volume: -initial.sum(), excess_pressure: 0.0 };
    let [xx, yy, zz]: [f64; 3] = initial.map(|eps| (2.0 * eps).exp_m1()).into();
    let mut excess = SymmetricTensor { xx, yy, zz, ..SymmetricTensor::ZERO };
    let h = Matrix3::new(-3e-3, 2e-3, 0.0, 1e-3, 2.5e-3, 0.0, 0.0, 0.0, 1e-4);
    let mut total = Matrix3::identity();
    let mut plastic = 0;
    for _ in 0..40 {
        let step = Matrix3::identity() + h;
        total = step * total;
        let moved = step * excess.to_matrix() * step.transpose();
        let trial = SymmetricTensor::from_matrix(&(h + h.transpose() + h * h.transpose() + moved));
        let response = respond(&law, &trial, &history).expect("a return");
        (excess, history) = (response.elastic_excess, response.history);
        plastic += usize::from(response.plastic);
        let j = total.determinant();
        let pressure = -FLUID * j.ln() / j;
        assert!(
            (history.excess_pressure - pressure).abs() < 1e-10 * FLUID * 1e-2,
            "{} {pressure}",
            history.excess_pressure
        );
    }
    assert!(plastic > 20, "{plastic}");
}

#[test]
fn plastic_volume_counts() {
    let elasticity = Elasticity::from_young_poisson(1e4, 0.3).expect("in range");
    let sand = MohrCoulomb::new(elasticity, 1.0, 35.0, 10.0).expect("in range");
    check_volume(sand, PlasticStrain(0.0), Vector3::repeat(-50.0 / (3.0 * elasticity.bulk())));
    let rest = clay().elastic_strain(&Vector3::repeat(-50.0), &Preconsolidation(1.0)).expect("compression");
    check_volume(clay(), Preconsolidation(60.0), rest);
}

/// Undrained compression of a clay ends where its critical state says: p_f = (p_c0/2)^Λ p_0^(1−Λ), q_f = M p_f,
/// whatever the water takes of the total stress.
#[test]
fn undrained_strength_follows_from_the_state() {
    let law = Undrained::new(clay(), FLUID).expect("positive");
    let parameters = *clay().parameters();
    let plastic_part = 1.0 - parameters.swelling / parameters.compression;
    for (p_0, p_c0) in [(60.0, 60.0), (20.0, 160.0)] {
        let mut strain =
            clay().elastic_strain(&Vector3::repeat(-p_0), &Preconsolidation(1.0)).expect("compression");
        let mut history = PoreFluid {
            skeleton: Preconsolidation(p_c0),
            inelastic_volume: -strain.sum(),
            excess_pressure: 0.0,
        };
        let mut tau = Vector3::zeros();
        for _ in 0..4000 {
            let update = law.update(&(strain + Vector3::new(-1e-3, 5e-4, 5e-4)), &history).expect("a return");
            (strain, history, tau) = (update.elastic_strain, update.history, update.kirchhoff);
        }
        let p_f = (p_c0 / 2.0).powf(plastic_part) * p_0.powf(1.0 - plastic_part);
        let q = 1.5_f64.sqrt() * tau.add_scalar(-tau.sum() / 3.0).norm();
        assert!((q / (parameters.critical_ratio * p_f) - 1.0).abs() < 1e-5, "{q}");
        assert!(history.excess_pressure.abs() < 1e-9 * FLUID);
        let effective = -tau.sum() / 3.0 - history.excess_pressure;
        assert!((effective / p_f - 1.0).abs() < 1e-4, "{effective} {p_f}");
    }
}

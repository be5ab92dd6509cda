//! Parameters of points: the same answer as a law with those parameters, carried by the history.

use crate::random::Numbers;
use mpm_material::{
    CamClay, CamClayParameters, ConeMatch, Consolidation, DruckerPrager, Elasticity, Hencky, History, Material,
    MohrCoulomb, NeoHooke, OwnParameters, PerPoint, PointHistory, PointParameters, Preconsolidation, Tresca,
    Undrained, UndrainedStrength, Varied, VolumeCorrected, VonMises,
};
use nalgebra::Vector3;

fn elasticity(young: f64) -> Elasticity {
    Elasticity::from_young_poisson(young, 0.3).expect("in range")
}

/// A point whose own parameters are those of `law`.
fn point<M: Varied>(law: &M) -> PointParameters {
    let mut point = PointParameters::at(Vector3::new(1.0, 2.0, 3.0));
    point.own = Some(law.own());
    point
}

/// A point that has the parameters of `other` for its own answers as `other` does, whatever law is wrapped.
fn check<M: Varied>(wrapped: M, other: M) {
    let (p, is_symmetric) = (point(&other), other.has_symmetric_tangent());
    let wrapped = PerPoint::new(wrapped).for_points(p.own.iter());
    let history = wrapped.initial(&p);
    let mut numbers = Numbers(13);
    for _ in 0..500 {
        let trial = numbers.strain(0.05);
        let ours = wrapped.update(&trial, &history).expect("a return");
        let theirs = other.update(&trial, &M::history(&history.numbers)).expect("a return");
        let scale = other.elasticity().p_wave();
        assert!((ours.kirchhoff - theirs.kirchhoff).amax() < 1e-13 * scale);
        assert!((ours.tangent - theirs.tangent).amax() < 1e-11 * scale);
        assert!((ours.secant - theirs.secant).amax() < 1e-11 * scale);
        for (ours, theirs) in ours.history.numbers.iter().zip(M::numbers(&theirs.history)) {
            assert!((ours - theirs).abs() < 1e-12 * (scale + ours.abs()));
        }
        assert_eq!((ours.plastic, ours.history.own), (theirs.plastic, history.own));
    }
    assert_eq!(wrapped.has_symmetric_tangent(), is_symmetric);
}

fn clay(shear: f64) -> CamClay {
    CamClay::new(parameters(shear)).expect("in range")
}

fn parameters(shear: f64) -> CamClayParameters {
    CamClayParameters {
        critical_ratio: 0.9,
        compression: 0.15,
        swelling: 0.03,
        shear,
        shear_ratio: 0.0,
        reference_pressure: 20.0,
        preconsolidation: 80.0,
    }
}

#[test]
fn every_law_is_that_of_the_point() {
    check(Hencky(elasticity(2e4)), Hencky(elasticity(5e3)));
    let rubber = |young| NeoHooke::new(elasticity(young)).expect("in range");
    check(rubber(2e4), rubber(5e3));
    // H, s_res and δ are the law's, whatever the strength.
    let strengths = |intact: f64| {
        [
            UndrainedStrength::perfect(intact),
            UndrainedStrength::linear(intact, -512.0, 4.0),
            UndrainedStrength::remoulding(intact, 0.25, 0.5),
        ]
        .map(|strength| strength.expect("in range"))
    };
    for (once, twice) in strengths(16.0).into_iter().zip(strengths(32.0)) {
        let tresca = |young, strength| Tresca::new(elasticity(young), strength).expect("in range");
        check(tresca(2e4, once), tresca(1e4, twice));
        let von_mises =
            |young, strength| VonMises::with_strength(elasticity(young), strength).expect("in range");
        check(von_mises(2e4, once), von_mises(1e4, twice));
    }
    let sand = |young, c| MohrCoulomb::new(elasticity(young), c, 30.0, 5.0).expect("in range");
    let cut = |young, c, tension| sand(young, c).with_cut_off(tension).expect("in range");
    check(sand(2e4, 8.0), sand(1e4, 16.0));
    check(cut(2e4, 8.0, 2.0), cut(1e4, 16.0, 1.0));
    let clay_of = |c| MohrCoulomb::new(elasticity(2e4), c, 0.0, 0.0).expect("in range");
    check(clay_of(8.0), clay_of(16.0));
    let cone = |young, c| {
        DruckerPrager::matched(elasticity(young), ConeMatch::PlaneStrain, c, 30.0, 5.0).expect("in range")
    };
    let flat = |young, c, tension| cone(young, c).with_cut_off(tension).expect("in range");
    check(cone(2e4, 8.0), cone(1e4, 16.0));
    check(flat(2e4, 8.0, 2.0), flat(1e4, 16.0, 1.0));
    check(clay(1500.0), clay(900.0));
}

#[test]
fn angles_slopes_and_ratios_are_those_of_the_point() {
    let sand = |c, phi, psi| MohrCoulomb::new(elasticity(2e4), c, phi, psi).expect("in range");
    check(sand(8.0, 30.0, 5.0), sand(8.0, 35.0, 35.0));
    check(sand(8.0, 30.0, 30.0), sand(8.0, 20.0, 0.0));
    let cut = |phi| sand(8.0, phi, 5.0).with_cut_off(2.0).expect("in range");
    check(cut(30.0), cut(40.0));
    let cone = |slope, flow| DruckerPrager::new(elasticity(2e4), slope, flow, 8.0).expect("in range");
    check(cone(1.0, 0.2), cone(0.7, 0.7));
    let soft = CamClayParameters {
        critical_ratio: 1.2,
        compression: 0.2,
        swelling: 0.05,
        shear_ratio: 20.0,
        ..parameters(700.0)
    };
    check(clay(1500.0), CamClay::new(soft).expect("in range"));
    let wet = |fluid| Undrained::new(sand(8.0, 30.0, 5.0), fluid).expect("positive");
    check(wet(1e5), wet(3e5));
    check(VolumeCorrected::new(wet(1e5)), VolumeCorrected::new(wet(3e5)));
    check(
        Undrained::new(VolumeCorrected::new(sand(8.0, 30.0, 5.0)), 1e5).expect("positive"),
        Undrained::new(VolumeCorrected::new(sand(2.0, 33.0, 5.0)), 1e4).expect("positive"),
    );
}

#[test]
fn all_points_decide_whether_the_tangent_is_symmetric() {
    let sand = |phi, psi| MohrCoulomb::new(elasticity(2e4), 8.0, phi, psi).expect("in range");
    let associated = [sand(30.0, 30.0).own(), sand(35.0, 35.0).own()];
    let law = |own: &[OwnParameters]| PerPoint::new(sand(30.0, 30.0)).for_points(own.iter());
    assert!(law(&associated).has_symmetric_tangent());
    assert!(!law(&[associated[0], sand(35.0, 34.0).own()]).has_symmetric_tangent());
    assert!(!PerPoint::new(sand(30.0, 5.0)).has_symmetric_tangent());
}

#[test]
fn parameters_are_stored_and_shown() {
    let sand = MohrCoulomb::new(elasticity(2e4), 8.0, 30.0, 5.0).expect("in range");
    let law = PerPoint::new(Undrained::new(sand, 1e6).expect("positive"));
    let mut p = PointParameters::at(Vector3::zeros());
    p.own = Some([1e4, 3.0, 1.0, 35.0, 5.0, 2e6]);
    let mut history = law.initial(&p);
    history.numbers = [0.25, 0.01, 7.0, 0.0];
    let names: Vec<_> = law.history_fields().iter().map(|field| field.name).collect();
    let own = ["young", "cohesion", "tensile_strength", "friction", "dilation", "fluid_bulk"];
    assert_eq!(names[..2], ["plastic_strain", "excess_pore_pressure"]);
    assert_eq!(names[2..], own);
    let mut shown = Vec::new();
    law.show(&history, &mut shown);
    assert_eq!(shown, [0.25, 7.0, 1e4, 3.0, 1.0, 35.0, 5.0, 2e6]);
    let mut numbers = Vec::new();
    history.store(&mut numbers);
    assert_eq!((numbers.len(), PointHistory::restore(&numbers)), (PointHistory::NUMBERS, Ok(history)));
    assert!(PointHistory::restore(&numbers[1..]).is_err());
    // Whatever is stored is finite, or no checkpoint could hold it.
    let clay = MohrCoulomb::new(elasticity(2e4), 8.0, 0.0, 0.0).expect("in range");
    assert!(clay.own().iter().all(|value| value.is_finite()));
}

#[test]
fn the_past_of_a_clay_decides_its_preconsolidation() {
    let law = clay(1500.0);
    let mut point = PointParameters::at(Vector3::zeros());
    assert_eq!(law.initial(&point), Preconsolidation(80.0));
    point.consolidation = Consolidation::Pressure(120.0);
    assert_eq!(law.initial(&point), Preconsolidation(120.0));
    // p = 100, q = 60: p + q²/(M² p).
    point.consolidation = Consolidation::Stress(Vector3::new(-140.0, -80.0, -80.0));
    let expected = 100.0 + 3600.0 / (0.81 * 100.0);
    assert!((law.initial(&point).0 - expected).abs() < 1e-12 * expected);
}

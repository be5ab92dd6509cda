//! Strengths of points: the same answer as a law with that strength, carried by the history.

use crate::random::Numbers;
use mpm_material::{
    CamClay, CamClayParameters, ConeMatch, DruckerPrager, Elasticity, FieldInfo, History, Material,
    MohrCoulomb, PerPoint, PlasticShear, PlasticStrain, PointHistory, PointParameters, Preconsolidation,
    Scalable, Tresca, Undrained, UndrainedStrength, VonMises,
};
use nalgebra::Vector3;

fn elasticity() -> Elasticity {
    Elasticity::from_young_poisson(2e4, 0.3).expect("in range")
}

fn point(strength: f64) -> PointParameters {
    let mut point = PointParameters::at(Vector3::new(1.0, 2.0, 3.0));
    point.strength = strength;
    point
}

/// `law` at a factor answers as `twice` does, whose strengths are twice as large.
fn check<M: Scalable>(law: M, twice: M)
where
    M::History: PartialEq + std::fmt::Debug,
{
    let wrapped = PerPoint(law);
    let history = wrapped.initial(&point(2.0));
    let mut numbers = Numbers(13);
    for _ in 0..500 {
        let trial = numbers.strain(0.05);
        let ours = wrapped.update(&trial, &history).expect("a return");
        let theirs = twice.update(&trial, &history.law).expect("a return");
        assert_eq!(
            (ours.kirchhoff, ours.tangent, ours.secant),
            (theirs.kirchhoff, theirs.tangent, theirs.secant)
        );
        assert_eq!(ours.history, PointHistory { law: theirs.history, strength: 2.0 });
    }
    assert_eq!(wrapped.has_symmetric_tangent(), twice.has_symmetric_tangent());
    assert_eq!(wrapped.elasticity(), twice.elasticity());
}

#[test]
fn every_scalable_law_is_that_of_the_larger_strength() {
    let strengths = |factor: f64| {
        [
            UndrainedStrength::perfect(16.0 * factor),
            UndrainedStrength::linear(16.0 * factor, -512.0 * factor, 4.0 * factor),
            UndrainedStrength::remoulding(16.0 * factor, 0.25, 0.5),
        ]
        .map(|strength| strength.expect("in range"))
    };
    for (once, twice) in strengths(1.0).into_iter().zip(strengths(2.0)) {
        let tresca = |strength| Tresca::new(elasticity(), strength).expect("in range");
        check(tresca(once), tresca(twice));
        let von_mises = |strength| VonMises::with_strength(elasticity(), strength).expect("in range");
        check(von_mises(once), von_mises(twice));
    }
    let sand = |c, cut_off| {
        MohrCoulomb::new(elasticity(), c, 30.0, 5.0)
            .and_then(|law| law.with_cut_off(cut_off))
            .expect("in range")
    };
    check(sand(8.0, 2.0), sand(16.0, 4.0));
    let cone = |c, tension| {
        DruckerPrager::matched(elasticity(), ConeMatch::PlaneStrain, c, 30.0, 5.0)
            .and_then(|law| law.with_cut_off(tension))
            .expect("in range")
    };
    check(cone(8.0, 2.0), cone(16.0, 4.0));
}

#[test]
fn factors_are_stored_and_shown() {
    type Both = PointHistory<PlasticShear>;
    let names = |fields: &[FieldInfo]| fields.iter().map(|field| field.name).collect::<Vec<_>>();
    assert_eq!(names(Both::FIELDS), ["plastic_shear", "strength_factor"]);
    let history = Both { law: PlasticShear(0.1), strength: 1.7 };
    let mut numbers = Vec::new();
    history.store(&mut numbers);
    assert_eq!((numbers.len(), Both::restore(&numbers)), (Both::NUMBERS, Ok(history)));
    assert!(Both::restore(&[0.1, 0.0]).is_err());
    // Wrapped twice.
    let sand = MohrCoulomb::new(elasticity(), 8.0, 30.0, 5.0).expect("in range");
    let law = Undrained::new(PerPoint(sand), 1e6).expect("positive");
    let history = law.initial(&point(0.5));
    assert_eq!(history.skeleton, PointHistory { law: PlasticStrain(0.0), strength: 0.5 });
    fn fields<M: Material>(_: &M) -> &'static [FieldInfo] {
        M::History::FIELDS
    }
    assert_eq!(names(fields(&law)), ["plastic_strain", "strength_factor", "excess_pore_pressure"]);
}

#[test]
fn points_that_would_snap_back_are_refused() {
    let g = elasticity().shear();
    let strength = UndrainedStrength::linear(10.0, -0.5 * g, 1.0).expect("in range");
    let law = PerPoint(Tresca::new(elasticity(), strength).expect("in range"));
    assert!(law.check(1.4).is_ok());
    assert!(law.check(1.6).expect_err("too steep").expected.contains("snaps back"));
    assert!(law.check(0.0).is_err() && law.check(f64::NAN).is_err());
}

#[test]
fn the_factor_of_a_clay_is_on_its_preconsolidation() {
    let law = CamClay::new(CamClayParameters {
        critical_ratio: 0.9,
        compression: 0.15,
        swelling: 0.03,
        shear: 1500.0,
        shear_ratio: 0.0,
        reference_pressure: 20.0,
        preconsolidation: 80.0,
    })
    .expect("in range");
    assert_eq!(law.initial(&point(1.5)), Preconsolidation(120.0));
}

//! The apex: stiffness that is added to the tangent alone, and points that close before they bear anything.

use crate::random::Numbers;
use mpm_material::{
    DruckerPrager, Elasticity, History, Material, MohrCoulomb, Opened, PlasticStrain, PointParameters, Update,
    VolumeCorrected,
};
use nalgebra::{Matrix3, Vector3};

const PART: f64 = 1e-3;

fn elasticity() -> Elasticity {
    Elasticity::from_young_poisson(1e4, 0.3).expect("in range")
}

fn sand(cohesion: f64) -> MohrCoulomb {
    MohrCoulomb::new(elasticity(), cohesion, 30.0, 5.0).expect("in range")
}

fn cone(strength: f64) -> DruckerPrager {
    DruckerPrager::new(elasticity(), 1.0, 0.2, strength).expect("in range")
}

/// With the option only tangents change that were zero, by so much of the elastic moduli.
fn check_stiffness<M: Material<History = PlasticStrain>>(
    plain: &M,
    stiff: &M,
    vanishes: fn(&Update<PlasticStrain>) -> bool,
) {
    let (mut numbers, mut met) = (Numbers(3), 0);
    let none = PlasticStrain::default();
    for _ in 0..2000 {
        let trial = numbers.strain(0.05);
        let without = plain.update(&trial, &none).expect("a return");
        let with = stiff.update(&trial, &none).expect("a return");
        assert_eq!(
            (with.kirchhoff, with.elastic_strain, with.history),
            (without.kirchhoff, without.elastic_strain, without.history)
        );
        let g = elasticity().shear();
        let (added, sheared) = if vanishes(&without) {
            met += 1;
            let moduli = Matrix3::from_diagonal_element(2.0 * g).add_scalar(elasticity().lame());
            (moduli * PART, 2.0 * g * PART)
        } else {
            (Matrix3::zeros(), 0.0)
        };
        assert!((with.tangent - without.tangent - added).amax() < 1e-12 * g);
        assert!((with.secant - without.secant).add_scalar(-sheared).amax() < 1e-12 * g);
    }
    assert!(met > 20, "{met}");
}

#[test]
fn stiffness_is_added_to_tangents_alone() {
    let has_none = |update: &Update<PlasticStrain>| update.tangent == Matrix3::zeros();
    for law in [sand(2.0), sand(2.0).with_cut_off(1.0).expect("in range")] {
        check_stiffness(&law, &law.with_apex_stiffness(PART).expect("in range"), has_none);
    }
    // In the corner of a cut-off the tangent keeps what turns the deviator.
    let is_corner = |update: &Update<PlasticStrain>| {
        let (k, e) = (elasticity().bulk(), update.elastic_strain);
        let q = 3.0 * elasticity().shear() * ((e.add_scalar(-e.sum() / 3.0)).norm() * (2.0_f64 / 3.0).sqrt());
        (k * e.sum() - 1.0).abs() < 1e-9 && (q - 1.0).abs() < 1e-9
    };
    let cut = cone(2.0).with_cut_off(1.0).expect("in range");
    check_stiffness(&cut, &cut.with_apex_stiffness(PART).expect("in range"), is_corner);
    check_stiffness(&cone(2.0), &cone(2.0).with_apex_stiffness(PART).expect("in range"), has_none);
    for part in [-1e-3, 1.1, f64::NAN] {
        assert_eq!(sand(2.0).with_apex_stiffness(part).unwrap_err().name, "apex_stiffness");
        assert_eq!(cone(2.0).with_apex_stiffness(part).unwrap_err().name, "apex_stiffness");
    }
}

/// Strains a point by equal steps, and answers with its last state.
fn strained<M: Material>(
    law: &M,
    from: &Update<M::History>,
    by: Vector3<f64>,
    steps: usize,
) -> Update<M::History> {
    let mut now = *from;
    for _ in 0..steps {
        let trial = now.elastic_strain + by / steps as f64;
        now = law.update(&trial, &now.history).expect("a return");
    }
    now
}

fn at_rest<M: Material>(law: &M) -> Update<M::History> {
    let history = law.initial(&PointParameters::at(Vector3::zeros()));
    law.update(&Vector3::zeros(), &history).expect("a return")
}

/// A point that was stretched alike in all directions beyond the apex, and is compressed again: it bears the tension of the
/// apex until its volume is that at which it came apart, then K times what follows. The plain law has lost the stretch.
fn check_isotropic<M: Material + Copy>(law: &M, plain: &M, tension: f64) -> Vec<f64> {
    let (k, all) = (elasticity().bulk(), Vector3::repeat(1.0));
    let corrected = VolumeCorrected::new(*law);
    let apex = tension / (9.0 * k);
    let mut opened = Vec::new();
    for steps in [1, 7] {
        let far = strained(&corrected, &at_rest(&corrected), all * (apex + 0.01), steps);
        assert!((far.history.volume - 0.03).abs() < 1e-14, "{}", far.history.volume);
        assert!((far.kirchhoff - all * tension / 3.0).amax() < 1e-12 * k);
        let half = strained(&corrected, &far, all * -0.004, steps);
        assert!((half.history.volume - 0.018).abs() < 1e-14 && half.tangent == Matrix3::zeros());
        let closed = strained(&corrected, &half, all * -0.007, steps);
        assert_eq!(closed.history.volume, 0.0);
        let expected = tension / 3.0 - k * 0.003;
        assert!((closed.kirchhoff - all * expected).amax() < 1e-11 * k, "{} {expected}", closed.kirchhoff[0]);
        opened.push(half.history.volume);

        let far = strained(plain, &at_rest(plain), all * (apex + 0.01), steps);
        let half = strained(plain, &far, all * -0.004, steps);
        assert!((half.kirchhoff.sum() / 3.0 - (tension / 3.0 - k * 0.012)).abs() < 1e-11 * k);
    }
    opened
}

#[test]
fn what_has_come_apart_closes_first() {
    // c cot φ, k/η, and the tips of the cut-offs, as the sum of three stresses.
    let root = 3.0_f64.sqrt();
    for (cohesion, tension) in [(0.0, 0.0), (2.0, 3.0 * 2.0 * root)] {
        check_isotropic(&sand(cohesion), &sand(cohesion), tension);
    }
    let cut = sand(2.0).with_cut_off(0.5).expect("in range");
    check_isotropic(&cut, &cut, 1.5);
    for strength in [0.0, 2.0] {
        check_isotropic(&cone(strength), &cone(strength), 3.0 * strength);
    }
    // A cut-off of the cone bears shear beside the largest tension, so that there is nothing to close.
    let cut = cone(2.0).with_cut_off(0.5).expect("in range");
    assert_eq!(cut.apex(&PlasticStrain::default()), None);
}

/// Without lateral strain: v is the logarithm of the volume since the point came apart. In steps of any length the stress is
/// zero until it has closed, and then that of a fresh point, whose K₀ is ν/(1 − ν) > K_a.
#[test]
fn a_crack_that_has_closed_bears_as_before() {
    let law = VolumeCorrected::new(sand(0.0));
    let axis = Vector3::new(1.0, 0.0, 0.0);
    let fresh = strained(&law, &at_rest(&law), axis * -1e-3, 1);
    assert!(fresh.kirchhoff[0] < -1.0 && !fresh.plastic);
    for steps in [1, 4, 21] {
        let open = strained(&law, &at_rest(&law), axis * 0.02, steps);
        assert!((open.history.volume - 0.02).abs() < 1e-14 && open.kirchhoff == Vector3::zeros());
        let nearly = strained(&law, &open, axis * -0.019, steps);
        assert!((nearly.history.volume - 0.001).abs() < 1e-14 && nearly.kirchhoff == Vector3::zeros());
        let pressed = strained(&law, &open, axis * -0.021, steps);
        assert_eq!(pressed.history.volume, 0.0);
        assert!((pressed.kirchhoff - fresh.kirchhoff).amax() < 1e-9, "{steps}: {:?}", pressed.kirchhoff);
        // Shear does not close it.
        let sheared = strained(&law, &open, Vector3::new(0.3, -0.3, -0.01), steps);
        assert!((sheared.history.volume - 0.01).abs() < 1e-14 && sheared.kirchhoff == Vector3::zeros());
    }
}

#[test]
fn tangents_of_points_that_close_are_derivatives() {
    let law = VolumeCorrected::new(sand(1.0));
    let history = Opened { law: PlasticStrain::default(), volume: 0.012 };
    let (mut numbers, mut closed, mut wrong) = (Numbers(11), 0, 0);
    for _ in 0..300 {
        let trial = numbers.strain(0.03).add_scalar(-0.006);
        let update = law.update(&trial, &history).expect("a return");
        closed += usize::from(update.history.volume == 0.0);
        assert!(update.plastic);
        let h = 1e-7;
        let difference = Matrix3::from_columns(&[0, 1, 2].map(|b| {
            let at = |sign: f64| {
                let mut moved = trial;
                moved[b] += sign * h;
                law.update(&moved, &history).expect("a return").kirchhoff
            };
            (at(1.0) - at(-1.0)) / (2.0 * h)
        }));
        let error = (update.tangent - difference).amax() / elasticity().p_wave();
        wrong += usize::from(error > 1e-6);
        for (pair, (i, j)) in [(0, 1), (1, 2), (2, 0)].into_iter().enumerate() {
            let (stress, gap) = (update.kirchhoff[i] - update.kirchhoff[j], trial[i] - trial[j]);
            assert!((stress - update.secant[pair] * gap).abs() < 1e-9);
        }
    }
    assert!(closed > 50 && wrong <= 2, "{closed} closed; {wrong} at borders of two regions");
}

#[test]
fn a_point_that_is_not_apart_has_the_bits_of_the_plain_law() {
    let (plain, law) = (sand(1.0), VolumeCorrected::new(sand(1.0)));
    let mut numbers = Numbers(5);
    for _ in 0..500 {
        let trial = numbers.strain(0.05);
        let theirs = plain.update(&trial, &PlasticStrain::default()).expect("a return");
        let ours = law.update(&trial, &Opened::default()).expect("a return");
        assert_eq!(
            (ours.kirchhoff, ours.tangent, ours.secant),
            (theirs.kirchhoff, theirs.tangent, theirs.secant)
        );
        assert_eq!((ours.plastic, ours.history.law), (theirs.plastic, theirs.history));
    }
}

#[test]
fn the_opened_volume_is_stored_and_shown() {
    let law = VolumeCorrected::new(sand(1.0));
    let names: Vec<_> = law.history_fields().iter().map(|field| field.name).collect();
    assert_eq!(names, ["plastic_strain", "opened_volume"]);
    let history = Opened { law: PlasticStrain(0.5), volume: 0.25 };
    let (mut numbers, mut shown) = (Vec::new(), Vec::new());
    history.store(&mut numbers);
    law.show(&history, &mut shown);
    assert_eq!((&numbers, &shown), (&vec![0.5, 0.25], &vec![0.5, 0.25]));
    assert_eq!(Opened::restore(&numbers), Ok(history));
    assert!(Opened::<PlasticStrain>::restore(&[0.5, -0.25]).is_err());
}

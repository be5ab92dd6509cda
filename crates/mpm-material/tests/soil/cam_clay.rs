//! Modified Cam-Clay: states that are hard to return from, closed forms, energy in cycles.

use crate::random::Numbers;
use mpm_material::lanes::{LANES, Lanes, Work, four, vectorised};
use mpm_material::{CamClay, CamClayParameters, LaneUpdate, Material, NoReturn, Preconsolidation};
use nalgebra::Vector3;

const PARAMETERS: CamClayParameters = CamClayParameters {
    critical_ratio: 0.9,
    compression: 0.15,
    swelling: 0.03,
    shear: 1500.0,
    shear_ratio: 0.0,
    reference_pressure: 20.0,
    preconsolidation: 80.0,
};

fn clay(shear: f64, shear_ratio: f64) -> CamClay {
    CamClay::new(CamClayParameters { shear, shear_ratio, ..PARAMETERS }).expect("in range")
}

fn p_and_q(tau: &Vector3<f64>) -> (f64, f64) {
    let p = -tau.sum() / 3.0;
    (p, 1.5_f64.sqrt() * tau.add_scalar(p).norm())
}

/// f/p_c².
fn overshoot(law: &CamClay, tau: &Vector3<f64>, p_c: f64) -> f64 {
    let (p, q) = p_and_q(tau);
    let along = q / law.parameters().critical_ratio;
    (along * along + p * (p - p_c)) / (p_c * p_c)
}

/// A clay that is soft or stiff, an elastic strain down to pressures of 1e-4 of p_c = 100, and a size of strains up to 3.
fn hostile(numbers: &mut Numbers) -> (CamClay, Vector3<f64>, f64) {
    let swelling = numbers.of_any_size(0.005, 0.1);
    let [shear, ratio] = match numbers.between(0.0, 3.0) as u32 {
        0 => [numbers.of_any_size(10.0, 1e5), 0.0],
        1 => [0.0, numbers.of_any_size(1.0, 200.0)],
        _ => [numbers.of_any_size(10.0, 1e5), numbers.of_any_size(1.0, 200.0)],
    };
    let parameters = CamClayParameters {
        critical_ratio: numbers.between(0.5, 1.6),
        swelling,
        compression: swelling * numbers.of_any_size(1.2, 20.0),
        shear,
        shear_ratio: ratio,
        ..PARAMETERS
    };
    let law = CamClay::new(parameters).expect("in range");
    let p = 100.0 * numbers.of_any_size(1e-4, 1.0);
    let rest = law.elastic_strain(&Vector3::repeat(-p), &Preconsolidation(1.0)).expect("compression");
    (law, rest, numbers.of_any_size(1e-3, 3.0))
}

/// Wet and dry.
#[test]
fn every_hostile_state_returns() {
    let mut numbers = Numbers(6);
    let mut plastic = 0;
    for _ in 0..3000 {
        let (law, rest, size) = hostile(&mut numbers);
        let (p_c, parameters, trial) = (100.0, *law.parameters(), rest + numbers.strain(size));
        let Ok(update) = law.update(&trial, &Preconsolidation(p_c)) else {
            // Swollen so far that the pressure is below all measure.
            assert!(trial.sum() > 100.0 * parameters.swelling, "{parameters:?}, {trial:?}");
            continue;
        };
        let (p, q) = p_and_q(&update.kirchhoff);
        assert!(p > 0.0 && p.is_finite() && q.is_finite(), "{parameters:?}, {trial:?}: p {p}, q {q}");
        assert!(update.tangent.iter().all(|d| d.is_finite()), "{parameters:?}, {trial:?}");
        let f = overshoot(&law, &update.kirchhoff, update.history.0);
        let scale = 1.0_f64.max((p / update.history.0).powi(2));
        assert!(f <= 1e-9 * scale, "{parameters:?}, {trial:?}: f {f:e}");
        if update.plastic {
            plastic += 1;
            // Backward Euler's own equations: flow along the normal, hardening with plastic volume.
            let flow = trial - update.elastic_strain;
            let hardening = parameters.compression - parameters.swelling;
            let expected = p_c * (-flow.sum() / hardening).exp();
            assert!((update.history.0 / expected - 1.0).abs() < 1e-9, "{parameters:?}, {trial:?}: hardening");
            let m2 = parameters.critical_ratio * parameters.critical_ratio;
            let normal =
                (update.kirchhoff.add_scalar(p) * (3.0 / m2)).add_scalar(-(2.0 * p - update.history.0) / 3.0);
            let aligned = normal.dot(&flow) / (normal.norm() * flow.norm());
            if flow.norm() > 1e-6 {
                assert!(aligned > 1.0 - 1e-7, "{parameters:?}, {trial:?}: flow turned by {aligned}");
            }
        }
    }
    assert!(plastic > 700, "{plastic}");
}

struct Four<'a>(&'a CamClay, &'a [Vector3<f64>; LANES], &'a Preconsolidation);

impl Work for Four<'_> {
    type Output = Result<LaneUpdate<Preconsolidation>, NoReturn>;

    #[inline(always)]
    fn run<const VECTORS: bool>(self) -> Self::Output {
        let Self(law, points, history) = self;
        law.update_lanes(&[0, 1, 2].map(|a| Lanes(four(|k| points[k][a]))), [history; LANES])
    }
}

/// Some are elastic, some take more steps than others, some get stuck and are bracketed, some do not return.
#[test]
fn hostile_states_side_by_side_have_the_bits_of_each() {
    let (mut numbers, history) = (Numbers(8), Preconsolidation(100.0));
    let (mut plastic, mut mixed, mut refused) = (0, 0, 0);
    for turn in 0..1500 {
        let (law, rest, size) = hostile(&mut numbers);
        let mut points = std::array::from_fn(|_| rest + numbers.strain(size));
        if turn % 50 == 0 {
            // Swollen so far that the pressure is below all measure.
            points[turn / 50 % LANES] += Vector3::repeat(20.0);
        }
        let each = points.each_ref().map(|strain| law.update(strain, &history));
        let n_plastic = each.iter().flatten().filter(|one| one.plastic).count();
        for all in [vectorised(Four(&law, &points, &history)), Four(&law, &points, &history).run::<false>()] {
            match all {
                Ok(all) => {
                    let expected = LaneUpdate::of(each.map(|one| one.expect("it answers them together")));
                    assert!(all == expected, "{:?}, {points:?}: {all:?}, alone {expected:?}", law.parameters());
                }
                Err(reason) => {
                    assert!(each.contains(&Err(reason)));
                    refused += 1;
                }
            }
        }
        plastic += n_plastic;
        mixed += usize::from(n_plastic > 0 && n_plastic < LANES);
    }
    assert!(plastic > 1500 && mixed > 500 && refused > 10, "{plastic}, {mixed}, {refused}");
}

/// A closed path of elastic strain returns the work that was put in, and leaves p_c as it was.
#[test]
fn elastic_cycles_make_no_energy() {
    for law in [clay(1500.0, 0.0), clay(0.0, 25.0), clay(500.0, 10.0)] {
        let centre = law.elastic_strain(&Vector3::repeat(-60.0), &Preconsolidation(1.0)).expect("compression");
        let axis =
            |k: usize, turn: f64| 2e-3 * (turn + 2.1 * k as f64).sin() + 1e-3 * (2.0 * turn + k as f64).cos();
        let mut work = 0.0;
        let mut moved = 0.0;
        // The trapezoidal rule is exact to round-off for what is periodic and smooth.
        const STEPS: usize = 400;
        for k in 0..STEPS {
            let turn = std::f64::consts::TAU * k as f64 / STEPS as f64;
            let at = |turn: f64| Vector3::new(axis(0, turn), axis(1, turn), axis(2, turn));
            let rate = |k: usize| {
                let (a, b) = ((turn + 2.1 * k as f64).cos(), (2.0 * turn + k as f64).sin());
                2e-3 * a - 2e-3 * b
            };
            let update = law.update(&(centre + at(turn)), &Preconsolidation(200.0)).expect("a return");
            assert!(!update.plastic && update.history.0 == 200.0);
            let error = (update.tangent - update.tangent.transpose()).amax();
            assert!(error < 1e-12 * update.tangent.amax(), "an elastic tangent is symmetric");
            let power = update.kirchhoff.dot(&Vector3::new(rate(0), rate(1), rate(2)));
            work += power / STEPS as f64;
            moved += power.abs() / STEPS as f64;
        }
        assert!(work.abs() < 1e-14 * moved, "{work:e} of {moved:e}");
    }
}

/// At the critical state shear changes nothing but shape; from elsewhere q/p goes to M.
#[test]
fn shear_ends_at_the_critical_state() {
    for law in [clay(1500.0, 0.0), clay(0.0, 25.0)] {
        let m = law.parameters().critical_ratio;
        let shape = Vector3::new(1.0, 1.0, -2.0) / 3.0;
        let critical = shape * (m * 40.0) + Vector3::repeat(-40.0);
        let mut strain = law.elastic_strain(&critical, &Preconsolidation(1.0)).expect("compression");
        let mut history = Preconsolidation(80.0);
        for _ in 0..20 {
            let update = law.update(&(strain + shape * 1e-3), &history).expect("a return");
            assert!(update.plastic);
            (strain, history) = (update.elastic_strain, update.history);
            assert!((update.kirchhoff - critical).norm() < 1e-11 * critical.norm());
            assert!((history.0 - 80.0).abs() < 1e-11 * 80.0);
        }
        for p_c in [41.0, 400.0] {
            let mut strain =
                law.elastic_strain(&Vector3::repeat(-40.0), &Preconsolidation(1.0)).expect("compression");
            let (mut history, mut tau) = (Preconsolidation(p_c), Vector3::zeros());
            for _ in 0..4000 {
                let update = law.update(&(strain + shape * 1e-3), &history).expect("a return");
                (strain, history, tau) = (update.elastic_strain, update.history, update.kirchhoff);
            }
            let (p, q) = p_and_q(&tau);
            assert!((q / p / m - 1.0).abs() < 1e-6, "{}", q / p);
        }
    }
}

/// ln p against ln J falls by λ in first compression and by κ in unloading, whatever the step.
#[test]
fn isotropic_lines_are_straight() {
    let law = clay(1500.0, 0.0);
    let (lambda, kappa) = (law.parameters().compression, law.parameters().swelling);
    let start = Preconsolidation(60.0);
    let rest = law.elastic_strain(&Vector3::repeat(-60.0), &Preconsolidation(1.0)).expect("compression");
    for size in [1e-3, 0.1, 0.6] {
        let loaded = law.update(&rest.add_scalar(-size / 3.0), &start).expect("a return");
        let (p, _) = p_and_q(&loaded.kirchhoff);
        assert!(((p / 60.0).ln() * lambda / size - 1.0).abs() < 1e-12);
        assert!((loaded.history.0 / p - 1.0).abs() < 1e-13);
        let unloaded = law
            .update(&loaded.elastic_strain.add_scalar(0.3 * kappa / 3.0), &loaded.history)
            .expect("a return");
        let (less, _) = p_and_q(&unloaded.kirchhoff);
        assert!(!unloaded.plastic && ((p / less).ln() - 0.3).abs() < 1e-13);
    }
}

/// The yield ellipse is met at any step in undrained shear: κ ln(p/p₀) − (3/2) g ε_s,e² + (λ − κ) ln(p_c/p_c0) = 0.
#[test]
fn undrained_paths_keep_the_sum_of_volumes() {
    let law = clay(200.0, 25.0);
    let parameters = *law.parameters();
    let shape = Vector3::new(1.0, 1.0, -2.0) / 3.0;
    for (p_0, p_c0) in [(60.0, 60.0), (20.0, 160.0)] {
        for size in [1e-3, 0.05, 0.5] {
            let mut strain =
                law.elastic_strain(&Vector3::repeat(-p_0), &Preconsolidation(1.0)).expect("compression");
            let mut history = Preconsolidation(p_c0);
            for _ in 0..10 {
                let update = law.update(&(strain + shape * size), &history).expect("a return");
                (strain, history) = (update.elastic_strain, update.history);
                let (p, _) = p_and_q(&update.kirchhoff);
                let shear = (2.0_f64 / 3.0).sqrt() * strain.add_scalar(-strain.sum() / 3.0).norm();
                let sum = parameters.swelling * (p / p_0).ln() - 1.5 * parameters.shear_ratio * shear * shear
                    + (parameters.compression - parameters.swelling) * (history.0 / p_c0).ln();
                assert!(sum.abs() < 1e-14, "{p_0}, {size}: {sum:e}");
            }
        }
    }
}

#[test]
fn flow_keeps_the_direction_of_the_trial_deviator() {
    let law = clay(500.0, 10.0);
    let mut numbers = Numbers(7);
    for _ in 0..500 {
        let trial = numbers.strain(0.1);
        let update = law.update(&trial, &Preconsolidation(60.0)).expect("a return");
        let deviator = |t: &Vector3<f64>| t.add_scalar(-t.sum() / 3.0).normalize();
        let error = (deviator(&trial) - deviator(&update.kirchhoff)).norm();
        let digits =
            1e-14 * update.kirchhoff.norm() / update.kirchhoff.add_scalar(-update.kirchhoff.sum() / 3.0).norm();
        assert!(error < 1e-11 + 10.0 * digits, "{trial:?}: {error:e}");
    }
}

#[test]
fn parameters_out_of_range_are_named() {
    let refused = [
        (CamClayParameters { critical_ratio: 0.0, ..PARAMETERS }, "critical_ratio"),
        (CamClayParameters { compression: 0.03, ..PARAMETERS }, "compression"),
        (CamClayParameters { swelling: 0.0, ..PARAMETERS }, "swelling"),
        (CamClayParameters { shear: 0.0, ..PARAMETERS }, "shear"),
        (CamClayParameters { shear_ratio: -1.0, ..PARAMETERS }, "shear_ratio"),
        (CamClayParameters { reference_pressure: 0.0, ..PARAMETERS }, "reference_pressure"),
        (CamClayParameters { preconsolidation: f64::NAN, ..PARAMETERS }, "preconsolidation"),
    ];
    for (parameters, name) in refused {
        let error = CamClay::new(parameters).expect_err("out of range");
        assert_eq!(error.name, name);
    }
    assert!(clay(1500.0, 0.0).elastic_strain(&Vector3::zeros(), &Preconsolidation(1.0)).is_err());
}

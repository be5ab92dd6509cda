//! What holds for the return of every law that yields, on many states of all regions.

use crate::random::Numbers;
use mpm_material::{
    CamClay, CamClayParameters, ConeMatch, DruckerPrager, Elasticity, Material, MohrCoulomb, PlasticShear,
    PlasticStrain, Preconsolidation, Tresca, UndrainedStrength, VonMises,
};
use nalgebra::Vector3;

const STATES: usize = 800;

/// Of a stress and a history: the largest violation [F/L²], and the strength that it is compared with.
type Overshoot<'a, H> = dyn Fn(&Vector3<f64>, &H) -> (f64, f64) + 'a;

/// A law at work: its yield function, the size of its stresses, a history, and the size of strains to try.
struct Case<'a, M: Material> {
    name: &'a str,
    law: M,
    history: M::History,
    size: f64,
    overshoot: &'a Overshoot<'a, M::History>,
}

/// Something that is asked of each of them.
trait Question {
    fn ask<M: Material>(&self, case: &Case<'_, M>);
}

fn elasticity(young: f64, poisson: f64) -> Elasticity {
    Elasticity::from_young_poisson(young, poisson).expect("in range")
}

/// Largest minus smallest.
fn range(tau: &Vector3<f64>) -> f64 {
    tau.max() - tau.min()
}

fn p_and_q(tau: &Vector3<f64>) -> (f64, f64) {
    let p = -tau.sum() / 3.0;
    (p, 1.5_f64.sqrt() * tau.add_scalar(p).norm())
}

fn mohr_coulomb(c: f64, phi: f64, tau: &Vector3<f64>) -> f64 {
    let (sin, cos) = phi.to_radians().sin_cos();
    tau.max() * (1.0 + sin) - tau.min() * (1.0 - sin) - 2.0 * c * cos
}

fn cam_clay(shear: f64, shear_ratio: f64) -> CamClay {
    CamClay::new(CamClayParameters {
        critical_ratio: 0.9,
        compression: 0.15,
        swelling: 0.03,
        shear,
        shear_ratio,
        reference_pressure: 20.0,
        preconsolidation: 80.0,
    })
    .expect("in range")
}

/// Strengths of their own, not those of the tables.
fn of_every_law(question: &impl Question) {
    of_undrained_strength(question);
    of_friction(question);
    of_cam_clay(question);
}

fn of_undrained_strength(question: &impl Question) {
    let stiff = elasticity(2e4, 0.3);
    let strengths = [
        UndrainedStrength::perfect(30.0),
        UndrainedStrength::linear(30.0, -900.0, 9.0),
        UndrainedStrength::remoulding(30.0, 0.3, 0.2),
    ];
    for (name, strength) in ["perfect", "linear", "remoulding"].into_iter().zip(strengths) {
        let strength = strength.expect("in range");
        question.ask(&Case {
            name: &format!("von Mises, {name}"),
            law: VonMises::with_strength(stiff, strength).expect("in range"),
            history: PlasticStrain(0.01),
            size: 0.1,
            overshoot: &|tau, history| {
                let s_u = strength.at(2.0_f64.sqrt() * history.0);
                (p_and_q(tau).1 / 3.0_f64.sqrt() - s_u, s_u)
            },
        });
        question.ask(&Case {
            name: &format!("Tresca, {name}"),
            law: Tresca::new(stiff, strength).expect("in range"),
            history: PlasticShear(0.01),
            size: 0.1,
            overshoot: &|tau, history| (range(tau) - 2.0 * strength.at(history.0), strength.at(history.0)),
        });
    }
}

fn of_friction(question: &impl Question) {
    let stiff = elasticity(2e4, 0.3);
    for (c, phi, psi, cut_off) in [
        (10.0, 25.0, 5.0, None),
        (10.0, 25.0, 25.0, None),
        (0.0, 40.0, 0.0, None),
        (10.0, 0.0, 0.0, None),
        (10.0, 25.0, 5.0, Some(6.0)),
        (10.0, 25.0, 5.0, Some(0.0)),
        (10.0, 0.0, 0.0, Some(2.0)),
    ] {
        let mut law = MohrCoulomb::new(stiff, c, phi, psi).expect("in range");
        if let Some(cut_off) = cut_off {
            law = law.with_cut_off(cut_off).expect("in range");
        }
        question.ask(&Case {
            name: &format!("Mohr-Coulomb, c {c}, phi {phi}, psi {psi}, cut-off {cut_off:?}"),
            law,
            history: PlasticStrain(0.01),
            size: 0.05,
            overshoot: &|tau, _| {
                let tension = tau.max() - cut_off.unwrap_or(f64::INFINITY);
                (mohr_coulomb(c, phi, tau).max(tension), c)
            },
        });
    }
    for (eta, flow, k, tension) in
        [(1.1, 0.3, 10.0, None), (1.1, 1.1, 10.0, None), (1.1, 0.0, 0.0, None), (1.1, 0.3, 10.0, Some(2.0))]
    {
        let mut law = DruckerPrager::new(stiff, eta, flow, k).expect("in range");
        if let Some(tension) = tension {
            law = law.with_cut_off(tension).expect("in range");
        }
        question.ask(&Case {
            name: &format!("Drucker-Prager, eta {eta}, {flow}, k {k}, cut-off {tension:?}"),
            law,
            history: PlasticStrain(0.01),
            size: 0.05,
            overshoot: &|tau, _| {
                let (p, q) = p_and_q(tau);
                ((q - eta * p - k).max(-p - tension.unwrap_or(k / eta)), k)
            },
        });
    }
}

fn of_cam_clay(question: &impl Question) {
    for (g0, g) in [(1500.0, 0.0), (0.0, 25.0), (500.0, 10.0)] {
        let law = cam_clay(g0, g);
        question.ask(&Case {
            name: &format!("Cam-Clay, G0 {g0}, g {g}"),
            law,
            history: Preconsolidation(80.0),
            size: 0.1,
            overshoot: &|tau, history| {
                let (p, q) = p_and_q(tau);
                let f = (q / 0.9).powi(2) + p * (p - history.0);
                (f / p.max(q).max(history.0), history.0)
            },
        });
    }
}

struct Admissible;

impl Question for Admissible {
    fn ask<M: Material>(&self, case: &Case<'_, M>) {
        let mut numbers = Numbers(1);
        let mut yielded = 0;
        for _ in 0..STATES {
            let trial = numbers.strain(case.size);
            let update = case.law.update(&trial, &case.history).expect("a return");
            let (overshoot, strength) = (case.overshoot)(&update.kirchhoff, &update.history);
            // The trial stress is of this size.
            let reach = (case.law.elasticity().p_wave() * trial.amax())
                .min(1e6 * update.kirchhoff.amax().max(strength));
            let scale = update.kirchhoff.amax().max(strength).max(reach);
            assert!(overshoot <= 2e-12 * scale, "{}: {trial:?}, {overshoot:e}", case.name);
            yielded += usize::from(update.plastic);
            let again = case.law.update(&update.elastic_strain, &update.history).expect("a return");
            let error = (again.kirchhoff - update.kirchhoff).norm();
            assert!(error <= 1e-11 * scale, "{}: {trial:?} returns to another stress, {error:e}", case.name);
            if strength > 0.0 {
                assert!(!again.plastic, "{}: {trial:?} yields again", case.name);
            }
        }
        assert!(yielded > STATES / 10 && yielded < STATES, "{}: {yielded}", case.name);
    }
}

#[test]
fn stresses_are_admissible_and_elastic_from_there() {
    of_every_law(&Admissible);
}

struct Permuted;

impl Question for Permuted {
    fn ask<M: Material>(&self, case: &Case<'_, M>) {
        // The axis that each axis becomes, and the pair that each pair (0,1), (1,2), (2,0) becomes.
        let turns =
            [([1, 2, 0], [1, 2, 0]), ([2, 0, 1], [2, 0, 1]), ([1, 0, 2], [0, 2, 1]), ([2, 1, 0], [1, 0, 2])];
        let mut numbers = Numbers(2);
        for _ in 0..STATES {
            let trial = numbers.strain(case.size);
            let still = case.law.update(&trial, &case.history).expect("a return");
            let scale = still.kirchhoff.amax().max(case.law.elasticity().p_wave() * 1e-3);
            for (axes, pairs) in turns {
                let mut turned = Vector3::zeros();
                (0..3).for_each(|a| turned[axes[a]] = trial[a]);
                let moved = case.law.update(&turned, &case.history).expect("a return");
                let size = still.tangent.amax().max(case.law.elasticity().p_wave());
                for a in 0..3 {
                    let error = (moved.kirchhoff[axes[a]] - still.kirchhoff[a]).abs();
                    assert!(error <= 1e-12 * scale, "{}: {trial:?}, stress {error:e}", case.name);
                    let error = (moved.secant[pairs[a]] - still.secant[a]).abs();
                    assert!(error <= 1e-9 * size, "{}: {trial:?}, secant {a} {error:e}", case.name);
                    for b in 0..3 {
                        let error = (moved.tangent[(axes[a], axes[b])] - still.tangent[(a, b)]).abs();
                        assert!(error <= 1e-9 * size, "{}: {trial:?}, tangent {error:e}", case.name);
                    }
                }
            }
        }
    }
}

#[test]
fn axes_have_equal_rights() {
    of_every_law(&Permuted);
}

struct Differentiated;

impl Question for Differentiated {
    /// Differences to both sides must agree with each other, or a border of two regions lies between them.
    fn ask<M: Material>(&self, case: &Case<'_, M>) {
        let step = 1e-6 * case.size;
        let mut numbers = Numbers(3);
        let mut compared = 0;
        for _ in 0..STATES {
            let trial = numbers.strain(case.size);
            let still = case.law.update(&trial, &case.history).expect("a return");
            let size = still.tangent.amax().max(case.law.elasticity().p_wave());
            for b in 0..3 {
                let at = |sign: f64| {
                    let mut moved = trial;
                    moved[b] += sign * step;
                    case.law.update(&moved, &case.history).expect("a return").kirchhoff
                };
                let (ahead, behind) = ((at(1.0) - still.kirchhoff) / step, (still.kirchhoff - at(-1.0)) / step);
                if (ahead - behind).amax() > 1e-3 * size {
                    continue;
                }
                let error = (0.5 * (ahead + behind) - still.tangent.column(b)).amax();
                assert!(error < 1e-5 * size, "{}: {trial:?}, column {b}: {error:e}", case.name);
                compared += 1;
            }
        }
        assert!(compared > 2 * STATES, "{}: {compared}", case.name);
    }
}

#[test]
fn tangents_are_derivatives() {
    of_every_law(&Differentiated);
}

struct Secants;

impl Question for Secants {
    fn ask<M: Material>(&self, case: &Case<'_, M>) {
        let mut numbers = Numbers(4);
        for _ in 0..STATES {
            let trial = numbers.strain(case.size);
            let update = case.law.update(&trial, &case.history).expect("a return");
            let size = update.kirchhoff.amax().max(case.law.elasticity().p_wave() * trial.amax());
            for (pair, (a, b)) in [(0, 1), (1, 2), (2, 0)].into_iter().enumerate() {
                let difference = update.kirchhoff[a] - update.kirchhoff[b];
                let error = (update.secant[pair] * (trial[a] - trial[b]) - difference).abs();
                assert!(error <= 1e-12 * size, "{}: {trial:?}, pair {pair}: {error:e}", case.name);
            }
        }
    }
}

#[test]
fn secants_are_quotients() {
    of_every_law(&Secants);
}

struct Continuous;

impl Question for Continuous {
    /// Along lines through all regions no step of the stress exceeds what a stiffness allows.
    fn ask<M: Material>(&self, case: &Case<'_, M>) {
        const STEPS: usize = 1500;
        let mut numbers = Numbers(5);
        for _ in 0..20 {
            let (from, to) = (numbers.strain(case.size), numbers.strain(case.size));
            let step = (to - from) / STEPS as f64;
            let mut last = case.law.update(&from, &case.history).expect("a return");
            for k in 1..=STEPS {
                let trial = from + step * k as f64;
                let next = case.law.update(&trial, &case.history).expect("a return");
                let stiffness =
                    last.tangent.norm().max(next.tangent.norm()).max(case.law.elasticity().p_wave());
                let jump = (next.kirchhoff - last.kirchhoff).norm();
                assert!(jump <= 2.0 * stiffness * step.norm(), "{}: {trial:?}, {jump:e}", case.name);
                last = next;
            }
        }
    }
}

#[test]
fn stresses_are_continuous_across_regions() {
    of_every_law(&Continuous);
}

/// The cone that meets Mohr–Coulomb in triaxial compression, and the one in extension, do so.
#[test]
fn matched_cones_meet_mohr_coulomb() {
    let stiff = elasticity(2e4, 0.3);
    let (c, phi) = (10.0, 25.0);
    for (at, axial) in [(ConeMatch::Compression, -1.0), (ConeMatch::Extension, 1.0)] {
        let cone = DruckerPrager::matched(stiff, at, c, phi, 0.0).expect("in range");
        let surface = MohrCoulomb::new(stiff, c, phi, 0.0).expect("in range");
        for size in [0.01, 0.02, 0.05] {
            let trial = Vector3::new(axial, -0.5 * axial, -0.5 * axial).add_scalar(-0.3) * size;
            let [ours, theirs] = [
                cone.update(&trial, &PlasticStrain(0.0)).expect("a return").kirchhoff,
                surface.update(&trial, &PlasticStrain(0.0)).expect("a return").kirchhoff,
            ];
            assert!((ours - theirs).norm() < 1e-12 * theirs.norm(), "{at:?}: {ours:?} {theirs:?}");
        }
    }
}

/// In plane strain both conditions of flow (associated; volume kept) are met by the cones that are named for it:
/// the limit of a shear test at constant mean stress in the plane is Mohr–Coulomb's.
#[test]
fn matched_cones_fail_in_plane_strain_as_mohr_coulomb_does() {
    let stiff = elasticity(2e4, 0.3);
    let (c, phi) = (10.0, 25.0_f64);
    let (sin, cos) = phi.to_radians().sin_cos();
    for (at, psi) in [(ConeMatch::PlaneStrain, phi), (ConeMatch::IsochoricPlaneStrain, 0.0)] {
        let cone = DruckerPrager::matched(stiff, at, c, phi, psi).expect("in range");
        // Steps in the plane, long enough that elastic strain along z is forgotten.
        let (mut strain, mut history) = (Vector3::repeat(-1e-3), PlasticStrain(0.0));
        let mut tau = Vector3::zeros();
        for _ in 0..400 {
            let update = cone.update(&(strain + Vector3::new(1e-3, -1e-3, 0.0)), &history).expect("a return");
            (strain, history, tau) = (update.elastic_strain, update.history, update.kirchhoff);
            // The mean of both is held, as a test at constant confinement does.
            let excess = 0.5 * (tau[0] + tau[1]) + 40.0;
            let lateral = excess / (2.0 * (stiff.lame() + stiff.shear()));
            strain -= Vector3::new(lateral, lateral, 0.0);
        }
        let (mean, radius) = (0.5 * (tau[0] + tau[1]), 0.5 * (tau[0] - tau[1]));
        let limit = c * cos - mean * sin;
        assert!((radius / limit - 1.0).abs() < 1e-3, "{at:?}: {radius} of {limit}");
    }
}

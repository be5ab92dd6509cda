//! Mohr–Coulomb's returns against an enumeration of all sets of active planes, and closed forms.

use crate::random::Numbers;
use mpm_material::{Elasticity, Material, MohrCoulomb, PlasticStrain, Tresca, UndrainedStrength};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

const C: f64 = 10.0;
const PHI: f64 = 25.0;

fn elasticity() -> Elasticity {
    Elasticity::from_young_poisson(2e4, 0.3).expect("in range")
}

/// A plane: normal, flow, strength.
type Plane = (Vector3<f64>, Vector3<f64>, f64);

fn planes(psi: f64, cut_off: f64) -> Vec<Plane> {
    let ((s, cos), t) = (PHI.to_radians().sin_cos(), psi.to_radians().sin());
    let mut planes = Vec::new();
    for i in 0..3 {
        for j in (0..3).filter(|&j| j != i) {
            let side = |sin: f64| {
                let mut normal = Vector3::zeros();
                normal[i] = 1.0 + sin;
                normal[j] = -1.0 + sin;
                normal
            };
            planes.push((side(s), side(t), 2.0 * C * cos));
        }
        let axis = Vector3::from_fn(|a, _| if a == i { 1.0 } else { 0.0 });
        planes.push((axis, axis, cut_off));
    }
    planes
}

/// The stresses of all sets of up to three planes whose multipliers are not negative, that violate no plane, and
/// that keep the order of the trial (a return that exchanges axes is not isotropic's limit of small steps).
fn enumerated(planes: &[Plane], trial: &Vector3<f64>) -> Vec<Vector3<f64>> {
    let elastic = Matrix3::from_diagonal_element(2.0 * elasticity().shear()).add_scalar(elasticity().lame());
    let reach = elastic * trial;
    let scale = reach.amax().max(C);
    let n = planes.len();
    let mut sets: Vec<Vec<usize>> = vec![vec![]];
    for a in 0..n {
        sets.push(vec![a]);
        for b in a + 1..n {
            sets.push(vec![a, b]);
            sets.extend((b + 1..n).map(|c| vec![a, b, c]));
        }
    }
    assert_eq!(sets.len(), 130);
    let mut found: Vec<Vector3<f64>> = Vec::new();
    for set in sets {
        if set.is_empty() {
            let is_elastic =
                planes.iter().all(|(normal, _, strength)| normal.dot(&reach) - strength <= 1e-12 * scale);
            found.extend(is_elastic.then_some(reach));
            continue;
        }
        let normals = DMatrix::from_fn(3, set.len(), |a, k| planes[set[k]].0[a]);
        let flows = DMatrix::from_fn(3, set.len(), |a, k| planes[set[k]].1[a]);
        let elastic = DMatrix::from_fn(3, 3, |a, b| elastic[(a, b)]);
        let excess = DVector::from_fn(set.len(), |k, _| planes[set[k]].0.dot(&reach) - planes[set[k]].2);
        let Some(multipliers) = (normals.transpose() * &elastic * &flows).lu().solve(&excess) else { continue };
        let tau = DVector::from_fn(3, |a, _| reach[a]) - elastic * flows * &multipliers;
        let tau = Vector3::new(tau[0], tau[1], tau[2]);
        let is_admissible =
            planes.iter().all(|(normal, _, strength)| normal.dot(&tau) - strength <= 1e-10 * scale);
        let is_pushed = multipliers.iter().all(|m| m * elasticity().shear() >= -1e-10 * scale);
        let is_ordered = (0..3).all(|a| {
            let b = (a + 1) % 3;
            (trial[a] - trial[b]).signum() * (tau[a] - tau[b]) >= -1e-9 * scale
        });
        if is_admissible
            && is_pushed
            && is_ordered
            && found.iter().all(|other| (other - tau).norm() > 1e-7 * scale)
        {
            found.push(tau);
        }
    }
    found
}

#[test]
fn the_only_admissible_stress_is_found() {
    for psi in [0.0, 5.0, PHI] {
        for cut_off in [0.0, 6.0, 15.0] {
            let law = MohrCoulomb::new(elasticity(), C, PHI, psi).and_then(|law| law.with_cut_off(cut_off));
            let law = law.expect("in range");
            let planes = planes(psi, cut_off);
            let mut numbers = Numbers(8);
            for _ in 0..40 {
                let trial = numbers.strain(0.03) + Vector3::repeat(numbers.between(-1e-3, 2e-3));
                let all = enumerated(&planes, &trial);
                assert_eq!(all.len(), 1, "psi {psi}, cut-off {cut_off}: {trial:?} {all:?}");
                let ours = law.update(&trial, &PlasticStrain(0.0)).expect("a return").kirchhoff;
                let error = (ours - all[0]).norm();
                let scale = C.max(2e4 * trial.amax());
                assert!(error < 1e-9 * scale, "psi {psi}, cut-off {cut_off}: {trial:?} {error:e}");
            }
        }
    }
}

/// Without friction it is Tresca's law, s_u = c.
#[test]
fn without_friction_it_is_tresca() {
    let law = MohrCoulomb::new(elasticity(), C, 0.0, 0.0).expect("in range");
    let strength = UndrainedStrength::perfect(C).expect("positive");
    let tresca = Tresca::new(elasticity(), strength).expect("in range");
    let mut numbers = Numbers(9);
    for _ in 0..2000 {
        let trial = numbers.strain(0.05);
        let ours = law.update(&trial, &PlasticStrain(0.0)).expect("a return");
        let theirs = tresca.update(&trial, &Default::default()).expect("a return");
        assert_eq!(ours.plastic, theirs.plastic);
        let scale = theirs.kirchhoff.amax().max(C);
        assert!((ours.kirchhoff - theirs.kirchhoff).norm() < 1e-12 * scale, "{trial:?}");
        assert!((ours.tangent - theirs.tangent).norm() < 1e-11 * 2e4, "{trial:?}");
        assert!((ours.secant - theirs.secant).norm() < 1e-9 * 2e4, "{trial:?}");
        assert!((ours.elastic_strain - theirs.elastic_strain).norm() < 1e-15 + 1e-13 * trial.norm());
    }
}

/// Compression and extension at constant lateral stress: strengths σ₁ = σ₃ K_p + 2c √K_p, rates of dilation
/// −dε_v/dε_1 = 2t/(1 − t) and 2t/(1 + t).
#[test]
fn triaxial_strength_and_dilation() {
    let psi = 8.0_f64;
    let law = MohrCoulomb::new(elasticity(), C, PHI, psi).expect("in range");
    let (s, t) = (PHI.to_radians().sin(), psi.to_radians().sin());
    let passive = (1.0 + s) / (1.0 - s);
    let cell = -50.0;
    for (sign, strength, rate) in [
        (-1.0, cell * passive - 2.0 * C * passive.sqrt(), 2.0 * t / (1.0 - t)),
        (1.0, cell / passive + 2.0 * C / passive.sqrt(), 2.0 * t / (1.0 + t)),
    ] {
        let mut strain = Vector3::repeat(cell / (3.0 * elasticity().bulk()));
        let (mut volume, mut last) = (0.0, 0.0);
        for _ in 0..100 {
            // Lateral strain such that the lateral stress is that of the cell: secant steps.
            let at = |lateral: f64| {
                law.update(&(strain + Vector3::new(sign * 1e-4, lateral, lateral)), &PlasticStrain(0.0))
                    .expect("a return")
            };
            let (mut x, mut y) = (-0.3 * sign * 1e-4, 0.1 * sign * 1e-4);
            for _ in 0..50 {
                let (fx, fy) = (at(x).kirchhoff[1] - cell, at(y).kirchhoff[1] - cell);
                if fx == fy || fy.abs() < 1e-11 {
                    break;
                }
                (x, y) = (y, y - fy * (y - x) / (fy - fx));
            }
            let update = at(y);
            volume = 2.0 * y + sign * 1e-4;
            last = update.kirchhoff[0];
            strain = update.elastic_strain;
        }
        assert!((last - strength).abs() < 1e-8 * strength.abs(), "{last} {strength}");
        assert!((volume / 1e-4 - rate).abs() < 1e-6, "{} {rate}", volume / 1e-4);
    }
}

#[test]
fn parameters_out_of_range_are_named() {
    let new = |c, phi, psi| MohrCoulomb::new(elasticity(), c, phi, psi);
    for (law, name) in [
        (new(-1.0, 30.0, 0.0), "cohesion"),
        (new(0.0, 0.0, 0.0), "cohesion"),
        (new(1.0, 90.0, 0.0), "friction"),
        (new(1.0, f64::NAN, 0.0), "friction"),
        (new(1.0, 30.0, 31.0), "dilation"),
        (new(1.0, 30.0, -1.0), "dilation"),
        (new(1.0, 45.0, 0.0).and_then(|law| law.with_cut_off(1.1)), "tensile_strength"),
        (new(1.0, 45.0, 0.0).and_then(|law| law.with_cut_off(-0.1)), "tensile_strength"),
    ] {
        assert_eq!(law.expect_err("out of range").name, name);
    }
    assert!(new(0.0, 30.0, 30.0).expect("in range").has_symmetric_tangent());
}

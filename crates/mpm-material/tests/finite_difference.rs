//! The spatial tangent of every law against central differences of its stress, one table.
//!
//! A nodal force is V⁰ P G with P = τ(ΔF b ΔFᵀ) ΔF⁻ᵀ and G the gradient at the start of the
//! step. Since g = ΔF⁻ᵀ G, the definition of a_ikjl says ∂P_iK/∂ΔF_jL = ΔF⁻ᵀ_kK a_ikjl ΔF⁻ᵀ_lL.
//! A new law is one more line in `every_law`.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use mpm_material::{Elasticity, Hencky, Material, PointParameters, SymmetricTensor, VonMises, respond};
use nalgebra::{Matrix3, Rotation3, SMatrix, Vector3};

const STEP: f64 = 1e-6;
/// Of the P-wave modulus.
const TOLERANCE: f64 = 1e-8;
const GAPS: [f64; 8] = [0.0, 1e-15, 1e-13, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2];

/// A state at the start of a step and the increment that is applied to it.
struct State {
    name: String,
    b_e: Matrix3<f64>,
    increment: Matrix3<f64>,
}

fn trial(state: &State, increment: &Matrix3<f64>) -> SymmetricTensor {
    let b = increment * state.b_e * increment.transpose();
    SymmetricTensor::from_matrix(&(b - Matrix3::identity()))
}

/// P = τ ΔF⁻ᵀ.
fn nominal<M: Material>(law: &M, state: &State, increment: &Matrix3<f64>) -> Matrix3<f64> {
    let history = law.initial(&PointParameters::at(Vector3::zeros()));
    let tau = respond(law, &trial(state, increment), &history).expect("it returns").kirchhoff.to_matrix();
    tau * increment.transpose().try_inverse().expect("increments are invertible")
}

fn check<M: Material, const D: usize>(law: &M, state: &State, plastic: bool) {
    let history = law.initial(&PointParameters::at(Vector3::zeros()));
    let response = respond(law, &trial(state, &state.increment), &history).expect("it returns");
    let name = &state.name;
    assert_eq!(response.plastic, plastic, "{name}");

    let a = response.tangent.spatial_tangent::<D>();
    let pull = state.increment.try_inverse().expect("increments are invertible");
    for (j, big_l) in (0..D * D).map(|m| (m / D, m % D)) {
        let at = |sign: f64| {
            let mut increment = state.increment;
            increment[(j, big_l)] += sign * STEP;
            nominal(law, state, &increment)
        };
        let difference = (at(1.0) - at(-1.0)) / (2.0 * STEP);
        for (i, big_k) in (0..D * D).map(|m| (m / D, m % D)) {
            let mut analytic = 0.0;
            for (k, l) in (0..D * D).map(|m| (m / D, m % D)) {
                analytic += pull[(big_k, k)] * a[k][l][(i, j)] * pull[(big_l, l)];
            }
            let error = (difference[(i, big_k)] - analytic).abs() / law.elasticity().p_wave();
            assert!(error < TOLERANCE, "{name}, D = {D}, dP_{i}{big_k}/dF_{j}{big_l}: {error:e}");
        }
    }
    check_symmetry(law, &a, name);
}

/// a_ikjl = a_jlik.
fn check_symmetry<M: Material, const D: usize>(law: &M, a: &[[SMatrix<f64, D, D>; D]; D], name: &str) {
    assert!(law.has_symmetric_tangent());
    for (k, l) in (0..D * D).map(|m| (m / D, m % D)) {
        let error = (a[k][l] - a[l][k].transpose()).amax();
        assert!(error < 1e-14 * law.elasticity().p_wave(), "{name}, D = {D}, block {k}{l}: {error:e}");
    }
}

/// In the plane the two-dimensional tangent is a part of the three-dimensional one.
fn check_part<M: Material>(law: &M, state: &State) {
    let history = law.initial(&PointParameters::at(Vector3::zeros()));
    let modes = respond(law, &trial(state, &state.increment), &history).expect("it returns").tangent;
    let (flat, full) = (modes.spatial_tangent::<2>(), modes.spatial_tangent::<3>());
    for (k, l) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let error = (flat[k][l] - full[k][l].fixed_view::<2, 2>(0, 0)).amax();
        assert!(error < 1e-14 * law.elasticity().p_wave(), "{}, block {k}{l}: {error:e}", state.name);
    }
}

/// b_e = R diag R⁻¹.
fn turned(values: [f64; 3], turn: &Rotation3<f64>) -> Matrix3<f64> {
    turn * Matrix3::from_diagonal(&values.into()) * turn.inverse()
}

fn plane_states() -> Vec<State> {
    let mut states = Vec::new();
    let stretch = Matrix3::new(1.3, 0.2, 0.0, -0.4, 0.9, 0.0, 0.0, 0.0, 1.0);
    for (name, increment) in [("at rest", Matrix3::identity()), ("moved", stretch)] {
        for angle in [0.0, 0.3, FRAC_PI_4, 1.2, FRAC_PI_2, -0.7] {
            let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), angle);
            let b_e = turned([1.7, 0.8, 1.1], &turn);
            states.push(State { name: format!("plane, {name}, {angle}"), b_e, increment });
        }
    }
    for gap in GAPS {
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), 0.6);
        let b_e = turned([1.2, 1.2 + gap, 0.7], &turn);
        let increment = Matrix3::identity();
        states.push(State { name: format!("plane, gap {gap:e}"), b_e, increment });
    }
    states
}

fn space_states() -> Vec<State> {
    let turn = Rotation3::from_euler_angles(0.4, -0.9, 1.7);
    let increment = Matrix3::new(1.2, 0.1, -0.2, 0.3, 0.9, 0.15, -0.1, 0.25, 1.1);
    let mut states = vec![
        State {
            name: "space, at rest".into(),
            b_e: turned([1.7, 0.8, 1.1], &turn),
            increment: Matrix3::identity(),
        },
        State { name: "space, moved".into(), b_e: turned([1.7, 0.8, 1.1], &turn), increment },
    ];
    for gap in GAPS {
        for place in 0..3 {
            let mut values = [1.2, 1.2 + gap, 0.7];
            values.rotate_right(place);
            states.push(State {
                name: format!("space, gap {gap:e} at {place}"),
                b_e: turned(values, &turn),
                increment: Matrix3::identity(),
            });
        }
    }
    states
}

/// All three values equal or nearly so: no deviator to yield with.
fn spherical_states() -> Vec<State> {
    let turn = Rotation3::from_euler_angles(0.4, -0.9, 1.7);
    GAPS.into_iter()
        .map(|gap| State {
            name: format!("spherical, gap {gap:e}"),
            b_e: turned([1.3, 1.3 - gap, 1.3 + gap], &turn),
            increment: Matrix3::identity(),
        })
        .collect()
}

fn check_law<M: Material>(law: &M, plastic: bool) {
    for state in plane_states() {
        check::<M, 2>(law, &state, plastic);
        check::<M, 3>(law, &state, plastic);
        check_part(law, &state);
    }
    for state in space_states() {
        // Gradients along z would need the part of the tangent that D = 2 leaves out.
        if state.increment == Matrix3::identity() {
            check::<M, 2>(law, &state, plastic);
        }
        check::<M, 3>(law, &state, plastic);
    }
    for state in spherical_states() {
        check::<M, 3>(law, &state, false);
    }
}

#[test]
fn every_law() {
    let elasticity = Elasticity::from_young_poisson(1000.0, 0.3).expect("in range");
    let von_mises = |radius| VonMises::new(elasticity, radius).expect("positive");
    check_law(&Hencky(elasticity), false);
    check_law(&von_mises(1e6), false);
    check_law(&von_mises(15.0), true);
}

//! What holds for any law and any state, on random positive definite states.

use mpm_material::{
    Elasticity, Hencky, Material, PlasticStrain, PointParameters, SymmetricTensor, VonMises, log_strain,
    respond,
};
use nalgebra::{Matrix3, Rotation3, Vector3};
use proptest::{array::uniform3, array::uniform9, prelude::*};

const YIELD_RADIUS: f64 = 15.0;

fn hencky() -> Hencky {
    Hencky(Elasticity::from_young_poisson(1000.0, 0.3).expect("in range"))
}

fn von_mises() -> VonMises {
    VonMises::new(hencky().0, YIELD_RADIUS).expect("positive")
}

/// Deformation gradients that neither invert nor flatten, with strains from 1e-8 to about 1.
fn deformation() -> impl Strategy<Value = Matrix3<f64>> {
    (uniform9(-0.8..0.8_f64), -8.0..0.0_f64)
        .prop_map(|(entries, exponent)| {
            Matrix3::identity() + Matrix3::from_row_slice(&entries) * 10.0_f64.powf(exponent)
        })
        .prop_filter("far from inversion", |f| f.determinant() > 0.2)
}

fn excess(f: &Matrix3<f64>) -> SymmetricTensor {
    let h = f - Matrix3::identity();
    SymmetricTensor::from_matrix(&(h + h.transpose() + h * h.transpose()))
}

fn deviatoric_norm(tau: &SymmetricTensor) -> f64 {
    let mean = tau.trace() / 3.0;
    (tau.to_matrix() - Matrix3::from_diagonal_element(mean)).norm()
}

fn b_e(excess: &SymmetricTensor) -> Matrix3<f64> {
    excess.to_matrix() + Matrix3::identity()
}

/// τ(R b Rᵀ) = R τ(b) Rᵀ, for the elastic state too, and the tangent turns with them.
fn check_objectivity<M: Material>(law: &M, f: &Matrix3<f64>, turn: &Matrix3<f64>) -> Result<(), TestCaseError> {
    let history = law.initial(&PointParameters::at(Vector3::zeros()));
    let turned = |t: &SymmetricTensor| SymmetricTensor::from_matrix(&(turn * t.to_matrix() * turn.transpose()));
    let still = respond(law, &excess(f), &history).expect("it returns");
    let moved = respond(law, &turned(&excess(f)), &history).expect("it returns");

    let error = moved.kirchhoff.to_matrix() - turned(&still.kirchhoff).to_matrix();
    prop_assert!(error.norm() <= 1e-13 * law.elasticity().p_wave(), "stress {:e}", error.norm());
    let error = moved.elastic_excess.to_matrix() - turned(&still.elastic_excess).to_matrix();
    prop_assert!(error.norm() <= 1e-13, "excess {:e}", error.norm());

    let (a, turned_a) = (still.tangent.spatial_tangent::<3>(), moved.tangent.spatial_tangent::<3>());
    for (k, l) in (0..9).map(|m| (m / 3, m % 3)) {
        let mut expected = Matrix3::zeros();
        for (m, n) in (0..9).map(|m| (m / 3, m % 3)) {
            expected += turn * a[m][n] * turn.transpose() * (turn[(k, m)] * turn[(l, n)]);
        }
        let error = (turned_a[k][l] - expected).norm();
        prop_assert!(error <= 1e-11 * law.elasticity().p_wave(), "tangent {error:e}");
    }
    Ok(())
}

proptest! {
    #[test]
    fn laws_are_objective(f in deformation(), angles in uniform3(-3.0..3.0_f64)) {
        let turn = Rotation3::from_euler_angles(angles[0], angles[1], angles[2]);
        check_objectivity(&hencky(), &f, turn.matrix())?;
        check_objectivity(&von_mises(), &f, turn.matrix())?;
    }

    #[test]
    fn stress_stays_on_or_below_the_yield_surface(f in deformation()) {
        let response = respond(&von_mises(), &excess(&f), &PlasticStrain::default()).expect("it returns");
        let rho = deviatoric_norm(&response.kirchhoff);
        prop_assert!(rho <= YIELD_RADIUS * (1.0 + 1e-12), "rho = {rho}");
        prop_assert_eq!(response.plastic, response.history.0 > 0.0);
    }

    #[test]
    fn plastic_flow_preserves_volume(f in deformation()) {
        let response = respond(&von_mises(), &excess(&f), &PlasticStrain::default()).expect("it returns");
        let before = b_e(&excess(&f)).determinant();
        let after = b_e(&response.elastic_excess).determinant();
        prop_assert!((after - before).abs() <= 1e-13 * before, "{before} to {after}");
        let growth = log_strain(&response.elastic_excess).trace() - log_strain(&excess(&f)).trace();
        prop_assert!(growth.abs() <= 1e-14);
    }

    #[test]
    fn stress_is_hencky_s_of_the_elastic_state_left(f in deformation()) {
        let first = respond(&von_mises(), &excess(&f), &PlasticStrain::default()).expect("it returns");
        let elastic = respond(&hencky(), &first.elastic_excess, &()).expect("it returns");
        let error = elastic.kirchhoff.to_matrix() - first.kirchhoff.to_matrix();
        prop_assert!(error.norm() <= 1e-12 * hencky().elasticity().p_wave(), "{:e}", error.norm());
    }

    #[test]
    fn logarithmic_volume_is_the_logarithm_of_det_f(f in deformation()) {
        let error = log_strain(&excess(&f)).trace() - f.determinant().ln();
        prop_assert!(error.abs() < 1e-13, "{error:e}");
    }

    /// The tangent along one random direction; `finite_difference.rs` goes through them all.
    #[test]
    fn tangent_is_the_derivative(f in deformation(), along in uniform9(-1.0..1.0_f64)) {
        let (law, history) = (von_mises(), PlasticStrain::default());
        let response = respond(&law, &excess(&f), &history).expect("it returns");
        let reach = respond(&hencky(), &excess(&f), &()).expect("it returns").kirchhoff;
        // The stress has a kink on the yield surface.
        prop_assume!((deviatoric_norm(&reach) / YIELD_RADIUS - 1.0).abs() > 1e-2);

        let l = Matrix3::from_row_slice(&along);
        let h = 1e-6;
        let at = |s: f64| {
            let step = Matrix3::identity() + l * (s * h);
            let tau = respond(&law, &excess(&(step * f)), &history).expect("it returns").kirchhoff.to_matrix();
            tau * step.transpose().try_inverse().expect("close to the identity")
        };
        let difference = (at(1.0) - at(-1.0)) / (2.0 * h);
        let a = response.tangent.spatial_tangent::<3>();
        for (k, row) in a.iter().enumerate() {
            let column = (0..3).map(|m| row[m] * l.column(m)).sum::<Vector3<f64>>();
            let error = (column - difference.column(k)).norm() / law.elasticity().p_wave();
            prop_assert!(error < 1e-7, "column {k}: {error:e}");
        }
    }
}

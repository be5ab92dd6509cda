//! Responses that are known in closed form, and digits at strains of any size.

use mpm_material::{Elasticity, Hencky, PlasticStrain, SymmetricTensor, VonMises, log_strain, respond};
use nalgebra::Matrix3;

const YOUNG: f64 = 1000.0;
const POISSON: f64 = 0.3;
const YIELD_RADIUS: f64 = 15.0;

fn elasticity() -> Elasticity {
    Elasticity::from_young_poisson(YOUNG, POISSON).expect("in range")
}

fn von_mises() -> VonMises {
    VonMises::new(elasticity(), YIELD_RADIUS).expect("positive")
}

fn diagonal(xx: f64, yy: f64, zz: f64) -> SymmetricTensor {
    SymmetricTensor { xx, yy, zz, ..SymmetricTensor::ZERO }
}

/// F = I + γ e_x⊗e_y.
fn simple_shear(gamma: f64) -> SymmetricTensor {
    SymmetricTensor { xx: gamma * gamma, xy: gamma, ..SymmetricTensor::ZERO }
}

fn assert_close(actual: &SymmetricTensor, expected: &SymmetricTensor, tolerance: f64) {
    let error = (actual.to_matrix() - expected.to_matrix()).norm();
    assert!(error <= tolerance, "{actual:?} is not {expected:?}: {error:e}");
}

#[test]
fn confined_stretch() {
    let (k, g) = (elasticity().bulk(), elasticity().shear());
    for stretch in [0.3, 0.9, 1.0, 1.01, 2.0, 5.0_f64] {
        let excess = diagonal(stretch * stretch - 1.0, 0.0, 0.0);
        let eps = stretch.ln();

        let elastic = respond(&Hencky(elasticity()), &excess, &()).expect("it returns");
        let (axial, lateral) = ((k + 4.0 / 3.0 * g) * eps, (k - 2.0 / 3.0 * g) * eps);
        assert_close(&elastic.kirchhoff, &diagonal(axial, lateral, lateral), 1e-12 * YOUNG);

        // |dev τ| = √(2/3) 2G |ε| while elastic.
        let plastic = respond(&von_mises(), &excess, &PlasticStrain::default()).expect("it returns");
        let reach = (2.0_f64 / 3.0).sqrt() * 2.0 * g * eps.abs();
        let held = reach.min(YIELD_RADIUS) * eps.signum();
        let (axial, lateral) = ((2.0_f64 / 3.0).sqrt() * held, -(1.0_f64 / 6.0).sqrt() * held);
        let tau = diagonal(k * eps + axial, k * eps + lateral, k * eps + lateral);
        assert_eq!(plastic.plastic, reach > YIELD_RADIUS);
        assert_close(&plastic.kirchhoff, &tau, 1e-12 * YOUNG);
        let flow = (reach - YIELD_RADIUS).max(0.0) / (2.0 * g);
        assert!((plastic.history.0 - flow).abs() < 1e-14);
    }
}

#[test]
fn free_stretch() {
    for stretch in [0.5, 1.2, 3.0_f64] {
        let lateral = stretch.powf(-2.0 * POISSON) - 1.0;
        let excess = diagonal(stretch * stretch - 1.0, lateral, lateral);
        let tau = respond(&Hencky(elasticity()), &excess, &()).expect("it returns").kirchhoff;
        assert_close(&tau, &diagonal(YOUNG * stretch.ln(), 0.0, 0.0), 1e-12 * YOUNG);
    }
}

/// b = [[1+γ², γ], [γ, 1]] has the strains ±asinh(γ/2), and tan 2θ = 2/γ.
#[test]
fn shear() {
    let g = elasticity().shear();
    for gamma in [-2.0, -1e-3, 1e-6, 0.01, 0.5, 1.0, 4.0_f64] {
        let (cos_2, sin_2) = (gamma.abs() / 2.0_f64.hypot(gamma), 2.0 / 2.0_f64.hypot(gamma));
        let eps = (0.5 * gamma.abs()).asinh();
        let turned = |tau: f64| SymmetricTensor {
            xx: tau * cos_2,
            yy: -tau * cos_2,
            xy: tau * sin_2 * gamma.signum(),
            ..SymmetricTensor::ZERO
        };

        let elastic = respond(&Hencky(elasticity()), &simple_shear(gamma), &()).expect("it returns");
        assert_close(&elastic.kirchhoff, &turned(2.0 * g * eps), 1e-13 * YOUNG * eps);

        let plastic =
            respond(&von_mises(), &simple_shear(gamma), &PlasticStrain::default()).expect("it returns");
        let tau = (2.0 * g * eps).min(YIELD_RADIUS / 2.0_f64.sqrt());
        assert_close(&plastic.kirchhoff, &turned(tau), 1e-13 * YOUNG * eps);
    }
}

/// ½ ln(I + c) = ½(c − c²/2 + c³/3 − …) with c = H + Hᵀ + HHᵀ.
#[test]
fn tiny_strains_keep_their_digits() {
    let plane = Matrix3::new(1.0, -0.3, 0.0, 0.7, 0.4, 0.0, 0.0, 0.0, -0.2);
    let space = Matrix3::new(1.0, -0.3, 0.2, 0.7, 0.4, -0.6, 0.1, 0.5, -0.2);
    let (lambda, two_g) = (elasticity().lame(), 2.0 * elasticity().shear());
    for direction in [plane, space] {
        for size in [1e-4, 1e-7, 1e-10, 1e-13, 1e-30, 1e-100] {
            let h = direction * size;
            let c = h + h.transpose() + h * h.transpose();
            let eps = (c - c * c / 2.0 + c * c * c / 3.0 - c * c * c * c / 4.0) / 2.0;

            let excess = SymmetricTensor::from_matrix(&c);
            assert_close(&log_strain(&excess), &SymmetricTensor::from_matrix(&eps), 2e-15 * eps.norm());
            let response = respond(&Hencky(elasticity()), &excess, &()).expect("it returns");
            let tau = Matrix3::from_diagonal_element(lambda * eps.trace()) + eps * two_g;
            assert_close(&response.kirchhoff, &SymmetricTensor::from_matrix(&tau), 3e-15 * tau.norm());
            assert_eq!(response.elastic_excess, excess);
        }
    }
}

/// The return keeps the digits of the excess as well.
#[test]
fn tiny_plastic_strains_keep_their_digits() {
    let size = 1e-10;
    let law = VonMises::new(elasticity(), size * elasticity().shear()).expect("positive");
    let response = respond(&law, &simple_shear(4.0 * size), &PlasticStrain::default()).expect("it returns");
    assert!(response.plastic);
    // Principal elastic strains ±ρ_y/(√2 2G).
    let eps = size / 8.0_f64.sqrt();
    let (cos_2, sin_2) = (2.0 * size, 1.0);
    let expected = SymmetricTensor {
        xx: 2.0 * eps * (eps + cos_2),
        yy: 2.0 * eps * (eps - cos_2),
        xy: 2.0 * eps * sin_2,
        ..SymmetricTensor::ZERO
    };
    assert_close(&response.elastic_excess, &expected, 3e-15 * expected.norm());
    assert_close(
        &log_strain(&response.elastic_excess),
        &SymmetricTensor { xx: eps * cos_2, yy: -eps * cos_2, xy: eps, ..SymmetricTensor::ZERO },
        3e-15 * eps,
    );
}

#[test]
fn impossible_states_give_nan_everywhere() {
    for bad in [-1.0, -1.5, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let (along_x, along_z) = (diagonal(bad, 0.2, -0.1), diagonal(0.2, -0.1, bad));
        for excess in [
            along_x,
            along_z,
            SymmetricTensor { yz: 1e-3, ..along_x },
            SymmetricTensor { zx: 4.0 * bad, ..diagonal(0.1, 0.2, -0.1) },
        ] {
            let hencky = respond(&Hencky(elasticity()), &excess, &()).expect("it returns");
            let von_mises = respond(&von_mises(), &excess, &PlasticStrain::default()).expect("it returns");
            for tau in [hencky.kirchhoff, von_mises.kirchhoff] {
                for component in [tau.xx, tau.yy, tau.zz, tau.xy] {
                    assert!(component.is_nan(), "{excess:?}: {tau:?}");
                }
            }
            assert!(hencky.tangent.spatial_tangent::<2>()[0][0][(0, 0)].is_nan(), "{excess:?}");
        }
    }
}

//! Compressible neo-Hooke elasticity: energy, derivatives, limits.

use crate::random::Numbers;
use mpm_material::{Elasticity, Hencky, Material, NeoHooke, SymmetricTensor, respond};
use nalgebra::{Matrix3, Vector3};

fn law(poisson: f64) -> NeoHooke {
    NeoHooke::new(Elasticity::from_young_poisson(1000.0, poisson).expect("in range")).expect("in range")
}

#[test]
fn stress_is_the_derivative_of_the_energy_and_the_tangent_that_of_the_stress() {
    let law = law(0.3);
    let mut numbers = Numbers(12);
    for _ in 0..500 {
        let strain = numbers.strain(1.0);
        let update = law.update(&strain, &()).expect("a return");
        let step = 1e-5;
        for a in 0..3 {
            let at = |sign: f64| {
                let mut moved = strain;
                moved[a] += sign * step;
                moved
            };
            let slope = (law.energy(&at(1.0)) - law.energy(&at(-1.0))) / (2.0 * step);
            assert!((slope - update.kirchhoff[a]).abs() < 1e-6 * update.tangent.amax(), "{strain:?}");
            let change = law.update(&at(1.0), &()).expect("a return").kirchhoff
                - law.update(&at(-1.0), &()).expect("a return").kirchhoff;
            let error = (change / (2.0 * step) - update.tangent.column(a)).amax();
            assert!(error < 1e-7 * update.tangent.amax(), "{strain:?}: {error:e}");
        }
    }
}

/// τ = G (b − I) + λ ln J I, whatever the axes.
#[test]
fn tensors_need_no_axes() {
    let law = law(0.35);
    let (g, lambda) = (law.elasticity().shear(), law.elasticity().lame());
    for f in [
        Matrix3::new(1.3, 0.4, 0.0, -0.2, 0.8, 0.0, 0.0, 0.0, 1.0),
        Matrix3::new(1.3, 0.4, -0.3, -0.2, 0.8, 0.6, 0.1, 0.3, 1.2),
        Matrix3::new(1.0, 5.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
    ] {
        let excess = f * f.transpose() - Matrix3::identity();
        let response = respond(&law, &SymmetricTensor::from_matrix(&excess), &()).expect("a return");
        let expected = excess * g + Matrix3::identity() * (lambda * f.determinant().ln());
        let error = (response.kirchhoff.to_matrix() - expected).norm();
        assert!(error < 1e-13 * expected.norm(), "{error:e}");
    }
}

#[test]
fn small_strains_are_those_of_linear_elasticity() {
    let law = law(0.3);
    let strain = Vector3::new(1.0, -2.0, 0.5) * 1e-9;
    let (ours, theirs) = (
        law.update(&strain, &()).expect("a return"),
        Hencky(law.elasticity()).update(&strain, &()).expect("a return"),
    );
    assert!((ours.kirchhoff - theirs.kirchhoff).norm() < 1e-8 * theirs.kirchhoff.norm());
    assert!((ours.tangent - theirs.tangent).norm() < 1e-7 * theirs.tangent.norm());
    assert!((ours.secant - theirs.secant).norm() < 1e-7 * theirs.secant.norm());
}

/// Closed form on both sides of the switch, and the limit of equal strains.
#[test]
fn secants_are_quotients_and_their_limits() {
    let law = law(0.3);
    let g = law.elasticity().shear();
    for gap in [0.0_f64, 1e-12, 1e-6, 1e-3, 0.0999, 0.1001, 0.5, 2.0] {
        let base = 0.3;
        let update = law.update(&Vector3::new(base, base + gap, -0.4), &()).expect("a return");
        // 2G e^{ε_a + ε_b} (sinh δ)/δ.
        let ratio = if gap > 1e-4 { gap.sinh() / gap } else { 1.0 + gap * gap / 6.0 };
        let expected = 2.0 * g * (2.0 * base + gap).exp() * ratio;
        assert!((update.secant[0] / expected - 1.0).abs() < 1e-14, "{gap}: {}", update.secant[0] / expected);
        let difference = update.kirchhoff[1] - update.kirchhoff[2];
        let quotient = difference / (base + gap + 0.4);
        assert!((update.secant[1] / quotient - 1.0).abs() < 1e-14);
    }
}

/// As ν goes to ½ the volume is kept: uniaxial tension tends to τ = G (λ² − 1/λ).
#[test]
fn nearly_incompressible_bars_stretch_as_incompressible_ones() {
    let stretch = 1.5_f64;
    for (poisson, tolerance) in [(0.49, 2e-2), (0.4999, 2e-4), (0.499_999, 2e-6)] {
        let law = law(poisson);
        let (mut low, mut high) = (-0.5 * stretch.ln() - 0.1, -0.5 * stretch.ln() + 0.1);
        let at = |lateral: f64| {
            law.update(&Vector3::new(stretch.ln(), lateral, lateral), &()).expect("a return").kirchhoff
        };
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if at(middle)[1] > 0.0 { high = middle } else { low = middle }
        }
        let expected = law.elasticity().shear() * (stretch * stretch - 1.0 / stretch);
        let tau = at(0.5 * (low + high))[0];
        assert!((tau / expected - 1.0).abs() < tolerance, "{poisson}: {tau} {expected}");
    }
}

#[test]
fn negative_poisson_s_ratios_are_refused() {
    let new = |poisson| NeoHooke::new(Elasticity::from_young_poisson(1000.0, poisson).expect("in range"));
    let error = new(-0.1).expect_err("falls without bound");
    assert!((error.value + 0.1).abs() < 1e-15 && error.name == "poisson", "{error}");
    for poisson in [0.0, 0.2, 0.499] {
        assert!(new(poisson).is_ok());
    }
}

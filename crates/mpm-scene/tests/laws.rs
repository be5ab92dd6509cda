//! A scene per law: it reads, runs, and ends where the law says; what a law refuses is told where it stands.

use mpm_scene::{Scene, compile};
use mpm_solver::observe::{Field, LoadStep, Observer, ObserverError};

/// Fields at the end, of the first point.
#[derive(Default)]
struct Last {
    stress: Vec<f64>,
    deformation: Vec<f64>,
    volume: Vec<f64>,
}

impl Observer for Last {
    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        self.stress = step.fields.field(Field::CAUCHY_STRESS);
        self.deformation = step.fields.field(Field::DEFORMATION_GRADIENT);
        self.volume = step.fields.field(Field::VOLUME_RATIO);
        Ok(())
    }
}

/// The stress along x and its volume ratio at the end.
fn run(text: &str) -> Last {
    let mut last = Last::default();
    compile(&Scene::from_ron(text).expect("a scene")).expect("a model").run(&mut last).expect("balance");
    last
}

#[test]
fn rubber_is_pulled() {
    let last = run(include_str!("../../../scenes/laws/neo_hooke.ron"));
    // G (λ_x² − λ_y²) = τ_x where τ_y = 0.
    let (g, f) = (1e3 / 2.9, &last.deformation);
    let tau = g * (f[0] * f[0] - f[4] * f[4]);
    assert!((last.stress[0] * last.volume[0] - tau).abs() < 1e-6 * tau, "{} {tau}", last.stress[0]);
    assert!(last.stress[4].abs() < 1e-6 * tau);
}

/// Unconfined compression ends at the strength of the law, by J.
#[test]
fn blocks_bear_what_the_law_says() {
    // Strength / J: plastic shear is nearly the whole of ln λ_y − ln λ_x.
    let shear: f64 = -2.0 * 0.8_f64.ln();
    let passive: f64 = 2.0 * 5.0 * 3.0_f64.sqrt();
    for (scene, tau, tolerance) in [
        (include_str!("../../../scenes/laws/von_mises.ron"), 20.0 * (0.5 + 0.5 * (-6.0 * shear).exp()), 0.02),
        (include_str!("../../../scenes/laws/tresca.ron"), 2.0 * 4.0, 0.02),
        (include_str!("../../../scenes/laws/mohr_coulomb.ron"), passive, 1e-8),
        (include_str!("../../../scenes/laws/drucker_prager.ron"), passive, 1e-3),
    ] {
        let last = run(scene);
        let found = -last.stress[0] * last.volume[0];
        assert!((found / tau - 1.0).abs() < tolerance, "{scene:.80}: {found} of {tau}");
        assert!(last.stress[4].abs() < 1e-6 * tau, "{scene:.80}: {} at the free side", last.stress[4]);
    }
}

#[test]
fn clay_is_compressed_at_rest() {
    let last = run(include_str!("../../../scenes/laws/cam_clay.ron"));
    let ratio = last.stress[4] / last.stress[0];
    assert!((ratio - 0.685_685_747).abs() < 1e-3, "{ratio}");
}

#[test]
fn water_keeps_the_volume() {
    let last = run(include_str!("../../../scenes/laws/pore_fluid.ron"));
    // With ψ = 0 and no lateral stress, v = ln J is elastic, ε_z = 0 stays so, and τ'_y = −K_f v: the cone
    // 1.5 τ'_y − 0.5 τ'_x = 2 c cos φ gives v = −2 c cos φ/(2 K_f + ½ (3K − λ)) and τ_x = (3K − λ + 2 K_f) v.
    let (fluid, skeleton) = (5e5, 3.0 * 1e4 / 1.8 - 1e4 * 0.2 / (1.2 * 0.6));
    let volume = -2.0 * 5.0 * 0.75_f64.sqrt() / (2.0 * fluid + 0.5 * skeleton);
    let tau = (skeleton + 2.0 * fluid) * volume;
    assert!((last.volume[0].ln() / volume - 1.0).abs() < 1e-6, "{} {volume}", last.volume[0].ln());
    assert!((last.stress[0] * last.volume[0] / tau - 1.0).abs() < 1e-8, "{} {tau}", last.stress[0]);
}

#[test]
fn what_a_law_refuses_is_told_where_it_stands() {
    let scene = include_str!("../../../scenes/laws/mohr_coulomb.ron");
    let (from, _) = scene.split_once("MohrCoulomb").expect("its law");
    let (_, to) = scene.split_once("tensile_strength: 2,\n        ),").expect("the end of its law");
    for (law, path, said) in [
        (
            "MohrCoulomb(young: 1, poisson: 0, cohesion: 1, friction: 95, dilation: 0)",
            ".friction",
            "90 degrees",
        ),
        ("MohrCoulomb(young: 1, poisson: 0, cohesion: 1, friction: 30, dilation: 31)", ".dilation", "31"),
        ("VonMises(young: 1, poisson: 0)", "", "exactly one of `yield_radius`"),
        ("VonMises(young: 1, poisson: 0, yield_radius: 1, undrained_strength: 1)", "", "exactly one of"),
        (
            "Tresca(young: 1, poisson: 0, undrained_strength: 1, softening: Linear(modulus: -1, residual: 0.1))",
            ".softening",
            "snaps back",
        ),
        (
            "Tresca(young: 1, poisson: 0, undrained_strength: 1, softening: Linear(modulus: -1, residual: 2))",
            ".softening.residual",
            "2",
        ),
        (
            "DruckerPrager(young: 1, poisson: 0, cone: Slopes(slope: 3, flow_slope: 0, strength: 1))",
            ".cone.slope",
            "below 3",
        ),
        ("NeoHooke(young: 1, poisson: -0.2)", ".poisson", "at least 0"),
        (
            "CamClay(critical_ratio: 1, compression: 0.1, swelling: 0.2, shear: 1, reference_pressure: 1, preconsolidation: 1)",
            ".compression",
            "above swelling",
        ),
    ] {
        let text = format!("{from}{law},{to}");
        let error = compile(&Scene::from_ron(&text).expect("a scene")).err().expect("out of range").to_string();
        assert!(error.starts_with(&format!("materials.soil{path}:")) && error.contains(said), "{law}: {error}");
    }
}

//! A scene per law: it reads, runs, and ends where the law says; what a law refuses is told where it stands.

use mpm_scene::{Scene, compile};
use mpm_solver::observe::{Entry, Field, LoadStep, Observer, ObserverError, RunStart};

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

/// Points that came apart: their number in the history, and the stress when they have closed.
#[test]
fn sand_closes_before_it_bears_anything() {
    #[derive(Default)]
    struct AtApex {
        column: usize,
        counts: Vec<u64>,
        last: Last,
    }
    impl Observer for AtApex {
        fn start(&mut self, start: &RunStart) -> Result<(), ObserverError> {
            let place = start.columns.iter().position(|column| column.name == "points_at_apex");
            self.column = place.expect("the law has an apex");
            Ok(())
        }

        fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
            let Entry::Count(count) = &step.row[self.column] else { panic!("a count") };
            self.counts.extend(count);
            self.last.load_step(step)
        }
    }
    let run = |text: &str| {
        let mut seen = AtApex::default();
        compile(&Scene::from_ron(text).expect("a scene")).expect("a model").run(&mut seen).expect("balance");
        seen
    };
    let text = include_str!("../../../scenes/laws/apex.ron");
    let seen = run(text);
    // Open from the first step to the one before the last, which closes it.
    assert_eq!((seen.counts[0], &seen.counts[1..20], seen.counts[20]), (0, &[16; 19][..], 0));
    let strain = f64::ln(1.0 - 0.001);
    let modulus = 1e4 * 0.7 / (1.3 * 0.4);
    let expected = modulus * strain / (1.0 - 0.001);
    assert!((seen.last.stress[4] / expected - 1.0).abs() < 1e-9, "{} {expected}", seen.last.stress[4]);
    // The plain law has lost the stretch, and bears all of the way back.
    let plain = run(&text.replace("volume_correction: true,", "").replace(", OpenedVolume", ""));
    let back = modulus * f64::ln(0.999 / 1.05) / 0.999;
    assert!((plain.last.stress[4] / back - 1.0).abs() < 1e-9, "{} {back}", plain.last.stress[4]);
}

/// The largest strain of a load step among points that yield: of a block that is compressed evenly, that of one of its axes.
#[test]
fn the_strain_of_a_step_is_that_of_points_that_yield() {
    #[derive(Default)]
    struct Strains {
        column: Option<usize>,
        told: Vec<f64>,
        stretches: Vec<[f64; 2]>,
        last: Last,
    }
    impl Observer for Strains {
        fn start(&mut self, start: &RunStart) -> Result<(), ObserverError> {
            self.column = start.columns.iter().position(|column| column.name == "largest_step_strain");
            Ok(())
        }

        fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
            if let Some(Entry::Real(strain)) = self.column.map(|column| &step.row[column]) {
                self.told.extend(strain);
            }
            self.last.load_step(step)?;
            self.stretches.push([0, 4].map(|entry| self.last.deformation[entry]));
            Ok(())
        }
    }
    let run = |text: &str| {
        let mut seen = Strains::default();
        compile(&Scene::from_ron(text).expect("a scene")).expect("a model").run(&mut seen).expect("balance");
        seen
    };
    let seen = run(include_str!("../../../scenes/laws/von_mises.ron"));
    assert_eq!(seen.told.len(), 21);
    let yields = seen.told.iter().filter(|strain| **strain > 0.0).count();
    assert!(yields > 10 && seen.told[0] == 0.0, "{:?}", seen.told);
    for (told, stretches) in seen.told[1..].iter().zip(seen.stretches.windows(2)) {
        let along = |d: usize| (stretches[1][d] / stretches[0][d]).ln().abs();
        let strain = f64::max(along(0), along(1));
        assert!(*told == 0.0 || (told - strain).abs() < 1e-9, "{told} {strain}");
    }
    assert_eq!(run(include_str!("../../../scenes/laws/neo_hooke.ron")).column, None, "elasticity is exact");
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
            "MohrCoulomb(young: 1, poisson: 0, cohesion: 0, friction: 30, dilation: 0, apex_stiffness: 2)",
            ".apex_stiffness",
            "a part from 0 to 1",
        ),
        (
            "DruckerPrager(young: 1, poisson: 0, cone: Slopes(slope: 1, flow_slope: 0, strength: 1), tension: 0.5, \
             volume_correction: true)",
            ".volume_correction",
            "the law has no apex",
        ),
        (
            "MohrCoulomb(young: 1, poisson: 0, cohesion: 1, friction: 0, dilation: 0, volume_correction: true)",
            ".volume_correction",
            "has no apex",
        ),
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

/// A block between rough plates that are pressed together (elastic ones: pulled apart), every load step begun at rest: laws and their stress at the start.
const PRESSED: [(&str, f64); 12] = [
    ("Hencky(young: 1e4, poisson: 0.3)", 0.0),
    ("NeoHooke(young: 1e4, poisson: 0.3)", 0.0),
    ("VonMises(young: 1e4, poisson: 0.3, undrained_strength: 20)", 0.0),
    (
        "VonMises(young: 1e4, poisson: 0.3, undrained_strength: 20, softening: Remoulding(remoulded: 0.5, shear_95: 1))",
        0.0,
    ),
    ("Tresca(young: 1e4, poisson: 0.3, undrained_strength: 20)", 0.0),
    ("MohrCoulomb(young: 1e4, poisson: 0.3, cohesion: 5, friction: 30, dilation: 10)", -20.0),
    ("MohrCoulomb(young: 1e4, poisson: 0.3, cohesion: 5, friction: 30, dilation: 30)", -20.0),
    (
        "MohrCoulomb(young: 1e4, poisson: 0.3, cohesion: 5, friction: 30, dilation: 10, tensile_strength: 1)",
        -20.0,
    ),
    ("DruckerPrager(young: 1e4, poisson: 0.3, cone: Slopes(slope: 0.9, flow_slope: 0.2, strength: 5))", -20.0),
    (
        "CamClay(critical_ratio: 1, compression: 0.1, swelling: 0.02, shear: 2000, reference_pressure: 100, \
         preconsolidation: 110)",
        -100.0,
    ),
    (
        "CamClay(critical_ratio: 1, compression: 0.1, swelling: 0.02, shear_ratio: 30, reference_pressure: 100, \
         preconsolidation: 110)",
        -100.0,
    ),
    (
        "MohrCoulomb(young: 1e4, poisson: 0.3, cohesion: 5, friction: 30, dilation: 10, fluid_bulk: 1e5, \
         volume_correction: true)",
        -20.0,
    ),
];

/// Newton's method closes in with the second order under every law: slope of ln r over the last three residuals above
/// round-off, the median of all load steps. Below 1e-1 no more points begin to yield or change their region.
#[test]
fn newton_s_method_is_of_second_order_under_every_law() {
    #[derive(Default)]
    struct Slopes(Vec<f64>);
    impl Observer for Slopes {
        fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
            let usable = step.residuals.iter().filter(|r| (1e-13..1e-1).contains(*r));
            if let [.., a, b, c] = usable.map(|r| r.ln()).collect::<Vec<_>>()[..] {
                self.0.push((c - b) / (b - a));
            }
            Ok(())
        }
    }
    for (law, stress) in PRESSED {
        let (by, steps) = if law.contains("young") && stress == 0.0 && !law.contains("strength") {
            (0.8, 3)
        } else {
            (-0.1, 10)
        };
        let side = format!(
            r#"Traction(body: "block", axis: X, at: 3, resultant: ({}, 0), ramp: [(0, 1)])"#,
            2.0 * stress
        );
        let loads = if stress == 0.0 { String::new() } else { side };
        let text = format!(
            r#"PlaneStrain(
                mesh: Box(axes: [Uniform(from: 0, to: 4, cells: 4), Uniform(from: 0, to: 2, cells: 2)]),
                motion: Stretch([(axis: Y, anchor: 0, driven: 2, displacement: {by})]),
                basis: Gimp,
                materials: {{ "soil": {law} }},
                bodies: [(name: "block", material: "soil", shape: Box(from: (0, 0), to: (3, 2)), points_per_cell: 2,
                    initial: Stress(xx: {stress}, yy: {stress}, zz: {stress}))],
                supports: [
                    (name: "bottom", region: Plane(axis: Y, at: 0), fix: [X, Y]),
                    (name: "left", region: Plane(axis: X, at: 0), fix: [X]),
                    (name: "top", region: Plane(axis: Y, at: 2), fix: [X], follow_mesh: [Y]),
                ],
                loads: [{loads}],
                schedule: (steps: {steps}, predictor: Rest), tolerance: (residual: 1e-14), output: (fields: []),
            )"#
        );
        let mut slopes = Slopes::default();
        compile(&Scene::from_ron(&text).expect("a scene")).expect("a model").run(&mut slopes).expect("balance");
        slopes.0.sort_by(f64::total_cmp);
        assert!(slopes.0.len() >= steps / 2, "{law}: {} load steps have three residuals", slopes.0.len());
        let median = slopes.0[slopes.0.len() / 2];
        assert!(median >= 1.9, "{law}: {median} of {:?}", slopes.0);
    }
}

//! A point along its path: the paths that were computed with 40 digits, and what is refused.

use mpm_scene::drive;
use mpm_scene::language::DriveInput;
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// A law and a path as `mpm drive` reads them, from the two lines that head a table.
fn text(law: &str, path: &str) -> String {
    format!("(law: {}, stress: {}, path: [{}])", law_of(law, path), stress(path), segments(path))
}

/// The number behind `name=` or `name = `.
fn number(text: &str, name: &str) -> Option<f64> {
    let (_, rest) = text.split_once(&format!("{name}=")).or_else(|| text.split_once(&format!("{name} = ")))?;
    let end = rest.find(|c: char| !(c.is_ascii_digit() || ".-e".contains(c))).unwrap_or(rest.len());
    rest[..end].trim_end_matches('.').parse().ok()
}

fn law_of(law: &str, path: &str) -> String {
    let of = |name: &str| number(law, name).unwrap_or_else(|| panic!("{name} in {law}"));
    let elastic = || format!("young: {}, poisson: {}", of(" E"), of("nu"));
    let softening = || {
        let (remoulded, shear) = (of("delta_rem"), of("xi95"));
        format!(
            "undrained_strength: {}, softening: Remoulding(remoulded: {remoulded}, shear_95: {shear})",
            of("su0")
        )
    };
    match law.split(':').next().expect("a name") {
        "# modified Cam-Clay" => format!(
            "CamClay(critical_ratio: {}, compression: {}, swelling: {}, shear: {}, shear_ratio: {}, \
             reference_pressure: {}, preconsolidation: {})",
            of(" M"),
            of("lambda"),
            of("kappa"),
            of("G0"),
            of(" g"),
            of("p_r"),
            number(path, "pc").expect("a preconsolidation"),
        ),
        "# Drucker-Prager" => format!(
            "DruckerPrager({}, cone: Slopes(slope: {}, flow_slope: {}, strength: {}))",
            elastic(),
            of(" eta"),
            of("eta_bar"),
            of(" k"),
        ),
        "# Mohr-Coulomb" => format!(
            "MohrCoulomb({}, cohesion: {}, friction: {}, dilation: {})",
            elastic(),
            of(" c"),
            of("phi"),
            of("psi"),
        ),
        "# Tresca" => format!("Tresca({}, {})", elastic(), softening()),
        "# von Mises" => format!("VonMises({}, {})", elastic(), softening()),
        other => panic!("{other}"),
    }
}

fn stress(path: &str) -> String {
    let s = if path.contains("start p = pc") {
        -number(path, "pc").expect("a pressure")
    } else if path.contains("start p") {
        -number(path, "start p").expect("a pressure")
    } else if path.contains("sigma = -I") {
        -1.0
    } else {
        number(path, "start sigma").unwrap_or(0.0)
    };
    format!("({s}, {s}, {s})")
}

/// `0 -> a (n steps) -> b (m)` as steps by differences.
fn legs(path: &str) -> Vec<(f64, u32)> {
    let (_, all) = path.split_once(": 0 -> ").expect("legs");
    let (mut at, mut legs) = (0.0, Vec::new());
    for leg in all.split(" -> ") {
        let (to, count) = leg.split_once(" (").expect("a number of steps");
        let to: f64 = to.parse().expect("a number");
        let count = count.split([' ', ')']).next().expect("a number");
        legs.push((to - at, count.parse().expect("a count")));
        at = to;
    }
    legs
}

fn segments(path: &str) -> String {
    let mut text = String::new();
    let mut add = |kind: &str, by: f64, steps: u32| {
        write!(text, "{kind}(by: {by}, steps: {steps}), ").expect("text grows");
    };
    let to = || path.split_once(" to ").and_then(|(_, rest)| rest.split(' ').next()?.parse::<f64>().ok());
    let steps = || {
        let (before, _) = path.split_once(" equal steps").or_else(|| path.split_once(" steps")).expect("steps");
        before.rsplit(' ').next().expect("a word").parse::<u32>().expect("a count")
    };
    if path.contains("dF = [[1, 0.01]") {
        add("DirectShear", 0.01 * f64::from(steps()), steps());
    } else if path.contains("sigma22 = sigma33") {
        add("Triaxial", to().expect("an end"), steps());
    } else if path.contains("ln F22 = ln F33 = x/2") {
        add("UndrainedTriaxial", -to().expect("an end"), steps());
    } else if path.contains("diag(exp(-x)") {
        add("PlaneStrain", -to().expect("an end"), steps());
    } else if path.contains("F12 = 2 in 80") {
        add("SimpleShear", 2.0, 80);
    } else {
        let kind = if path.contains("F22 = F33 = 1") {
            "Oedometer"
        } else if path.contains("each ln F_aa") {
            "Isotropic"
        } else {
            assert!(path.contains("F12: 0"), "{path}");
            "SimpleShear"
        };
        legs(path).into_iter().for_each(|(by, steps)| add(kind, by, steps));
    }
    text
}

#[test]
fn every_tabulated_path_is_driven() {
    const TOLERANCE: f64 = 1e-11;

    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../mpm-material/tests/tables");
    let (mut tables, mut steps) = (0, 0);
    for entry in fs::read_dir(folder).expect("the tables") {
        let file = entry.expect("an entry").path();
        let name = file.file_name().expect("a name").to_string_lossy().into_owned();
        if !name.starts_with("path_") {
            continue;
        }
        tables += 1;
        let table = fs::read_to_string(&file).expect("a table");
        let mut lines = table.lines();
        let (law, path) = (lines.next().expect("a law"), lines.next().expect("a path"));
        let input = DriveInput::from_ron(&text(law, path)).unwrap_or_else(|it| panic!("{name}: {it}"));
        let driven = drive(&input).unwrap_or_else(|it| panic!("{name}: {it}"));
        assert_eq!(driven.stopped, None, "{name}");
        let mut lines = lines.skip_while(|line| line.starts_with('#'));
        let heads: Vec<&str> = lines.next().expect("names").split(',').collect();
        let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
        assert_eq!(rows.len(), driven.rows.len(), "{name}");
        let column = |head: &str| {
            let place = heads.iter().position(|other| *other == head).expect("a column");
            rows.iter().map(|row| row[place].parse().expect("a number")).collect::<Vec<f64>>()
        };
        let compare = |head: &str, scale: f64| {
            for (step, (found, exact)) in driven.column(head).iter().zip(column(head)).enumerate() {
                let error = (found - exact).abs();
                assert!(
                    error <= TOLERANCE * scale,
                    "{name}, step {step}: {head} is off by {error:e} of {scale}"
                );
            }
        };
        let stresses = ["s11", "s22", "s33", "s12"];
        let largest = stresses.iter().flat_map(|head| column(head)).fold(0.0_f64, |most, s| most.max(s.abs()));
        stresses.iter().for_each(|head| compare(head, largest));
        ["f11", "f12", "f22", "f33", "j"].iter().for_each(|head| compare(head, 1.0));
        steps += rows.len();
    }
    assert!(tables == 32 && steps > 1500, "{tables} tables, {steps} steps");
}

fn driven(text: &str) -> mpm_scene::DrivenPath {
    drive(&DriveInput::from_ron(text).unwrap_or_else(|it| panic!("{it}"))).unwrap_or_else(|it| panic!("{it}"))
}

#[test]
fn stresses_are_met_component_by_component() {
    // An elastic point to σ₁₁ = −30 and σ₁₂ = 4 with its axis 2 held.
    let path = driven(
        "(law: Hencky(young: 1e3, poisson: 0.25), path: [Mixed(axis_1: Stress(-30), axis_2: Strain(0), \
         axis_3: Stress(0), shear: Stress(4), steps: 7)])",
    );
    let last = |name: &str| *path.column(name).last().expect("a row");
    assert!(
        (last("s11") + 30.0).abs() < 1e-11 && last("s33").abs() < 1e-11 && (last("s12") - 4.0).abs() < 1e-11
    );
    assert_eq!(last("f22"), 1.0);
    // Half of the way at half of the steps: stresses go in equal parts.
    assert!((path.column("s11")[3] + 30.0 * 3.0 / 7.0).abs() < 1e-11);
    // Sand with water: the volume is kept although the lateral stress is.
    let path = driven(
        "(law: MohrCoulomb(young: 1e4, poisson: 0.2, cohesion: 0, friction: 30, dilation: 0, fluid_bulk: 1e7), \
         stress: (-100, -100, -100), path: [Triaxial(by: -0.05, steps: 20)])",
    );
    let last = |name: &str| *path.column(name).last().expect("a row");
    assert!((last("j") - 1.0).abs() < 1e-5, "{}", last("j"));
    // q = 6 sin φ/(3 − sin φ) p' with p' kept by ψ = 0: s_u from the state.
    assert!((last("q") - 1.2 * (last("p") - last("excess_pore_pressure"))).abs() < 1e-6 * 100.0);
    assert!((last("p") - last("excess_pore_pressure") - 100.0).abs() < 0.2);
}

#[test]
fn a_path_without_a_solution_ends_early() {
    // The strength is 20 at most.
    let path = driven(
        "(law: Tresca(young: 1e3, poisson: 0.3, undrained_strength: 10), path: [Mixed(axis_1: Stress(-30), \
         axis_2: Stress(0), axis_3: Stress(0), steps: 30)])",
    );
    let stopped = path.stopped.expect("it cannot reach its end");
    assert!(stopped.starts_with("path[0] ends at step 21 of 30: no strain was found"), "{stopped}");
    assert_eq!(path.rows.len(), 21);
}

#[test]
fn what_cannot_be_driven_is_refused_where_it_stands() {
    let error =
        |text: &str| drive(&DriveInput::from_ron(text).expect("a path")).expect_err("refused").to_string();
    let elastic = "Hencky(young: 1e3, poisson: 0.25)";
    assert!(error(&format!("(law: {elastic}, path: [])")).starts_with("path: expected at least one segment"));
    let path = "path: [Oedometer(by: -0.1, steps: 2)]";
    let clay = "CamClay(critical_ratio: 1, compression: 0.1, swelling: 0.02, shear_ratio: 30, reference_pressure: 50, \
                preconsolidation: 100)";
    let said = error(&format!("(law: {clay}, {path})"));
    assert!(
        said.starts_with("stress: the point cannot begin under this stress: the law bears mean pressure"),
        "{said}"
    );
    let said = error(&format!("(law: {clay}, stress: (-300, -300, -300), {path})"));
    assert_eq!(said, "stress: the point cannot begin under this stress: the law yields under it");
    let said = error(&format!("(law: {}, {path})", clay.replace("compression: 0.1", "compression: 0.01")));
    assert!(said.starts_with("law.compression: compression is 0.01"), "{said}");
    let said =
        error(&format!("(law: Hencky(young: Linear(at: 0, value: 1, gradient: 1), poisson: 0), {path})"));
    assert!(said.starts_with("law.young: expected a number"), "{said}");
    assert!(DriveInput::from_ron("(law: Hencky(young: 1, poisson: 0), path: [Square(by: 1)])").is_err());
}

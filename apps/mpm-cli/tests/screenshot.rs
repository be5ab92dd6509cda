//! Other people's programs draw what we wrote: VTK, without a screen, with its own readers.

mod common;

use common::{says, workspace};
use mpm_io::Results;
use std::process::Command;

/// A plastic block, pressed by its weight and sheared, with domains that tile it.
const SCENE: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 6, cells: 6), Uniform(from: 0, to: 4, cells: 4)]),
    basis: Cpdi2q,
    materials: { "clay": VonMises(young: 1e3, poisson: 0.3, yield_radius: 4, density: 2) },
    bodies: [(name: "block", material: "clay", shape: Box(from: (0, 0), to: (4, 3)), points_per_cell: 4)],
    supports: [(name: "base", region: Plane(axis: Y, at: 0), fix: [Y], displace: [(axis: X, by: 1)])],
    loads: [BodyForce(acceleration: (0, -3))],
    schedule: (steps: 3),
    output: (fields: [CauchyStress, Volume, Outline], every: 3),
)"#;

/// What a picture shows.
struct Shown {
    area: f64,
    /// Lowest and highest x, lowest and highest y.
    bounds: [f64; 4],
    colours: f64,
}

/// `None` where this machine cannot draw.
fn drawn(directory: &std::path::Path, file: &str) -> Option<Shown> {
    let python = std::env::var("MPM_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let script = workspace("apps/mpm-cli/tests/screenshot.py");
    let output = Command::new(&python).arg(script).args([file, "a.png"]).current_dir(directory).output();
    let output = output.expect("the interpreter starts; MPM_PYTHON names it");
    let said = String::from_utf8_lossy(&output.stdout);
    if output.status.code() == Some(77) {
        println!("skipped: {said}");
        return None;
    }
    assert!(output.status.success(), "{python}: {said}{}", String::from_utf8_lossy(&output.stderr));
    let numbers: Vec<f64> = said.split_whitespace().map(|number| number.parse().expect("a number")).collect();
    let &[area, a, b, c, d, colours] = &numbers[..] else { panic!("{said}") };
    Some(Shown { area, bounds: [a, b, c, d], colours })
}

#[test]
fn vtk_draws_points_and_domains() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    std::fs::write(at.join("a.ron"), SCENE).expect("a scene can be written");
    says(at, &["run", "-q", "a.ron"]);
    says(at, &["export", "a.h5", "--vtu"]);
    let results = Results::open(at.join("a.h5")).expect("readable results");
    let last = results.fractions().len() - 1;
    let points = results.points(last).expect("points");
    let volume: f64 = results.field("volume", last).expect("volumes").values().iter().sum();

    // Every point is a square of five pixels.
    let Some(shown) = drawn(at, "a.h5") else { return };
    let end = |d: usize, fold: fn(f64, f64) -> f64| {
        points.values().chunks_exact(3).map(|x| x[d]).reduce(fold).expect("points")
    };
    let expected = [end(0, f64::min), end(0, f64::max), end(1, f64::min), end(1, f64::max)];
    let pixel = 1.2 * (expected[1] - expected[0]) / 600.0;
    for (found, expected) in shown.bounds.iter().zip(expected) {
        assert!((found - expected).abs() < 4.0 * pixel, "{:?}, points between {expected:?}", shown.bounds);
    }
    let squares = points.len() as f64 * 25.0 * pixel * pixel;
    assert!((shown.area / squares - 1.0).abs() < 0.05, "{} instead of {squares}", shown.area);
    assert!(shown.colours > 20.0, "{} colours", shown.colours);

    // Domains leave no gaps.
    let shown = drawn(at, &format!("a_vtu/domains_{last:04}.vtu")).expect("drawn before");
    assert!((shown.area / volume - 1.0).abs() < 0.01, "{} is drawn of {volume}", shown.area);
    assert!(shown.colours > 20.0, "{} colours", shown.colours);
}

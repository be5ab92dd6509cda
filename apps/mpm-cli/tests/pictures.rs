//! Pictures of bodies whose domains are not recorded, of columns of histories, and tables of sweeps.

mod common;

use common::{flat, says};
use std::fs;
use std::path::Path;
use std::sync::OnceLock;

/// Two blocks side by side, one of which is pulled; no field but the displacement.
const PLANE: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 6, cells: 6), Uniform(from: 0, to: 4, cells: 4)]),
    basis: Smpm,
    materials: { "soft": Hencky(young: 1e3, poisson: 0.3) },
    bodies: [
        (name: "left", material: "soft", shape: Box(from: (0, 0), to: (2, 2)), points_per_cell: 2),
        (name: "right", material: "soft", shape: Box(from: (4, 0), to: (6, 2)), points_per_cell: 2),
    ],
    supports: [
        (name: "base", region: Plane(axis: Y, at: 0), fix: [Y]),
        (name: "side", region: Plane(axis: X, at: 0), fix: [X]),
        (name: "end", region: Plane(axis: X, at: 6), fix: [X]),
    ],
    loads: [Traction(body: "left", axis: X, at: 2, value: (10, 0))],
    schedule: (steps: 4),
    probes: [(name: "tip", body: "left", points: Near(2, 2))],
    output: (fields: [Displacement], every: 2),
)"#;

/// A block in space that is pressed by a tenth.
const SOLID: &str = r#"Solid(
    mesh: Box(axes: [
        Uniform(from: 0, to: 3, cells: 3), Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 2, cells: 2),
    ]),
    basis: Gimp,
    materials: { "soft": Hencky(young: 1e3, poisson: 0.3) },
    bodies: [(name: "block", material: "soft", shape: Box(from: (0, 0, 0), to: (3, 2, 2)), points_per_cell: 1)],
    supports: [
        (name: "base", region: Plane(axis: Z, at: 0), fix: [X, Y, Z]),
        (name: "top", region: Plane(axis: Z, at: 2), fix: [X, Y], displace: [(axis: Z, by: -0.2)]),
    ],
    schedule: (steps: 2),
)"#;

/// A folder with the results `plane.h5` and `solid.h5`; it is only read.
fn results() -> &'static Path {
    static RESULTS: OnceLock<tempfile::TempDir> = OnceLock::new();
    let folder = RESULTS.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        for (name, scene) in [("plane.ron", PLANE), ("solid.ron", SOLID)] {
            fs::write(folder.path().join(name), scene).unwrap();
            says(folder.path(), &["run", "-q", name]);
        }
        folder
    });
    folder.path()
}

/// An SVG picture of results.
fn drawn(results_file: &str, arguments: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = results().join(results_file);
    let all = [&["plot", path.to_str().unwrap(), "-o", "a.svg"], arguments].concat();
    says(folder.path(), &all);
    fs::read_to_string(folder.path().join("a.svg")).unwrap()
}

/// Corners of the polygons of a picture.
fn polygons(svg: &str) -> Vec<Vec<(f64, f64)>> {
    let tags = svg.lines().filter(|line| line.starts_with("<polygon"));
    let corners = tags.map(|tag| {
        let points = tag.split("points=\"").nth(1).unwrap().split('"').next().unwrap();
        let pair = |pair: &str| {
            let (x, y) = pair.split_once(',').unwrap();
            (x.parse().unwrap(), y.parse().unwrap())
        };
        points.split_whitespace().map(pair).collect()
    });
    corners.collect()
}

fn area(of: &[(f64, f64)]) -> f64 {
    let pairs = of.iter().zip(of.iter().cycle().skip(1));
    (0.5 * pairs.map(|(a, b)| a.0 * b.1 - a.1 * b.0).sum::<f64>()).abs()
}

/// Sizes of the box round all polygons.
fn extent(of: &[Vec<(f64, f64)>]) -> (f64, f64) {
    let along = |of_corner: fn(&(f64, f64)) -> f64, of: &[Vec<(f64, f64)>]| {
        let all = of.iter().flatten().map(of_corner);
        let (from, to) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        to - from
    };
    (along(|at| at.0, of), along(|at| at.1, of))
}

#[test]
fn a_body_without_recorded_domains_is_drawn_without_gaps() {
    let at_rest = polygons(&drawn("plane.h5", &["--show", "body", "--no-mesh", "--step", "0"]));
    assert_eq!(at_rest.len(), 2 * 16, "a part for every point");
    let pulled = polygons(&drawn("plane.h5", &["--show", "body", "--no-mesh", "--body", "left"]));
    assert_eq!(pulled.len(), 16, "of one body");
    // The parts cover the box round them: none overlaps another and no gap is left, up to whole pixels.
    let (wide, high) = extent(&pulled);
    let covered: f64 = pulled.iter().map(|corners| area(corners)).sum();
    assert!((covered / (wide * high) - 1.0).abs() < 0.02, "{covered} of {wide} times {high}");
    // Pulled by about 1 %, and thinner by nearly half of that: a share of the height that is no pixel.
    assert!((wide / high - 1.0).abs() < 0.05);
}

#[test]
fn what_acts_is_drawn_with_the_mesh() {
    let body = polygons(&drawn("plane.h5", &["--show", "body", "--no-mesh"])).len();
    let all = polygons(&drawn("plane.h5", &["--show", "body"])).len();
    // Each of the 7 + 3 + 3 held nodes in the picture, of which two are held twice, has a wedge, a bar and two wheels; each of four
    // loaded edges an arrow of two parts.
    assert_eq!(all - body, 4 * (7 + 2 + 2) + 2 * 4);
    let at_rest = polygons(&drawn("plane.h5", &["--show", "body", "--step", "0"])).len();
    assert_eq!(at_rest - body, 4 * (7 + 2 + 2), "no load acts yet");
    assert!(drawn("plane.h5", &["--show", "body"]).contains("\nx [L]\n"));
}

#[test]
fn a_body_in_space_is_drawn_by_the_faces_that_one_sees() {
    // From a corner 3 by 2 cells from above, 3 by 2 from the front, 2 by 2 from the right.
    let faces = polygons(&drawn("solid.h5", &["--show", "body"]));
    assert_eq!(faces.len(), 6 + 6 + 4);
    let from_above = drawn("solid.h5", &["--show", "body", "--view", "z", "--step", "0"]);
    assert_eq!(polygons(&from_above).len(), 6);
    assert!(from_above.contains("\ny [L]\n"));
    // A slice between two rows shows a row and its own sides.
    assert_eq!(polygons(&drawn("solid.h5", &["--show", "body", "--slice", "y=0.5", "--step", "0"])).len(), 6);
}

#[test]
fn columns_are_drawn_against_each_other() {
    let svg = drawn("plane.h5", &["--y", "reaction/side.x", "--x", "probe/tip/displacement.x", "--abs"]);
    for text in ["size of reaction/side.x [F]", "size of probe/tip/displacement.x [L]"] {
        assert!(svg.contains(text), "{text}");
    }
    let folder = tempfile::tempdir().unwrap();
    for name in ["a", "b"] {
        fs::create_dir(folder.path().join(name)).unwrap();
        fs::copy(results().join("plane.h5"), folder.path().join(name).join("results.h5")).unwrap();
    }
    let both = ["plot", "a/results.h5", "b/results.h5", "--y", "reaction/side", "-o", "both.svg"];
    says(folder.path(), &both);
    let svg = fs::read_to_string(folder.path().join("both.svg")).unwrap();
    assert!(svg.contains("\na\n") && svg.contains("\nb\n"), "folders tell the curves apart");
    says(folder.path(), &["plot", "a/results.h5", "--y", "reaction/side.x", "-o", "a.pdf"]);
    assert!(fs::read(folder.path().join("a.pdf")).unwrap().starts_with(b"%PDF-"));

    let file = "a/results.h5";
    let wrong: &[(&[&str], &str)] = &[
        (
            &["plot", file, "--y", "force"],
            "no column `force` in the history of a/results.h5; there are active_nodes",
        ),
        (
            &["plot", file, "--y", "reaction/side.q"],
            "column `reaction/side` has no component `.q`; there are .x, .y",
        ),
        (&["plot", file, "b/results.h5"], "2 results files can be drawn together by --y alone"),
        (&["plot", file, "--body", "middle"], "--body: no body `middle`; the scene has left, right"),
    ];
    for (arguments, part) in wrong {
        let text = flat(&common::complains(folder.path(), 2, arguments));
        assert!(text.contains(part), "{arguments:?}: {text}");
    }
}

#[test]
fn values_of_a_sweep_go_together_and_its_table_shows_what_is_wanted() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.ron"), PLANE).unwrap();
    let set = "schedule.steps=1,2; materials.soft.young=1e3,2e3";
    let text =
        says(folder.path(), &["sweep", "a.ron", "--set", set, "--show", "probe/tip/displacement.x last"]);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.iter().filter(|line| line.ends_with("completed")).count(), 2, "{text}");
    assert!(lines[0].contains("probe/tip/displacement.x last") && !lines[0].contains("peak"), "{text}");
    let tip: Vec<f64> =
        lines[1..3].iter().map(|line| line.split_whitespace().nth(2).unwrap().parse().unwrap()).collect();
    assert!((tip[0] / tip[1] - 2.0).abs() < 0.05, "twice as stiff: {tip:?}");

    for (set, part) in [
        ("schedule.steps=1,2; materials.soft.young=1e3", "has 1 values, expected 2, as many as the field"),
        ("schedule.steps", "expected PATH=VALUE,VALUE as in schedule.steps=10,20, got schedule.steps"),
    ] {
        let text = flat(&common::complains(folder.path(), 2, &["sweep", "a.ron", "--set", set]));
        assert!(text.contains(part), "{text}");
    }
    let text = common::complains(folder.path(), 2, &["sweep", "a.ron", "--set", set, "--show", "force"]);
    assert!(flat(&text).contains("--show: no column `force`; there are load_fraction"), "{text}");
}

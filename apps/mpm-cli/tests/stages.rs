//! Stages on the command line: what is told of them, and runs that go on with more of them.

mod common;

use common::{complains, flat, says};
use mpm_io::Results;
use std::fs;
use std::path::Path;

/// A block under its weight, then propped and pressed.
const SCENE: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 3, cells: 3), Uniform(from: 0, to: 3, cells: 3)]),
    basis: Cpdi1,
    materials: { "clay": VonMises(young: 1e3, poisson: 0.3, yield_radius: 20, density: 1) },
    bodies: [(name: "block", material: "clay", shape: Box(from: (0, 0), to: (2, 2)), points_per_cell: 2)],
    supports: [
        (name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y]),
        (name: "top", region: Plane(axis: Y, at: 2), displace: [(axis: Y, by: -0.1)], active: (from: "press")),
    ],
    loads: [BodyForce(acceleration: (0, -1))],
    schedule: (stages: [
        (name: "weight", steps: 2),
        (name: "press", steps: 3),
    ]),
    output: (every: 2, checkpoint: (every: 100)),
)"#;

/// The same without its second stage and what comes with it.
fn first() -> String {
    SCENE
        .replace("        (name: \"press\", steps: 3),\n", "")
        .lines()
        .filter(|line| !line.contains("name: \"top\""))
        .collect::<Vec<_>>()
        .join("\n")
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("whole.ron"), SCENE).unwrap();
    fs::write(folder.path().join("first.ron"), first()).unwrap();
    folder
}

/// Bits of the history, without what the clock says, and load fractions of the recorded points.
fn bits(file: &Path) -> (Vec<(String, Vec<u64>)>, Vec<f64>) {
    let results = Results::open(file).unwrap();
    let columns = results.columns().iter().filter(|column| column.name != "wall_seconds");
    let values = |name: &str| results.column(name).unwrap().values().iter().map(|x| x.to_bits()).collect();
    let columns = columns.map(|column| (column.name.clone(), values(&column.name))).collect();
    (columns, results.fractions().to_vec())
}

#[test]
fn stages_are_told_by_check_and_inspect() {
    let folder = folder();
    let text = says(folder.path(), &["check", "whole.ron"]);
    let told = "stage             `press`, load steps: 3; begin: `top`";
    assert!(text.contains("stage             `weight`, load steps: 2") && text.contains(told), "{text}");
    let text = says(folder.path(), &["check", "whole.ron", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["load_steps"], 5);
    assert_eq!(json["stages"][1]["supports_begun"][0], "top");
    says(folder.path(), &["run", "whole.ron", "-q"]);
    let text = says(folder.path(), &["inspect", "whole.h5"]);
    assert!(text.contains("stages            `weight` 2, `press` 3"), "{text}");
    assert!(text.contains("recorded          4 steps, load fraction 0 to 2"), "{text}");
    let text = says(folder.path(), &["inspect", "whole.h5", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["stages"][1]["load_steps"], 3);
    says(folder.path(), &["plot", "whole.h5", "-o", "whole.png"]);
}

#[test]
fn a_run_goes_on_with_a_stage_more_as_if_it_had_always_been_there() {
    let folder = folder();
    says(folder.path(), &["run", "whole.ron", "-q"]);
    says(folder.path(), &["run", "first.ron", "-q"]);
    let before = Results::open(folder.path().join("first.h5")).unwrap();
    assert!(!before.columns().iter().any(|column| column.name == "reaction/top"));
    drop(before);
    let resume = ["resume", "first.checkpoint.h5", "--scene", "whole.ron"];
    says(folder.path(), &resume);
    assert_eq!(bits(&folder.path().join("first.h5")), bits(&folder.path().join("whole.h5")));
    // The results and the checkpoint hold the scene with all its stages.
    assert_eq!(Results::open(folder.path().join("first.h5")).unwrap().scene(), SCENE);
    let text = complains(folder.path(), 2, &["resume", "first.checkpoint.h5", "--scene", "first.ron"]);
    assert!(flat(&text).contains("stage `press` differs from that of the checkpoint"), "{text}");
}

#[test]
fn what_else_has_changed_is_shown_where_it_stands() {
    let folder = folder();
    says(folder.path(), &["run", "first.ron", "-q"]);
    fs::write(folder.path().join("other.ron"), SCENE.replace("young: 1e3", "young: 2e3")).unwrap();
    let resume = ["resume", "-q", "first.checkpoint.h5", "--scene", "other.ron"];
    let text = complains(folder.path(), 2, &resume);
    assert!(
        text.contains("other.ron:4:")
            && flat(&text).contains("`materials` differs from that of the checkpoint"),
        "{text}"
    );
    let resume = ["resume", "-q", "first.checkpoint.h5", "--scene", "missing.ron"];
    assert!(complains(folder.path(), 2, &resume).contains("cannot read scene missing.ron"));
    // The same scene will do.
    fs::write(folder.path().join("same.ron"), first().replace("every: 2, ", "every: 2,")).unwrap();
    let resume = ["resume", "-q", "first.checkpoint.h5", "--scene", "same.ron"];
    says(folder.path(), &resume);
}

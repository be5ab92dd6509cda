//! How what is wrong is told: once, where it stands, in plain text, with exit code 2. What is told is listed in the guide
//! (`messages.rs`).

mod common;

use common::{complains, flat, mpm, says};

const SCENE: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 4, cells: 4), Uniform(from: 0, to: 4, cells: 4)]),
    basis: Smpm,
    materials: { "soft": Hencky(young: 1e3, poisson: 0.3) },
    bodies: [(name: "block", material: "soft", shape: Box(from: (0, 0), to: (2, 2)), points_per_cell: 2)],
    supports: [(name: "bottom", region: Plane(axis: Y, at: 0), fix: [X, Y])],
    schedule: (steps: 4),
)
"#;

#[test]
fn the_scene_itself_is_right() {
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("scene.ron"), SCENE).unwrap();
    let text = says(directory.path(), &["check", "scene.ron"]);
    for line in
        ["material points   16", "cells             16, 4 with material", "nodes             25, 9 active"]
    {
        assert!(text.contains(line), "{text}");
    }
}

#[test]
fn the_caret_stands_under_the_culprit() {
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("scene.ron"), SCENE.replace("0.3", "0.7")).unwrap();
    let text = complains(directory.path(), 2, &["check", "scene.ron"]);
    let lines: Vec<&str> = text.lines().collect();
    let shown = lines.iter().position(|line| line.contains("poisson: 0.7")).expect("the line is shown");
    let column = lines[shown].find("0.7").unwrap();
    assert_eq!(lines[shown + 1].find('^'), Some(column), "{text}");
}

#[test]
fn files_and_arguments_are_checked_before_the_run() {
    let directory = tempfile::tempdir().unwrap();
    let inside = |name: &str| directory.path().join(name);
    std::fs::write(inside("scene.ron"), SCENE).unwrap();
    std::fs::write(inside("latin1.ron"), b"PlaneStrain(\n    title: \"gr\xf6\xdfe\",\n)").unwrap();
    std::fs::create_dir(inside("directory")).unwrap();
    // All of it a hole: it takes no space.
    std::fs::File::create(inside("endless.ron")).unwrap().set_len(1 << 40).unwrap();
    let cases: &[(&[&str], &[&str])] = &[
        (&["run", "none.ron"], &["cannot read scene none.ron", "No such file"]),
        (&["run", "directory"], &["cannot read scene directory"]),
        (&["run", "endless.ron"], &["cannot read scene endless.ron", "longer than 64 MiB"]),
        (&["run", "latin1.ron"], &["not UTF-8", "[latin1.ron:2:15]"]),
        (&["run", "scene.ron", "--output", "directory"], &["cannot create results file directory"]),
        (&["run", "scene.ron", "-o", "none/run.h5"], &["cannot create results file none/run.h5"]),
        (&["run", "scene.ron", "-o", "run.xdmf"], &["run.xdmf", "another ending"]),
        (&["run", "scene.ron", "-o", "./scene.ron"], &["is the scene itself"]),
    ];
    for (arguments, parts) in cases {
        let text = flat(&complains(directory.path(), 2, arguments));
        assert!(parts.iter().all(|part| text.contains(part)), "{arguments:?}: {text}");
    }
    assert_eq!(std::fs::read_to_string(inside("scene.ron")).unwrap(), SCENE);
    let arguments: &[&[&str]] =
        &[&["run"], &["run", "scene.ron", "--threads", "0"], &["walk"], &["check", "scene.ron", "--fast"]];
    for arguments in arguments {
        let output = mpm(directory.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(!output.stderr.is_empty() && output.stdout.is_empty(), "{arguments:?}");
    }
}

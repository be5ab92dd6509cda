//! Where files are read and written: nothing is written over what is read, and files may lie elsewhere.

mod common;

use common::{complains, flat, says, workspace};
use std::fs;
use std::path::Path;

const SCENE: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 2, cells: 2)]),
    basis: Cpdi1,
    materials: { "clay": Hencky(young: 1e3, poisson: 0.3, density: 1) },
    bodies: [(name: "body", material: "clay", shape: Points(file: "data/points.csv"))],
    supports: [(name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y])],
    loads: [BodyForce(acceleration: (0, -10))],
    schedule: (steps: 4),
    output: (checkpoint: (every: 2)),
)"#;

const POINTS: &str = "x, y, volume\n0.25, 0.25, 0.25\n0.75, 0.25, 0.25\n0.25, 0.75, 0.25\n0.75, 0.75, 0.25\n";

/// A scene and its points, in folders of their own.
fn place() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir_all(folder.path().join("data")).unwrap();
    fs::write(folder.path().join("data/points.csv"), POINTS).unwrap();
    fs::write(folder.path().join("a.ron"), SCENE).unwrap();
    folder
}

#[test]
fn nothing_is_written_over_what_is_read_or_written_otherwise() {
    let place = place();
    let folder = place.path();
    for (name, scene) in
        [("c.xdmf", SCENE.to_owned()), ("grains.ron", SCENE.replace("data/points.csv", "grains.h5"))]
    {
        fs::write(folder.join(name), scene).unwrap();
    }
    fs::write(folder.join("d.checkpoint.h5"), SCENE).unwrap();
    says(folder, &["run", "a.ron", "-q", "-o", "before.h5"]);
    let points = h5_points(folder);
    #[cfg(unix)]
    std::os::unix::fs::symlink("a.ron", folder.join("link.h5")).unwrap();
    let before = contents(folder);
    let mut cases: Vec<(&[&str], &str)> = vec![
        (
            &["run", "a.ron", "-o", "data/points.csv"],
            "the results file data/points.csv is the file that the scene names",
        ),
        (
            &["run", "a.ron", "--checkpoint", "./data/../data/points.csv"],
            "is the file that the scene names itself",
        ),
        (&["run", "a.ron", "--checkpoint", "a.ron"], "the checkpoint a.ron is the scene itself"),
        (&["run", "c.xdmf", "-o", "c.h5"], "the .xdmf file of the results c.xdmf is the scene itself"),
        (&["run", "d.checkpoint.h5", "-o", "d.h5"], "the checkpoint d.checkpoint.h5 is the scene itself"),
        (
            &["run", "a.ron", "-o", "z.h5", "--checkpoint", "z.h5"],
            "the checkpoint z.h5 is the results file itself",
        ),
        (
            &["run", "a.ron", "-o", "z.h5", "--checkpoint", "./z.xdmf"],
            "is the .xdmf file of the results itself",
        ),
        (
            &["resume", "before.checkpoint.h5", "--checkpoint", "before.h5"],
            "the checkpoint before.h5 is the results file",
        ),
        (&["resume", "before.checkpoint.h5", "-o", "data/points.csv"], "is the file that the scene names"),
    ];
    if points {
        cases.push((
            &["run", "grains.ron"],
            "the results file grains.h5 is the file that the scene names itself",
        ));
    }
    #[cfg(unix)]
    cases.push((&["run", "a.ron", "-o", "link.h5"], "the results file link.h5 is the scene itself"));
    for (arguments, part) in cases {
        let text = flat(&complains(folder, 2, arguments));
        assert!(text.contains(part), "{arguments:?}: {text}");
        assert!(contents(folder) == before, "{arguments:?} wrote something");
    }
}

/// Puts the points into `grains.h5`, too; false where nothing here can.
fn h5_points(folder: &Path) -> bool {
    let Some(python) = std::env::var_os("MPM_PYTHON") else { return false };
    let program = "import h5py, numpy as np
f = h5py.File('grains.h5', 'w')
f['position'] = np.array([[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]])
f['volume'] = np.full(4, 0.25)
f.close()";
    std::process::Command::new(python).args(["-c", program]).current_dir(folder).status().unwrap().success()
}

/// Names and contents of all files.
fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut all = Vec::new();
    for below in ["", "data"] {
        for entry in fs::read_dir(folder.join(below)).unwrap().map(Result::unwrap) {
            if entry.path().is_file() {
                all.push((format!("{below}/{}", entry.file_name().display()), fs::read(entry.path()).unwrap()));
            }
        }
    }
    all.sort();
    all
}

#[test]
fn a_sweep_finds_the_files_of_its_scene_and_says_why_a_run_did_not_begin() {
    let place = place();
    let sweep = ["sweep", "a.ron", "--set", "schedule.steps=2,3"];
    let text = says(place.path(), &sweep);
    assert_eq!(text.matches("completed").count(), 2, "{text}");
    // Checked before the first run, gone when it begins.
    fs::remove_dir_all(place.path().join("a_sweep")).unwrap();
    fs::write(place.path().join("a_sweep"), "").unwrap();
    let text = flat(&complains(place.path(), 2, &sweep));
    assert!(text.contains("cannot write a_sweep"), "{text}");
}

#[test]
fn a_run_with_files_goes_on_where_its_folder_has_moved() {
    let place = place();
    let (old, new) = (place.path().join("old"), place.path().join("new"));
    fs::create_dir_all(old.join("data")).unwrap();
    fs::copy(place.path().join("data/points.csv"), old.join("data/points.csv")).unwrap();
    fs::copy(place.path().join("a.ron"), old.join("a.ron")).unwrap();
    says(&old, &["run", "a.ron", "-q"]);
    fs::rename(&old, &new).unwrap();
    says(&new, &["resume", "a.checkpoint.h5", "-q"]);
    // The files lie elsewhere now.
    fs::rename(new.join("data"), new.join("points")).unwrap();
    fs::create_dir(new.join("files")).unwrap();
    fs::rename(new.join("points"), new.join("files/data")).unwrap();
    let text = flat(&complains(&new, 2, &["resume", "a.checkpoint.h5", "-q"]));
    assert!(text.contains("data/points.csv: No such file"), "{text}");
    fs::create_dir(new.join("data")).unwrap();
    fs::write(new.join("data/points.csv"), "").unwrap();
    let text = flat(&complains(&new, 2, &["check", "a.ron"]));
    assert!(text.contains("data/points.csv: the file is empty"), "{text}");
    says(&new, &["resume", "a.checkpoint.h5", "-q", "--files", "files"]);
    says(&new, &["run", "a.ron", "-q", "-o", "b.h5", "--files", "files"]);
    says(&new, &["resume", "b.checkpoint.h5", "-q"]);
}

#[test]
fn mistakes_far_along_a_line_are_told_without_the_line() {
    let folder = tempfile::tempdir().unwrap();
    let scene = fs::read_to_string(workspace("scenes/collapse.ron")).unwrap();
    let nodes: Vec<String> = (0..20_000).map(|k| format!("{:.6}", f64::from(k) * 1e-3)).collect();
    let wrong = scene.replacen("axes: [", &format!("axes: [Nodes([{}, x]), ", nodes.join(", ")), 1);
    assert_ne!(wrong, scene);
    fs::write(folder.path().join("long.ron"), &wrong).unwrap();
    let text = complains(folder.path(), 2, &["check", "long.ron"]);
    assert!(text.contains("long.ron:5:") && text.contains("expected a number") && text.len() < 500, "{text}");
}

#[test]
fn a_byte_order_mark_is_no_mistake_and_a_nul_is_one() {
    let place = place();
    fs::write(place.path().join("marked.ron"), format!("\u{feff}{SCENE}")).unwrap();
    says(place.path(), &["check", "marked.ron"]);
    fs::write(place.path().join("nul.ron"), SCENE.replace("base", "ba\0se")).unwrap();
    let text = flat(&complains(place.path(), 2, &["check", "nul.ron"]));
    assert!(text.contains("a NUL character is part of no scene") && text.contains("nul.ron:6:"), "{text}");
}

#[test]
fn checkpoints_and_results_are_told_apart() {
    let place = place();
    says(place.path(), &["run", "a.ron", "-q"]);
    let text = flat(&complains(place.path(), 2, &["inspect", "a.checkpoint.h5"]));
    assert!(text.contains("it is a checkpoint"), "{text}");
    let text = flat(&complains(place.path(), 2, &["resume", "a.h5"]));
    assert!(text.contains("this is no checkpoint"), "{text}");
}

//! Scenes that name files: found beside the scene, refused with their reason, found again by `mpm resume`.

mod common;

use common::mpm;
use mpm_io::Results;
use std::path::Path;

/// A tetrahedron.
const SURFACE: &str = "solid t
facet normal 0 0 0\n outer loop\n vertex 0 0 0\n vertex 0 2 0\n vertex 2 0 0\n endloop\nendfacet
facet normal 0 0 0\n outer loop\n vertex 0 0 0\n vertex 2 0 0\n vertex 0 0 2\n endloop\nendfacet
facet normal 0 0 0\n outer loop\n vertex 2 0 0\n vertex 0 2 0\n vertex 0 0 2\n endloop\nendfacet
facet normal 0 0 0\n outer loop\n vertex 0 2 0\n vertex 0 0 0\n vertex 0 0 2\n endloop\nendfacet
endsolid t
";

fn scene(shape: &str) -> String {
    let basis = if shape.starts_with("Points") { "Smpm" } else { "Cpdi1" };
    format!(
        r#"Solid(
    mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 4), Uniform(from: 0, to: 2, cells: 4), Uniform(from: 0, to: 2, cells: 4)]),
    basis: {basis},
    materials: {{ "clay": Hencky(young: 1e3, poisson: 0.3, density: 1) }},
    bodies: [(name: "body", material: "clay", shape: {shape})],
    supports: [(name: "base", region: Plane(axis: Z, at: 0), fix: [X, Y, Z])],
    loads: [BodyForce(acceleration: (0, 0, -10))],
    schedule: (steps: 4),
    output: (checkpoint: (every: 2)),
)"#
    )
}

const TETRAHEDRON: &str = "Surface(file: \"shapes/t.stl\"), points_per_cell: 2";

/// A folder `scenes` with the scene `a.ron` and files in `scenes/shapes`.
fn folder(shape: &str, files: &[(&str, &str)]) -> tempfile::TempDir {
    let directory = tempfile::tempdir().unwrap();
    let shapes = directory.path().join("scenes/shapes");
    std::fs::create_dir_all(&shapes).unwrap();
    std::fs::write(directory.path().join("scenes/a.ron"), scene(shape)).unwrap();
    for (name, content) in files {
        std::fs::write(shapes.join(name), content).unwrap();
    }
    directory
}

#[test]
fn a_surface_is_found_beside_its_scene_and_by_whoever_goes_on() {
    let directory = folder(TETRAHEDRON, &[("t.stl", SURFACE)]);
    let at = directory.path();
    let check = mpm(at, &["check", "scenes/a.ron"]);
    let text = String::from_utf8(check.stdout).unwrap();
    assert!(check.status.success() && text.contains("volume") && text.contains("1.33333 of `body`"), "{text}");
    assert!(text.contains("ns per point"), "{text}");
    let run = mpm(at, &["run", "-q", "scenes/a.ron", "-o", "a.h5"]);
    assert_eq!(run.status.code(), Some(0), "{}", String::from_utf8_lossy(&run.stderr));
    let results = Results::open(at.join("a.h5")).unwrap();
    assert_eq!((results.status(), results.rows()), ("completed", 5));

    // From elsewhere, from the checkpoint alone.
    let elsewhere = tempfile::tempdir().unwrap();
    let checkpoint = elsewhere.path().join("c.checkpoint.h5");
    std::fs::copy(at.join("a.checkpoint.h5"), &checkpoint).unwrap();
    let resumed = mpm(elsewhere.path(), &["resume", "-q", "c.checkpoint.h5", "-o", "b.h5"]);
    assert_eq!(resumed.status.code(), Some(0), "{}", String::from_utf8_lossy(&resumed.stderr));

    // What is gone is missed by name.
    std::fs::remove_file(at.join("scenes/shapes/t.stl")).unwrap();
    let missed = mpm(elsewhere.path(), &["resume", "-q", "c.checkpoint.h5", "-o", "d.h5"]);
    let text = String::from_utf8(missed.stderr).unwrap();
    assert!(missed.status.code() == Some(2) && text.contains("t.stl"), "{text}");
}

#[test]
fn points_come_from_tables() {
    let table = "x,y,z,volume\n0.25,0.25,0.25,0.125\n0.75,0.25,0.25,0.125\n";
    let directory = folder("Points(file: \"shapes/p.csv\")", &[("p.csv", table)]);
    let run = mpm(directory.path(), &["run", "-q", "scenes/a.ron", "-o", "a.h5"]);
    assert_eq!(run.status.code(), Some(0), "{}", String::from_utf8_lossy(&run.stderr));
    assert_eq!(Results::open(directory.path().join("a.h5")).unwrap().points(0).unwrap().len(), 2);
}

/// The screw of an STL file, turned in a block of soil from which it is cut out.
#[test]
fn a_screw_turns_in_soil() {
    let folder = tempfile::tempdir().expect("a folder for results");
    let screw = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/screw.ron");
    let screw = screw.to_str().expect("a path in UTF-8");
    let mut run = common::command(folder.path(), &["run", "-q", screw, "-o", "screw.h5"]);
    // Large enough for all threads.
    let run = run.env_remove("RAYON_NUM_THREADS").output().expect("the program starts");
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let results = Results::open(folder.path().join("screw.h5")).expect("readable results");
    assert_eq!(results.fractions().last(), Some(&1.0));
}

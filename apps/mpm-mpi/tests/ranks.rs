//! Scenes on one to four ranks against one process.

mod common;

use common::{alone, compare, compare_counting, resume_alone, root, run_on, scene, text};
use mpm_scene::language::set_value;
use std::fs;
use std::path::{Path, PathBuf};

/// Largest difference to one process, of the largest entry.
const WITHIN: f64 = 1e-9;

/// Scenes in the plane and in space, elastic and plastic, of several bases, with and without a mesh that moves.
const SCENES: [&str; 5] = [
    "scenes/column.ron",
    "scenes/simple_stretch_rollers.ron",
    "scenes/column_solid.ron",
    "scenes/simple_stretch.ron",
    "scenes/doughnut_elastic.ron",
];

#[test]
fn results_are_those_of_one_process() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in SCENES {
        // Otherwise what an iteration leaves over shows in the last Newton iteration.
        let path = folder.path().join("scene.ron");
        let exact =
            set_value(&fs::read_to_string(scene(name)).expect("a scene"), "tolerance.residual", "1e-10");
        fs::write(&path, exact.expect("a scene").text).expect("it is writable");
        let expected = folder.path().join("alone.h5");
        alone(&path, &expected);
        for n in [1, 2, 3, 4] {
            let found = folder.path().join(format!("{n}.h5"));
            run_on(n, &["run", text(&path), "--quiet", "--force", "-o", text(&found)]);
            println!("{name} on {n} ranks");
            compare(&found, &expected, WITHIN);
        }
        fs::remove_file(expected).expect("it is there");
    }
}

#[test]
fn the_same_ranks_give_the_same_bits() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = scene("scenes/column_solid.ron");
    for n in [2, 3, 4] {
        let [first, second] = ["first.h5", "second.h5"].map(|it| folder.path().join(it));
        for results in [&first, &second] {
            run_on(n, &["run", text(&path), "--quiet", "--force", "-o", text(results)]);
        }
        compare(&first, &second, 0.0);
    }
}

#[test]
fn a_checkpoint_goes_on_with_any_number_of_ranks_and_with_one_process() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = scene("scenes/column.ron");
    let expected = folder.path().join("alone.h5");
    alone(&path, &expected);
    let (results, checkpoint) = (folder.path().join("3.h5"), folder.path().join("3.checkpoint.h5"));
    let every = ["--checkpoint-every", "4"];
    let arguments = ["run", text(&path), "--quiet", "--force", "-o", text(&results)];
    run_on(3, &[&arguments[..], &every[..]].concat());
    for n in [1, 2, 4] {
        let found = folder.path().join(format!("{n}.h5"));
        let copy = folder.path().join(format!("{n}.checkpoint.h5"));
        fs::copy(&results, &found).expect("a copy");
        fs::copy(&checkpoint, &copy).expect("a copy");
        run_on(n, &["resume", text(&copy), "--quiet", "-o", text(&found)]);
        compare(&found, &expected, WITHIN);
    }
    let found = folder.path().join("one.h5");
    fs::copy(&results, &found).expect("a copy");
    resume_alone(&checkpoint, &found);
    compare(&found, &expected, WITHIN);
}

#[test]
fn tools_and_walls_are_shared() {
    let folder = tempfile::tempdir().expect("a folder");
    let plough = fs::read_to_string(scene("scenes/plough.ron")).expect("a scene");
    let path = folder.path().join("scene.ron");
    let mut short = plough;
    for (name, value) in [
        ("schedule.steps", "3"),
        ("tools[0].motion", "Move(by: (0.015, 0))"),
        ("tolerance.residual", "1e-10"),
        ("output.every", "1"),
    ] {
        short = set_value(&short, name, value).expect("a scene").text;
    }
    let loaded =
        set_value(&short, "tools[0].motion", "Loaded(free: [X], force: (8, 0))").expect("a scene").text;
    for text_of in [short, loaded] {
        fs::write(&path, text_of).expect("it is writable");
        // Whether a corner touches may turn on what an inexact correction leaves.
        let expected = compare_in(folder.path(), &path, 4);
        fs::remove_file(expected).expect("it is there");
    }
}

/// Of some values of a scene, on one and on two ranks.
fn compare_with(name: &str, values: &[(&str, &str)]) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.ron");
    let whole = fs::read_to_string(scene(name)).expect("a scene");
    let set = |text: String, (name, value): &(&str, &str)| set_value(&text, name, value).expect("a scene").text;
    fs::write(&path, values.iter().fold(whole, set)).expect("it is writable");
    compare_in(folder.path(), &path, 1);
}

/// Compares one and two ranks with one process, whose results it returns, as many Newton iterations but for some; all of them in a
/// folder.
fn compare_in(folder: &Path, scene: &Path, more: usize) -> PathBuf {
    let expected = folder.join("alone.h5");
    alone(scene, &expected);
    for n in [1, 2] {
        let found = folder.join(format!("{n}.h5"));
        run_on(n, &["run", text(scene), "--quiet", "--force", "-o", text(&found)]);
        compare_counting(&found, &expected, (WITHIN, more));
    }
    expected
}

#[test]
fn a_nodal_field_is_shared() {
    let short = [("schedule.steps", "3"), ("supports[1].turn.angle", "3"), ("tolerance.residual", "1e-10")];
    compare_with("scenes/doughnut_regularised.ron", &[&short[..], &[("output.every", "1")]].concat());
}

/// At the limit points of an arch the tangent is nearly singular, and a solution is large beside the force that it belongs to.
#[test]
fn limit_points_are_passed() {
    compare_with("scenes/path_arch.ron", &[("tolerance.residual", "1e-10")]);
}

/// A column that may slide sideways, which no load makes it do.
#[test]
fn a_motion_that_nothing_holds_is_kept_at_zero() {
    let slides = r#"[(name: "base", region: Plane(axis: Y, at: 0), fix: [Y])]"#;
    let values = [
        ("supports", slides),
        ("unheld_motion", "Zero"),
        ("loads[0].acceleration", "(0, -0.5)"),
        ("tolerance.residual", "1e-10"),
    ];
    compare_with("scenes/column.ron", &values);
}

#[test]
fn check_tells_what_every_rank_has() {
    let path = root().join("scenes/column_solid.ron");
    let output = run_on(3, &["check", text(&path)]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let table: Vec<&str> = said.lines().skip_while(|it| !it.trim_start().starts_with("rank")).collect();
    assert_eq!(table.len(), 4, "{said}");
    let points = |line: &&str| line.split_whitespace().nth(1).and_then(|it| it.parse::<usize>().ok());
    let points: Vec<usize> = table[1..].iter().filter_map(points).collect();
    assert!(points.iter().all(|&it| it > 0) && points.len() == 3, "{said}");
}

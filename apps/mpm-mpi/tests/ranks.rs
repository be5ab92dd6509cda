//! Scenes on one to four ranks against one process.

mod common;

use common::{alone, compare, ranks, resume_alone, root, run_on, scene};
use mpm_io::Results;
use mpm_scene::language::set_value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

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

fn text(path: &Path) -> &str {
    path.to_str().expect("paths are UTF-8")
}

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

/// Expects one message, an exit code, and an end soon.
fn refused(n: usize, arguments: &[&str], code: i32, message: &str) {
    let clock = Instant::now();
    let output = ranks(n, arguments).output().expect("mpirun is installed");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{said}");
    assert_eq!(said.matches(message).count(), 1, "{message:?} is not said once: {said}");
    assert!(clock.elapsed() < Duration::from_secs(20));
}

#[test]
fn what_is_wrong_is_said_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let broken = folder.path().join("broken.ron");
    fs::write(&broken, "Plane(nothing: 1)").expect("it is writable");
    refused(3, &["run", text(&broken)], 2, "broken.ron");
    refused(2, &["run"], 2, "Usage");
    let path = scene("scenes/column.ron");
    let nowhere = folder.path().join("nowhere/results.h5");
    refused(3, &["run", text(&path), "-o", text(&nowhere)], 2, "cannot create results file");
    // A body that nothing holds.
    let free = fs::read_to_string(&path).expect("a scene");
    let free = set_value(&free, "supports", "[]").expect("a scene").text;
    let (free_scene, results) = (folder.path().join("free.ron"), folder.path().join("free.h5"));
    fs::write(&free_scene, free).expect("it is writable");
    refused(2, &["run", text(&free_scene), "-o", text(&results)], 1, "nothing holds");
}

/// A disk of its own that fills up, where the system lets us have one.
#[test]
fn a_full_disk_ends_all_ranks_and_leaves_readable_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let in_namespace = |script: &str| {
        let script = format!("cd \"$0\" && mkdir -p disk kept && {script}");
        let mut command = Command::new("unshare");
        command.args(["-rm", "sh", "-c", &script, text(folder.path())]);
        command.env("OMPI_ALLOW_RUN_AS_ROOT", "1").env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1");
        command.env("OMP_NUM_THREADS", "1").output()
    };
    if !in_namespace("mount -t tmpfs -o size=64k none disk").is_ok_and(|it| it.status.success()) {
        eprintln!("no disk of its own here: not tested");
        return;
    }
    let path = scene("scenes/column.ron");
    let whole = folder.path().join("whole.h5");
    run_on(2, &["run", text(&path), "--quiet", "-o", text(&whole)]);
    let kilobytes = fs::metadata(&whole).expect("it was written").len() / 2048 + 64;
    let (program, path) = (env!("CARGO_BIN_EXE_mpm-mpi"), text(&path));
    let output = in_namespace(&format!(
        "mount -t tmpfs -o size={kilobytes}k none disk; \
         mpirun -n 2 --oversubscribe \"{program}\" run \"{path}\" --quiet -o disk/b.h5; \
         code=$?; cp disk/* kept; exit $code"
    ));
    let output = output.expect("it starts");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert_eq!(said.matches("No space left on device").count(), 1, "{said}");
    let (kept, whole) = (Results::open(&folder.path().join("kept/b.h5")), Results::open(&whole));
    let (kept, whole) = (kept.expect("readable"), whole.expect("readable"));
    assert!(kept.rows() > 0 && kept.rows() < whole.rows(), "{} rows", kept.rows());
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
        let expected = compare_in(folder.path(), &path);
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
    compare_in(folder.path(), &path);
}

/// Compares one and two ranks with one process, whose results it returns; all of them in a folder.
fn compare_in(folder: &Path, scene: &Path) -> PathBuf {
    let expected = folder.join("alone.h5");
    alone(scene, &expected);
    for n in [1, 2] {
        let found = folder.join(format!("{n}.h5"));
        run_on(n, &["run", text(scene), "--quiet", "--force", "-o", text(&found)]);
        compare(&found, &expected, WITHIN);
    }
    expected
}

#[test]
fn a_nodal_field_is_shared() {
    let short = [("schedule.steps", "3"), ("supports[1].turn.angle", "3"), ("tolerance.residual", "1e-10")];
    compare_with("scenes/doughnut_regularised.ron", &[&short[..], &[("output.every", "1")]].concat());
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
fn a_signal_ends_all_ranks() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = scene("scenes/collapse.ron");
    let results = folder.path().join("collapse.h5");
    let mut command = ranks(3, &["run", text(&path), "--quiet", "-o", text(&results)]);
    let mut child = command.stderr(Stdio::piped()).spawn().expect("mpirun is installed");
    sleep(Duration::from_secs(8));
    let kill = Command::new("kill").args(["-TERM", &child.id().to_string()]).status();
    assert!(kill.expect("kill is there").success());
    let clock = Instant::now();
    while child.try_wait().expect("it is a child").is_none() {
        assert!(clock.elapsed() < Duration::from_secs(20), "ranks go on");
        sleep(Duration::from_millis(100));
    }
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

//! Failures of one rank and of all: one message, and all ranks end soon.

mod common;

use common::{ranks, run_on, scene, text};
use mpm_io::Results;
use mpm_scene::language::set_value;
use std::fs;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Ranks end within this time of a failure.
const SOON: Duration = Duration::from_secs(10);

/// Expects one message, an exit code, and an end soon.
fn refused(n: usize, arguments: &[&str], code: i32, message: &str) {
    let clock = Instant::now();
    let output = ranks(n, arguments).output().expect("mpirun is installed");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{said}");
    assert_eq!(said.matches(message).count(), 1, "{message:?} is not said once: {said}");
    assert!(clock.elapsed() < SOON, "{message:?} after {:?}", clock.elapsed());
}

/// A soft block on whose right end something goes wrong, where one rank alone has its points.
fn block(more: &str) -> String {
    format!(
        r#"PlaneStrain(
            mesh: Box(axes: [Uniform(from: 0, to: 8, cells: 8), Uniform(from: 0, to: 4, cells: 4)]),
            basis: Cpdi1,
            materials: {{ "soft": VonMises(young: 1e3, poisson: 0.3, yield_radius: 20, density: 1) }},
            bodies: [(name: "low", material: "soft", shape: Box(from: (0, 0), to: (6, 2)), points_per_cell: 2)],
            {more}
        )"#
    )
}

const HELD: &str = r#"(name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y]), (name: "side", region: Plane(axis: X, at: 0), fix: [X])"#;

/// Runs a scene on one rank, which says what goes wrong, and expects of several ranks the same once.
fn fails_as_on_one(scene: &str, message: &str) {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, results) = (folder.path().join("scene.ron"), folder.path().join("results.h5"));
    fs::write(&path, scene).expect("it is writable");
    for n in [1, 2, 3] {
        refused(n, &["run", text(&path), "--quiet", "--force", "-o", text(&results)], 1, message);
        let results = Results::open(&results).expect("what was before is written");
        assert!(results.rows() > 0);
    }
}

#[test]
fn a_point_that_is_inverted_on_one_rank_ends_all() {
    // The right end is driven through the cells next to it; steps are not halved.
    let end = r#"(name: "end", region: Box(from: (5.9, 0.5), to: (6.1, 2.1)), displace: [(axis: X, by: -3)])"#;
    let more = format!("supports: [{HELD}, {end}], schedule: (steps: 1, cuts: 0)");
    fails_as_on_one(&block(&more), "invert");
}

#[test]
fn a_point_outside_the_mesh_on_one_rank_ends_all() {
    let scene = r#"PlaneStrain(
        mesh: Box(axes: [Uniform(from: 0, to: 7, cells: 7), Uniform(from: 0, to: 4, cells: 4)]),
        basis: Cpdi1,
        materials: { "soft": Hencky(young: 1e3, poisson: 0, density: 1) },
        bodies: [(name: "low", material: "soft", shape: Box(from: (0, 0), to: (6, 2)), points_per_cell: 2)],
        supports: [
            (name: "base", region: Plane(axis: Y, at: 0), fix: [Y]),
            (name: "side", region: Plane(axis: X, at: 0), fix: [X]),
        ],
        // The right end is drawn out of the mesh.
        loads: [BodyForce(acceleration: (120, 0))],
        schedule: (steps: 8, cuts: 0),
    )"#;
    fails_as_on_one(scene, "outside the mesh");
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

/// An interrupt from the terminal goes to `mpirun`, which ends the ranks.
#[test]
fn signals_end_all_ranks() {
    ["-INT", "-TERM"].into_iter().for_each(ended_by);
}

fn ended_by(signal: &str) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = scene("scenes/collapse.ron");
    let results = folder.path().join("collapse.h5");
    let mut command = ranks(3, &["run", text(&path), "--quiet", "-o", text(&results)]);
    let mut child = command.stderr(Stdio::piped()).spawn().expect("mpirun is installed");
    sleep(Duration::from_secs(6));
    let kill = Command::new("kill").args([signal, &child.id().to_string()]).status();
    assert!(kill.expect("kill is there").success());
    let clock = Instant::now();
    while child.try_wait().expect("it is a child").is_none() {
        assert!(clock.elapsed() < SOON, "ranks go on");
        sleep(Duration::from_millis(100));
    }
}

//! Files in which HDF5 loops or crashes: every command that reads one ends with a message.
#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

const SCENE: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 1, cells: 1), Uniform(from: 0, to: 1, cells: 1)]),
    basis: Smpm,
    materials: { "clay": Hencky(young: 1e3, poisson: 0.3, density: 1) },
    bodies: [(name: "body", material: "clay", shape: Box(from: (0, 0), to: (1, 1)), points_per_cell: 1)],
    supports: [(name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y])],
    loads: [BodyForce(acceleration: (0, -10))],
    schedule: (steps: 4),
    output: (checkpoint: (every: 2)),
)"#;

/// Seconds that a call into HDF5 may take here.
const SECONDS: &str = "1";

fn mpm(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mpm"));
    command.env("MPM_READ_SECONDS", SECONDS).env("RAYON_NUM_THREADS", "1").current_dir(folder);
    command.args(arguments).output().expect("it starts")
}

/// A folder with a scene `a.ron` that was run.
fn run() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.ron"), SCENE).unwrap();
    let output = mpm(folder.path(), &["run", "a.ron", "-q"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    folder
}

/// Texts are in a heap without a check sum; this replaces the index and the size of the first one of it.
fn damage(file: &Path, index: u16, size: u64) {
    let mut bytes = fs::read(file).unwrap();
    let heap = bytes.windows(4).position(|it| it == b"GCOL").expect("a heap of texts");
    bytes[heap + 16..heap + 18].copy_from_slice(&index.to_le_bytes());
    bytes[heap + 24..heap + 32].copy_from_slice(&size.to_le_bytes());
    fs::write(file, bytes).unwrap();
}

/// Every command that reads results refuses `a.h5` with one message, which holds `told` where HDF5 is 1.10.
#[track_caller]
fn is_refused(folder: &Path, told: &str) {
    let kept = fs::read(folder.join("a.h5")).unwrap();
    for arguments in [
        &["inspect", "a.h5"][..],
        &["plot", "a.h5"],
        &["export", "--csv", "a.h5"],
        &["resume", "a.checkpoint.h5", "-q"],
    ] {
        let clock = Instant::now();
        let output = mpm(folder, arguments);
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {text}");
        assert!(clock.elapsed() < Duration::from_secs(60), "{arguments:?}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
        // Later versions of HDF5 find the damage themselves.
        let is_told = text.contains(told) || text.contains("cannot open") || text.contains("a.h5: ");
        assert!(text.contains("a.h5") && is_told, "{arguments:?}: {text}");
        assert_eq!(text.matches("a.h5").count(), 1, "{arguments:?}: {text}");
    }
    assert_eq!(fs::read(folder.join("a.h5")).unwrap(), kept);
}

#[test]
fn results_that_hdf5_never_finishes_reading_are_refused() {
    let folder = run();
    damage(&folder.path().join("a.h5"), 0, 0);
    is_refused(folder.path(), "did not come back within 1 s");
}

#[test]
fn results_that_crash_hdf5_are_refused() {
    let folder = run();
    damage(&folder.path().join("a.h5"), 1, u64::MAX << 32);
    is_refused(folder.path(), "HDF5 crashes");
}

#[test]
fn a_sweep_runs_anew_what_cannot_be_read() {
    let folder = run();
    let sweep = ["sweep", "a.ron", "--set", "schedule.steps=3", "--json"];
    let first = mpm(folder.path(), &sweep);
    assert!(first.status.success(), "{}", String::from_utf8_lossy(&first.stderr));
    let runs: Vec<_> =
        fs::read_dir(folder.path().join("a_sweep")).unwrap().map(|it| it.unwrap().path()).collect();
    let results = runs.iter().map(|it| it.join("results.h5")).find(|it| it.exists()).expect("a run");
    damage(&results, 1, u64::MAX << 32);
    let second = mpm(folder.path(), &sweep);
    assert!(second.status.success(), "{}", String::from_utf8_lossy(&second.stderr));
    let but_time = |output: &Output| {
        let text = String::from_utf8_lossy(&output.stdout);
        text.lines().filter(|line| !line.contains("\"seconds\"")).map(str::to_owned).collect::<Vec<_>>()
    };
    assert!(but_time(&first).iter().any(|line| line.contains("completed")), "{:?}", but_time(&first));
    assert_eq!(but_time(&second), but_time(&first));
}

/// Points at the quarters of the unit square, written by another program; the tree of the root group's names has
/// itself as a branch, so that HDF5 1.10 descends without end.
const POINTS: &[u8] = include_bytes!("data/crashing_points.bin");

#[test]
fn tables_of_points_that_crash_hdf5_are_refused() {
    let folder = run();
    let scene = SCENE
        .replace("shape: Box(from: (0, 0), to: (1, 1)), points_per_cell: 1", "shape: Points(file: \"p.h5\")");
    fs::write(folder.path().join("a.ron"), &scene).unwrap();
    let check = ["check", "a.ron"];
    for arguments in [&check[..], &["run", "a.ron", "-q", "-o", "b.h5"]] {
        fs::write(folder.path().join("p.h5"), POINTS).unwrap();
        let output = mpm(folder.path(), arguments);
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {text}");
        // Where it stands in the scene is told, too.
        assert!(text.contains("p.h5") && text.contains("bodies[0].shape"), "{text}");
    }
    assert!(!folder.path().join("b.h5").exists());
    // The level of the tree and its branch, as they were written.
    let mut honest = POINTS.to_vec();
    let tree = honest.windows(4).position(|it| it == b"TREE").unwrap();
    honest[tree + 5] = 0;
    honest[tree + 32..tree + 40].copy_from_slice(&0x430_u64.to_le_bytes());
    fs::write(folder.path().join("p.h5"), honest).unwrap();
    let output = mpm(folder.path(), &check);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(String::from_utf8_lossy(&output.stdout).contains("material points   4"));
}

#[test]
fn checkpoints_that_crash_hdf5_are_refused_although_their_sum_is_right() {
    const BLOCK: usize = 512;
    let folder = run();
    let (file, sum) = (folder.path().join("a.checkpoint.h5"), crc32fast::hash(POINTS));
    let honest = fs::read(&file).unwrap();
    let format = String::from_utf8_lossy(&honest[..BLOCK]).lines().next().unwrap().to_owned();
    let mut forged =
        format!("{format}\n{} bytes follow this block, CRC-32 {sum:08x}\n", POINTS.len()).into_bytes();
    forged.resize(BLOCK, 0);
    forged.extend(POINTS);
    fs::write(&file, forged).unwrap();
    let results = fs::read(folder.path().join("a.h5")).unwrap();
    let output = mpm(folder.path(), &["resume", "a.checkpoint.h5", "-q"]);
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(
        text.contains("checkpoint a.checkpoint.h5: HDF5 crashes") || text.contains("every_steps"),
        "{text}"
    );
    assert_eq!(fs::read(folder.path().join("a.h5")).unwrap(), results);
    fs::write(&file, honest).unwrap();
    assert!(mpm(folder.path(), &["resume", "a.checkpoint.h5", "-q"]).status.success());
}

/// `/dev/zero` never ends, and nobody writes into a pipe that lies around.
#[test]
fn devices_and_pipes_are_no_tables() {
    let folder = run();
    let scene = |name: &str| SCENE.replace("shape: Box(from: (0, 0), to: (1, 1)), points_per_cell: 1", name);
    assert!(Command::new("mkfifo").arg(folder.path().join("pipe")).status().unwrap().success());
    for file in ["/dev/zero", "pipe"] {
        fs::write(folder.path().join("b.ron"), scene(&format!("shape: Points(file: \"{file}\")"))).unwrap();
        let output = mpm(folder.path(), &["check", "b.ron"]);
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains(file) && text.contains("no regular file"), "{text}");
    }
}

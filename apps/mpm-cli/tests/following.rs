//! A run can be followed while it goes, and what it has written is not replaced unasked.

mod common;

use common::{command, complains, flat, mpm, says};
use mpm_io::{Checkpoint, Results, is_being_written};
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// An elastic block under its weight, in as many load steps as it takes to look at it.
const SCENE: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 8, cells: 16), Uniform(from: 0, to: 8, cells: 16)]),
    basis: Cpdi1,
    materials: { "clay": Hencky(young: 1e3, poisson: 0.3, density: 1) },
    bodies: [(name: "block", material: "clay", shape: Box(from: (0, 0), to: (6, 6)), points_per_cell: 2)],
    supports: [(name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y])],
    loads: [BodyForce(acceleration: (0, -1))],
    schedule: (steps: STEPS),
    output: (fields: [CauchyStress], every: 5),
)"#;

fn folder(steps: usize) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.ron"), SCENE.replace("STEPS", &steps.to_string())).unwrap();
    folder
}

fn start(folder: &Path, arguments: &[&str]) -> Child {
    command(folder, arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts")
}

fn wait_for_rows(path: &Path, rows: usize, run: &mut Child) {
    let began = Instant::now();
    while Results::open(path).map_or(0, |results| results.rows()) < rows {
        assert!(run.try_wait().unwrap().is_none(), "the run ended before {rows} rows");
        assert!(began.elapsed() < Duration::from_secs(120), "no {rows} rows in two minutes");
        sleep(Duration::from_millis(5));
    }
}

fn bits(results: &Results, column: &str) -> Vec<u64> {
    results.column(column).unwrap().values().iter().map(|x| x.to_bits()).collect()
}

#[test]
fn every_load_step_is_a_line_at_once() {
    let folder = folder(100_000);
    let mut run = start(folder.path(), &["run", "a.ron"]);
    let mut lines = BufReader::new(run.stdout.take().unwrap()).lines().map(Result::unwrap);
    assert_eq!(lines.next().unwrap(), "  step  fraction  iterations  equations  method  cuts  residuals");
    for step in 1..20 {
        let line = lines.next().unwrap();
        let words: Vec<&str> = line.split_whitespace().collect();
        assert_eq!(
            (words[0], words[1]),
            (&*step.to_string(), &*format!("{:.6}", f64::from(step) * 1e-5)),
            "{line}"
        );
    }
    assert!(run.try_wait().unwrap().is_none(), "it goes on");
    run.kill().unwrap();
    run.wait().unwrap();
}

#[test]
fn readers_do_not_disturb_a_run() {
    let folder = folder(600);
    let at = |name: &str| folder.path().join(name);
    says(folder.path(), &["run", "a.ron", "-q", "-o", "alone.h5"]);
    let mut run = start(folder.path(), &["run", "a.ron", "-q", "-o", "a.h5"]);
    wait_for_rows(&at("a.h5"), 20, &mut run);
    let mut looks = 0;
    while run.try_wait().unwrap().is_none() {
        if looks == 0 {
            assert!(is_being_written(at("a.h5")));
        }
        let inspected = mpm(folder.path(), &["inspect", "a.h5", "--json"]);
        assert_eq!(inspected.status.code(), Some(0), "{}", String::from_utf8_lossy(&inspected.stderr));
        says(folder.path(), &["plot", "a.h5", "-o", "now.png"]);
        // Nobody else writes it meanwhile.
        if run.try_wait().unwrap().is_none() && is_being_written(at("a.h5")) {
            let other = mpm(folder.path(), &["run", "a.ron", "-q", "-o", "a.h5", "--force"]);
            let text = String::from_utf8_lossy(&other.stderr).into_owned();
            assert!(
                run.try_wait().unwrap().is_some() || text.contains("another program has the file open"),
                "{text}"
            );
        }
        looks += 1;
    }
    assert!(looks > 0, "the run was seen");
    assert_eq!(run.wait().unwrap().code(), Some(0));
    let [alone, seen] = ["alone.h5", "a.h5"].map(|name| Results::open(at(name)).unwrap());
    assert_eq!((alone.rows(), alone.status()), (seen.rows(), seen.status()));
    for column in alone.columns().iter().filter(|it| it.name != "wall_seconds") {
        assert_eq!(bits(&alone, &column.name), bits(&seen, &column.name), "{}", column.name);
    }
    assert_eq!(alone.fractions(), seen.fractions());
}

#[test]
fn interrupted_and_longer_results_are_not_replaced_unasked() {
    let folder = folder(100_000);
    let at = |name: &str| folder.path().join(name);
    let checkpointed = ["run", "a.ron", "-q", "--checkpoint-every", "10"];
    let mut run = start(folder.path(), &checkpointed);
    wait_for_rows(&at("a.h5"), 30, &mut run);
    run.kill().unwrap();
    run.wait().unwrap();
    let read = || ["a.h5", "a.xdmf", "a.checkpoint.h5"].map(|name| fs::read(at(name)).unwrap());
    let before = read();
    fs::write(at("short.ron"), SCENE.replace("STEPS", "5")).unwrap();
    for arguments in [&checkpointed[..], &["run", "a.ron"], &["run", "short.ron", "-o", "a.h5"]] {
        let text = flat(&complains(folder.path(), 2, arguments));
        for part in [
            "results file a.h5 holds",
            "load steps of a run that was interrupted",
            "go on with them by `mpm resume a.checkpoint.h5`",
            "--output",
            "--force",
        ] {
            assert!(text.contains(part), "{part} in {text}");
        }
    }
    // Nor its checkpoint, under other results.
    let arguments = ["run", "short.ron", "-q", "--checkpoint", "a.checkpoint.h5"];
    let text = flat(&complains(folder.path(), 2, &arguments));
    assert!(
        text.contains("checkpoint a.checkpoint.h5 is that of an unfinished run with the results a.h5"),
        "{text}"
    );
    assert!(read() == before && !at("short.h5").exists(), "nothing was touched");
    assert!(Checkpoint::open(at("a.checkpoint.h5")).is_ok());
    let text = says(folder.path(), &["inspect", "a.h5"]);
    assert!(text.contains("running when it was last written; no program writes it now"), "{text}");

    // Asked to, and then of another length: fewer load steps than there are.
    says(folder.path(), &["run", "short.ron", "-q", "-o", "a.h5", "--force"]);
    assert_eq!(Results::open(at("a.h5")).unwrap().rows(), 6);
    says(folder.path(), &["run", "short.ron", "-q", "-o", "a.h5"]);
    fs::write(at("shorter.ron"), SCENE.replace("STEPS", "3")).unwrap();
    let text = flat(&complains(folder.path(), 2, &["run", "shorter.ron", "-q", "-o", "a.h5"]));
    assert!(text.contains("results file a.h5 holds 5 load steps, and this run plans 3"), "{text}");
    fs::write(at("longer.ron"), SCENE.replace("STEPS", "6")).unwrap();
    says(folder.path(), &["run", "longer.ron", "-q", "-o", "a.h5"]);

    // What is no results file at all.
    fs::write(at("notes.h5"), "of somebody else").unwrap();
    let text = flat(&complains(folder.path(), 2, &["run", "short.ron", "-q", "-o", "notes.h5"]));
    assert!(text.contains("results file notes.h5 is there and cannot be read as results"), "{text}");
    assert_eq!(fs::read_to_string(at("notes.h5")).unwrap(), "of somebody else");
}

//! The memory and the time that `mpm check` predicts are what a run takes.
#![cfg(target_os = "linux")]

use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::time::Duration;

/// Children of one test at a time are what is measured.
static ALONE: Mutex<()> = Mutex::new(());

/// A cube under its own weight.
fn cube(cells: u32, solver: &str) -> String {
    let axis = format!("Uniform(from: 0, to: 8, cells: {cells})");
    format!(
        r#"Solid(
    mesh: Box(axes: [{axis}, {axis}, {axis}]),
    basis: Smpm,
    materials: {{ "clay": Hencky(young: 1e5, poisson: 0.3, density: 80) }},
    bodies: [(name: "cube", material: "clay", shape: Box(from: (0, 0, 0), to: (8, 8, 8)), points_per_cell: 2)],
    supports: [
        (name: "base", region: Plane(axis: Z, at: 0), fix: [Z]),
        (name: "left", region: Plane(axis: X, at: 0), fix: [X]),
        (name: "front", region: Plane(axis: Y, at: 0), fix: [Y]),
    ],
    loads: [BodyForce(acceleration: (0, 0, -1))],
    solver: {solver},
    schedule: (steps: 2),
    output: (fields: [CauchyStress]),
)"#
    )
}

fn mpm(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mpm"));
    command.env("RAYON_NUM_THREADS", "1").args(arguments).current_dir(folder);
    command
}

/// Memory that a run of `a.ron` is predicted to take, and its largest resident memory.
fn predicted_and_taken(folder: &Path) -> (f64, f64) {
    let output = mpm(folder, &["check", "a.ron", "--json"]).output().expect("the program starts");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}");
    let told: serde_json::Value = serde_json::from_str(&said).expect("JSON");
    let predicted = told["memory"]["total"].as_f64().expect("a number");
    let seconds = told["seconds"]["most"].as_f64().expect("a number");
    // How good it is, is tested below: on a busy machine it is whatever the machine needs.
    assert!(seconds > 0.0 && seconds.is_finite(), "{seconds}");

    let mut run =
        mpm(folder, &["run", "a.ron", "-q"]).stdout(Stdio::null()).spawn().expect("the program starts");
    let status = format!("/proc/{}/status", run.id());
    let mut most = 0.0_f64;
    let ended = loop {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kibibytes = line.and_then(|it| it.trim().strip_suffix("kB")?.trim().parse::<f64>().ok());
        most = most.max(1024.0 * kibibytes.unwrap_or(0.0));
        if let Some(ended) = run.try_wait().expect("a child") {
            break ended;
        }
        std::thread::sleep(Duration::from_millis(1));
    };
    assert!(ended.success());
    (predicted, most)
}

#[test]
fn the_memory_of_a_run_is_predicted() {
    let _alone = ALONE.lock();
    let folder = tempfile::tempdir().expect("a folder");
    let plane = include_str!("../../../scenes/collapse.ron")
        .replace("cells: 16", "cells: 64")
        .replace("cells: 8", "cells: 32");
    assert_eq!(plane.matches("cells: 64").count(), 1, "the scene has changed");
    let plane = plane.replace("steps: 40", "steps: 3");
    // Domains that fill their cells at the start, and corners near a tool.
    let pile = include_str!("../../../validation/scenes/contact/screw_pile_turns.ron")
        .replace(
            "0.3, 0.44, 0.58, 0.72, 0.86, 1.05, 1.3",
            "0.3, 0.37, 0.44, 0.51, 0.58, 0.65, 0.72, 0.79, 0.86, 1.05, 1.3",
        )
        .replace("cells: 19", "cells: 38")
        .replace("steps: 288", "steps: 1")
        .replace("steps: 40", "steps: 1")
        .replace("by: (0, 0, -0.8)", "by: (0, 0, -0.0011)")
        .replace("angle: -720", "angle: -1")
        .replace("by: (0, 0, 0.2)", "by: (0, 0, 0.0001)");
    let scenes = [cube(2, "Auto"), cube(14, "Direct"), cube(16, "Iterative"), cube(22, "Auto"), plane, pile];
    for (k, scene) in scenes.iter().enumerate() {
        std::fs::write(folder.path().join("a.ron"), scene).expect("a file");
        let (predicted, taken) = predicted_and_taken(folder.path());
        let ratio = predicted / taken;
        println!("{k}: {:.1} MB predicted, {:.1} MB taken", predicted * 1e-6, taken * 1e-6);
        assert!((0.77..1.3).contains(&ratio), "{k}: {predicted} predicted, {taken} taken");
    }
}

/// Processor seconds that a run takes, all of a clock tick (1/100 s); nothing where it fails. A child that has ended keeps its
/// times until it is waited for.
fn processor_seconds(folder: &Path, arguments: &[&str]) -> Option<f64> {
    let mut run = mpm(folder, arguments).stdout(Stdio::null()).spawn().expect("the program starts");
    let stat = format!("/proc/{}/stat", run.id());
    let ticks = loop {
        let text = std::fs::read_to_string(&stat).expect("the system has it");
        let mut fields = text[text.rfind(')').expect("a name in brackets") + 2..].split(' ');
        if fields.next() == Some("Z") {
            let ticks = fields.skip(10).take(2).map(|it| it.parse::<f64>().expect("a number"));
            break ticks.sum::<f64>();
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    run.wait().expect("a child").success().then_some(ticks / 100.0)
}

#[test]
fn the_time_of_every_shipped_scene_is_in_its_range() {
    let _alone = ALONE.lock();
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut files: Vec<_> =
        std::fs::read_dir(&scenes).expect("scenes").map(|it| it.expect("an entry").path()).collect();
    files.retain(|file| file.extension().is_some_and(|it| it == "ron"));
    files.sort();
    assert!(files.len() > 20);
    // Small steps, of which a row in the results takes more than the rest.
    files.push(scenes.join("../validation/scenes/faults/many_steps.ron"));
    // Two at a time, the next one as soon as one has ended.
    let next = Mutex::new(files.iter());
    let runs = || {
        let folder = tempfile::tempdir().expect("a folder");
        let results = folder.path().join("a.h5");
        while let Some(file) = next.lock().ok().and_then(|mut files| files.next()) {
            let name = file.to_string_lossy().into_owned();
            let output = mpm(&scenes, &["check", &name, "--json"]).output().expect("the program starts");
            let told: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
            let [least, most] = ["least", "most"].map(|it| told["seconds"][it].as_f64().expect("a number"));
            let run = ["run", &name, "-q", "--force", "-o", results.to_str().expect("a path")];
            let spent = processor_seconds(&scenes, &run).unwrap_or_else(|| panic!("{name} has failed"));
            println!("{name}: {spent:.2} s, predicted {least:.2} to {most:.2} s");
            // Below a tenth of a second ticks and the start of the program are what is measured.
            assert!(spent < most.max(0.2) && least < spent.max(0.1), "{name}: {spent} s, {least} to {most} s");
        }
    };
    std::thread::scope(|scope| {
        scope.spawn(runs);
        runs();
    });
}

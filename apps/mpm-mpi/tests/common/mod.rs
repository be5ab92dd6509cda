//! Runs of scenes on one process and on ranks. Not every program of tests needs all of it.

#![allow(dead_code)]

use mpm_io::{Checkpoint, FolderFiles, Options, Results, ResultsWriter};
use mpm_scene::{Compiled, Scene, compile_with};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The folder of the repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A path as an argument.
pub fn text(path: &Path) -> &str {
    path.to_str().expect("paths are UTF-8")
}

/// `mpirun` of the program with arguments.
pub fn ranks(n: usize, arguments: &[&str]) -> Command {
    let mut command = Command::new("mpirun");
    command.args(["-n", &n.to_string(), "--oversubscribe", env!("CARGO_BIN_EXE_mpm-mpi")]).args(arguments);
    for (name, value) in
        [("OMPI_ALLOW_RUN_AS_ROOT", "1"), ("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"), ("OMP_NUM_THREADS", "1")]
    {
        command.env(name, value);
    }
    command
}

/// Runs it, and expects it to end well.
pub fn run_on(n: usize, arguments: &[&str]) -> Output {
    let output = ranks(n, arguments).output().expect("mpirun is installed");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{arguments:?} on {n} ranks: {said}");
    output
}

/// A scene by its path in the repository.
pub fn scene(name: &str) -> PathBuf {
    root().join(name)
}

fn compiled(text: &str, folder: &Path) -> (Scene, Compiled) {
    let scene = Scene::from_ron(text).expect("a scene of the repository");
    let compiled = compile_with(&scene, &FolderFiles::new(folder)).expect("a scene of the repository");
    (scene, compiled)
}

fn options(scene: &Scene, text: &str, compiled: &Compiled) -> Options {
    let fields = compiled.fields(scene.output()).expect("compiled with them");
    Options { scene: text.to_owned(), ..Options::of(scene.output(), fields) }
}

/// Runs a scene on this process alone.
pub fn alone(path: &Path, results: &Path) {
    let text = std::fs::read_to_string(path).expect("a scene of the repository");
    let (scene, mut compiled) = compiled(&text, path.parent().expect("a folder"));
    let mut writer = ResultsWriter::create(results, options(&scene, &text, &compiled)).expect("it is writable");
    compiled.run(&mut writer).expect("it runs");
}

/// Goes on from a checkpoint on this process alone.
pub fn resume_alone(checkpoint: &Path, results: &Path) {
    let found = Checkpoint::open(checkpoint).expect("it was written");
    let text = found.head().scene.clone();
    let (scene, mut compiled) = compiled(&text, &found.head().folder);
    let state = found.state(&compiled.state_layout()).expect("it is of the scene");
    let mut writer = ResultsWriter::resume(results, options(&scene, &text, &compiled)).expect("it goes on");
    compiled.resume(&state, &mut writer).expect("it runs");
}

/// Expects the same results: positions and fields within `within` of the largest entry, columns of forces likewise, and as many
/// Newton iterations in every load step but for one.
pub fn compare(found: &Path, expected: &Path, within: f64) {
    compare_counting(found, expected, (within, 1));
}

/// The same with as many Newton iterations but for some.
pub fn compare_counting(found: &Path, expected: &Path, (within, more): (f64, usize)) {
    let (found, expected) = (Results::open(found).expect("results"), Results::open(expected).expect("results"));
    assert_eq!(found.status(), "completed");
    assert_eq!(found.rows(), expected.rows());
    // An iterate close to where the iteration ends may end it on one side only.
    for row in 0..expected.rows() {
        let (ours, theirs) = (found.residuals(row).expect("a row"), expected.residuals(row).expect("a row"));
        assert!(
            ours.len().abs_diff(theirs.len()) <= more,
            "Newton iterations of row {row}: {ours:?}, {theirs:?}"
        );
    }
    let largest = |of: &[f64]| of.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let close = |what: &str, ours: &[f64], theirs: &[f64], largest: f64| {
        assert_eq!(ours.len(), theirs.len(), "{what}");
        let apart = ours.iter().zip(theirs).fold(0.0_f64, |most, (x, y)| most.max((x - y).abs()));
        assert!(apart <= within * largest, "{what}: {apart:e} apart of {largest:e}");
    };
    // Along a path they are unknowns.
    close("load fractions", &found.fractions(), &expected.fractions(), 1.0);
    let size = largest(&expected.points(0).expect("a step").into_values());
    for kind in ["reaction", "displacement", "load_fraction"] {
        let columns = expected.columns();
        let names: Vec<&str> =
            columns.iter().map(|it| it.name.as_str()).filter(|it| it.starts_with(kind)).collect();
        let of = |results: &Results, name: &str| results.column(name).expect("a column").into_values();
        // A reaction may be all rounding beside the others, a displacement beside the body.
        let least = if kind == "displacement" { size } else { 0.0 };
        let scale = names.iter().map(|name| largest(&of(&expected, name))).fold(least, f64::max);
        for name in names {
            close(name, &of(&found, name), &of(&expected, name), scale);
        }
    }
    for step in 0..expected.fractions().len() {
        let of = |results: &Results| results.points(step).expect("a step").into_values();
        let theirs = of(&expected);
        close("positions", &of(&found), &theirs, largest(&theirs));
        for field in expected.fields().expect("fields") {
            let of = |results: &Results| results.field(&field, step).expect("a field").into_values();
            let theirs = of(&expected);
            close(&field, &of(&found), &theirs, largest(&theirs));
        }
    }
}

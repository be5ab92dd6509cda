//! What the tests of the program share: how it is called, and what it says.
#![allow(dead_code, reason = "every test program takes what it needs")]

use std::path::Path;
use std::process::{Command, Output};

/// The program, to be started in `directory`. Small systems: a second thread would only wait for its turn.
pub fn command(directory: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mpm"));
    command.env("RAYON_NUM_THREADS", "1").args(arguments).current_dir(directory);
    command
}

/// Runs the program in `directory`.
pub fn mpm(directory: &Path, arguments: &[&str]) -> Output {
    command(directory, arguments).output().expect("the program starts")
}

/// What the program prints where it succeeds.
#[track_caller]
pub fn says(directory: &Path, arguments: &[&str]) -> String {
    let output = mpm(directory, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("output is UTF-8")
}

/// What it says on standard error, where it ends with exit code `code`; nothing on standard output, no colours, no
/// traces of the program's insides.
#[track_caller]
pub fn complains(directory: &Path, code: i32, arguments: &[&str]) -> String {
    let output = mpm(directory, arguments);
    let text = String::from_utf8(output.stderr).expect("messages are UTF-8");
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {text}");
    assert!(output.stdout.is_empty(), "{arguments:?} prints to standard output");
    for noise in ["\u{1b}", "panicked", "backtrace", "Error("] {
        assert!(!text.contains(noise), "{arguments:?}: {text}");
    }
    text
}

/// With every space and line break a single space: a message can be longer than a line.
pub fn flat(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A file of the workspace.
pub fn workspace(file: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(file)
}

//! Tries to break the code: `stress [--readme] [--pictures DIRECTORY] [part of a name]...`.

use mpm_validation::{STRESS, program};
use std::process::ExitCode;

fn main() -> ExitCode {
    program(STRESS, INTRODUCTION)
}

const INTRODUCTION: &str = "# Stress tests

Attempts to break the code, and their outcome. `cargo run --release -p mpm-validation --bin stress` runs all of them (with words as
arguments: those whose names hold one of the words); `-- --readme` prints this page. `cargo test --profile quick -p mpm-validation` runs a small
part of each. Where an error counts exceptions, the tolerance is zero. Tables report what has no tolerance, failures included.

A second program tries hostile input. `cargo run --release -p mpm-validation --bin fuzz -- --cases 1000000` changes words, numbers, and groups
of the scenes of this repository, corners of surfaces, and bytes of tables of points, checkpoints, and results files. It feeds them to
processes with bounded memory and time. Every fault that it found is now a test in `crates/mpm-scene/tests/hostile.rs`. Its last run, all on one
state of the code and with checked arithmetic: 650,000 scenes, 250,000 surfaces and tables of points, 250,000 checkpoints, and 100,000 results
files; no panic, no hang, no memory beyond the bound. HDF5 1.10.8 itself crashed on 25 of the damaged files and looped on 8. `mpm` therefore reads
such files in a child process, and reports its end as an error.";

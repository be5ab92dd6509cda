//! Tries to break the code: `stress [--readme] [--pictures DIRECTORY] [part of a name]...`.

use mpm_validation::{STRESS, program};
use std::process::ExitCode;

fn main() -> ExitCode {
    program(STRESS, INTRODUCTION)
}

const INTRODUCTION: &str = "# Stress tests

What was tried to break the code, and what failed. `cargo run --release -p mpm-validation --bin stress` runs
everything (with words as arguments: the parts whose names hold one of them); the page is printed
with `-- --readme`. `cargo test --release -p mpm-validation` runs a small part of each. Where an error
counts exceptions the tolerance is zero; tables report what has no tolerance, failures included.

Hostile input is a program of its own: `cargo run --release -p mpm-validation --bin fuzz -- --cases 1000000` changes words,
numbers and groups of the scenes of this repository, corners of surfaces, and bytes of tables of points, checkpoints and results
files, and feeds them in processes with bounded memory and time. What it found so far is tests in `crates/mpm-scene/tests/hostile.rs`.
Its last run, all on one state of the code, with arithmetic checked: 650,000 scenes, 250,000 surfaces and tables of points, 250,000
checkpoints and 100,000 results files; no panic, no hang, no memory beyond its bounds. HDF5 1.10.8 itself crashed in 25 and looped in 8
of the damaged files: `mpm` reads them first in a process that may die, and says so.";

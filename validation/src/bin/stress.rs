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
numbers and groups of the scenes of this repository, and bytes of checkpoints and results files, and feeds them in processes
with bounded memory and time. What it found so far is a test in `crates/mpm-solver/tests/hostile.rs`. Its last run: 700,000 scenes,
300,000 checkpoints and 40,000 results files, no panic, no crash but HDF5's own in results files. Two scenes wanted more memory or time than
there was (an axis stretched in part, pieces of a cylinder); both are refused now. In some damaged results files HDF5 1.10.8 loops or crashes:
`mpm` reads them in a process that may die, and says so.";

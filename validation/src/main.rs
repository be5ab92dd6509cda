//! Runs the validation cases: `mpm-validation [--readme] [--quick] [--list] [--pictures DIRECTORY]
//! [--report FILE] [part of a name]...` prints a table, or with `--readme` the text of the README, draws
//! the pictures, and writes one HTML page of it all. `mpm validate` starts it.

use mpm_validation::{CASES, program};
use std::process::ExitCode;

fn main() -> ExitCode {
    program(CASES, INTRODUCTION)
}

const INTRODUCTION: &str = "# Validation

What the code computes, against what it should. `cargo run --release -p mpm-validation` runs all
cases and prints one table (with words as arguments: the cases whose names hold one of them);
`--pictures docs/pictures` draws the pictures as well, `--report FILE` writes all of it as one HTML page,
`--quick` keeps to the coarse meshes; `mpm validate` starts the same program. `cargo test --release -p mpm-validation` runs
the same functions as tests, the coarse meshes only, and checks that this page tells of every
comparison. The page is printed by `cargo run --release -p mpm-validation -- --readme`.

Tables of reference values are in `reference/`, each saying how it was obtained; closed forms are
in `src/analytic.rs`. Scenes are in `../scenes/` and, where they serve no other purpose, in
`scenes/`; variants (basis, points, mesh, load steps) are made of them in `src/variants.rs`. Where an
error counts exceptions the tolerance is zero. \"Patch test\" needs a word: with standard MPM the
points are the integration points, so it can only be passed where the points of neighbouring cells
balance, that is while each full cell holds an even grid of them.";

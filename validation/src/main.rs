//! Runs the validation cases: `mpm-validation [--pages FOLDER] [--quick] [--list] [--pictures DIRECTORY]
//! [--report FILE] [part of a name]...` prints a table, writes the pages of the repository, draws the pictures, and writes
//! one HTML page of it all. `mpm validate` starts it.

use mpm_validation::{CASES, pages, program};
use std::process::ExitCode;

fn main() -> ExitCode {
    program(CASES, pages::INTRODUCTION)
}

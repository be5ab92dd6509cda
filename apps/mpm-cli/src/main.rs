//! The program `mpm`.

use std::process::ExitCode;

fn main() -> ExitCode {
    mpm_cli::main()
}

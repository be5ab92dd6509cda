//! The implicit Material Point Method on many machines: `mpirun -n 4 mpm-mpi run scene.ron`.
//!
//! Commands, messages, exit codes and files are those of `mpm` (`mpm-cli`); ranks share the points (`mpm-cluster`), PETSc the
//! linear systems (`mpm-petsc`).

mod ranks;
mod shares;

use mpm_petsc::Session;
use ranks::MpiCrew;
use std::panic;
use std::process::ExitCode;

/// Exit code of a panic.
const PANIC: i32 = 101;

fn main() -> ExitCode {
    // A rank that has panicked would let the others wait for ever.
    let says = panic::take_hook();
    panic::set_hook(Box::new(move |panic| {
        says(panic);
        Session::abort(PANIC);
        std::process::exit(PANIC);
    }));
    mpm_cli::main_of_ranks(&|options| {
        let session = Session::start(options).map_err(|error| error.to_string())?;
        Ok(Box::new(MpiCrew::of(session)))
    })
}

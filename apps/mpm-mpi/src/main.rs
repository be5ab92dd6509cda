//! The implicit Material Point Method on many machines: `mpirun -n 4 mpm-mpi run scene.ron`.
//!
//! Commands, messages, exit codes and files are those of `mpm` (`mpm-cli`); ranks share the points (`mpm-cluster`), PETSc the
//! linear systems (`mpm-petsc`).

mod panics;
mod ranks;
mod shares;
mod taken;

use mpm_petsc::Session;
use ranks::MpiCrew;
use std::process::ExitCode;

fn main() -> ExitCode {
    panics::end_all_ranks();
    mpm_cli::main_of_ranks(&|options| {
        let session = Session::start(options).map_err(|error| error.to_string())?;
        Ok(Box::new(MpiCrew::of(session)))
    })
}

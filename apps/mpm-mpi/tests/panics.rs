//! A panic of one rank, by the hook of the program: this program of tests starts itself by `mpirun`.

#[path = "../src/panics.rs"]
mod panics;

use mpm_cluster::Wire;
use mpm_petsc::{MpiWire, Session};
use std::process::Command;
use std::time::{Duration, Instant};

#[test]
#[ignore = "is started by the other one, on three ranks"]
fn rank_one_panics() {
    panics::end_all_ranks();
    let session = Session::start(&[]).expect("MPI and PETSc start");
    let wire = MpiWire::of(&session);
    assert!(wire.rank() != 1, "something is wrong on this rank");
    wire.gather(&[1.0], &mut [0.0; 3]);
}

#[test]
fn a_panic_of_one_rank_ends_all() {
    let clock = Instant::now();
    let mut command = Command::new("mpirun");
    command.args(["-n", "3", "--oversubscribe"]).arg(std::env::current_exe().expect("a program has a path"));
    command.args(["--ignored", "--exact", "rank_one_panics", "--nocapture"]);
    command.env("OMPI_ALLOW_RUN_AS_ROOT", "1").env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1");
    let output = command.env("OMP_NUM_THREADS", "1").output().expect("mpirun is installed");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(101), "{said}");
    assert_eq!(said.matches("something is wrong on this rank").count(), 1, "{said}");
    assert!(clock.elapsed() < Duration::from_secs(10), "after {:?}", clock.elapsed());
}

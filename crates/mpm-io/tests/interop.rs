//! Other people's readers see what we wrote: h5py, VTK's VTKHDF reader and its XDMF reader.

mod fake;

use std::error::Error;
use std::process::Command;

use mpm_io::{Options, Precision, ResultsWriter};
use mpm_solver::observe::{Observer, Outcome};

const NEEDS: &str = "import h5py, vtkmodules.vtkIOHDF, vtkmodules.vtkIOXdmf2";

/// The interpreter named by `MPM_PYTHON`, else `python3`, if it has what the check needs.
fn python() -> String {
    let named = std::env::var("MPM_PYTHON").ok();
    let python = named.unwrap_or_else(|| "python3".to_owned());
    let probe = Command::new(&python).args(["-c", NEEDS]).output();
    let ready = probe.as_ref().is_ok_and(|probe| probe.status.success());
    assert!(
        ready,
        "{python} cannot import h5py and vtk ({probe:?}).\nInstall them (pip install h5py vtk), or name an \
         interpreter that has them: MPM_PYTHON=/path/to/venv/bin/python"
    );
    python
}

/// Writes ten rows with `points(step)` points and has the script compare every reader.
fn check(options: Options, points: impl Fn(usize) -> usize) -> Result<(), Box<dyn Error + Send + Sync>> {
    let directory = tempfile::tempdir()?;
    let path = directory.path().join("a & b.h5");
    let mut writer = ResultsWriter::create(&path, options)?;
    fake::start(&mut writer, points(0))?;
    for step in 0..10 {
        fake::load_step(&mut writer, step, points(step))?;
    }
    writer.finish(&Outcome::Completed, &fake::timings(9))?;

    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/check_results.py");
    let output = Command::new(python()).arg(script).arg(&path).output()?;
    let said = [output.stdout, output.stderr].concat();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&said));
    Ok(())
}

#[test]
fn plain_results() -> Result<(), Box<dyn Error + Send + Sync>> {
    check(fake::options(), |_| 123)
}

#[test]
fn compressed_single_precision() -> Result<(), Box<dyn Error + Send + Sync>> {
    check(Options { compression: 1, precision: Precision::Single, every: 4, ..fake::options() }, |_| 123)
}

#[test]
fn more_points_than_a_chunk() -> Result<(), Box<dyn Error + Send + Sync>> {
    check(Options { compression: 1, every: 5, ..fake::options() }, |_| 131_073)
}

#[test]
fn a_changing_number_of_points() -> Result<(), Box<dyn Error + Send + Sync>> {
    for compression in [0, 1] {
        check(Options { compression, ..fake::options() }, |step| {
            [30, 30, 41, 41, 29, 30, 77, 200, 5, 41][step]
        })?;
    }
    Ok(())
}

//! Other people's readers see what we wrote: h5py, VTK's VTKHDF reader and its XDMF reader.

mod fake;

use std::error::Error;
use std::process::Command;
use std::sync::Mutex;

use mpm_io::{Options, Precision, Results, ResultsWriter};
use mpm_solver::observe::{Field, Observer, Outcome};

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

/// Tests take turns: a process that is being started holds, for a moment, the files that another test has open,
/// and their locks.
static TURN: Mutex<()> = Mutex::new(());

/// Writes ten rows with `points(step)` points and has the script compare every reader.
fn check(options: Options, points: impl Fn(usize) -> usize) -> Result<(), Box<dyn Error + Send + Sync>> {
    let directory = tempfile::tempdir()?;
    let path = directory.path().join("a & b.h5");
    let _turn = TURN.lock();
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

/// Opens results as people do, with the locks that HDF5 takes by itself.
const READ_RUNNING: &str = r#"
import sys
import h5py
from vtkmodules.vtkIOHDF import vtkHDFReader
with h5py.File(sys.argv[1], "r") as file:
    reader = vtkHDFReader()
    reader.SetFileName(sys.argv[1])
    reader.UpdateInformation()
    print(file.attrs["status"], file["history"].attrs["rows"], reader.GetNumberOfSteps())
try:
    h5py.File(sys.argv[1], "r+")
    print("written by two")
except OSError:
    print("kept")
"#;

#[test]
fn results_are_read_while_they_are_written_and_nobody_else_writes_them()
-> Result<(), Box<dyn Error + Send + Sync>> {
    let directory = tempfile::tempdir()?;
    let path = directory.path().join("a.h5");
    let _turn = TURN.lock();
    let mut writer = ResultsWriter::create(&path, fake::options())?;
    fake::start(&mut writer, 7)?;
    for step in 0..30 {
        fake::load_step(&mut writer, step, 7)?;
        if step % 10 == 9 {
            writer.flush()?;
            let output = Command::new(python()).args(["-c", READ_RUNNING]).arg(&path).output()?;
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            let rows = step + 1;
            assert_eq!(String::from_utf8(output.stdout)?, format!("running {rows} {rows}\nkept\n"));
        }
    }
    writer.finish(&Outcome::Completed, &fake::timings(29))?;
    assert_eq!(Results::open(&path)?.rows(), 30);
    Ok(())
}

/// Reads the last file of a series with VTK's own reader and prints its numbers, bit for bit.
const READ_VTU: &str = r#"
import sys
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
from vtkmodules.util.numpy_support import vtk_to_numpy
reader = vtkXMLUnstructuredGridReader()
reader.SetFileName(sys.argv[1])
reader.Update()
grid = reader.GetOutput()
assert grid.CheckAttributes() == 0
data = grid.GetCellData() if grid.GetCellType(0) == 7 else grid.GetPointData()
print(grid.GetNumberOfCells(), grid.GetCellType(0), grid.GetCell(0).GetNumberOfPoints())
for name in ["cauchy_stress", "displacement", "volume"]:
    print(*[float(x).hex() for x in vtk_to_numpy(data.GetArray(name)).ravel()])
print(*[float(x).hex() for x in vtk_to_numpy(grid.GetPoints().GetData()).ravel()])
"#;

#[test]
fn exported_points_and_domains() -> Result<(), Box<dyn Error + Send + Sync>> {
    let directory = tempfile::tempdir()?;
    let path = directory.path().join("a.h5");
    let options = Options { fields: [fake::fields(), vec![Field::OUTLINE]].concat(), ..fake::options() };
    let _turn = TURN.lock();
    let mut writer = ResultsWriter::create(&path, options)?;
    fake::start(&mut writer, 7)?;
    for step in 0..3 {
        fake::load_step(&mut writer, step, 7)?;
    }
    writer.finish(&Outcome::Completed, &fake::timings(2))?;
    let results = Results::open(&path)?;
    let folder = directory.path().join("ä & b");
    let written = results.write_vtu(&folder)?;
    assert_eq!(written.len(), 2 * (1 + 3));
    assert!(std::fs::read_to_string(&written[0])?.contains("file=\"ä &amp; b/points_0002.vtu\""));
    for (file, shape) in [("points_0002.vtu", "7 1 1"), ("domains_0002.vtu", "7 7 4")] {
        let output = Command::new(python()).args(["-c", READ_VTU]).arg(folder.join(file)).output()?;
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let said = String::from_utf8(output.stdout)?;
        let lines: Vec<&str> = said.lines().collect();
        assert_eq!(lines[0], shape);
        for (line, name) in lines[1..4].iter().zip(["cauchy_stress", "displacement", "volume"]) {
            let expected: Vec<String> = results.field(name, 2)?.values().iter().map(|x| hex(*x)).collect();
            assert_eq!(*line, expected.join(" "), "{name}");
        }
        if shape.starts_with("7 1") {
            let expected: Vec<String> = results.points(2)?.values().iter().map(|x| hex(*x)).collect();
            assert_eq!(lines[4], expected.join(" "));
        }
    }
    Ok(())
}

/// As Python's `float.hex` of a normal number.
fn hex(x: f64) -> String {
    let bits = x.to_bits();
    let sign = if x < 0.0 { "-" } else { "" };
    let (exponent, mantissa) = ((bits >> 52 & 0x7ff) as i64 - 1023, bits & ((1 << 52) - 1));
    if x == 0.0 { format!("{sign}0x0.0p+0") } else { format!("{sign}0x1.{mantissa:013x}p{exponent:+}") }
}

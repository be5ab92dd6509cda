//! Other people's readers see what we wrote: h5py, VTK's VTKHDF reader and its XDMF reader.

mod fake;

use std::error::Error;
use std::process::Command;
use std::sync::Mutex;

use mpm_io::{Options, Precision, Results, ResultsWriter, Revolution};
use mpm_solver::observe::{Field, Fields, LoadStep, Observer, Outcome, Space};

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

/// A parallelogram and a triangle in (r, z).
const SECTIONS: [[f64; 8]; 2] =
    [[0.0, 0.0, 1.0, 0.1, 1.2, 0.6, 0.2, 0.5], [2.0, 0.0, 3.0, 0.5, 2.5, 1.0, 2.5, 1.0]];

/// Two points with these domains.
struct Sections;

impl Fields for Sections {
    fn n_points(&self) -> usize {
        2
    }
    fn positions(&self) -> Vec<f64> {
        vec![0.6, 0.3, 0.0, 2.5, 0.5, 0.0]
    }
    fn field(&self, field: Field) -> Vec<f64> {
        match field {
            Field::OUTLINE => SECTIONS.concat(),
            Field::VOLUME => vec![1.0, 2.0],
            Field::DISPLACEMENT => vec![0.1, 0.2, 0.0, 0.3, 0.4, 0.0],
            _ => (0..18).map(|k| f64::from(k % 9) + f64::from(k / 9)).collect(),
        }
    }
}

/// Volume of every wedge, and the components of its vectors and tensors along r, z and the hoop of its own centre.
const READ_WEDGES: &str = r#"
import sys
import numpy as np
from vtkmodules.vtkFiltersCore import vtkCellCenters
from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
from vtkmodules.util.numpy_support import vtk_to_numpy
reader = vtkXMLUnstructuredGridReader()
reader.SetFileName(sys.argv[1])
reader.Update()
grid = reader.GetOutput()
assert grid.CheckAttributes() == 0
sizes, centres = vtkCellSizeFilter(), vtkCellCenters()
sizes.SetInputData(grid)
sizes.Update()
centres.SetInputData(grid)
centres.Update()
volumes = vtk_to_numpy(sizes.GetOutput().GetCellData().GetArray("Volume"))
places = vtk_to_numpy(centres.GetOutput().GetPoints().GetData())
data = grid.GetCellData()
displacement, stress, parts = (vtk_to_numpy(data.GetArray(n)) for n in ["displacement", "cauchy_stress", "volume"])
for k, (x, y, _) in enumerate(places):
    c, s = np.array([x, y]) / np.hypot(x, y)
    axes = np.array([[c, s, 0], [0, 0, 1], [-s, c, 0]])
    turned = axes @ stress[k].reshape(3, 3) @ axes.T
    numbers = [volumes[k], parts[k], *(axes @ displacement[k]), *turned.ravel()]
    print(grid.GetCellType(k), *[repr(float(number)) for number in numbers])
"#;

#[test]
fn domains_of_bodies_of_revolution_are_wedges() -> Result<(), Box<dyn Error + Send + Sync>> {
    let directory = tempfile::tempdir()?;
    let path = directory.path().join("a.h5");
    let options = Options { fields: [fake::fields(), vec![Field::OUTLINE]].concat(), ..fake::options() };
    let _turn = TURN.lock();
    let mut writer = ResultsWriter::create(&path, options)?;
    fake::start_in(Space::Axisymmetric, &mut writer, 2)?;
    writer.load_step(&LoadStep {
        index: 0,
        fraction: 0.0,
        row: &fake::row(0),
        residuals: &[],
        timings: &[],
        fields: &Sections,
    })?;
    writer.finish(&Outcome::Completed, &[])?;
    let by = Revolution::new(5, 200.0)?;
    let written = Results::open(&path)?.write_revolved(&directory.path().join("turned"), by)?;
    assert_eq!(written.len(), 2);
    let output = Command::new(python()).args(["-c", READ_WEDGES]).arg(&written[1]).output()?;
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let said = String::from_utf8(output.stdout)?;
    assert_eq!(said.lines().count(), 5 * 2);
    // A wedge between chords has the volume `sin α ∫ r dA`.
    let alpha = 40_f64.to_radians();
    let moments = [0.6 * 0.48, 2.5 * 0.375];
    for (k, line) in said.lines().enumerate() {
        let (point, numbers) = (k % 2, line.split(' ').map(str::parse).collect::<Result<Vec<f64>, _>>()?);
        assert_eq!(numbers[0], [12.0, 13.0][point]);
        let mut expected = vec![alpha.sin() * moments[point], (1.0 + point as f64) / 9.0];
        expected.extend(&Sections.field(Field::DISPLACEMENT)[3 * point..3 * point + 3]);
        expected.extend(&Sections.field(Field::CAUCHY_STRESS)[9 * point..9 * point + 9]);
        for (found, expected) in numbers[1..].iter().zip(expected) {
            assert!((found - expected).abs() < 1e-13, "wedge {k}: {found}, expected {expected}");
        }
    }
    Ok(())
}

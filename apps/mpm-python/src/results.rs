//! Results files.

use crate::arrays::{of_points, of_rows};
use crate::errors::Failure;
use mpm_io::{Results as File, ResultsError, Table, is_being_written};
use mpm_solver::observe::ColumnKind;
use numpy::PyArray1;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Mutex;
use std::time::Duration;

/// Times that results are read while a run writes them: it may change what belongs together.
const ATTEMPTS: usize = 5;
/// Time between two of them.
const PAUSE: Duration = Duration::from_millis(200);

/// A results file; `implicit_mpm.Results` wraps it.
#[pyclass(frozen, module = "implicit_mpm._native")]
pub(crate) struct Results {
    path: PathBuf,
    file: Mutex<File>,
}

impl Results {
    /// Reads something, again where a run has changed the file meanwhile.
    fn get<T: Send>(
        &self,
        py: Python<'_>,
        read: impl Fn(&File) -> Result<T, ResultsError> + Send + Sync,
    ) -> PyResult<T> {
        let read = || {
            let file = self.file.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            patiently(&self.path, || read(&file))
        };
        py.detach(read).map_err(|error| Failure::input(error).raise(py))
    }
}

fn patiently<T>(path: &PathBuf, read: impl Fn() -> Result<T, ResultsError>) -> Result<T, ResultsError> {
    for _ in 1..ATTEMPTS {
        match read() {
            Err(_) if is_being_written(path) => std::thread::sleep(PAUSE),
            done => return done,
        }
    }
    read()
}

#[pymethods]
impl Results {
    /// Opens a results file.
    #[new]
    fn new(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let file = py.detach(|| patiently(&path, || File::open(&path)));
        let file = file.map_err(|error| Failure::input(error).raise(py))?;
        Ok(Self { path, file: Mutex::new(file) })
    }

    /// Status, program, and text of the scene.
    fn head(&self, py: Python<'_>) -> PyResult<(String, String, String)> {
        self.get(py, |file| Ok((file.status().to_owned(), file.program().to_owned(), file.scene().to_owned())))
    }

    /// Letters of the directions: `xyz`, or `rzt` of bodies of revolution.
    fn letters(&self, py: Python<'_>) -> PyResult<String> {
        self.get(py, |file| Ok(file.space().letters().concat()))
    }

    /// Number of the first row, and number of rows.
    fn rows(&self, py: Python<'_>) -> PyResult<(usize, usize)> {
        self.get(py, |file| Ok((file.first_row(), file.rows())))
    }

    /// Load fractions of the recorded steps.
    fn fractions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let fractions = self.get(py, |file| Ok(file.fractions().to_vec()))?;
        Ok(PyArray1::from_vec(py, fractions))
    }

    /// Names and units of the columns of the history, and the numbers that each has in a row.
    fn columns(&self, py: Python<'_>) -> PyResult<Vec<(String, &'static str, usize)>> {
        self.get(py, |file| {
            Ok(file.columns().iter().map(|it| (it.name.clone(), it.unit(file.space()), it.width)).collect())
        })
    }

    /// A column of the history.
    fn column<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let (table, is_count) = self.get(py, |file| {
            let kind = file.columns().iter().find(|column| column.name == name).map(|column| column.kind);
            Ok((file.column(name)?, kind == Some(ColumnKind::Count)))
        })?;
        let width = table.width();
        if is_count && width == 1 {
            // Counts are below 2⁵³, where reals are exact.
            let counts: Vec<u64> = table.values().iter().map(|&count| count as u64).collect();
            return Ok(PyArray1::from_vec(py, counts).into_any());
        }
        of_rows(py, table.into_values(), width)
    }

    /// Relative out-of-balance force of every iterate of the load step of a row.
    fn residuals<'py>(&self, py: Python<'py>, row: usize) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(PyArray1::from_vec(py, self.get(py, |file| file.residuals(row))?))
    }

    /// Phases of the run: name, seconds, and how often each was entered.
    fn timings(&self, py: Python<'_>) -> PyResult<Vec<(String, f64, u64)>> {
        let timings = self.get(py, File::timings)?;
        Ok(timings.into_iter().map(|it| (it.phase, it.seconds, it.count)).collect())
    }

    /// Names and units of the recorded fields.
    fn fields(&self, py: Python<'_>) -> PyResult<Vec<(String, String)>> {
        self.get(py, |file| {
            file.fields()?.into_iter().map(|name| file.unit(&name).map(|unit| (name, unit))).collect()
        })
    }

    /// Positions of the points at a recorded step.
    fn positions<'py>(&self, py: Python<'py>, step: usize) -> PyResult<Bound<'py, PyAny>> {
        let table = self.get(py, |file| file.points(step))?;
        of_points(py, table.into_values(), 3)
    }

    /// A field at a recorded step.
    fn field<'py>(&self, py: Python<'py>, name: &str, step: usize) -> PyResult<Bound<'py, PyAny>> {
        let table: Table = self.get(py, |file| file.field(name, step))?;
        let width = table.width();
        of_points(py, table.into_values(), width)
    }
}

//! One material point along a path.

use crate::errors::Failure;
use mpm_scene::drive as driven;
use mpm_scene::language::DriveInput;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;

/// The JSON schema of the language of paths.
#[pyfunction]
pub(crate) fn drive_schema() -> String {
    schemars::schema_for!(DriveInput).as_value().to_string()
}

/// Names and units of the columns, the rows, and why the path ends before its end.
type Driven<'py> = (Vec<String>, Vec<&'static str>, Bound<'py, PyAny>, Option<String>);

/// Drives a point along the path in a text, which has a name for messages.
#[pyfunction]
pub(crate) fn drive(py: Python<'_>, text: String, name: String) -> PyResult<Driven<'_>> {
    let path = py.detach(|| {
        let input = DriveInput::from_ron(&text).map_err(|error| Failure::read(&name, error))?;
        driven(&input).map_err(|error| Failure::refused(&name, &text, error))
    });
    let path = path.map_err(|failure| failure.raise(py))?;
    let shape = [path.rows.len(), path.columns.len()];
    let rows = PyArray1::from_vec(py, path.rows.concat()).reshape(shape)?;
    Ok((path.columns, path.units, rows.into_any(), path.stopped.as_deref().map(mpm_grid::rounded)))
}

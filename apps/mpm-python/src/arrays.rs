//! Numbers as numpy arrays, without copies.

use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;

/// Numbers of points, so many each, as an array: one row per point; matrices of 3 × 3, outlines of 4 corners.
pub(crate) fn of_points(py: Python<'_>, values: Vec<f64>, width: usize) -> PyResult<Bound<'_, PyAny>> {
    let points = values.len() / width.max(1);
    let array = PyArray1::from_vec(py, values);
    Ok(match width {
        1 => array.into_any(),
        9 => array.reshape([points, 3, 3])?.into_any(),
        8 => array.reshape([points, 4, 2])?.into_any(),
        width => array.reshape([points, width])?.into_any(),
    })
}

/// Rows of a column of the history: a list, or one row of numbers each.
pub(crate) fn of_rows(py: Python<'_>, values: Vec<f64>, width: usize) -> PyResult<Bound<'_, PyAny>> {
    let rows = values.len() / width.max(1);
    let array = PyArray1::from_vec(py, values);
    Ok(if width == 1 { array.into_any() } else { array.reshape([rows, width])?.into_any() })
}

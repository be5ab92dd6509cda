//! Load steps.

use crate::arrays::of_points;
use crate::errors::Failure;
use crate::link::{Link, Numbers, Shown};
use mpm_scene::{Compiled, Scene};
use mpm_solver::observe::{Column, Entry, Field};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// What is known of all load steps of a run.
#[derive(Clone, Default)]
pub(crate) struct Known {
    /// Columns of the history.
    pub columns: Vec<Column>,
    /// Fields of the points.
    pub fields: Vec<Field>,
    /// Names of the stages, if they have any.
    stages: Vec<String>,
}

impl Known {
    pub(crate) fn of(scene: &Scene, compiled: &Compiled) -> Self {
        let stages = scene.schedule().stages.iter().map(|stage| stage.name.clone()).collect();
        Self { columns: Vec::new(), fields: compiled.known_fields(), stages }
    }

    /// With the columns of the history.
    pub(crate) fn with(self, columns: Vec<Column>) -> Self {
        Self { columns, ..self }
    }
}

/// A converged load step, or (``index`` 0) the initial state.
///
/// Its numbers stay; positions and fields of the points are asked of the run and can be had as long as it waits at this load
/// step, and later if they were asked for then. Those of the last load step can be had until the run is closed.
#[pyclass(frozen, module = "implicit_mpm._native")]
pub(crate) struct Step {
    shown: Shown,
    known: Arc<Known>,
    link: Arc<Link>,
    /// What was asked for.
    numbers: Mutex<BTreeMap<Numbers, Py<PyAny>>>,
}

impl Step {
    pub(crate) fn new(shown: Shown, known: Arc<Known>, link: Arc<Link>) -> Self {
        Self { shown, known, link, numbers: Mutex::default() }
    }

    fn of_points(&self, py: Python<'_>, of: Numbers, width: usize) -> PyResult<Py<PyAny>> {
        let kept = || self.numbers.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(numbers) = kept().get(&of) {
            return Ok(numbers.clone_ref(py));
        }
        let step = self.shown.index;
        let Some(values) = py.detach(|| self.link.numbers(step, of)) else {
            let what = match of {
                Numbers::Positions => "positions".to_owned(),
                Numbers::Field(field) => format!("field `{}`", field.name()),
            };
            let reason = format!(
                "the run has gone on from load step {step}: ask for its {what} before the next load step, within the loop, \
                 or read them from the results file"
            );
            return Err(Failure::input(reason).raise(py));
        };
        let array = of_points(py, values, width)?.unbind();
        kept().insert(of, array.clone_ref(py));
        Ok(array)
    }

    /// The entries of the history whose names begin with `group/`, by the rest of their names.
    fn group<'py>(&self, py: Python<'py>, group: &str) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (column, entry) in self.known.columns.iter().zip(&self.shown.row) {
            let name = column.name.strip_prefix(group).and_then(|rest| rest.strip_prefix('/'));
            if let Some(name) = name {
                dict.set_item(name, value(py, entry)?)?;
            }
        }
        Ok(dict)
    }
}

/// An entry: a number, or an array of several.
fn value<'py>(py: Python<'py>, entry: &Entry) -> PyResult<Bound<'py, PyAny>> {
    Ok(match entry {
        Entry::Count(values) if values.len() == 1 => values[0].into_pyobject(py)?.into_any(),
        Entry::Real(values) if values.len() == 1 => values[0].into_pyobject(py)?.into_any(),
        Entry::Count(values) => PyArray1::from_slice(py, values).into_any(),
        Entry::Real(values) => PyArray1::from_slice(py, values).into_any(),
    })
}

#[pymethods]
impl Step {
    /// Row of the history: 0 is the initial state.
    #[getter]
    fn index(&self) -> usize {
        self.shown.index
    }

    /// Load fraction at its end; it counts stages.
    #[getter]
    fn load_fraction(&self) -> f64 {
        self.shown.fraction
    }

    /// Name of its stage; none where the schedule has no stages.
    #[getter]
    fn stage(&self) -> Option<&str> {
        let at = self.known.columns.iter().position(|column| column.name == "stage/number")?;
        let Entry::Count(number) = &self.shown.row[at] else { return None };
        let number = usize::try_from(*number.first()?).ok()?;
        self.known.stages.get(number.saturating_sub(1)).map(String::as_str)
    }

    /// The row of the history by the names of its columns: numbers, and arrays where a column has several.
    #[getter]
    fn history<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (column, entry) in self.known.columns.iter().zip(&self.shown.row) {
            dict.set_item(&column.name, value(py, entry)?)?;
        }
        Ok(dict)
    }

    /// Forces on the nodes of the supports by their names, and their sum, ``total`` [F].
    #[getter]
    fn reactions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.group(py, "reaction")
    }

    /// Mean displacements of the nodes of the supports by their names [L].
    #[getter]
    fn displacements<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.group(py, "displacement")
    }

    /// What the history says of the tools, by their names: force, moment, position, and so on.
    #[getter]
    fn tools<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let tools = PyDict::new(py);
        for (column, entry) in self.known.columns.iter().zip(&self.shown.row) {
            let path = column.name.strip_prefix("tool/").and_then(|path| path.rsplit_once('/'));
            let Some((tool, name)) = path else { continue };
            let of_tool = match tools.get_item(tool)? {
                Some(known) => known.cast_into::<PyDict>()?,
                None => PyDict::new(py),
            };
            of_tool.set_item(name, value(py, entry)?)?;
            tools.set_item(tool, of_tool)?;
        }
        Ok(tools)
    }

    /// Relative out-of-balance force of every iterate, first to last.
    #[getter]
    fn residuals<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.shown.residuals)
    }

    /// Number of material points.
    #[getter]
    fn n_points(&self) -> usize {
        self.shown.points
    }

    /// Positions of the points, one row of three each (z = 0 in the plane) [L].
    #[getter]
    fn positions(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.of_points(py, Numbers::Positions, 3)
    }

    /// A field of the points, by its name in results files: one entry per point, a number, a row, or a 3 × 3 matrix.
    fn field(&self, py: Python<'_>, name: &str) -> PyResult<Py<PyAny>> {
        let Some(&field) = self.known.fields.iter().find(|field| field.name() == name) else {
            let known: Vec<&str> = self.known.fields.iter().map(|field| field.name()).collect();
            let reason = format!("no point has a field `{name}`, expected one of {}", known.join(", "));
            return Err(Failure::input(reason).raise(py));
        };
        self.of_points(py, Numbers::Field(field), field.components())
    }

    fn __repr__(&self) -> String {
        format!("<implicit_mpm.Step {}: load fraction {}>", self.shown.index, self.shown.fraction)
    }
}

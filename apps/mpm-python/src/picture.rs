//! Pictures of results.

use crate::errors::Failure;
use mpm_pictures::{BodyView, Drawing, PictureError, Show, View, Wanted, plane};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::PathBuf;

/// A picture of results, which notebooks show.
#[pyclass(frozen, module = "implicit_mpm._native")]
pub(crate) struct Picture(Drawing);

/// How a body is looked at, as Python says.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Looked {
    field: Option<String>,
    step: Option<usize>,
    range: Option<(f64, f64)>,
    body: Option<String>,
    mesh: bool,
    tools: bool,
    domains: bool,
    mirror: bool,
    view: String,
    slice: Option<String>,
    cut: Option<String>,
}

impl Looked {
    fn view(self) -> Result<BodyView, Failure> {
        let view: View =
            self.view.parse().map_err(|reason: String| Failure::input(format!("view: {reason}")))?;
        let across = |argument: &str, text: Option<String>| {
            let wrong = |reason| Failure::input(format!("{argument}: {reason}"));
            text.map(|text| plane(&text)).transpose().map_err(wrong)
        };
        let (slice, cut) = (across("slice", self.slice)?, across("cut", self.cut)?);
        if slice.is_some() && cut.is_some() {
            return Err(Failure::input("expected slice or cut, got both"));
        }
        let Self { field, step, range, body, mesh, tools, domains, mirror, .. } = self;
        Ok(BodyView { field, step, range, body, mesh, tools, domains, mirror, view, slice, cut })
    }
}

/// A picture of a results file; all panels that it can have if none is named.
#[pyfunction]
pub(crate) fn picture(
    py: Python<'_>,
    results: PathBuf,
    show: Vec<String>,
    looked: Looked,
) -> PyResult<Picture> {
    let drawn = py.detach(|| {
        let view = looked.view()?;
        let show = show.iter().map(|name| named(name)).collect::<Result<Vec<Show>, _>>()?;
        mpm_pictures::picture(&results, &show, &view).map_err(Failure::input)
    });
    drawn.map(Picture).map_err(|failure| failure.raise(py))
}

/// Columns of the histories of results files against each other.
#[pyfunction]
pub(crate) fn compared(
    py: Python<'_>,
    files: Vec<PathBuf>,
    y: Vec<String>,
    x: Option<String>,
    absolute: bool,
) -> PyResult<Picture> {
    let drawn = py.detach(|| mpm_pictures::compared(&files, &Wanted { y, x, absolute }));
    drawn.map(Picture).map_err(|error| raise(py, error))
}

fn named(name: &str) -> Result<Show, Failure> {
    Show::ALL.into_iter().find(|show| show.name() == name).ok_or_else(|| {
        let known = Show::ALL.map(Show::name).join(", ");
        Failure::input(format!("show: expected some of {known}, got {name}"))
    })
}

fn raise(py: Python<'_>, error: impl Into<PictureError>) -> PyErr {
    Failure::input(error.into()).raise(py)
}

#[pymethods]
impl Picture {
    /// The text of an SVG file.
    fn svg(&self, py: Python<'_>) -> PyResult<String> {
        py.detach(|| self.0.figure().svg()).map_err(|error| raise(py, error))
    }

    /// The bytes of a PNG file of at most 256 colours.
    fn png<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| self.0.figure().image()?.small_png());
        bytes.map(|bytes| PyBytes::new(py, &bytes)).map_err(|error| raise(py, error))
    }

    /// The bytes of a PDF file of one page.
    fn pdf<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| self.0.figure().pdf());
        bytes.map(|bytes| PyBytes::new(py, &bytes)).map_err(|error| raise(py, error))
    }

    /// Writes a file; its ending, ``.svg``, ``.png`` or ``.pdf``, says the format.
    fn save(&self, py: Python<'_>, file: PathBuf) -> PyResult<()> {
        py.detach(|| self.0.figure().save(&file)).map_err(|error| raise(py, error))
    }

    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        self.png(py)
    }

    fn __repr__(&self) -> String {
        let (width, height) = self.0.figure().size();
        format!("<implicit_mpm.Picture of {width} × {height} pixels>")
    }
}

//! What goes wrong, and the exceptions that tell it: the classes are those of `implicit_mpm._errors`.

use mpm_grid::rounded;
use mpm_scene::SceneError;
use mpm_scene::language::{Position, ReadError, position_of};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;

/// Why something was not done.
#[derive(Clone, Debug)]
pub(crate) enum Failure {
    /// The input is wrong.
    Input(Box<Fault>),
    /// The simulation could not finish: why, and the whole message.
    Run { reason: String, message: String },
}

/// What is wrong in an input, and where.
#[derive(Clone, Debug, Default)]
pub(crate) struct Fault {
    /// Name of the file or text.
    file: Option<String>,
    /// Line and column, from 1.
    place: Option<(usize, usize)>,
    /// Path of the field.
    field: Option<String>,
    reason: String,
}

impl Failure {
    /// An input that is wrong as a whole.
    pub(crate) fn input(reason: impl ToString) -> Self {
        Self::Input(Box::new(Fault { reason: rounded(&reason.to_string()), ..Fault::default() }))
    }

    /// A simulation that could not finish.
    pub(crate) fn run(reason: impl ToString) -> Self {
        let reason = rounded(&reason.to_string());
        Self::Run { message: reason.clone(), reason }
    }

    /// The same failure, with a sentence behind the reason.
    pub(crate) fn with(self, more: &str) -> Self {
        match self {
            Self::Run { reason, message } => Self::Run { reason, message: message + more },
            input => input,
        }
    }

    /// Text of a scene that cannot be read.
    pub(crate) fn read(file: &str, error: ReadError) -> Self {
        let place = Some((error.start.line, error.start.column));
        let reason = rounded(&error.reason);
        Self::Input(Box::new(Fault { file: Some(file.into()), place, reason, field: None }))
    }

    /// A scene that is well formed and does not compile.
    pub(crate) fn refused(file: &str, text: &str, error: SceneError) -> Self {
        let place =
            position_of(text, &error.path).map(|(start, _): (Position, Position)| (start.line, start.column));
        let reason = rounded(&error.reason);
        Self::Input(Box::new(Fault { file: Some(file.into()), place, field: Some(error.path), reason }))
    }

    /// The exception.
    pub(crate) fn raise(self, py: Python<'_>) -> PyErr {
        static INPUT: PyOnceLock<Py<PyType>> = PyOnceLock::new();
        static RUN: PyOnceLock<Py<PyType>> = PyOnceLock::new();
        let class = |cell: &'static PyOnceLock<Py<PyType>>, name: &str| {
            cell.import(py, "implicit_mpm._errors", name).cloned()
        };
        let made = match self {
            Self::Input(fault) => class(&INPUT, "InputError").and_then(|class| {
                let Fault { file, place, field, reason } = *fault;
                class.call1((reason, file, place.map(|it| it.0), place.map(|it| it.1), field))
            }),
            Self::Run { reason, message } => {
                class(&RUN, "RunError").and_then(|class| class.call1((message, reason)))
            }
        };
        made.map_or_else(|error| error, PyErr::from_value)
    }
}

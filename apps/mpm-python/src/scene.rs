//! Scenes.

use crate::errors::Failure;
use mpm_io::{ArrayFiles, FolderFiles};
use mpm_scene::language::{EditError, set_value};
use mpm_scene::{Check, Compiled, NamedColumns, PointTable, Scene as Language, SceneFiles, compile_with};
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Tables in place of files, as Python hands them over: columns by the names of files.
pub(crate) type Tables<'py> = BTreeMap<String, Vec<(String, PyReadonlyArray1<'py, f64>)>>;

/// A scene that was read; `implicit_mpm.Scene` wraps it.
#[pyclass(frozen, module = "implicit_mpm._native")]
#[derive(Clone)]
pub(crate) struct Scene {
    text: String,
    name: String,
    scene: Language,
    files: ArrayFiles,
}

/// The JSON schema of the language of scenes.
#[pyfunction]
pub(crate) fn schema() -> String {
    schemars::schema_for!(Language).as_value().to_string()
}

/// Text of a file, without the byte order mark that some editors write.
#[pyfunction]
pub(crate) fn read_text(py: Python<'_>, file: PathBuf) -> PyResult<String> {
    let read = py.detach(|| std::fs::read(&file));
    let cannot =
        |reason: String| Failure::input(format!("cannot read scene {}: {reason}", file.display())).raise(py);
    let bytes = read.map_err(|error| cannot(error.to_string()))?;
    let text = String::from_utf8(bytes).map_err(|error| {
        cannot(format!("it is not UTF-8 text: byte {} is no character", error.utf8_error().valid_up_to()))
    })?;
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

/// Tables in place of files, and a folder for the others.
pub(crate) fn files(folder: PathBuf, tables: Tables<'_>) -> ArrayFiles {
    let mut files = ArrayFiles::beside(FolderFiles::new(folder));
    for (file, columns) in tables {
        let columns = columns.iter().map(|(name, it)| (name.clone(), it.as_array().to_vec())).collect();
        files.insert(file, columns);
    }
    files
}

impl Scene {
    pub(crate) fn read(text: String, name: String, files: ArrayFiles) -> Result<Self, Failure> {
        let scene = Language::from_ron(&text).map_err(|error| Failure::read(&name, error))?;
        Ok(Self { text, name, scene, files })
    }

    pub(crate) fn source(&self) -> &str {
        &self.text
    }

    pub(crate) fn file(&self) -> &str {
        &self.name
    }

    pub(crate) fn language(&self) -> &Language {
        &self.scene
    }

    pub(crate) fn files(&self) -> &ArrayFiles {
        &self.files
    }

    /// The model, and notes on what of the scene's files was not read.
    pub(crate) fn compiled(&self) -> Result<(Compiled, Vec<String>), Failure> {
        let files = Noted { files: &self.files, notes: RefCell::default() };
        let compiled = compile_with(&self.scene, &files);
        let compiled = compiled.map_err(|error| Failure::refused(&self.name, &self.text, error))?;
        let mut notes = files.notes.into_inner();
        notes.sort();
        notes.dedup();
        Ok((compiled, notes))
    }

    fn checked(&self) -> Result<String, Failure> {
        let (mut compiled, notes) = self.compiled()?;
        let estimate = compiled.estimate().map_err(Failure::run)?;
        serde_json::to_string(&Check::of(&estimate, &self.scene, &notes)).map_err(Failure::run)
    }
}

#[pymethods]
impl Scene {
    /// Reads a scene; `folder` and `tables` have the files that it names.
    #[new]
    fn new(py: Python<'_>, text: String, name: String, folder: PathBuf, tables: Tables<'_>) -> PyResult<Self> {
        let files = files(folder, tables);
        py.detach(|| Self::read(text, name, files)).map_err(|failure| failure.raise(py))
    }

    /// Its text.
    #[getter]
    fn text(&self) -> &str {
        &self.text
    }

    /// Name of its file.
    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    /// What it shows.
    #[getter]
    fn title(&self) -> &str {
        self.scene.title()
    }

    /// The scene as JSON, with the values that its text leaves out.
    fn json(&self, py: Python<'_>) -> PyResult<String> {
        serde_json::to_string(&self.scene).map_err(|error| Failure::input(error).raise(py))
    }

    /// The scene with one value set.
    fn with_value(&self, py: Python<'_>, path: &str, value: &str) -> PyResult<Self> {
        let wrong = |reason: String| Failure::input(format!("{path}={value}: {reason}")).raise(py);
        let edited = set_value(&self.text, path, value).map_err(|error| {
            let (EditError::Path(reason) | EditError::Value(reason)) = error;
            wrong(reason)
        })?;
        let scene = Language::from_ron(&edited.text).map_err(|error| wrong(error.reason))?;
        Ok(Self { text: edited.text, scene, ..self.clone() })
    }

    /// What `mpm check --json` prints.
    fn check(&self, py: Python<'_>) -> PyResult<String> {
        py.detach(|| self.checked()).map_err(|failure| failure.raise(py))
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.scene == other.scene
    }
}

/// Files, with what of them was not read.
struct Noted<'a> {
    files: &'a ArrayFiles,
    notes: RefCell<Vec<String>>,
}

impl SceneFiles for Noted<'_> {
    fn surface(&self, file: &str) -> Result<mpm_geometry::Surface, String> {
        self.files.surface(file)
    }

    fn points(&self, file: &str, dimensions: usize) -> Result<PointTable, String> {
        let table = self.files.points(file, dimensions)?;
        self.notes.borrow_mut().extend(table.notes.iter().map(|note| format!("{}: {note}", table.file)));
        Ok(table)
    }

    fn columns(&self, file: &str) -> Result<NamedColumns, String> {
        self.files.columns(file)
    }
}

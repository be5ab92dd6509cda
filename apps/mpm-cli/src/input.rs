//! From a path to a compiled scene, or to a complaint that points into the file.

use crate::complaint::Complaint;
use mpm_io::FolderFiles;
use mpm_solver::scene::{Position, Scene, position_of};
use mpm_solver::{Compiled, SceneError, compile_with};
use std::path::Path;

/// A scene that was read and compiled.
pub struct Input {
    /// Its text.
    pub text: String,
    /// What the text says.
    pub scene: Scene,
    /// What it comes to.
    pub compiled: Compiled,
}

/// Reads and compiles the scene in `file`.
pub fn read(file: &Path) -> Result<Input, Complaint> {
    let bytes = std::fs::read(file)
        .map_err(|error| Complaint::input(format!("cannot read scene {}: {error}", file.display())))?;
    let text = String::from_utf8(bytes).map_err(|error| not_text(file, &error))?;
    parse(file, text, &FolderFiles::beside(file))
}

/// Reads and compiles the scene in `text`, which comes from `file`; `files` has what it names.
pub fn parse(file: &Path, text: String, files: &FolderFiles) -> Result<Input, Complaint> {
    let scene = Scene::from_ron(&text).map_err(|error| {
        let place = error.start.offset(&text)..error.end.offset(&text);
        Complaint::at(file, &text, place, None, error.reason)
    })?;
    let compiled = compile_with(&scene, files).map_err(|error| refused(file, &text, error))?;
    Ok(Input { text, scene, compiled })
}

/// What is wrong only in the light of the whole scene.
pub fn refused(file: &Path, text: &str, error: SceneError) -> Complaint {
    let (start, end) = position_of(text, &error.path).unwrap_or((Position::of(text, 0), Position::of(text, 0)));
    Complaint::at(file, text, start.offset(text)..end.offset(text), Some(error.path), error.reason)
}

fn not_text(file: &Path, error: &std::string::FromUtf8Error) -> Complaint {
    let valid = error.utf8_error().valid_up_to();
    let before = String::from_utf8_lossy(&error.as_bytes()[..valid]).into_owned();
    let message = format!("scene is not UTF-8 text: byte {valid} is no character");
    Complaint::at(file, &before, valid..valid, None, message)
}

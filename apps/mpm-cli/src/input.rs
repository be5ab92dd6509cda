//! From a path to a compiled scene, or to a complaint that points into the file.

use crate::complaint::Complaint;
use mpm_solver::scene::{Position, Scene, position_of};
use mpm_solver::{Compiled, SceneError, compile};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Longest scene that is read: some files never end [bytes].
const LONGEST: u64 = 64 << 20;

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
    let cannot = |reason: String| Complaint::input(format!("cannot read scene {}: {reason}", file.display()));
    let mut bytes = Vec::new();
    let opened = File::open(file).and_then(|it| it.take(LONGEST + 1).read_to_end(&mut bytes));
    opened.map_err(|error| cannot(error.to_string()))?;
    if bytes.len() as u64 > LONGEST {
        return Err(cannot(format!("it is longer than {} MiB", LONGEST >> 20)));
    }
    parse(file, String::from_utf8(bytes).map_err(|error| not_text(file, &error))?)
}

/// Reads and compiles the scene in `text`, which comes from `file`.
pub fn parse(file: &Path, text: String) -> Result<Input, Complaint> {
    let scene = Scene::from_ron(&text).map_err(|error| {
        let place = error.start.offset(&text)..error.end.offset(&text);
        Complaint::at(file, &text, place, None, error.reason)
    })?;
    let compiled = compile(&scene).map_err(|error| refused(file, &text, error))?;
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

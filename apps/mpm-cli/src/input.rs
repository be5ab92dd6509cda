//! From a path to a compiled scene, or to a complaint that points into the file.

use crate::complaint::Complaint;
use crate::reading::Files;
use clap::Args;
use mpm_io::FolderFiles;
use mpm_scene::language::{EditError, Position, ReadError, Scene, position_of, set_value};
use mpm_scene::{Compiled, SceneError, ShareOfPoints, compile_share, compile_with, implausible};
use std::fs::File;
use std::io::Read;
use std::ops::Range;
use std::path::Path;

/// What is set in the scene before it is read.
#[derive(Args)]
pub struct Settings {
    /// Set a value of the scene, as in `schedule.steps=20` or `bodies[0].points_per_cell=3`; several times, if
    /// needed. The results keep the scene as it was run.
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub set: Vec<String>,
}

/// Longest scene that is read, because files such as devices never end `[B]`.
const LONGEST: u64 = 64 << 20;

/// A scene that was read and compiled.
pub struct Input {
    /// Its text.
    pub text: String,
    /// What the text says.
    pub scene: Scene,
    /// What it comes to.
    pub compiled: Compiled,
    /// What of the files that it names was not read.
    pub notes: Vec<String>,
}

/// Reads the scene in `file`, sets values in it, each `path=value`, and compiles it; `files` has what it names.
pub fn read(file: &Path, settings: &[String], files: &FolderFiles) -> Result<Input, Complaint> {
    set(file, text(file)?, settings, files)
}

/// The same of the points that this process makes; of all, where no others make any.
pub fn read_share(
    file: &Path,
    settings: &[String],
    files: &FolderFiles,
    share: Option<ShareOfPoints>,
) -> Result<Input, Complaint> {
    set_share(file, text(file)?, settings, files, share)
}

/// The text of the scene in `file`.
pub fn text(file: &Path) -> Result<String, Complaint> {
    let cannot = |reason: String| Complaint::input(format!("cannot read scene {}: {reason}", file.display()));
    let mut bytes = Vec::new();
    let opened = File::open(file).and_then(|it| it.take(LONGEST + 1).read_to_end(&mut bytes));
    opened.map_err(|error| cannot(error.to_string()))?;
    if bytes.len() as u64 > LONGEST {
        return Err(cannot(format!("it is longer than {} MiB", LONGEST >> 20)));
    }
    if bytes.starts_with("\u{feff}".as_bytes()) {
        // The byte order mark that some editors write.
        bytes.drain(.."\u{feff}".len());
    }
    String::from_utf8(bytes).map_err(|error| not_text(file, &error))
}

/// Sets values in the scene in `text`, which comes from `file`, and compiles it; `files` has what it names.
pub fn set(file: &Path, text: String, settings: &[String], files: &FolderFiles) -> Result<Input, Complaint> {
    set_share(file, text, settings, files, None)
}

fn set_share(
    file: &Path,
    mut text: String,
    settings: &[String],
    files: &FolderFiles,
    share: Option<ShareOfPoints>,
) -> Result<Input, Complaint> {
    let mut scene = read_text(file, &text)?;
    for setting in settings {
        (text, scene) = set_one(&text, setting)?;
    }
    let files = Files::of(files);
    let compiled = match share {
        None => compile_with(&scene, &files),
        Some(share) => compile_share(&scene, &files, share),
    };
    let compiled = compiled.map_err(|error| refused_setting(file, &text, settings, told(&scene, error)))?;
    Ok(Input { text, scene, compiled, notes: files.into_notes() })
}

/// Reads and compiles the scene in `text`, which comes from `file`; `files` has what it names.
pub fn parse(file: &Path, text: String, files: &FolderFiles) -> Result<Input, Complaint> {
    let scene = read_text(file, &text)?;
    let files = Files::of(files);
    let compiled = compile_with(&scene, &files).map_err(|error| refused(file, &text, error))?;
    Ok(Input { text, scene, compiled, notes: files.into_notes() })
}

fn read_text(file: &Path, text: &str) -> Result<Scene, Complaint> {
    Scene::from_ron(text).map_err(|error| Complaint::at(file, text, place(text, &error), None, error.reason))
}

fn place(text: &str, error: &ReadError) -> Range<usize> {
    error.start.offset(text)..error.end.offset(text)
}

/// The text with one value set, `path=value`, and what it then says. What is wrong stands in the setting, not in
/// the file.
fn set_one(text: &str, setting: &str) -> Result<(String, Scene), Complaint> {
    let Some((path, value)) = setting.split_once('=') else {
        let reason = "expected a path and a value, as in schedule.steps=20".to_string();
        return Err(in_setting(setting, 0..setting.len(), reason));
    };
    let of_path = 0..path.len();
    let of_value = value_in(setting);
    let edited = set_value(text, path.trim(), value).map_err(|error| match error {
        EditError::Path(reason) => in_setting(setting, of_path.clone(), reason),
        EditError::Value(reason) => in_setting(setting, of_value.clone(), reason),
    })?;
    let scene = Scene::from_ron(&edited.text).map_err(|error| {
        let found = place(&edited.text, &error);
        let place = if edited.value.contains(&found.start) {
            let start = of_value.start + (found.start - edited.value.start);
            start..(start + found.len()).min(of_value.end)
        } else if edited.new.contains(&found.start) {
            of_path.clone()
        } else {
            of_value.clone()
        };
        in_setting(setting, place, error.reason)
    })?;
    Ok((edited.text, scene))
}

/// Where the value of a setting stands.
fn value_in(setting: &str) -> Range<usize> {
    let start = setting.find('=').map_or(0, |at| at + 1);
    let value = &setting[start..];
    let start = start + value.len() - value.trim_start().len();
    start..(start + value.trim().len())
}

fn in_setting(setting: &str, place: Range<usize>, reason: String) -> Complaint {
    Complaint::at(Path::new("--set"), setting, place, None, reason)
}

/// The message for a scene that is well formed but does not compile.
pub fn refused(file: &Path, text: &str, error: SceneError) -> Complaint {
    let place = place_of(text, &error.path).unwrap_or(0..0);
    Complaint::at(file, text, place, Some(error.path), error.reason)
}

/// An error of a scene with what in it is probably not meant, which may be the cause.
fn told(scene: &Scene, SceneError { path, mut reason }: SceneError) -> SceneError {
    for doubt in implausible(scene) {
        reason = format!("{reason}; {doubt}");
    }
    SceneError { path, reason }
}

/// As [`refused`]; an error in a value given by `--set`, or around it, is reported at the setting.
fn refused_setting(file: &Path, text: &str, settings: &[String], error: SceneError) -> Complaint {
    let found = place_of(text, &error.path);
    let culprit = settings.iter().rev().find(|setting| {
        let path = setting.split_once('=').map_or("", |(path, _)| path.trim());
        let (Some(found), Some(value)) = (&found, place_of(text, path)) else { return false };
        let holds =
            |outer: &Range<usize>, inner: &Range<usize>| outer.start <= inner.start && inner.end <= outer.end;
        holds(&value, found) || holds(found, &value)
    });
    match culprit {
        Some(setting) => {
            let SceneError { path, reason } = error;
            Complaint::at(Path::new("--set"), setting, value_in(setting), Some(path), reason)
        }
        None => refused(file, text, error),
    }
}

fn place_of(text: &str, path: &str) -> Option<Range<usize>> {
    let (start, end): (Position, Position) = position_of(text, path)?;
    Some(start.offset(text)..end.offset(text))
}

fn not_text(file: &Path, error: &std::string::FromUtf8Error) -> Complaint {
    let valid = error.utf8_error().valid_up_to();
    let before = String::from_utf8_lossy(&error.as_bytes()[..valid]).into_owned();
    let message = format!("scene is not UTF-8 text: byte {valid} is no character");
    Complaint::at(file, &before, valid..valid, None, message)
}

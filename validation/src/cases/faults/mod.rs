//! Inputs that are easily answered wrongly: each gets its right value, or a message.

mod driven;
mod files;
mod held;
mod said_and_run;

use crate::scenes::{Run, run_compiled};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_io::FolderFiles;
use mpm_scene::{Compiled, Scene, SceneError, compile_with};
use std::path::{Path, PathBuf};

pub(super) const CASE: Case = Case {
    name: "inputs that are easily answered wrongly",
    goal: "Every input gets its right value, or is refused with a message that names what is wrong; none ends as completed with a wrong number.",
    setup: "Small scenes (`validation/scenes/faults`), each for one kind of input, most with every basis. What only the program `mpm` can tell of (drawing, files of other programs, time of the output) is in `apps/mpm-cli/tests/kinds.rs`.",
    reference: "Closed forms, balance of forces and moments, volumes; for what is refused, the message.",
    run: faults,
};

/// One kind of input and what is to come of it.
struct Kind {
    /// What the input is.
    input: &'static str,
    /// Name of a scene of its kind.
    scene: &'static str,
    /// Tries it: the answer in words, how far that is from the right one, and how far it may be.
    answer: fn(&str) -> Result<Answer, Broken>,
}

struct Answer {
    said: String,
    error: f64,
    tolerance: f64,
}

impl Answer {
    fn new(said: impl Into<String>, error: f64, tolerance: f64) -> Self {
        Self { said: said.into(), error, tolerance }
    }

    /// A message that must contain some words.
    fn message(said: impl Into<String>, words: &str) -> Self {
        let said = said.into();
        let error = f64::from(u8::from(!said.contains(words)));
        Self { said, error, tolerance: 0.0 }
    }
}

fn kinds() -> impl Iterator<Item = &'static Kind> {
    [said_and_run::KINDS, files::KINDS, driven::KINDS, held::KINDS].into_iter().flatten()
}

fn faults(_: Extent) -> Result<Findings, Broken> {
    let mut table = Table::new("What each input is answered with.", &["kind", "scene", "answer"]);
    let mut findings = Findings::default();
    for Kind { input, scene, answer } in kinds() {
        // What stops one of them must not hide the others.
        let Answer { said, error, tolerance } =
            answer(scene).unwrap_or_else(|error| Answer::new(error.to_string(), f64::NAN, 0.0));
        table.push([(*input).into(), format!("`{scene}`"), said.clone()]);
        findings.checks.push(Check::new(*input, error, tolerance).remark(said));
    }
    findings.tables.push(table);
    Ok(findings)
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/faults")
}

/// Text of a scene.
fn text(name: &str) -> Result<String, Broken> {
    let path = folder().join(name).with_extension("ron");
    std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()).into())
}

fn compiled(text: &str) -> Result<(Scene, Result<Compiled, SceneError>), Broken> {
    let scene = Scene::from_ron(text)?;
    let compiled = compile_with(&scene, &FolderFiles::new(folder()));
    Ok((scene, compiled))
}

/// Runs a scene to its end.
fn run(text: &str) -> Result<Run, Broken> {
    let (scene, compiled) = compiled(text)?;
    let run = run_compiled(&mut compiled?, &scene);
    run.outcome.as_ref().map_err(|error| error.to_string())?;
    Ok(run)
}

/// The message with which a scene is refused.
fn refusal(text: &str) -> Result<String, Broken> {
    match compiled(text)?.1 {
        Ok(_) => Ok("accepted".into()),
        Err(error) => Ok(error.to_string()),
    }
}

/// What `mpm check` remarks about a scene.
fn remarks(text: &str) -> Result<String, Broken> {
    Ok(compiled(text)?.1?.estimate()?.remarks.join("; "))
}

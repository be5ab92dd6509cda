//! `mpm run` and `mpm resume`.

use crate::complaint::Complaint;
use crate::input::Input;
use crate::keeper::{self, Keeper};
use crate::reading::{self, Files, Kind};
use crate::watch::Watch;
use crate::{ResumeArguments, RunArguments, input, inspect, report, say};
use mpm_io::{Checkpoint, CheckpointError, CheckpointHead, FolderFiles, Options, ResultsWriter};
use mpm_solver::scene::Scene;
use mpm_solver::{Error, State};
use std::io::Write;
use std::path::{Path, PathBuf};

/// The program that writes the files.
const PROGRAM: &str = concat!("mpm ", env!("CARGO_PKG_VERSION"));

/// Runs a scene from file to file.
pub fn run(arguments: &RunArguments) -> Result<(), Complaint> {
    start_threads(arguments.threads)?;
    let input = input::read(&arguments.scene, &arguments.settings.set)?;
    let path = output(arguments)?;
    let head = CheckpointHead {
        scene: input.text.clone(),
        folder: folder(&input.scene, &arguments.scene),
        program: PROGRAM.into(),
        results: path.clone(),
        interval: keeper::interval(&input.scene),
    };
    let keeper = Keeper::new(keeper::beside(&path), head, &arguments.checkpoints)?;
    let writer = ResultsWriter::create(&path, options(&input));
    let writer = writer.map_err(|error| Complaint::input(error.to_string()))?;
    let files = Paths { scene: &arguments.scene, results: &path };
    let outcome = carry_out(input, None, writer, keeper, &files, arguments.quiet || arguments.json);
    // Results that cannot be read back are no reason to forget why the run ended.
    let said = if arguments.json { inspect::inspect(&path, true).and_then(|text| say(&text)) } else { Ok(()) };
    outcome.and(said)
}

/// Goes on with a run from its checkpoint.
pub fn resume(arguments: &ResumeArguments) -> Result<(), Complaint> {
    start_threads(arguments.threads)?;
    let file = &arguments.checkpoint_file;
    let refuse = |error: CheckpointError| Complaint::input(error.to_string());
    reading::survives(file, Kind::Checkpoint)?;
    let checkpoint = Checkpoint::open(file).map_err(refuse)?;
    let mut head = checkpoint.head().clone();
    let input = input::parse(file, head.scene.clone(), &Files(FolderFiles::new(&head.folder)))?;
    let state = checkpoint.state(&input.compiled.state_layout()).map_err(refuse)?;
    if head.program != PROGRAM {
        let note = format!(
            "{} was written by {}, this is {PROGRAM}: the rest may differ in its last digits",
            file.display(),
            head.program
        );
        // Nobody is left to tell if this fails.
        let _ = writeln!(std::io::stderr(), "warning: {note}");
    }
    let path = arguments.output.clone().unwrap_or(head.results);
    if arguments.output.is_none() && !path.exists() {
        return Err(Complaint::input(format!(
            "the results file {} is not there: name it by --output, or a new file for the rest of the history",
            path.display()
        )));
    }
    if is_same(&path, file) {
        return Err(Complaint::input(format!("the results file {} is the checkpoint itself", path.display())));
    }
    (head.program, head.results) = (PROGRAM.into(), path.clone());
    let mut keeper = Keeper::new(file.clone(), head, &arguments.checkpoints)?;
    if arguments.checkpoints.checkpoint.is_none() {
        keeper.has_kept(state.progress.rows().saturating_sub(1));
    }
    reading::survives(&path, Kind::Results)?;
    let writer = ResultsWriter::resume(&path, options(&input));
    let writer = writer.map_err(|error| Complaint::input(error.to_string()))?;
    let files = Paths { scene: file, results: &path };
    carry_out(input, Some(&state), writer, keeper, &files, arguments.quiet)
}

/// Where a run comes from and goes to.
struct Paths<'a> {
    scene: &'a Path,
    results: &'a Path,
}

fn carry_out(
    mut input: Input,
    state: Option<&State>,
    writer: ResultsWriter,
    keeper: Keeper,
    files: &Paths<'_>,
    quiet: bool,
) -> Result<(), Complaint> {
    keeper::listen(keeper.cancellation())?;
    let mut watch = Watch::new(writer, keeper, quiet);
    let outcome = match state {
        None => input.compiled.run(&mut watch),
        Some(state) => input.compiled.resume(state, &mut watch),
    };
    if !quiet {
        say(&report::convergence(watch.rows()))?;
        if let Ok(summary) = &outcome {
            say(&report::summary(summary, &input.scene, files.results))?;
        }
    }
    match outcome {
        Ok(_) => Ok(()),
        Err(Error::Scene(error)) => Err(input::refused(files.scene, &input.text, error)),
        Err(Error::State(error)) => {
            Err(Complaint::input(format!("checkpoint {}: {error}", files.scene.display())))
        }
        // The results file of before is not what it should be.
        Err(Error::Observer(error)) if state.is_some() && !watch.has_started() => {
            Err(Complaint::input(error.to_string()))
        }
        Err(error) => Err(Complaint::unfinished(format!(
            "{error}\n{} in {}{}",
            match watch.steps() {
                0 => "The state at its start is".to_string(),
                1 => "The load step before it is".to_string(),
                steps => format!("The {steps} load steps before it are"),
            },
            files.results.display(),
            watch.advice()
        ))),
    }
}

fn start_threads(threads: Option<u16>) -> Result<(), Complaint> {
    let Some(threads) = threads else { return Ok(()) };
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads.into())
        .build_global()
        .map_err(|error| Complaint::input(format!("cannot start {threads} threads: {error}")))
}

/// What the results file is to hold.
fn options(input: &Input) -> Options {
    Options {
        scene: input.text.clone(),
        program: PROGRAM.into(),
        fields: input.scene.output().fields.clone(),
        every: input.scene.output().every.0 as usize,
        ..Options::default()
    }
}

/// Where the files lie that a scene names, if it names any.
fn folder(scene: &Scene, file: &Path) -> PathBuf {
    if scene.files().is_empty() {
        return PathBuf::new();
    }
    let folder = file.parent().filter(|it| !it.as_os_str().is_empty()).unwrap_or(Path::new("."));
    folder.canonicalize().unwrap_or_else(|_| folder.into())
}

/// Where the results go.
fn output(arguments: &RunArguments) -> Result<PathBuf, Complaint> {
    let path = match &arguments.output {
        Some(path) => path.clone(),
        None => Path::new(arguments.scene.file_stem().unwrap_or_default()).with_extension("h5"),
    };
    // The results would replace the scene that they come from.
    if is_same(&path, &arguments.scene) {
        return Err(Complaint::input(format!("the results file {} is the scene itself", path.display())));
    }
    Ok(path)
}

fn is_same(a: &Path, b: &Path) -> bool {
    a.canonicalize().is_ok_and(|a| b.canonicalize().is_ok_and(|b| a == b))
}

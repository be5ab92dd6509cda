//! `mpm run` and `mpm resume`.

use crate::complaint::Complaint;
use crate::input::{Input, Settings};
use crate::keeper::{self, CheckpointArguments};
use crate::reading::{self, Kind};
use crate::say::say;
use crate::watch::{Show, Watch};
use crate::{input, inspect, previous, report};
use clap::Args;
use mpm_io::{
    Checkpoint, CheckpointError, CheckpointHead, CheckpointInterval, FolderFiles, Keeper, Options,
    ResultsWriter, check_places, is_same,
};
use mpm_scene::{AddedStages, Scene, doubts};
use mpm_solver::{Error, State};
use std::ffi::OsStr;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

#[derive(Args)]
pub struct RunArguments {
    /// The scene, a RON file (its language: scenes/README.md, or `mpm schema --markdown`).
    pub scene: PathBuf,
    #[command(flatten)]
    pub settings: Settings,
    /// Results file; an .xdmf file is written beside it [default: the scene's name with .h5, in this directory].
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Replace results of a run that was interrupted, or was longer, and its checkpoint.
    #[arg(long)]
    pub force: bool,
    /// Folder in which the files lie that the scene names [default: that of the scene].
    #[arg(long, value_name = "FOLDER")]
    pub files: Option<PathBuf>,
    #[command(flatten)]
    pub checkpoints: CheckpointArguments,
    /// Number of threads; never changes a result [default: one per core].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Print nothing unless something is wrong.
    #[arg(short, long)]
    pub quiet: bool,
    /// Print what `mpm inspect --json` says of the results, and nothing else.
    #[arg(long, conflicts_with = "quiet")]
    pub json: bool,
}

#[derive(Args)]
pub struct ResumeArguments {
    /// The checkpoint; the scene is in it.
    pub checkpoint_file: PathBuf,
    /// Go on with this scene: that of the checkpoint with stages added behind the others, and with what begins with them or ends
    /// in them.
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// Results file; where there is none, its history begins here [default: that of the interrupted run].
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Folder in which the files lie that the scene names [default: where they were].
    #[arg(long, value_name = "FOLDER")]
    pub files: Option<PathBuf>,
    #[command(flatten)]
    pub checkpoints: CheckpointArguments,
    /// Number of threads; never changes a result [default: one per core].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Print nothing unless something is wrong.
    #[arg(short, long)]
    pub quiet: bool,
}

/// The program that writes the files.
const PROGRAM: &str = concat!("mpm ", env!("CARGO_PKG_VERSION"));

/// A file with this extension beside what has the name; a dot in the name is part of it, as in `factor_0.5`.
pub fn named_after(name: &OsStr, extension: &str) -> PathBuf {
    let mut file = name.to_os_string();
    file.push(".");
    file.push(extension);
    file.into()
}

/// Runs a scene from file to file.
pub fn run(arguments: &RunArguments) -> Result<(), Complaint> {
    start_threads(arguments.threads)?;
    let files = files_of(&arguments.scene, arguments.files.as_deref());
    let input = input::read(&arguments.scene, &arguments.settings.set, &files)?;
    let path = arguments
        .output
        .clone()
        .unwrap_or_else(|| named_after(arguments.scene.file_stem().unwrap_or_default(), "h5"));
    let head = CheckpointHead {
        scene: input.text.clone(),
        folder: folder(&input.scene, &files),
        program: PROGRAM.into(),
        results: path.clone(),
        interval: CheckpointInterval::of(&input.scene),
    };
    let mut read = named(&input.scene, &files);
    read.push(("scene", arguments.scene.clone()));
    let checkpoint = arguments.checkpoints.checkpoint.clone().unwrap_or_else(|| Keeper::beside(&path));
    check_places(&read, Some(&path), Some(&checkpoint)).map_err(Complaint::input)?;
    if !arguments.force {
        previous::protect(&input.scene, &input.text, &path, &checkpoint)?;
    }
    let keeper = arguments.checkpoints.keeper(checkpoint, head)?;
    let writer = ResultsWriter::create(&path, options(&input, arguments.threads));
    let writer = writer.map_err(|error| Complaint::input(error.to_string()))?;
    let files = Paths { scene: &arguments.scene, results: &path };
    let outcome = carry_out(input, None, writer, keeper, &files, arguments.quiet || arguments.json);
    // The reason why the run ended is more important than an error in reading its results back.
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
    if let Some(folder) = &arguments.files {
        head.folder.clone_from(folder);
    }
    let files = FolderFiles::new(&head.folder);
    let mut input = input::parse(file, head.scene.clone(), &files)?;
    head.folder = folder(&input.scene, &files);
    let mut state = checkpoint.state(&input.compiled.state_layout()).map_err(refuse)?;
    let mut earlier_scene = None;
    if let Some(scene) = &arguments.scene {
        let added = with_stages(scene, input, state, file, &files)?;
        (input, state) = added;
        earlier_scene = Some(std::mem::replace(&mut head.scene, input.text.clone()));
    }
    if head.program != PROGRAM {
        let note = format!(
            "{} was written by {}, this is {PROGRAM}: the rest may differ in its last digits",
            file.display(),
            head.program
        );
        // If standard error is closed, there is nowhere to report it.
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
    let checkpoint = arguments.checkpoints.checkpoint.as_ref().unwrap_or(file);
    let mut read = named(&input.scene, &files);
    read.extend(arguments.scene.iter().map(|scene| ("scene", scene.clone())));
    check_places(&read, Some(&path), Some(checkpoint)).map_err(Complaint::input)?;
    (head.program, head.results) = (PROGRAM.into(), path.clone());
    let mut keeper = arguments.checkpoints.keeper(checkpoint.clone(), head)?;
    if arguments.checkpoints.checkpoint.is_none() {
        keeper.has_kept(state.progress.rows().saturating_sub(1));
    }
    reading::survives(&path, Kind::Results)?;
    let writer = ResultsWriter::resume(&path, Options { earlier_scene, ..options(&input, arguments.threads) });
    let writer = writer.map_err(|error| Complaint::input(error.to_string()))?;
    let files = Paths { scene: file, results: &path };
    carry_out(input, Some(&state), writer, keeper, &files, arguments.quiet)
}

/// The scene in `file`, which has more stages than that of the checkpoint, and the state as one of a run of it.
fn with_stages(
    file: &Path,
    before: Input,
    state: State,
    checkpoint: &Path,
    files: &FolderFiles,
) -> Result<(Input, State), Complaint> {
    let mut after = input::set(file, input::text(file)?, &[], files)?;
    let added = AddedStages::between(&before.scene, &after.scene);
    let added = added.map_err(|error| input::refused(file, &after.text, error))?;
    if added.names.is_empty() {
        return Ok((after, state));
    }
    let state = added.extend(state, &before.compiled, &after.compiled);
    let state =
        state.map_err(|error| Complaint::input(format!("checkpoint {}: {error}", checkpoint.display())))?;
    let names: Vec<String> = added.names.iter().map(|name| format!("`{name}`")).collect();
    after.notes.push(format!("stages that the scene of the checkpoint has not: {}", names.join(", ")));
    Ok((after, state))
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
    if !quiet {
        for note in &input.notes {
            // Nobody is left to tell if this fails.
            let _ = writeln!(std::io::stderr(), "note: {note}");
        }
        // Those of a run that goes on were told at its start.
        let doubts = if state.is_none() { doubts(&input.scene, &input.compiled) } else { Vec::new() };
        for doubt in doubts {
            let _ = writeln!(std::io::stderr(), "warning: {doubt}");
        }
    }
    let show = match quiet {
        true => Show::Nothing,
        false if std::io::stdout().is_terminal() => Show::Bar,
        false => Show::Lines,
    };
    let mut watch = Watch::new(writer, keeper, show);
    let outcome = match state {
        None => input.compiled.run(&mut watch),
        Some(state) => input.compiled.resume(state, &mut watch),
    };
    if !quiet {
        if show == Show::Bar {
            say(&report::convergence(watch.rows()))?;
        }
        if let Ok(summary) = &outcome {
            say(&report::summary(summary, &input.scene, files.results))?;
        }
    }
    match outcome {
        Ok(_) => Ok(()),
        Err(Error::State(error)) => {
            Err(Complaint::input(format!("checkpoint {}: {error}", files.scene.display())))
        }
        // The existing results file does not fit the checkpoint.
        Err(Error::Observer(error)) if state.is_some() && !watch.has_started() => {
            Err(Complaint::input(error.to_string()))
        }
        Err(error) => {
            let results = files.results.display();
            let before = match watch.steps() {
                _ if !files.results.exists() => format!("The results file {results} is gone"),
                0 => format!("The state at its start is in {results}"),
                1 => format!("The load step before it is in {results}"),
                steps => format!("The {steps} load steps before it are in {results}"),
            };
            let scene = files.scene.display();
            let hint = match (watch.steps(), state) {
                (0, None) => format!("\nWhat the scene may lack is told by: mpm check {scene}"),
                _ => String::new(),
            };
            Err(Complaint::unfinished(format!("{error}\n{before}{}{hint}", watch.advice())))
        }
    }
}

/// The files that a scene names: in a folder, or beside it.
pub fn files_of(scene: &Path, folder: Option<&Path>) -> FolderFiles {
    folder.map_or_else(|| FolderFiles::beside(scene), FolderFiles::new)
}

/// Lets the program compute on so many threads; on all that there are if none are named.
pub fn start_threads(threads: Option<u16>) -> Result<(), Complaint> {
    let Some(threads) = threads else { return Ok(()) };
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads.into())
        .build_global()
        .map_err(|error| Complaint::input(format!("cannot start {threads} threads: {error}")))
}

/// What the results file is to hold, of a run on so many threads.
fn options(input: &Input, threads: Option<u16>) -> Options {
    let output = input.scene.output();
    let asked = Options::of(output, input.compiled.fields(output).expect("compiled with them"));
    let beside = asked.beside && threads != Some(1);
    Options { scene: input.text.clone(), program: PROGRAM.into(), beside, ..asked }
}

/// Where the files lie that a scene names, if it names any.
fn folder(scene: &Scene, files: &FolderFiles) -> PathBuf {
    if scene.files().is_empty() {
        return PathBuf::new();
    }
    let folder = files.path(".");
    folder.canonicalize().unwrap_or(folder)
}

/// What is read, and where: the files that a scene names.
fn named(scene: &Scene, files: &FolderFiles) -> Vec<(&'static str, PathBuf)> {
    scene.files().into_iter().map(|file| ("file that the scene names", files.path(file))).collect()
}

//! `mpm run` and `mpm resume`.

use crate::complaint::Complaint;
use crate::crew::{Crew, agreed};
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
use mpm_solver::observe::{Cancellation, LoadStep, Observer, ObserverError};
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
pub fn run(arguments: &RunArguments, crew: &dyn Crew) -> Result<(), Complaint> {
    let threads = arguments.threads.or(crew.threads());
    start_threads(threads)?;
    let files = files_of(&arguments.scene, arguments.files.as_deref());
    let read = input::read_share(&arguments.scene, &arguments.settings.set, &files, crew.share());
    let input = agreed(crew, read)?;
    let path = arguments
        .output
        .clone()
        .unwrap_or_else(|| named_after(arguments.scene.file_stem().unwrap_or_default(), "h5"));
    let written = crew.leads().then(|| begin(arguments, &input, &path, &files, threads)).transpose();
    let written = agreed(crew, written)?;
    let files = Paths { scene: &arguments.scene, results: &path };
    let outcome = carry_out(input, None, written, &files, arguments.quiet || arguments.json, crew);
    // The reason why the run ended is more important than an error in reading its results back.
    let said = if arguments.json && crew.leads() {
        inspect::inspect(&path, true).and_then(|text| say(&text))
    } else {
        Ok(())
    };
    outcome.and(agreed(crew, said))
}

/// Creates the files of a run.
fn begin(
    arguments: &RunArguments,
    input: &Input,
    path: &Path,
    files: &FolderFiles,
    threads: Option<u16>,
) -> Result<(ResultsWriter, Keeper), Complaint> {
    let head = CheckpointHead {
        scene: input.text.clone(),
        folder: folder(&input.scene, files),
        program: PROGRAM.into(),
        results: path.to_path_buf(),
        interval: CheckpointInterval::of(&input.scene),
    };
    let mut read = named(&input.scene, files);
    read.push(("scene", arguments.scene.clone()));
    let checkpoint = arguments.checkpoints.checkpoint.clone().unwrap_or_else(|| Keeper::beside(path));
    check_places(&read, Some(path), Some(&checkpoint)).map_err(Complaint::input)?;
    if !arguments.force {
        previous::protect(&input.scene, &input.text, path, &checkpoint)?;
    }
    let keeper = arguments.checkpoints.keeper(checkpoint, head)?;
    let writer = ResultsWriter::create(path, options(input, threads));
    Ok((writer.map_err(|error| Complaint::input(error.to_string()))?, keeper))
}

/// Goes on with a run from its checkpoint.
pub fn resume(arguments: &ResumeArguments, crew: &dyn Crew) -> Result<(), Complaint> {
    let threads = arguments.threads.or(crew.threads());
    start_threads(threads)?;
    let file = &arguments.checkpoint_file;
    let survives = if crew.leads() { reading::survives(file, Kind::Checkpoint) } else { Ok(()) };
    agreed(crew, survives)?;
    let mut found = agreed(crew, Found::of(arguments))?;
    let path = arguments.output.clone().unwrap_or(found.head.results.clone());
    let written = crew.leads().then(|| go_on(arguments, &mut found, &path, threads)).transpose();
    let written = agreed(crew, written)?;
    let files = Paths { scene: file, results: &path };
    carry_out(found.input, Some(&found.state), written, &files, arguments.quiet, crew)
}

/// What a checkpoint holds.
struct Found {
    head: CheckpointHead,
    files: FolderFiles,
    input: Input,
    state: State,
    /// The scene of the checkpoint, where the run goes on with another.
    earlier_scene: Option<String>,
}

impl Found {
    fn of(arguments: &ResumeArguments) -> Result<Self, Complaint> {
        let file = &arguments.checkpoint_file;
        let refuse = |error: CheckpointError| Complaint::input(error.to_string());
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
        Ok(Self { head, files, input, state, earlier_scene })
    }
}

/// Goes on with the files of a run.
fn go_on(
    arguments: &ResumeArguments,
    found: &mut Found,
    path: &Path,
    threads: Option<u16>,
) -> Result<(ResultsWriter, Keeper), Complaint> {
    let Found { head, files, input, state, earlier_scene } = found;
    let file = &arguments.checkpoint_file;
    if head.program != PROGRAM {
        let note = format!(
            "{} was written by {}, this is {PROGRAM}: the rest may differ in its last digits",
            file.display(),
            head.program
        );
        // If standard error is closed, there is nowhere to report it.
        let _ = writeln!(std::io::stderr(), "warning: {note}");
    }
    if arguments.output.is_none() && !path.exists() {
        return Err(Complaint::input(format!(
            "the results file {} is not there: name it by --output, or a new file for the rest of the history",
            path.display()
        )));
    }
    if is_same(path, file) {
        return Err(Complaint::input(format!("the results file {} is the checkpoint itself", path.display())));
    }
    let checkpoint = arguments.checkpoints.checkpoint.as_ref().unwrap_or(file);
    let mut read = named(&input.scene, files);
    read.extend(arguments.scene.iter().map(|scene| ("scene", scene.clone())));
    check_places(&read, Some(path), Some(checkpoint)).map_err(Complaint::input)?;
    (head.program, head.results) = (PROGRAM.into(), path.to_path_buf());
    let mut keeper = arguments.checkpoints.keeper(checkpoint.clone(), head.clone())?;
    if arguments.checkpoints.checkpoint.is_none() {
        keeper.has_kept(state.progress.rows().saturating_sub(1));
    }
    reading::survives(path, Kind::Results)?;
    let options = Options { earlier_scene: earlier_scene.clone(), ..options(input, threads) };
    let writer = ResultsWriter::resume(path, options);
    Ok((writer.map_err(|error| Complaint::input(error.to_string()))?, keeper))
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
    input: Input,
    state: Option<&State>,
    written: Option<(ResultsWriter, Keeper)>,
    files: &Paths<'_>,
    quiet: bool,
    crew: &dyn Crew,
) -> Result<(), Complaint> {
    let done = match written {
        Some(written) => lead(input, state, written, files, quiet, crew),
        None => follow(input, state, crew),
    };
    agreed(crew, done)
}

/// Takes part in a run that another process leads.
fn follow(mut input: Input, state: Option<&State>, crew: &dyn Crew) -> Result<(), Complaint> {
    let mut listens = Listens(Cancellation::default());
    keeper::listen(listens.cancellation())?;
    let outcome = crew.run(&mut input.compiled, state, &mut listens);
    outcome.map(drop).map_err(|error| Complaint::unfinished(error.to_string()))
}

/// Sees nothing, and can be asked to stop.
struct Listens(Cancellation);

impl Observer for Listens {
    fn cancellation(&self) -> Cancellation {
        self.0.clone()
    }

    fn load_step(&mut self, _: &LoadStep<'_>) -> Result<(), ObserverError> {
        Ok(())
    }
}

fn lead(
    mut input: Input,
    state: Option<&State>,
    (writer, keeper): (ResultsWriter, Keeper),
    files: &Paths<'_>,
    quiet: bool,
    crew: &dyn Crew,
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
    let outcome = crew.run(&mut input.compiled, state, &mut watch);
    if !quiet {
        if show == Show::Bar {
            say(&report::convergence(watch.rows()))?;
        }
        if let Ok(summary) = &outcome {
            say(&report::summary(summary, &input.scene, files.results))?;
        }
    }
    outcome.map(drop).map_err(|error| failed(error, &watch, state, files))
}

/// What is said of a run that did not come to its end.
fn failed(error: Error, watch: &Watch, state: Option<&State>, files: &Paths<'_>) -> Complaint {
    match error {
        Error::State(error) => Complaint::input(format!("checkpoint {}: {error}", files.scene.display())),
        // The scene is none that ranks can share.
        Error::Ranks(reason) => Complaint::input(format!("{}: {reason}", files.scene.display())),
        // The existing results file does not fit the checkpoint.
        Error::Observer(error) if state.is_some() && !watch.has_started() => {
            Complaint::input(error.to_string())
        }
        error => {
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
            Complaint::unfinished(format!("{error}\n{before}{}{hint}", watch.advice()))
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

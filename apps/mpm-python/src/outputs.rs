//! The files of a run: results and checkpoints, if any.

use crate::errors::Failure;
use crate::scene::Scene;
use mpm_io::{
    CheckpointHead, CheckpointInterval, Keeper, Options, ResultsWriter, check_places, is_same,
    reason_to_keep_results, unfinished_results,
};
use mpm_scene::Compiled;
use mpm_solver::State;
use mpm_solver::observe::{
    Cancellation, Fields, LoadStep, Moment, Observer, ObserverError, Outcome, Resumed, RunStart, Timing,
};
use std::path::{Path, PathBuf};

/// What the files say of the program: they are those of the program `mpm` of this version.
pub(crate) const PROGRAM: &str = concat!("mpm ", env!("CARGO_PKG_VERSION"));

/// Where a run writes, as Python says.
#[derive(Clone, Debug, Default)]
pub(crate) struct Asked {
    pub output: Option<PathBuf>,
    pub checkpoint: Option<PathBuf>,
    pub interval: CheckpointInterval,
    pub force: bool,
    /// Whether laws or loads are written in Python: no checkpoint could tell of them.
    pub is_foreign: bool,
}

/// Results file and checkpoints.
#[derive(Default)]
pub(crate) struct Outputs {
    writer: Option<ResultsWriter>,
    keeper: Option<Keeper>,
    results: Option<PathBuf>,
}

impl Outputs {
    /// Those of a run from the beginning.
    pub(crate) fn begin(scene: &Scene, compiled: &Compiled, asked: &Asked) -> Result<Self, Failure> {
        let beside = || asked.output.as_deref().filter(|_| !asked.is_foreign).map(Keeper::beside);
        let checkpoint = asked.checkpoint.clone().or_else(beside);
        let mut read = named(scene);
        let own = PathBuf::from(scene.file());
        if own.is_file() {
            read.push(("scene", own));
        }
        check_places(&read, asked.output.as_deref(), checkpoint.as_deref()).map_err(Failure::input)?;
        if !asked.force {
            protect(scene, asked.output.as_deref(), checkpoint.as_deref())?;
        }
        let keeper = checkpoint.map(|path| {
            let interval = match asked.interval == CheckpointInterval::default() {
                true => CheckpointInterval::of(scene.language()),
                false => asked.interval,
            };
            let head = CheckpointHead {
                scene: scene.source().into(),
                folder: folder(scene),
                program: PROGRAM.into(),
                results: asked.output.clone().unwrap_or_default(),
                interval,
            };
            Keeper::new(path, head, asked.checkpoint.is_some())
        });
        let keeper = keeper.transpose().map_err(Failure::input)?;
        let writer = asked.output.as_ref().map(|path| {
            let mut options = options(scene, compiled)?;
            if asked.is_foreign {
                options.program += ", laws or loads in Python";
            }
            ResultsWriter::create(path, options).map_err(Failure::input)
        });
        Ok(Self { writer: writer.transpose()?, keeper, results: asked.output.clone() })
    }

    /// Those of a run that goes on from the checkpoint in `file`, of load step `step`.
    pub(crate) fn go_on(
        scene: &Scene,
        compiled: &Compiled,
        (file, mut head, step): (&Path, CheckpointHead, usize),
        asked: &Asked,
    ) -> Result<Self, Failure> {
        // A run without results has left the folder of its checkpoint in their place.
        let before = Some(head.results).filter(|path| path.file_name().is_some() && !path.is_dir());
        let results = asked.output.clone().or(before);
        if let Some(results) = results.as_ref().filter(|path| asked.output.is_none() && !path.exists()) {
            return Err(Failure::input(format!(
                "the results file {} is not there: name it by output=, or a new file for the rest of the history",
                results.display()
            )));
        }
        let checkpoint = asked.checkpoint.as_deref().unwrap_or(file);
        if let Some(results) = results.as_ref().filter(|path| is_same(path, file)) {
            let reason = format!("the results file {} is the checkpoint itself", results.display());
            return Err(Failure::input(reason));
        }
        check_places(&named(scene), results.as_deref(), Some(checkpoint)).map_err(Failure::input)?;
        if asked.interval != CheckpointInterval::default() {
            head.interval = asked.interval;
        }
        (head.program, head.results) = (PROGRAM.into(), results.clone().unwrap_or_default());
        let keeper = Keeper::new(checkpoint.to_path_buf(), head, asked.checkpoint.is_some());
        let mut keeper = keeper.map_err(Failure::input)?;
        if asked.checkpoint.is_none() {
            keeper.has_kept(step);
        }
        let writer = results
            .as_ref()
            .map(|path| ResultsWriter::resume(path, options(scene, compiled)?).map_err(Failure::input));
        Ok(Self { writer: writer.transpose()?, keeper: Some(keeper), results })
    }

    /// The flag that stops the run, where checkpoints are written.
    pub(crate) fn cancellation(&self) -> Option<Cancellation> {
        self.keeper.as_ref().map(Keeper::cancellation)
    }

    /// What there is of a run that failed.
    pub(crate) fn told(&self, steps: usize) -> String {
        let before = self.results.as_ref().map(|results| match (steps, results.display()) {
            (_, results) if !self.results.as_ref().is_some_and(|it| it.exists()) => {
                format!("\nThe results file {results} is gone")
            }
            (0, results) => format!("\nThe state at its start is in {results}"),
            (1, results) => format!("\nThe load step before it is in {results}"),
            (steps, results) => format!("\nThe {steps} load steps before it are in {results}"),
        });
        let advice = self.keeper.as_ref().and_then(|keeper| {
            let (step, path) = (keeper.kept()?, keeper.path().display().to_string());
            Some(format!("\nGo on from load step {step} with: mpm.resume({path:?})"))
        });
        before.unwrap_or_default() + &advice.unwrap_or_default()
    }

    /// Writes a checkpoint if one is due; a failure to do so is told.
    pub(crate) fn save(
        &mut self,
        at: Moment,
        state: &dyn Fn() -> State,
    ) -> Result<Option<String>, ObserverError> {
        let Some(keeper) = self.keeper.as_mut().filter(|keeper| keeper.wants(at)) else { return Ok(None) };
        let mut written = Ok(());
        if let Some(writer) = &mut self.writer {
            // The results file must hold every row before the checkpoint, also after a power cut.
            writer.flush()?;
            written = writer.sync().map_err(ObserverError::from);
        }
        let written = written.and_then(|()| keeper.write(&state()).map_err(ObserverError::from));
        let goes_on = if at == Moment::End { "" } else { "; the run goes on without" };
        Ok(written.err().map(|error| format!("{error}{goes_on}")))
    }
}

impl Observer for Outputs {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        self.writer.as_mut().map_or(Ok(()), |writer| writer.start(run))
    }

    fn resume(&mut self, run: &RunStart, so_far: &Resumed) -> Result<(), ObserverError> {
        self.writer.as_mut().map_or(Ok(()), |writer| writer.resume(run, so_far))
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        self.writer.as_mut().map_or(Ok(()), |writer| writer.load_step(step))
    }

    fn last(&mut self, fraction: f64, fields: &dyn Fields) -> Result<(), ObserverError> {
        self.writer.as_mut().map_or(Ok(()), |writer| writer.last(fraction, fields))
    }

    fn finish(&mut self, outcome: &Outcome, timings: &[Timing]) -> Result<(), ObserverError> {
        self.writer.as_mut().map_or(Ok(()), |writer| writer.finish(outcome, timings))
    }
}

/// Refuses to replace results that were interrupted or are longer, and checkpoints of unfinished runs.
fn protect(scene: &Scene, results: Option<&Path>, checkpoint: Option<&Path>) -> Result<(), Failure> {
    let read_here = |_: &Path| Ok(());
    let resume = |checkpoint: &Path| format!("mpm.resume({:?})", checkpoint.display().to_string());
    if let Some(path) = results
        && let Some(reason) = reason_to_keep_results(path, Some((scene.language(), scene.source())), &read_here)
    {
        let go_on = checkpoint.filter(|it| it.exists());
        let go_on = go_on.map_or(String::new(), |it| format!("go on with them by `{}`, ", resume(it)));
        return Err(Failure::input(format!(
            "results file {} {reason}: {go_on}write to another file by output=, or replace them by force=True",
            path.display()
        )));
    }
    let Some(path) = checkpoint else { return Ok(()) };
    let Some(of) = unfinished_results(path, &read_here, &read_here) else { return Ok(()) };
    Err(Failure::input(format!(
        "checkpoint {} is that of an unfinished run with the results {}: go on with it by `{}`, write to another file by \
         checkpoint=, or replace it by force=True",
        path.display(),
        of.display(),
        resume(path)
    )))
}

/// What is read, and where: the files that the scene names.
fn named(scene: &Scene) -> Vec<(&'static str, PathBuf)> {
    let files = scene.files();
    let named = scene.language().files().into_iter().filter(|file| !files.holds(file));
    named.map(|file| ("file that the scene names", files.folder().path(file))).collect()
}

/// Where the files lie that the scene names, if it names any.
fn folder(scene: &Scene) -> PathBuf {
    let files = scene.files();
    if scene.language().files().iter().all(|file| files.holds(file)) {
        return PathBuf::new();
    }
    let folder = files.folder().path(".");
    folder.canonicalize().unwrap_or(folder)
}

fn options(scene: &Scene, compiled: &Compiled) -> Result<Options, Failure> {
    let output = scene.language().output();
    // A law in Python may lack what that of the scene remembers.
    let fields =
        compiled.fields(output).map_err(|error| Failure::refused(scene.file(), scene.source(), error))?;
    Ok(Options { scene: scene.source().into(), program: PROGRAM.into(), ..Options::of(output, fields) })
}

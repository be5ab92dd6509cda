//! What hostile input is fed to.

use super::bodies::Bodies;
use super::bytes;
use super::language::{SMALL, WORDS};
use super::random::Random;
use super::text::Corpus;
use crate::Broken;
use mpm_io::{Checkpoint, CheckpointHead, CheckpointInterval, FolderFiles, Options, Results, ResultsWriter};
use mpm_scene::language::{Scene, position_of};
use mpm_scene::{Compiled, compile, compile_within};
use mpm_scene::{NoFiles, SceneFiles};
use mpm_solver::State;
use mpm_solver::observe::{LoadStep, Moment, Observer, ObserverError, Outcome, Resumed, RunStart, Timing};
use std::fs;
use std::path::{Path, PathBuf};

/// Memory that scenes may take up; what needs more must be refused `[bytes]`.
const ROOM: u64 = 16 << 20;
/// Bodies with more points are not connected for an estimate.
const MOST_ESTIMATED: usize = 3000;
/// Bodies with more points are not taken through a load step.
const MOST_RUN: usize = 400;

/// What is fed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// Scenes: read, compiled, estimated, and taken through a load step where they are small.
    Scenes,
    /// Checkpoints: opened, read, and gone on with for a load step.
    Checkpoints,
    /// Results files: all of them read, and gone on with.
    Results,
    /// Surfaces and tables of points: read, filled with points, and taken through a load step.
    Bodies,
    /// Nothing of ours: cases that panic, hang, crash and ask for too much memory, to show that it is seen.
    Traps,
}

/// How far an input came.
pub(super) const DEPTHS: [&str; 4] = ["refused by the reader", "refused thereafter", "accepted", "run"];

impl Target {
    /// All that are ours.
    pub const ALL: [Self; 4] = [Self::Scenes, Self::Checkpoints, Self::Results, Self::Bodies];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scenes => "scenes",
            Self::Checkpoints => "checkpoints",
            Self::Results => "results",
            Self::Bodies => "bodies",
            Self::Traps => "traps",
        }
    }

    /// Whether a case is a file that HDF5 reads, which can crash: Rust does not.
    pub(super) fn is_hdf5(self, case: u64) -> bool {
        match self {
            Self::Checkpoints | Self::Results => true,
            Self::Bodies => Bodies::is_hdf5(case),
            Self::Scenes | Self::Traps => false,
        }
    }

    /// The target of a name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().chain([Self::Traps]).find(|it| it.name() == name)
    }
}

/// A target, and what inputs to it start from.
pub(super) enum Prepared {
    Scenes(Corpus),
    Files {
        target: Target,
        /// An honest file of each model.
        honest: Vec<Vec<u8>>,
        /// A state in the middle of the run of each results file.
        states: Vec<State>,
        /// Where the file is put.
        path: PathBuf,
    },
    Bodies(Bodies),
    Traps,
}

impl Prepared {
    pub(super) fn new(target: Target, folder: &Path) -> Result<Self, Broken> {
        let path = folder.join("input.h5");
        match target {
            Target::Scenes => Ok(Self::Scenes(corpus()?)),
            Target::Bodies => Ok(Self::Bodies(Bodies::new(folder))),
            Target::Traps => Ok(Self::Traps),
            Target::Checkpoints | Target::Results => {
                let (mut honest, mut states) = (Vec::new(), Vec::new());
                for text in SMALL {
                    let mut writer = Kept {
                        writer: ResultsWriter::create(&path, options(text)).map_err(|it| it.to_string())?,
                        state: None,
                    };
                    compile(&Scene::from_ron(text)?)?.run(&mut writer)?;
                    let state = writer.state.take().ok_or("a run without a load step")?;
                    drop(writer);
                    if target == Target::Checkpoints {
                        let head = CheckpointHead {
                            scene: (*text).into(),
                            program: "fuzz".into(),
                            folder: PathBuf::new(),
                            results: path.clone(),
                            interval: CheckpointInterval { steps: Some(2), seconds: Some(0.5) },
                        };
                        Checkpoint::write(&path, &head, &state)?;
                    }
                    honest.push(fs::read(&path)?);
                    states.push(state);
                }
                Ok(Self::Files { target, honest, states, path })
            }
        }
    }

    /// The input of a case.
    pub(super) fn input(&self, case: u64, random: &mut Random) -> Vec<u8> {
        match self {
            Self::Scenes(corpus) => corpus.changed(random),
            Self::Files { target, honest, .. } => {
                let which = random.below(honest.len());
                let mut input = honest[which].clone();
                bytes::change(&mut input, random);
                // Only checkpoints with a right check sum reach HDF5: give most of them one.
                if *target == Target::Checkpoints && random.below(10) > 0 {
                    vouch_for(&mut input);
                }
                input
            }
            Self::Bodies(bodies) => bodies.changed(case, random),
            Self::Traps => Vec::new(),
        }
    }

    /// Feeds it; returns the index in [`DEPTHS`].
    pub(super) fn execute(&self, case: u64, input: &[u8], random: &mut Random) -> usize {
        match self {
            Self::Scenes(_) => feed_scene(input, random),
            Self::Files { target, states, path, .. } => {
                if fs::write(path, input).is_err() {
                    return 0;
                }
                match target {
                    Target::Checkpoints => feed_checkpoint(path),
                    _ => feed_results(path, states, random),
                }
            }
            Self::Bodies(bodies) => bodies.feed(case, input),
            Self::Traps => trap(case),
        }
    }
}

/// Where scenes of the repository name files.
fn files_of_scenes() -> FolderFiles {
    FolderFiles::new(Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes"))
}

/// The scenes of the repository and of the validation, and small ones that use all of the language.
fn corpus() -> Result<Corpus, Broken> {
    let mut texts: Vec<String> = Vec::new();
    for folder in ["../scenes", "scenes"] {
        let mut files: Vec<PathBuf> = fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(folder))?
            .map(|entry| entry.map(|it| it.path()))
            .collect::<Result<_, _>>()?;
        files.retain(|file| file.extension().is_some_and(|it| it == "ron"));
        files.sort();
        for file in files {
            texts.push(fs::read_to_string(file)?);
        }
    }
    // Small ones as often as large ones: they come farther.
    let small = SMALL.iter().cycle().take(texts.len().next_multiple_of(SMALL.len()));
    Ok(Corpus::new(texts.iter().map(String::as_str).chain(small.copied())).with_words(WORDS))
}

fn feed_scene(input: &[u8], random: &mut Random) -> usize {
    let Ok(text) = std::str::from_utf8(input) else { return 0 };
    let Ok(scene) = Scene::from_ron(text) else { return 0 };
    let mut compiled = match tamed(scene, text, &files_of_scenes()) {
        Ok(compiled) => compiled,
        Err(()) => return 1,
    };
    let points = points(&compiled);
    if points <= MOST_ESTIMATED && random.below(8) == 0 {
        let _ = compiled.estimate();
    }
    if random.below(4) > 0 {
        return 2;
    }
    one_step(&mut compiled)
}

/// Takes a model through a load step if it is small; returns how far that is.
pub(super) fn one_step(compiled: &mut Compiled) -> usize {
    if points(compiled) > MOST_RUN {
        return 2;
    }
    let _ = compiled.run(&mut OneStep);
    3
}

/// Compiles a scene, with bounds to how long its load steps take.
pub(super) fn tamed(mut scene: Scene, text: &str, files: &dyn SceneFiles) -> Result<Compiled, ()> {
    let (schedule, tolerance) = match &mut scene {
        Scene::PlaneStrain(scene) | Scene::Axisymmetric(scene) => (&mut scene.schedule, &mut scene.tolerance),
        Scene::Solid(scene) => (&mut scene.schedule, &mut scene.tolerance),
    };
    // A wrong number of cuts is for the compiler to see.
    if schedule.cuts <= 40 {
        schedule.cuts = schedule.cuts.min(2);
    }
    tolerance.iterations.0 = tolerance.iterations.0.min(8);
    compile_within(&scene, files, ROOM).map_err(|error| {
        // Where it stands must be found whatever the text.
        let _ = position_of(text, &error.path);
    })
}

/// How many points the bodies have.
fn points(compiled: &Compiled) -> usize {
    match compiled {
        Compiled::Plane(model) => model.bodies.iter().map(|it| it.body.n_points()).sum(),
        Compiled::Solid(model) => model.bodies.iter().map(|it| it.body.n_points()).sum(),
    }
}

fn feed_checkpoint(path: &Path) -> usize {
    let Ok(checkpoint) = Checkpoint::open(path) else { return 0 };
    // As `mpm resume` does, in another process.
    let _ = checkpoint.read_all();
    let text = &checkpoint.head().scene;
    let Ok(scene) = Scene::from_ron(text) else { return 1 };
    let Ok(mut compiled) = tamed(scene, text, &NoFiles) else { return 1 };
    let Ok(state) = checkpoint.state(&compiled.state_layout()) else { return 1 };
    if points(&compiled) > MOST_RUN {
        return 2;
    }
    let _ = compiled.resume(&state, &mut OneStep);
    3
}

fn feed_results(path: &Path, states: &[State], random: &mut Random) -> usize {
    let depth = read_results(path);
    // Going on with a run copies the file first.
    if random.below(4) > 0 {
        return depth;
    }
    let which = random.below(states.len());
    let (Some(text), Some(state)) = (SMALL.get(which), states.get(which)) else { return depth };
    let (Ok(writer), Ok(scene)) = (ResultsWriter::resume(path, options(text)), Scene::from_ron(text)) else {
        return depth;
    };
    let Ok(mut compiled) = tamed(scene, text, &NoFiles) else { return depth };
    let _ = compiled.resume(state, &mut OneStepOf(writer));
    3
}

fn read_results(path: &Path) -> usize {
    let Ok(results) = Results::open(path) else { return 0 };
    let mut depth = 2;
    let mut see = |right: bool| depth = depth.min(if right { 2 } else { 1 });
    for column in results.columns() {
        see(results.column(&column.name).is_ok());
    }
    for row in 0..results.rows().min(10) {
        see(results.residuals(row).is_ok());
    }
    see(results.timings().is_ok());
    let fields = results.fields();
    see(fields.is_ok());
    for step in 0..results.fractions().len().min(10) {
        see(results.points(step).is_ok());
        for field in fields.iter().flatten() {
            see(results.field(field, step).is_ok());
        }
    }
    depth
}

fn options(text: &str) -> Options {
    Options { scene: text.into(), program: "fuzz".into(), ..Options::default() }
}

/// Writes the right length and check sum before the bytes of a changed checkpoint.
fn vouch_for(bytes: &mut Vec<u8>) {
    const BLOCK: usize = 512;
    bytes.resize(bytes.len().max(BLOCK), 0);
    let sum = crc32fast::hash(&bytes[BLOCK..]);
    let length = bytes.len() - BLOCK;
    let mut block =
        format!("mpm-checkpoint 4\n{length} bytes follow this block, CRC-32 {sum:08x}\n").into_bytes();
    block.resize(BLOCK, 0);
    bytes[..BLOCK].copy_from_slice(&block);
}

fn trap(case: u64) -> usize {
    match case % 100 {
        10 => panic!("a trap"),
        20 => {
            let mut all: Vec<Vec<u8>> = Vec::new();
            loop {
                all.push(vec![1; 1 << 20]);
            }
        }
        30 => loop {
            std::hint::spin_loop();
        },
        40 => std::process::abort(),
        _ => 0,
    }
}

/// Keeps the state after the first load step beside the results.
struct Kept {
    writer: ResultsWriter,
    state: Option<State>,
}

impl Observer for Kept {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        self.writer.start(run)
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        self.writer.load_step(step)
    }

    fn save(&mut self, at: Moment, state: &dyn Fn() -> State) -> Result<(), ObserverError> {
        if at == Moment::Step(1) {
            self.state = Some(state());
        }
        Ok(())
    }

    fn finish(&mut self, outcome: &Outcome, timings: &[Timing]) -> Result<(), ObserverError> {
        self.writer.finish(outcome, timings)
    }
}

/// Ends a run after a load step.
struct OneStep;

fn enough() -> ObserverError {
    "enough".into()
}

impl Observer for OneStep {
    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        if step.index == 0 { Ok(()) } else { Err(enough()) }
    }
}

/// The same, of a results file that is gone on with.
struct OneStepOf(ResultsWriter);

impl Observer for OneStepOf {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        self.0.start(run)
    }

    fn resume(&mut self, run: &RunStart, so_far: &Resumed) -> Result<(), ObserverError> {
        self.0.resume(run, so_far)
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        self.0.load_step(step)?;
        Err(enough())
    }

    fn finish(&mut self, outcome: &Outcome, timings: &[Timing]) -> Result<(), ObserverError> {
        self.0.finish(outcome, timings)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All names of fields and variants in a JSON schema.
    fn names(schema: &serde_json::Value, found: &mut Vec<String>) {
        match schema {
            serde_json::Value::Object(entries) => {
                for (key, value) in entries {
                    match (key.as_str(), value) {
                        ("properties", serde_json::Value::Object(fields)) => {
                            found.extend(fields.keys().cloned())
                        }
                        ("const", serde_json::Value::String(name)) => found.push(name.clone()),
                        ("enum", serde_json::Value::Array(all)) => {
                            found.extend(all.iter().filter_map(|it| Some(it.as_str()?.to_owned())))
                        }
                        _ => {}
                    }
                    names(value, found);
                }
            }
            serde_json::Value::Array(all) => all.iter().for_each(|it| names(it, found)),
            _ => {}
        }
    }

    #[test]
    fn all_of_the_language_is_fed() {
        let corpus = corpus().unwrap();
        let mut all = Vec::new();
        names(schemars::schema_for!(Scene).as_value(), &mut all);
        all.retain(|it| !corpus.says(it));
        all.sort();
        all.dedup();
        assert!(all.is_empty(), "{all:?}");
    }

    #[test]
    fn honest_input_is_accepted() {
        for text in SMALL {
            let scene = Scene::from_ron(text).unwrap_or_else(|error| panic!("{error}: {text}"));
            let mut compiled =
                compile_within(&scene, &NoFiles, ROOM).unwrap_or_else(|error| panic!("{error}: {text}"));
            compiled.run(&mut ()).unwrap_or_else(|error| panic!("{error}: {text}"));
        }
        let folder = tempfile::tempdir().unwrap();
        for target in [Target::Checkpoints, Target::Results] {
            let prepared = Prepared::new(target, folder.path()).unwrap();
            let Prepared::Files { honest, .. } = &prepared else { panic!("files") };
            for (k, file) in honest.iter().enumerate() {
                let depth = prepared.execute(0, file, &mut Random::of_case(0, 1));
                assert!(depth >= 2, "{} {k}: {}", target.name(), DEPTHS[depth]);
                assert_eq!(target == Target::Checkpoints, {
                    let mut vouched = file.clone();
                    vouch_for(&mut vouched);
                    vouched == *file
                });
            }
        }
    }
}

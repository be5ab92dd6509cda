//! Scenes of the repository and of the validation, and running them.

use crate::Broken;
use crate::history::History;
use mpm_io::FolderFiles;
use mpm_scene::language::{Count, Edited, PredictorInput, Scene, set_value};
use mpm_scene::{Compiled, compile_with};
use mpm_solver::{Error, StepFailure, Summary};
use std::path::{Path, PathBuf};

/// A run that was watched.
pub struct Run {
    /// What was seen of it.
    pub history: History,
    /// How it ended.
    pub outcome: Result<Summary, Error>,
}

/// Text of a scene of the repository: `scenes/<name>.ron`.
///
/// # Errors
/// The file cannot be read.
pub fn text(name: &str) -> Result<String, Broken> {
    read(Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes").join(name).with_extension("ron"))
}

/// Text of a scene of the validation itself: `validation/scenes/<name>.ron`.
///
/// # Errors
/// The file cannot be read.
pub fn own_text(name: &str) -> Result<String, Broken> {
    read(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name).with_extension("ron"))
}

fn read(path: PathBuf) -> Result<String, Broken> {
    std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()).into())
}

/// A scene of the repository.
///
/// # Errors
/// It cannot be read.
pub fn load(name: &str) -> Result<Scene, Broken> {
    Ok(Scene::from_ron(&text(name)?)?)
}

/// A scene of the validation itself.
///
/// # Errors
/// It cannot be read.
pub fn load_own(name: &str) -> Result<Scene, Broken> {
    Ok(Scene::from_ron(&own_text(name)?)?)
}

/// The scene of a text with other values, each a path and what stands there.
///
/// # Errors
/// A path leads nowhere, or the text is no scene.
pub fn edited(mut text: String, changes: &[(&str, String)]) -> Result<Scene, Broken> {
    for (path, value) in changes {
        Edited { text, .. } = set_value(&text, path, value)?;
    }
    Ok(Scene::from_ron(&text)?)
}

/// The scene in another number of load steps.
pub fn in_steps(mut scene: Scene, steps: u32) -> Scene {
    match &mut scene {
        Scene::PlaneStrain(scene) | Scene::Axisymmetric(scene) => scene.schedule.steps = Some(Count(steps)),
        Scene::Solid(scene) => scene.schedule.steps = Some(Count(steps)),
    }
    scene
}

/// The scene with another number of cuts allowed.
pub fn with_cuts(mut scene: Scene, cuts: u8) -> Scene {
    match &mut scene {
        Scene::PlaneStrain(scene) | Scene::Axisymmetric(scene) => scene.schedule.cuts = cuts,
        Scene::Solid(scene) => scene.schedule.cuts = cuts,
    }
    scene
}

/// The scene with every load step begun at rest.
pub fn from_rest(mut scene: Scene) -> Scene {
    match &mut scene {
        Scene::PlaneStrain(scene) | Scene::Axisymmetric(scene) => {
            scene.schedule.predictor = PredictorInput::Rest
        }
        Scene::Solid(scene) => scene.schedule.predictor = PredictorInput::Rest,
    }
    scene
}

/// Compiles a scene of the repository, with the files that lie beside it.
///
/// # Errors
/// The scene does not compile.
pub fn compiled(scene: &Scene) -> Result<Compiled, Broken> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    Ok(compile_with(scene, &FolderFiles::new(folder))?)
}

/// Runs a scene and keeps its history and, of every load step, the fields it asks for.
///
/// # Errors
/// The scene does not compile. A run that ends early is an outcome.
pub fn run(scene: &Scene) -> Result<Run, Broken> {
    Ok(run_compiled(&mut compiled(scene)?, scene))
}

/// As [`run`], of a model that was already made from the scene.
pub fn run_compiled(compiled: &mut Compiled, scene: &Scene) -> Run {
    let fields = compiled.fields(scene.output()).expect("compiled with them");
    let mut history = History::of(&fields).with_outlines();
    let outcome = compiled.run(&mut history);
    Run { history, outcome }
}

impl Run {
    /// The reason why the run ended early, if it did.
    pub fn failure(&self) -> Option<&StepFailure> {
        match &self.outcome {
            Err(Error::Step { reason, .. }) => Some(reason),
            _ => None,
        }
    }

    /// The history of a run that must have reached its end.
    ///
    /// # Errors
    /// Why it did not.
    pub fn completed(self) -> Result<History, Broken> {
        self.outcome?;
        Ok(self.history)
    }
}

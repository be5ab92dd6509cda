//! The results file that is drawn.

use crate::error::PictureError;
use mpm_io::Results;
use mpm_scene::Scene;
use std::path::{Path, PathBuf};

/// A results file and its scene.
pub(crate) struct Drawn {
    pub(crate) path: PathBuf,
    pub(crate) results: Results,
    pub(crate) scene: Scene,
}

impl Drawn {
    pub(crate) fn open(path: &Path) -> Result<Self, PictureError> {
        let results = Results::open(path).map_err(complain)?;
        if results.fractions().is_empty() {
            return Err(unread(path));
        }
        let scene = scene_of(&results, path)?;
        Ok(Self { path: path.into(), results, scene })
    }
}

/// The scene of the results in the file at `path`.
///
/// # Errors
/// Its text cannot be read.
pub fn scene_of(results: &Results, path: &Path) -> Result<Scene, PictureError> {
    Scene::from_ron(results.scene()).map_err(|error| {
        PictureError::new(format!("results file {}: its scene cannot be read: {error}", path.display()))
    })
}

/// A results file without anything to draw.
pub(crate) fn unread(path: &Path) -> PictureError {
    PictureError::new(format!("results file {} holds no recorded step", path.display()))
}

/// What is wrong with a results file, told to the user.
pub(crate) fn complain(error: mpm_io::ResultsError) -> PictureError {
    PictureError::new(error.to_string())
}

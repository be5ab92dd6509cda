//! The results file that is drawn.

use crate::complaint::Complaint;
use mpm_io::Results;
use mpm_scene::Scene;
use std::path::{Path, PathBuf};

/// A results file and its scene.
pub struct Drawn {
    pub path: PathBuf,
    pub results: Results,
    pub scene: Scene,
}

impl Drawn {
    pub fn open(path: &Path) -> Result<Self, Complaint> {
        let results = Results::open(path).map_err(complain)?;
        if results.fractions().is_empty() {
            return Err(unread(path));
        }
        let scene = scene_of(&results, path)?;
        Ok(Self { path: path.into(), results, scene })
    }
}

/// The scene of the results in the file at `path`.
pub fn scene_of(results: &Results, path: &Path) -> Result<Scene, Complaint> {
    Scene::from_ron(results.scene()).map_err(|error| {
        Complaint::input(format!("results file {}: its scene cannot be read: {error}", path.display()))
    })
}

/// A results file without anything to draw.
pub fn unread(path: &Path) -> Complaint {
    Complaint::input(format!("results file {} holds no recorded step", path.display()))
}

/// What is wrong with a results file, told to the user.
pub fn complain(error: mpm_io::ResultsError) -> Complaint {
    Complaint::input(error.to_string())
}

//! The files that a scene names: surfaces and tables of points.

mod points;
mod stl;

use mpm_solver::files::{PointTable, SceneFiles, Surface};
use std::fs;
use std::path::{Path, PathBuf};

/// Reads the files that a scene names, from the folder that the scene lies in.
#[derive(Clone, Debug, Default)]
pub struct FolderFiles {
    folder: PathBuf,
}

impl FolderFiles {
    /// Files of this folder; those with an absolute path of their own are read from there.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self { folder: folder.into() }
    }

    /// Files beside a scene.
    pub fn beside(scene: &Path) -> Self {
        Self::new(scene.parent().unwrap_or(Path::new("")))
    }

    /// Where a file is that a scene names.
    pub fn path(&self, file: &str) -> PathBuf {
        self.folder.join(file)
    }

    /// Whether a table of points is read as HDF5: `.h5` or `.hdf5`.
    pub fn is_hdf5(path: &Path) -> bool {
        path.extension().is_some_and(|it| it == "h5" || it == "hdf5")
    }
}

/// All bytes of a file. Pipes and devices, which may never end, are refused before they are opened.
fn whole(path: &Path) -> Result<Vec<u8>, String> {
    let fail = |error: std::io::Error| error.to_string();
    if !fs::metadata(path).map_err(fail)?.is_file() {
        return Err("this is no regular file".into());
    }
    fs::read(path).map_err(fail)
}

impl SceneFiles for FolderFiles {
    fn surface(&self, file: &str) -> Result<Surface, String> {
        let path = self.path(file);
        let named = |reason: String| format!("{}: {reason}", path.display());
        let triangles = stl::read(&path).map_err(named)?;
        Surface::new(&triangles).map_err(|it| named(it.to_string()))
    }

    fn points(&self, file: &str, dimensions: usize) -> Result<PointTable, String> {
        let path = self.path(file);
        let name = path.display().to_string();
        let read =
            if Self::is_hdf5(&path) { points::hdf5(&path, dimensions) } else { points::csv(&path, dimensions) };
        read.map(|table| PointTable { file: name.clone(), ..table }).map_err(|it| format!("{name}: {it}"))
    }
}

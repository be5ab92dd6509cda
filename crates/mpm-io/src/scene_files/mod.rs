//! The files that a scene names: surfaces and tables of points.

mod arrays;
mod columns;
mod points;
mod stl;
mod whole;

pub use arrays::ArrayFiles;
use mpm_geometry::Surface;
use mpm_scene::{NamedColumns, PointTable, SceneFiles};
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

/// Refuses a surface so far from the origin that single precision, which STL files have, does not tell its shape.
fn check_precision(surface: &Surface) -> Result<(), String> {
    /// Part of the smallest extent that coordinates may be off by.
    const MOST: f64 = 1e-3;
    let (low, high) = surface.bounds();
    let farthest = low.amax().max(high.amax());
    let (step, smallest) = (farthest * f64::from(f32::EPSILON), (high - low).min());
    if step <= MOST * smallest {
        return Ok(());
    }
    Err(format!(
        "coordinates reach {farthest} and have single precision, steps of {step:.1e}, where the smallest extent is {smallest}: \
         move the surface towards the origin, and back by `shift`"
    ))
}

impl SceneFiles for FolderFiles {
    fn surface(&self, file: &str) -> Result<Surface, String> {
        let path = self.path(file);
        let named = |reason: String| format!("{}: {reason}", path.display());
        let triangles = stl::read(&path).map_err(named)?;
        let surface = Surface::new(&triangles).map_err(|it| named(it.to_string()))?;
        check_precision(&surface).map(|()| surface).map_err(named)
    }

    fn points(&self, file: &str, dimensions: usize) -> Result<PointTable, String> {
        let path = self.path(file);
        let name = path.display().to_string();
        let read =
            if Self::is_hdf5(&path) { points::hdf5(&path, dimensions) } else { points::csv(&path, dimensions) };
        read.map(|table| PointTable { file: name.clone(), ..table }).map_err(|it| format!("{name}: {it}"))
    }

    fn columns(&self, file: &str) -> Result<NamedColumns, String> {
        let path = self.path(file);
        let name = path.display().to_string();
        let read = if Self::is_hdf5(&path) { columns::hdf5(&path) } else { columns::csv(&path) };
        match read {
            Ok(columns) => Ok(NamedColumns { file: name, columns }),
            Err(reason) => Err(format!("{name}: {reason}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn surfaces_that_single_precision_does_not_tell_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let files = FolderFiles::new(folder.path());
        let read = |at: f64| {
            let [a, b, c, d] = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];
            let facet = |corners: [[i32; 3]; 3]| {
                let vertex = |[x, y, z]: [i32; 3]| format!("vertex {} {y} {z}\n", at + f64::from(x));
                format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", corners.map(vertex).concat())
            };
            let facets = [[a, c, b], [a, b, d], [b, c, d], [c, a, d]].map(facet).concat();
            fs::write(files.path("a.stl"), format!("solid a\n{facets}endsolid a\n")).unwrap();
            files.surface("a.stl").map(|surface| surface.volume())
        };
        assert!((read(1e3).unwrap() - 1.0 / 6.0).abs() < 1e-4);
        let said = read(5e5).unwrap_err();
        assert!(said.contains("single precision, steps of 6.0e-2") && said.contains("`shift`"), "{said}");
    }
}

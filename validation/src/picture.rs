//! Pictures of what was found, each a file in `docs/pictures`.

use crate::Broken;
use mpm_plot::Figure;
pub use mpm_plot::{Curve, Curves, Legend, Panel, Patch, Shapes, Stroke};
use std::path::Path;

/// A picture, one file.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Name of the file in `docs/pictures`; its ending says the format.
    pub file: &'static str,
    /// What it shows.
    pub caption: String,
    /// Panels, side by side, in rows of six.
    pub panels: Vec<Panel>,
}

impl Picture {
    /// Draws the picture into its file in a directory.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save(&self, directory: &Path) -> Result<(), Broken> {
        self.save_in_columns(directory, Figure::new(&self.panels).columns)
    }

    /// As [`Self::save`], so many panels side by side and the others below.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save_in_columns(&self, directory: &Path, columns: usize) -> Result<(), Broken> {
        let (figure, path) = (self.in_columns(columns), directory.join(self.file));
        match self.file.ends_with(".png") {
            // Kept with the sources.
            true => Ok(figure.image()?.save_small(&path)?),
            false => Ok(figure.save(&path)?),
        }
    }

    /// What is drawn.
    pub fn figure(&self) -> Figure<'_> {
        self.in_columns(Figure::new(&self.panels).columns)
    }

    fn in_columns(&self, columns: usize) -> Figure<'_> {
        let columns = columns.max(1);
        // Panels in many rows are small.
        let panel = match (self.file.ends_with(".svg"), self.panels.len().div_ceil(columns)) {
            (true, _) => (460, 380),
            (false, 1) => (420, 440),
            (false, _) => (270, 290),
        };
        Figure { columns, panel, ..Figure::new(&self.panels) }
    }
}

#![doc = include_str!("../README.md")]
//!
//! # In more detail
//!
//! Pictures of results: curves over two axes, and bodies with their domains, to scale; as SVG, PNG, PDF or an
//! animated GIF. Everything drawn is plain numbers.

mod animation;
mod colours;
mod curves;
mod figure;
mod labels;
mod palette;
mod pdf;
mod shapes;
mod shares;

pub use animation::Animation;
pub use curves::{Curve, Curves, Legend, Stroke};
pub use figure::{Figure, Image, Panel};
pub use shapes::{ColourBar, Patch, Shapes, Symbol};
pub use shares::{Face, Shares, normal};

use std::path::{Path, PathBuf};

/// Why a picture could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlotError {
    /// The picture cannot be drawn.
    #[error("cannot draw the picture: {0}")]
    Draw(String),
    /// The file cannot be written.
    #[error("cannot write picture {}: {reason}", path.display())]
    Write {
        /// Path of the file.
        path: PathBuf,
        /// What the operating system or the encoder says.
        reason: String,
    },
    /// The file's ending is that of no format.
    #[error("cannot write picture {}: expected a name that ends in .svg, .png or .pdf", path.display())]
    Format {
        /// Path of the file.
        path: PathBuf,
    },
}

impl PlotError {
    fn draw(reason: impl ToString) -> Self {
        Self::Draw(reason.to_string())
    }

    fn write(path: &Path, reason: impl ToString) -> Self {
        Self::Write { path: path.into(), reason: reason.to_string() }
    }
}

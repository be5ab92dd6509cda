//! Whole pictures of results files.

use crate::body::{Bodies, Scales, size};
use crate::columns::{Wanted, columns};
use crate::drawn::Drawn;
use crate::error::PictureError;
use crate::histories;
use crate::tools;
use crate::view::BodyView;
use mpm_plot::{Figure, Panel};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Panels of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Show {
    /// The body, coloured by a field.
    Body,
    /// Reactions against displacements of supports, or against the load fraction.
    Reaction,
    /// Moments of reactions against the angle of the mesh, or against the load fraction.
    Moment,
    /// Forces on rigid tools against their way, or against the load fraction.
    Tool,
    /// Out-of-balance force of the iterates of Newton's method.
    Convergence,
    /// Energies against the load fraction, where the scene asks for them.
    Energy,
}

impl Show {
    /// All, in the order of a picture.
    pub const ALL: [Self; 6] =
        [Self::Body, Self::Reaction, Self::Moment, Self::Tool, Self::Convergence, Self::Energy];

    /// Its name: `body`, `reaction` and so on.
    pub fn name(self) -> &'static str {
        match self {
            Self::Body => "body",
            Self::Reaction => "reaction",
            Self::Moment => "moment",
            Self::Tool => "tool",
            Self::Convergence => "convergence",
            Self::Energy => "energy",
        }
    }
}

/// Size of a panel beside others `[pixels]`.
const PANEL: (u32, u32) = (620, 500);
/// Size of curves alone `[pixels]`.
const ALONE: (u32, u32) = (960, 640);

/// What is to be drawn.
#[derive(Clone, Debug)]
pub struct Drawing {
    panels: Vec<Panel>,
    columns: usize,
    panel: (u32, u32),
}

impl Drawing {
    /// One panel.
    fn alone(panel: Panel, size: (u32, u32)) -> Self {
        Self { panels: vec![panel], columns: 1, panel: size }
    }

    /// The drawing with letters that can be read where it is 16 centimetres wide.
    pub fn figure(&self) -> Figure<'_> {
        Figure { columns: self.columns, panel: self.panel, ..Figure::new(&self.panels) }.legible()
    }
}

/// Columns of the histories of results files against each other.
///
/// # Errors
/// A file cannot be read, holds nothing, or has no such column.
pub fn compared(files: &[PathBuf], wanted: &Wanted) -> Result<Drawing, PictureError> {
    Ok(Drawing::alone(columns(files, wanted)?, ALONE))
}

/// A picture of a results file: what is to be shown side by side, all that the file holds if that is empty.
///
/// # Errors
/// The file cannot be read, holds nothing, or lacks what is to be shown.
pub fn picture(results: &Path, show: &[Show], view: &BodyView) -> Result<Drawing, PictureError> {
    let file = &Drawn::open(results)?;
    let asked = !show.is_empty();
    let mut panels = Vec::new();
    let mut alone = PANEL;
    for show in if asked { show } else { &Show::ALL[..] } {
        let panel = match show {
            Show::Body => {
                let body = Bodies::of(file, view)?;
                let steps = body.steps(view.step)?;
                let panel = body.panel(steps.end - 1, &body.scales(steps)?)?;
                alone = size(&panel);
                Some(Panel::Shapes(panel))
            }
            Show::Reaction => histories::reactions(file)?,
            Show::Moment => histories::moments(file)?,
            Show::Tool => tools::forces(file)?,
            Show::Convergence => histories::convergence(file)?,
            Show::Energy => histories::energies(file)?,
        };
        if panel.is_none() && asked {
            let (file, name) = (results.display(), show.name());
            return Err(PictureError::new(format!("results file {file} holds nothing to show as {name}")));
        }
        panels.extend(panel);
    }
    let panel = if let [Panel::Shapes(_)] = panels[..] { alone } else { PANEL };
    let columns = panels.len().clamp(1, 2);
    Ok(Drawing { panels, columns, panel })
}

/// The body at every recorded step, all on one scale.
pub struct Frames {
    file: Drawn,
    view: BodyView,
}

impl Frames {
    /// The steps of a results file.
    ///
    /// # Errors
    /// The file cannot be read, or holds nothing.
    pub fn open(results: &Path, view: &BodyView) -> Result<Self, PictureError> {
        Ok(Self { file: Drawn::open(results)?, view: view.clone() })
    }

    /// Hands the drawing of every recorded step on, with its number.
    ///
    /// # Errors
    /// A step cannot be drawn, or `each` fails.
    pub fn each<E: From<PictureError>>(
        &self,
        mut each: impl FnMut(usize, &Drawing) -> Result<(), E>,
    ) -> Result<(), E> {
        let body = Bodies::of(&self.file, &self.view)?;
        let steps: Range<usize> = 0..body.steps(None)?.end;
        let scales: Scales = body.scales(steps.clone())?;
        for step in steps {
            let panel = body.panel(step, &scales)?;
            let size = size(&panel);
            each(step, &Drawing::alone(Panel::Shapes(panel), size))?;
        }
        Ok(())
    }
}

//! `mpm plot`: pictures of a results file.

mod arguments;

use crate::complaint::Complaint;
use crate::run::named_after;
use arguments::BodyArguments;
use clap::{Args, ValueEnum};
use mpm_pictures::{Drawing, Frames, PictureError, Wanted, compared, picture};
use mpm_plot::{Animation, PlotError};
use std::path::{Path, PathBuf};

#[derive(Args)]
pub struct PlotArguments {
    /// The results file; with `--y`, one or several.
    #[arg(required = true)]
    pub results: Vec<PathBuf>,
    /// Picture, .png, .svg or .pdf; with `--frames`, the folder of the pictures [default: the results' name with .png, or
    /// with `_frames`].
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// What is drawn, side by side [default: all that the file holds].
    #[arg(long, value_enum, value_delimiter = ',', value_name = "WHAT")]
    show: Vec<Show>,
    /// A column of the history that is drawn, `reaction/base.y`; several times for several curves. `mpm inspect` lists the
    /// columns.
    #[arg(long, value_name = "COLUMN", conflicts_with_all = ["show", "frames"])]
    y: Vec<String>,
    /// The column against which it is drawn [default: the load fraction].
    #[arg(long, value_name = "COLUMN", requires = "y")]
    x: Option<String>,
    /// Draw sizes, without signs.
    #[arg(long, requires = "y")]
    abs: bool,
    #[command(flatten)]
    body: BodyArguments,
    /// Draw the body at every recorded step: a folder of pictures and an animated GIF beside it.
    #[arg(long, conflicts_with_all = ["show", "step"])]
    frames: bool,
    /// Pictures per second of the GIF.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u16).range(1..=50))]
    rate: u16,
}

/// Panels of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Show {
    /// The body, coloured by a field.
    Body,
    /// Reactions against displacements of supports, or against the load fraction.
    Reaction,
    /// Moments of reactions against the angle of the mesh, or against the load fraction.
    Moment,
    /// Out-of-balance force of the iterates of Newton's method.
    Convergence,
    /// Energies against the load fraction, where the scene asks for them.
    Energy,
    /// Forces on rigid tools against their way, or against the load fraction.
    Tool,
}

impl From<Show> for mpm_pictures::Show {
    fn from(show: Show) -> Self {
        match show {
            Show::Body => Self::Body,
            Show::Reaction => Self::Reaction,
            Show::Moment => Self::Moment,
            Show::Convergence => Self::Convergence,
            Show::Energy => Self::Energy,
            Show::Tool => Self::Tool,
        }
    }
}

/// Draws what the arguments ask for, and says where.
pub fn plot(arguments: &PlotArguments) -> Result<String, Complaint> {
    let first = &arguments.results[0];
    let written = match (&arguments.results[..], arguments.y.is_empty()) {
        (files, false) => {
            let (y, x) = (arguments.y.clone(), arguments.x.clone());
            vec![save(arguments, first, &compared(files, &Wanted { y, x, absolute: arguments.abs })?)?]
        }
        ([file], true) if arguments.frames => frames(arguments, file)?,
        ([file], true) => {
            let show: Vec<_> = arguments.show.iter().map(|show| (*show).into()).collect();
            vec![save(arguments, file, &picture(file, &show, &arguments.body.view())?)?]
        }
        (files, true) => {
            let n = files.len();
            return Err(Complaint::input(format!("{n} results files can be drawn together by --y alone")));
        }
    };
    Ok(written.iter().map(|path| format!("{}\n", path.display())).collect())
}

/// Writes a picture where the arguments say, or beside the results.
fn save(arguments: &PlotArguments, results: &Path, drawing: &Drawing) -> Result<PathBuf, Complaint> {
    let path = arguments.output.clone().unwrap_or_else(|| results.with_extension("png"));
    drawing.figure().save(&path)?;
    Ok(path)
}

/// A folder of pictures and a GIF, all of one size and on one scale.
fn frames(arguments: &PlotArguments, results: &Path) -> Result<Vec<PathBuf>, Complaint> {
    let frames = Frames::open(results, &arguments.body.view())?;
    let folder = arguments.output.clone().unwrap_or_else(|| {
        let name = results.file_stem().unwrap_or_default().to_string_lossy();
        results.with_file_name(format!("{name}_frames"))
    });
    let failed = |error| Complaint::input(format!("cannot create folder {}: {error}", folder.display()));
    std::fs::create_dir_all(&folder).map_err(failed)?;
    let gif = named_after(folder.as_os_str(), "gif");
    let mut animation: Option<Animation> = None;
    frames.each(|step, drawing| -> Result<(), Complaint> {
        let image = drawing.figure().image()?;
        image.save(&folder.join(format!("{step:04}.png")))?;
        let animation = match &mut animation {
            Some(animation) => animation,
            none => none.insert(Animation::create(&gif, image.size(), 100 / arguments.rate)?),
        };
        Ok(animation.add(&image)?)
    })?;
    Ok(vec![folder, gif])
}

impl From<PlotError> for Complaint {
    fn from(error: PlotError) -> Self {
        Self::input(error.to_string())
    }
}

/// Arguments are told as this program has them.
impl From<PictureError> for Complaint {
    fn from(error: PictureError) -> Self {
        Self::input(match error {
            PictureError::Argument { argument, reason } => format!("--{argument}: {reason}"),
            error => error.to_string(),
        })
    }
}

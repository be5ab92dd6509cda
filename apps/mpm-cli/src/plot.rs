//! `mpm plot`: pictures of a results file.

mod acting;
mod arguments;
mod body;
mod colour;
mod columns;
mod drawn;
mod histories;
mod seen;
mod tools;

use crate::complaint::Complaint;
use crate::run::named_after;
use arguments::BodyArguments;
use clap::{Args, ValueEnum};
use columns::Wanted;
use drawn::Drawn;
pub use drawn::scene_of;
use mpm_plot::{Animation, Figure, Panel, PlotError};
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

/// Size of a panel beside others `[pixels]`.
const PANEL: (u32, u32) = (620, 500);
/// Size of curves alone `[pixels]`.
const ALONE: (u32, u32) = (960, 640);

/// Draws what the arguments ask for, and says where.
pub fn plot(arguments: &PlotArguments) -> Result<String, Complaint> {
    let written = match (&arguments.results[..], arguments.y.is_empty()) {
        (files, false) => vec![compared(arguments, files)?],
        ([file], true) if arguments.frames => frames(arguments, file)?,
        ([file], true) => vec![picture(arguments, file)?],
        (files, true) => {
            let n = files.len();
            return Err(Complaint::input(format!("{n} results files can be drawn together by --y alone")));
        }
    };
    Ok(written.iter().map(|path| format!("{}\n", path.display())).collect())
}

/// Columns of the histories against each other.
fn compared(arguments: &PlotArguments, files: &[PathBuf]) -> Result<PathBuf, Complaint> {
    let beside = || files[0].with_extension("png");
    let path = arguments.output.clone().unwrap_or_else(beside);
    let wanted = Wanted { y: &arguments.y, x: arguments.x.as_deref(), absolute: arguments.abs };
    let panels = [columns::columns(files, &wanted)?];
    Figure { panel: ALONE, ..Figure::new(&panels) }.legible().save(&path).map_err(refuse)?;
    Ok(path)
}

fn picture(arguments: &PlotArguments, results: &Path) -> Result<PathBuf, Complaint> {
    let file = &Drawn::open(results)?;
    let path = arguments.output.clone().unwrap_or_else(|| results.with_extension("png"));
    let all = [Show::Body, Show::Reaction, Show::Moment, Show::Tool, Show::Convergence, Show::Energy];
    let asked = !arguments.show.is_empty();
    let mut panels = Vec::new();
    let mut alone = PANEL;
    for show in if asked { &arguments.show[..] } else { &all[..] } {
        let panel = match show {
            Show::Body => {
                let body = body::Bodies::of(file, &arguments.body)?;
                let steps = body.steps(arguments.body.step)?;
                let panel = body.panel(steps.end - 1, &body.scales(steps)?)?;
                alone = body::size(&panel);
                Some(Panel::Shapes(panel))
            }
            Show::Reaction => histories::reactions(file)?,
            Show::Moment => histories::moments(file)?,
            Show::Tool => tools::forces(file)?,
            Show::Convergence => histories::convergence(file)?,
            Show::Energy => histories::energies(file)?,
        };
        if panel.is_none() && asked {
            let name = show.to_possible_value().map_or(String::new(), |value| value.get_name().to_string());
            return Err(Complaint::input(format!(
                "results file {} holds nothing to show as {name}",
                results.display()
            )));
        }
        panels.extend(panel);
    }
    let panel = if let [Panel::Shapes(_)] = panels[..] { alone } else { PANEL };
    let columns = panels.len().clamp(1, 2);
    Figure { columns, panel, ..Figure::new(&panels) }.legible().save(&path).map_err(refuse)?;
    Ok(path)
}

/// A folder of pictures and a GIF, all of one size and on one scale.
fn frames(arguments: &PlotArguments, results: &Path) -> Result<Vec<PathBuf>, Complaint> {
    let file = &Drawn::open(results)?;
    let folder = arguments.output.clone().unwrap_or_else(|| {
        let name = results.file_stem().unwrap_or_default().to_string_lossy();
        results.with_file_name(format!("{name}_frames"))
    });
    let failed = |error| Complaint::input(format!("cannot create folder {}: {error}", folder.display()));
    std::fs::create_dir_all(&folder).map_err(failed)?;
    let body = body::Bodies::of(file, &arguments.body)?;
    let steps = body.steps(None)?;
    let steps = 0..steps.end;
    let scales = body.scales(steps.clone())?;
    let gif = named_after(folder.as_os_str(), "gif");
    let mut animation: Option<Animation> = None;
    for step in steps {
        let panel = body.panel(step, &scales)?;
        let size = body::size(&panel);
        let panels = [Panel::Shapes(panel)];
        let image = Figure { panel: size, ..Figure::new(&panels) }.legible().image().map_err(refuse)?;
        image.save(&folder.join(format!("{step:04}.png"))).map_err(refuse)?;
        let animation = match &mut animation {
            Some(animation) => animation,
            none => none.insert(Animation::create(&gif, image.size(), 100 / arguments.rate).map_err(refuse)?),
        };
        animation.add(&image).map_err(refuse)?;
    }
    Ok(vec![folder, gif])
}

fn refuse(error: PlotError) -> Complaint {
    Complaint::input(error.to_string())
}

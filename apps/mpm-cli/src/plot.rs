//! `mpm plot`: pictures of a results file.

mod arguments;
mod body;
mod drawn;
mod histories;
mod tools;

use crate::complaint::Complaint;
use crate::run::named_after;
use arguments::BodyArguments;
use clap::{Args, ValueEnum};
use drawn::Drawn;
pub use drawn::scene_of;
use mpm_plot::{Animation, Figure, Panel, PlotError};
use std::path::PathBuf;

#[derive(Args)]
pub struct PlotArguments {
    /// The results file.
    pub results: PathBuf,
    /// Picture, .png or .svg; with `--frames`, the folder of the pictures [default: the results' name with .png, or
    /// with `_frames`].
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// What is drawn, side by side [default: all that the file holds].
    #[arg(long, value_enum, value_delimiter = ',', value_name = "WHAT")]
    show: Vec<Show>,
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

/// Size of a panel beside others.
const PANEL: (u32, u32) = (620, 500);

/// Draws what the arguments ask for, and says where.
pub fn plot(arguments: &PlotArguments) -> Result<String, Complaint> {
    let file = Drawn::open(&arguments.results)?;
    let written = match arguments.frames {
        true => frames(arguments, &file)?,
        false => vec![picture(arguments, &file)?],
    };
    Ok(written.iter().map(|path| format!("{}\n", path.display())).collect())
}

fn picture(arguments: &PlotArguments, file: &Drawn) -> Result<PathBuf, Complaint> {
    let path = arguments.output.clone().unwrap_or_else(|| arguments.results.with_extension("png"));
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
                arguments.results.display()
            )));
        }
        panels.extend(panel);
    }
    let panel = if let [Panel::Shapes(_)] = panels[..] { alone } else { PANEL };
    let columns = if panels.len() == 4 { 2 } else { panels.len().clamp(1, 3) };
    Figure { panels: &panels, columns, panel }.save(&path).map_err(refuse)?;
    Ok(path)
}

/// A folder of pictures and a GIF, all of one size and on one scale.
fn frames(arguments: &PlotArguments, file: &Drawn) -> Result<Vec<PathBuf>, Complaint> {
    let folder = arguments.output.clone().unwrap_or_else(|| {
        let name = arguments.results.file_stem().unwrap_or_default().to_string_lossy();
        arguments.results.with_file_name(format!("{name}_frames"))
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
        let image = Figure { panels: &panels, columns: 1, panel: size }.image().map_err(refuse)?;
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

//! `mpm plot`: pictures of a results file.

mod body;
mod histories;

use crate::complaint::Complaint;
use clap::{Args, ValueEnum};
use mpm_io::Results;
use mpm_plot::{Animation, Figure, Panel, PlotError};
use mpm_scene::Scene;
use std::path::{Path, PathBuf};

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

#[derive(Args)]
pub struct BodyArguments {
    /// Field that colours the body, with a component where it has several: `displacement.x`, `cauchy_stress.xy`, or
    /// `.norm`, `.mean`, `.deviator` [default: the most telling one of the file].
    #[arg(long, value_name = "FIELD")]
    field: Option<String>,
    /// Recorded step, numbered from 0 [default: the last].
    #[arg(long, value_name = "N")]
    step: Option<usize>,
    /// Ends of the colour bar [default: those of the field].
    #[arg(long, num_args = 2, value_names = ["FROM", "TO"], allow_negative_numbers = true)]
    range: Option<Vec<f64>>,
    /// Leave the mesh out.
    #[arg(long)]
    no_mesh: bool,
    /// Three dimensions: where one looks from.
    #[arg(long, value_enum, default_value_t = View::Corner)]
    view: View,
    /// Three dimensions: only the points next to a plane across an axis, as in `z=0.5`.
    #[arg(long, value_name = "AXIS=AT", value_parser = slice)]
    slice: Option<(usize, f64)>,
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
}

/// Where one looks from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum View {
    /// From a corner, all three axes alike.
    Corner,
    /// Along x.
    X,
    /// Along y.
    Y,
    /// Along z, from above.
    Z,
}

fn slice(text: &str) -> Result<(usize, f64), String> {
    let wrong = || format!("expected an axis and a coordinate as in z=0.5, got {text}");
    let (axis, at) = text.split_once('=').ok_or_else(wrong)?;
    let axis = ["x", "y", "z"].iter().position(|name| name.eq_ignore_ascii_case(axis)).ok_or_else(wrong)?;
    let at = at.parse().ok().filter(|at: &f64| at.is_finite()).ok_or_else(wrong)?;
    Ok((axis, at))
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

/// A results file and its scene.
pub struct Drawn {
    results: Results,
    scene: Scene,
}

impl Drawn {
    fn open(path: &Path) -> Result<Self, Complaint> {
        let results = Results::open(path).map_err(complain)?;
        if results.fractions().is_empty() {
            return Err(Complaint::input(format!("results file {} holds no recorded step", path.display())));
        }
        let scene = Scene::from_ron(results.scene()).map_err(|error| {
            Complaint::input(format!("results file {}: its scene cannot be read: {error}", path.display()))
        })?;
        Ok(Self { results, scene })
    }
}

fn picture(arguments: &PlotArguments, file: &Drawn) -> Result<PathBuf, Complaint> {
    let path = arguments.output.clone().unwrap_or_else(|| arguments.results.with_extension("png"));
    let all = [Show::Body, Show::Reaction, Show::Moment, Show::Convergence, Show::Energy];
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
    let gif = folder.with_extension("gif");
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

fn complain(error: mpm_io::ResultsError) -> Complaint {
    Complaint::input(error.to_string())
}

fn refuse(error: PlotError) -> Complaint {
    Complaint::input(error.to_string())
}

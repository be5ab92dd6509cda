//! `mpm drive`: one material point along a path.

use crate::complaint::Complaint;
use crate::input;
use crate::say::say;
use clap::Args;
use mpm_plot::{Curve, Curves, Figure, Legend, Panel, Stroke};
use mpm_scene::language::DriveInput;
use mpm_scene::{DrivenPath, drive as driven};
use std::fmt::Write;
use std::path::{Path, PathBuf};

#[derive(Args)]
pub struct DriveArguments {
    /// Law and path, a RON file (its language: docs/guide/src/laws/driver.md).
    pub law: PathBuf,
    /// Print the table as CSV with all digits.
    #[arg(long)]
    csv: bool,
    /// Draw the path as well, .png or .svg.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Size of a panel.
const PANEL: (u32, u32) = (520, 460);

/// Drives the point, prints a row per step, and draws the path where that is asked for.
pub fn drive(arguments: &DriveArguments) -> Result<(), Complaint> {
    let file = &arguments.law;
    let text = input::text(file)?;
    let input = DriveInput::from_ron(&text).map_err(|error| {
        let place = error.start.offset(&text)..error.end.offset(&text);
        Complaint::at(file, &text, place, None, error.reason)
    })?;
    let path = driven(&input).map_err(|error| input::refused(file, &text, error))?;
    say(&if arguments.csv { csv(&path) } else { table(&path) })?;
    if let Some(picture) = &arguments.output {
        draw(&path, &input.title, picture)?;
    }
    match &path.stopped {
        None => Ok(()),
        Some(reason) => Err(Complaint::unfinished(format!("{}: {reason}", file.display()))),
    }
}

fn csv(path: &DrivenPath) -> String {
    let mut text = path.columns.join(",") + "\n";
    for row in &path.rows {
        let numbers: Vec<String> = row.iter().map(f64::to_string).collect();
        text += &(numbers.join(",") + "\n");
    }
    text
}

fn table(path: &DrivenPath) -> String {
    let cell = |name: &str, value: f64| match name {
        "step" | "segment" | "plastic" => format!("{value}"),
        name if name.starts_with('f') || name == "j" => format!("{value:.5}"),
        _ if value == 0.0 => "0".into(),
        _ if (1e-3..1e6).contains(&value.abs()) => format!("{value:.4}"),
        _ => format!("{value:.4e}"),
    };
    let rows: Vec<Vec<String>> = path
        .rows
        .iter()
        .map(|row| path.columns.iter().zip(row).map(|(name, &it)| cell(name, it)).collect())
        .collect();
    let width = |k: usize| rows.iter().map(|row| row[k].len()).fold(path.columns[k].len(), usize::max);
    let widths: Vec<usize> = (0..path.columns.len()).map(width).collect();
    let mut text = String::new();
    for row in std::iter::once(&path.columns).chain(&rows) {
        let cells: Vec<String> =
            row.iter().zip(&widths).map(|(cell, width)| format!("{cell:>width$}")).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{}", cells.join("  "));
    }
    text
}

/// Stress against strain, the path of stress, and the change of volume.
fn draw(path: &DrivenPath, title: &str, file: &Path) -> Result<(), Complaint> {
    let along = |name: &str, f: fn(f64) -> f64| path.column(name).into_iter().map(f).collect::<Vec<f64>>();
    let shear = path.column("f12");
    let is_sheared = shear.iter().any(|gamma| gamma.abs() > 1e-12);
    let (strain, of_strain) = if is_sheared { (shear, "F12") } else { (along("f11", |f| -f.ln()), "-ln F11") };
    let shear_stress = if is_sheared { ("s12", "shear stress s12") } else { ("q", "q") };
    let panels = [
        panel(title, [of_strain, shear_stress.1], &strain, &path.column(shear_stress.0)),
        panel("", ["p", "q"], &path.column("p"), &path.column("q")),
        panel("", [of_strain, "ln J"], &strain, &along("j", f64::ln)),
    ];
    let figure = Figure { columns: 3, panel: PANEL, ..Figure::new(&panels) };
    figure.save(file).map_err(|error| Complaint::input(error.to_string()))
}

fn panel(title: &str, axes: [&str; 2], x: &[f64], y: &[f64]) -> Panel {
    let range = |values: &[f64]| {
        let (low, high) = values
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &it| (low.min(it), high.max(it)));
        // Rounding alone is no range.
        let margin = (0.04 * (high - low)).max(1e-9 * high.abs().max(low.abs())).max(1e-12);
        (low - margin, high + margin)
    };
    let points = x.iter().copied().zip(y.iter().copied()).collect();
    let curve = Curve { name: String::new(), colour: 0, stroke: Stroke::Line, points };
    Panel::Curves(Curves {
        title: title.into(),
        axes: axes.map(Into::into),
        range: [range(x), range(y)],
        logarithmic: [false; 2],
        legend: Legend::None,
        curves: vec![curve],
    })
}

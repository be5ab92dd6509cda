//! `mpm export`: results for other programs.

use crate::complaint::Complaint;
use clap::{ArgGroup, Args};
use mpm_io::{FolderFiles, Results, Revolution};
use mpm_pictures::scene_of;
use mpm_scene::tool_surfaces;
use std::path::{Path, PathBuf};

#[derive(Args)]
#[command(group = ArgGroup::new("format").required(true))]
pub struct ExportArguments {
    /// The results file.
    pub results: PathBuf,
    /// Tables: history.csv with a line per load step, points_0000.csv … with a line per material point.
    #[arg(long, group = "format")]
    csv: bool,
    /// Points, tools, and domains where their outlines are recorded, as VTU files, and a PVD series of each for ParaView.
    #[arg(long, group = "format")]
    vtu: bool,
    /// Domains of a body of revolution as VTU files of so many wedges round the axis each, and a PVD series for ParaView;
    /// vectors and tensors along x, y and z.
    #[arg(long, group = "format", value_name = "N", value_parser = clap::value_parser!(u32).range(1..=3600))]
    revolve: Option<u32>,
    /// Angle of all wedges together, in degrees.
    #[arg(long, value_name = "DEGREES", default_value_t = 360.0, requires = "revolve")]
    angle: f64,
    /// Folder of the files; it need not be there yet [default: the results' name with `_csv`, `_vtu` or `_revolved`].
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Folder in which the surfaces of tools lie that the scene names [default: that of the results].
    #[arg(long, value_name = "FOLDER")]
    files: Option<PathBuf>,
}

/// Writes the files and says which: the folder, or the series beside it.
pub fn export(arguments: &ExportArguments) -> Result<String, Complaint> {
    let complain = |error: mpm_io::ResultsError| Complaint::input(error.to_string());
    let results = Results::open(&arguments.results).map_err(complain)?;
    let name = arguments.results.file_stem().unwrap_or_default().to_string_lossy();
    let revolution = arguments.revolve.map(|sectors| Revolution::new(sectors, arguments.angle)).transpose();
    let revolution = revolution.map_err(|reason| Complaint::input(format!("--revolve: {reason}")))?;
    let ending = match revolution {
        Some(_) => "revolved",
        None if arguments.csv => "csv",
        None => "vtu",
    };
    let beside = || arguments.results.with_file_name(format!("{name}_{ending}"));
    let folder = arguments.output.clone().unwrap_or_else(beside);
    if let Some(revolution) = revolution {
        let written = results.write_revolved(&folder, revolution).map_err(complain)?;
        return Ok(series(&written));
    }
    if arguments.csv {
        results.write_csv(&folder).map_err(complain)?;
        return Ok(format!("{}\n", folder.display()));
    }
    let mut written = results.write_vtu(&folder).map_err(complain)?;
    if results.columns().iter().any(|column| column.name.starts_with("tool/")) {
        written.extend(tools(arguments, &results, &folder)?);
    }
    Ok(series(&written))
}

/// A line for each series of files.
fn series(written: &[PathBuf]) -> String {
    let series = written.iter().filter(|path| path.extension().is_some_and(|it| it == "pvd"));
    series.map(|path| format!("{}\n", path.display())).collect()
}

/// Writes the surfaces of the tools.
fn tools(arguments: &ExportArguments, results: &Results, folder: &Path) -> Result<Vec<PathBuf>, Complaint> {
    let files = match &arguments.files {
        Some(folder) => FolderFiles::new(folder),
        None => FolderFiles::beside(&arguments.results),
    };
    let scene = scene_of(results, &arguments.results)?;
    let surfaces = tool_surfaces(&scene, &files)
        .map_err(|error| Complaint::input(format!("the scene of the results gives no tools: {error}")))?;
    results.write_tools_vtu(folder, &surfaces).map_err(|error| Complaint::input(error.to_string()))
}

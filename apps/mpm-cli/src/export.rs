//! `mpm export`: results for other programs.

use crate::complaint::Complaint;
use clap::{ArgGroup, Args};
use mpm_io::Results;
use std::path::PathBuf;

#[derive(Args)]
#[command(group = ArgGroup::new("format").required(true))]
pub struct ExportArguments {
    /// The results file.
    pub results: PathBuf,
    /// Tables: history.csv with a line per load step, points_0000.csv … with a line per material point.
    #[arg(long, group = "format")]
    csv: bool,
    /// Points, and domains where their outlines are recorded, as VTU files, and a PVD series for ParaView.
    #[arg(long, group = "format")]
    vtu: bool,
    /// Folder of the files; it need not be there yet [default: the results' name with `_csv` or `_vtu`].
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

/// Writes the files and says which: the folder, or the series beside it.
pub fn export(arguments: &ExportArguments) -> Result<String, Complaint> {
    let complain = |error: mpm_io::ResultsError| Complaint::input(error.to_string());
    let results = Results::open(&arguments.results).map_err(complain)?;
    let name = arguments.results.file_stem().unwrap_or_default().to_string_lossy();
    let ending = if arguments.csv { "csv" } else { "vtu" };
    let beside = || arguments.results.with_file_name(format!("{name}_{ending}"));
    let folder = arguments.output.clone().unwrap_or_else(beside);
    let written = match arguments.csv {
        true => results.write_csv(&folder),
        false => results.write_vtu(&folder),
    };
    let written = written.map_err(complain)?;
    if arguments.csv {
        return Ok(format!("{}\n", folder.display()));
    }
    let series = written.iter().filter(|path| path.extension().is_some_and(|it| it == "pvd"));
    Ok(series.map(|path| format!("{}\n", path.display())).collect())
}

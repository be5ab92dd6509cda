//! Any columns of the history against each other, of one results file or several.

use crate::drawn::{complain, unread};
use crate::error::PictureError;
use crate::histories::{ROUNDING, curves};
use mpm_io::{Results, component_name};
use mpm_plot::Panel;
use std::path::{Path, PathBuf};

/// Columns of the history that are drawn against another.
#[derive(Clone, Debug, Default)]
pub struct Wanted {
    /// Columns upwards, with a component where they have several: `reaction/base.y`.
    pub y: Vec<String>,
    /// Column along the axis; the load fraction if left out.
    pub x: Option<String>,
    /// Whether sizes are drawn in place of signed values.
    pub absolute: bool,
}

/// A column of a history, or a component of one.
struct Column {
    /// Its name with the component, and its unit.
    label: String,
    values: Vec<f64>,
}

/// A curve for every file and column.
pub(crate) fn columns(files: &[PathBuf], wanted: &Wanted) -> Result<Panel, PictureError> {
    let names = legend(files);
    let (mut lines, mut labels) = (Vec::new(), [None, None]);
    for (path, name) in files.iter().zip(names) {
        let results = Results::open(path).map_err(complain)?;
        if results.rows() == 0 {
            return Err(unread(path));
        }
        let x = column(&results, wanted.x.as_deref().unwrap_or("load_fraction"), path, wanted.absolute)?;
        for wanted_y in &wanted.y {
            let y = column(&results, wanted_y, path, wanted.absolute)?;
            let curve = match (wanted.y.len(), files.len()) {
                // The axis names the only curve.
                (1, 1) => String::new(),
                (_, 1) => y.label.clone(),
                (1, _) => name.clone(),
                _ => format!("{name}: {}", y.label),
            };
            labels[1].get_or_insert(y.label);
            lines.push((curve, x.values.iter().copied().zip(y.values).collect()));
        }
        labels[0].get_or_insert(x.label);
    }
    let [x, y] = labels.map(Option::unwrap_or_default);
    let y = if wanted.y.len() > 1 { String::new() } else { y };
    let size =
        |label: String| if wanted.absolute && !label.is_empty() { format!("size of {label}") } else { label };
    Ok(curves("", [&size(x), &size(y)], lines))
}

/// What tells files apart: their names; where these are the same, their folders'.
fn legend(files: &[PathBuf]) -> Vec<String> {
    let part = |of: Option<&std::ffi::OsStr>| of.unwrap_or_default().to_string_lossy().into_owned();
    let stems: Vec<String> = files.iter().map(|file| part(file.file_stem())).collect();
    if stems.iter().any(|stem| stems.iter().filter(|other| *other == stem).count() > 1) {
        return files.iter().map(|file| part(file.parent().and_then(Path::file_name))).collect();
    }
    stems
}

/// A column by its name: `reaction/base.y`, or `load_fraction`; a column of several numbers without a component is its size.
fn column(results: &Results, wanted: &str, path: &Path, absolute: bool) -> Result<Column, PictureError> {
    let of = |name: &str| results.columns().iter().find(|column| column.name == name);
    // A component follows the last dot or bracket.
    let split = wanted.rfind(['.', '[']).map(|at| wanted.split_at(at));
    let (known, component) = match (of(wanted), split) {
        (Some(column), _) => (Some(column), ""),
        (None, Some((name, component))) => (of(name), component),
        (None, None) => (None, ""),
    };
    let Some(known) = known else {
        let names: Vec<&str> = results.columns().iter().map(|column| column.name.as_str()).collect();
        return Err(PictureError::new(format!(
            "no column `{wanted}` in the history of {}; there are {}",
            path.display(),
            names.join(", ")
        )));
    };
    let table = results.column(&known.name).map_err(complain)?;
    let width = table.width();
    let number = (0..width).find(|&c| component_name(results.space(), width, c) == component);
    let rows = (0..table.len()).map(|row| table.row(row));
    let norm = |row: &[f64]| row.iter().map(|x| x * x).sum::<f64>().sqrt();
    let mut values: Vec<f64> = match (number, component) {
        (Some(c), _) => rows.map(|row| row[c]).collect(),
        (None, "") => rows.map(norm).collect(),
        (None, _) => {
            let names: Vec<String> = (0..width).map(|c| component_name(results.space(), width, c)).collect();
            let names = names.join(", ");
            return Err(PictureError::new(format!(
                "column `{}` has no component `{component}`; there are {names}",
                known.name
            )));
        }
    };
    // What is rounding beside the other components is nothing.
    let most = table.values().iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    if values.iter().all(|x| x.abs() <= ROUNDING * most) {
        values.fill(0.0);
    }
    if absolute {
        values.iter_mut().for_each(|x| *x = x.abs());
    }
    Ok(Column { label: format!("{wanted} [{}]", known.unit(results.space())), values })
}

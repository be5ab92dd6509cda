//! The table of a sweep: a row for every combination of values.

use crate::complaint::Complaint;
use mpm_grid::six_digits;
use mpm_io::{Results, component_name, shortest};
use serde_json::{Map, Value, json};
use std::fmt::Write as _;

/// A line of the table.
pub(super) struct Row {
    settings: Vec<(String, String)>,
    status: String,
    /// Name and value, in the order of the history.
    numbers: Vec<(String, f64)>,
}

impl Row {
    /// Of a combination: its settings, how its run stands, and its results, if they are those of the combination.
    pub fn of(settings: &[(String, String)], status: String, results: Option<&Results>) -> Self {
        Self { settings: settings.to_vec(), status, numbers: results.map_or(Vec::new(), numbers) }
    }

    pub fn json(&self) -> Value {
        let settings = self.settings.iter().map(|(path, value)| (path.clone(), json!(value)));
        let numbers = self.numbers.iter().map(|(name, value)| (name.clone(), json!(value)));
        json!({
            "settings": settings.collect::<Map<_, _>>(), "status": self.status,
            "results": numbers.collect::<Map<_, _>>(),
        })
    }
}

/// Totals of the run, and last value and peak of what the history says of supports, energies and probes.
fn numbers(results: &Results) -> Vec<(String, f64)> {
    let sum = |name: &str| results.column(name).map_or(0.0, |table| table.values().iter().sum());
    let reached = results.column("load_fraction").ok().and_then(|table| table.values().last().copied());
    let mut numbers = vec![
        ("load_fraction".to_string(), reached.unwrap_or(0.0)),
        ("load_steps".to_string(), results.rows().saturating_sub(1) as f64),
        ("iterations".to_string(), sum("newton_iterations")),
        ("cuts".to_string(), sum("cuts")),
        ("seconds".to_string(), sum("wall_seconds")),
    ];
    for column in results.columns().iter().filter(|column| column.name.contains('/')) {
        let Ok(table) = results.column(&column.name) else { continue };
        for c in 0..table.width() {
            let values = || (0..table.len()).map(|row| table.row(row)[c]);
            let name = format!("{}{}", column.name, component_name(results.space(), table.width(), c));
            let peak = values().fold(0.0_f64, |peak, x| if x.abs() > peak.abs() { x } else { peak });
            numbers.push((format!("{name} last"), values().next_back().unwrap_or(0.0)));
            numbers.push((format!("{name} peak"), peak));
        }
    }
    numbers
}

/// Names of all numbers of the rows; a run that has not begun has none.
fn names(rows: &[Row]) -> Vec<&String> {
    let longest = rows.iter().max_by_key(|row| row.numbers.len());
    longest.map_or(Vec::new(), |row| row.numbers.iter().map(|(name, _)| name).collect())
}

/// All of it, for other programs.
pub(super) fn csv(rows: &[Row]) -> String {
    let quoted = |text: &str| match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_string(),
    };
    let names = names(rows);
    let settings = rows[0].settings.iter().map(|(path, _)| path.as_str());
    let heads = settings.chain(["status"]).chain(names.iter().map(|name| name.as_str()));
    let mut text = heads.map(quoted).collect::<Vec<_>>().join(",") + "\n";
    for row in rows {
        let mut cells: Vec<String> = row.settings.iter().map(|(_, value)| quoted(value)).collect();
        cells.push(quoted(&row.status));
        cells.extend(names.iter().map(|name| {
            let found = row.numbers.iter().find(|(other, _)| other == *name);
            found.map_or(String::new(), |(_, value)| shortest(*value))
        }));
        text += &(cells.join(",") + "\n");
    }
    text
}

/// The columns that are wanted; else what fits on a screen: totals, and peaks that are not zero throughout.
fn shown<'a>(rows: &'a [Row], wanted: &[String]) -> Result<Vec<&'a String>, Complaint> {
    let names = names(rows);
    if wanted.is_empty() {
        let is_told = |name: &&String| {
            let is_told = !name.contains('/') || (name.contains("reaction") && name.ends_with(" peak"));
            let of = |row: &Row| row.numbers.iter().find(|(other, _)| other == *name).map_or(0.0, |it| it.1);
            is_told && rows.iter().any(|row| of(row) != 0.0)
        };
        return Ok(names.into_iter().filter(is_told).collect());
    }
    let mut shown = Vec::new();
    for wanted in wanted {
        let is_it = |name: &&&String| {
            **name == wanted || [" last", " peak"].iter().any(|end| name.strip_suffix(end) == Some(wanted))
        };
        let before = shown.len();
        shown.extend(names.iter().filter(is_it).copied());
        if shown.len() == before && !names.is_empty() {
            let names: Vec<&str> = names.iter().map(|name| name.as_str()).collect();
            return Err(Complaint::input(format!(
                "--show: no column `{wanted}`; there are {}",
                names.join(", ")
            )));
        }
    }
    Ok(shown)
}

/// The table as text.
pub(super) fn table(rows: &[Row], wanted: &[String]) -> Result<String, Complaint> {
    let shown = shown(rows, wanted)?;
    let mut cells: Vec<Vec<String>> = Vec::new();
    let settings = rows[0].settings.iter().map(|(path, _)| path.clone());
    cells.push(
        settings.chain(shown.iter().map(|name| name.to_string())).chain(["status".to_string()]).collect(),
    );
    for row in rows {
        let mut line: Vec<String> = row.settings.iter().map(|(_, value)| value.clone()).collect();
        line.extend(shown.iter().map(|name| {
            let found = row.numbers.iter().find(|(other, _)| other == *name);
            found.map_or(String::new(), |(_, value)| six_digits(*value))
        }));
        line.push(row.status.clone());
        cells.push(line);
    }
    let columns = cells[0].len();
    let width = |c: usize| cells.iter().map(|line| line[c].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut text = String::new();
    for line in &cells {
        for (cell, width) in line[..columns - 1].iter().zip(&widths) {
            // Writing to a string cannot fail.
            let _ = write!(text, "{cell:>width$}  ");
        }
        let _ = writeln!(text, "{}", line[columns - 1]);
    }
    Ok(text)
}

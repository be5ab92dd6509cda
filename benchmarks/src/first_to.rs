//! Who is first to an error, and quadratic finite elements beside the bases.

use crate::Failure;
use mpm_validation::Table;
use serde::Deserialize;
use std::path::Path;

/// Name of the curve of finite elements.
pub const ELEMENTS: &str = "quadratic finite elements";

/// Errors that runs are to reach.
const LEVELS: [f64; 6] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6];

/// Time and error of something on a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Reached {
    /// Name of the problem.
    pub problem: String,
    /// Basis, or [`ELEMENTS`].
    pub name: String,
    /// The mesh.
    pub cells: String,
    /// Processor time on one thread `[s]`.
    pub seconds: f64,
    /// The error `[-]`.
    pub error: f64,
}

#[derive(Deserialize)]
struct File {
    rows: Vec<Row>,
}

#[derive(Deserialize)]
struct Row {
    problem: String,
    mesh: u32,
    error: Option<f64>,
    seconds: Option<f64>,
}

/// What `foreign/quadratic_elements.py` has written; nothing where there is no such file.
///
/// # Errors
/// The file cannot be read, or is of something else.
pub fn elements(path: &Path) -> Result<Vec<Reached>, Failure> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    let wrong = |reason: String| format!("{}: {reason}", path.display());
    let text = std::fs::read_to_string(path).map_err(|error| wrong(error.to_string()))?;
    let file: File = serde_json::from_str(&text)
        .map_err(|error| wrong(format!("expected what `foreign/quadratic_elements.py` writes: {error}")))?;
    let reached = |row: Row| {
        let (error, seconds) = (row.error?, row.seconds?);
        let (name, cells) = (ELEMENTS.to_owned(), row.mesh.to_string());
        Some(Reached { problem: row.problem, name, cells, seconds, error })
    };
    Ok(file.rows.into_iter().filter_map(reached).collect())
}

/// The quickest run of each group to each error; a group has the names that belong to it. What nothing reaches is left out.
pub fn table(reached: &[Reached], groups: &[(&str, Vec<&str>)]) -> Table {
    let heads: Vec<&str> = ["problem", "error"].into_iter().chain(groups.iter().map(|it| it.0)).collect();
    let mut table = Table::new("Who is first to an error, in processor seconds on one thread:", &heads);
    let mut problems: Vec<&str> = reached.iter().map(|it| &it.problem[..]).collect();
    problems.dedup();
    let mut met: Vec<&str> = Vec::new();
    for problem in problems {
        if met.contains(&problem) {
            continue;
        }
        met.push(problem);
        for level in LEVELS {
            let first = |names: &[&str]| {
                let good = reached
                    .iter()
                    .filter(|it| it.problem == problem && names.contains(&&it.name[..]) && it.error <= level);
                good.min_by(|a, b| a.seconds.total_cmp(&b.seconds))
            };
            let found: Vec<Option<&Reached>> = groups.iter().map(|(_, names)| first(names)).collect();
            if found.iter().all(Option::is_none) {
                continue;
            }
            let least = found.iter().flatten().map(|it| it.seconds).fold(f64::INFINITY, f64::min);
            let told = |it: &Option<&Reached>| {
                it.map_or(String::new(), |it| {
                    let bold = if it.seconds == least { "**" } else { "" };
                    format!("{bold}{:.2e}{bold} ({}, {})", it.seconds, it.name, it.cells)
                })
            };
            table.push([problem.to_owned(), format!("{level:.0e}")].into_iter().chain(found.iter().map(told)));
        }
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(name: &str, seconds: f64, error: f64) -> Reached {
        Reached { problem: "p".into(), name: name.into(), cells: "8".into(), seconds, error }
    }

    #[test]
    fn the_quickest_run_that_is_good_enough_counts() {
        let runs = [run("a", 1.0, 0.05), run("a", 2.0, 0.005), run("b", 0.5, 0.02), run("b", 3.0, 0.002)];
        let table = table(&runs, &[("first", vec!["a"]), ("other", vec!["b"])]);
        assert_eq!(
            table.rows,
            [
                ["p", "1e-1", "1.00e0 (a, 8)", "**5.00e-1** (b, 8)"],
                ["p", "1e-2", "**2.00e0** (a, 8)", "3.00e0 (b, 8)"],
            ]
        );
    }

    #[test]
    fn a_file_of_something_else_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("elements.json");
        assert!(elements(&path).unwrap().is_empty());
        std::fs::write(&path, r#"{"rows": [{"problem": "p", "mesh": 2, "error": 0.5, "seconds": 1.5}, {"problem": "p", "mesh": 4, "error": null}]}"#).unwrap();
        assert_eq!(elements(&path).unwrap(), [Reached { cells: "2".into(), ..run(ELEMENTS, 1.5, 0.5) }]);
        std::fs::write(&path, "[]").unwrap();
        assert!(elements(&path).unwrap_err().to_string().contains("quadratic_elements.py"));
    }
}

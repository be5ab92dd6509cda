//! The validation as Markdown: a page per case, and a table of all of them.

use crate::{Broken, Case, Check, Findings, Table};
use std::fmt::Write as _;
use std::path::Path;

/// What the table of all cases opens with.
pub const INTRODUCTION: &str = include_str!("introduction.md");

/// Folder of the case pages, beside the table.
const CASES: &str = "cases";

const HEAD: &str = "| what is compared | error | tolerance | | remark |\n|---|---|---|---|---|";

/// Name of a case's page.
pub fn file_name(case: &Case) -> String {
    let words = case.name.split(|c: char| !c.is_alphanumeric() && c != '\'').filter(|word| !word.is_empty());
    words.map(|word| word.replace('\'', "").to_lowercase()).collect::<Vec<_>>().join("_") + ".md"
}

/// A case under a heading of `level`; pictures are found below `pictures`.
pub(crate) fn section(case: &Case, findings: &Findings, level: &str, pictures: &str) -> String {
    let mut text = format!("{level} {}\n\n", case.name);
    // Writing to a string cannot fail.
    let _ =
        writeln!(text, "*Goal.* {}\n\n*Setup.* {}\n\n*Reference.* {}\n", case.goal, case.setup, case.reference);
    let _ = writeln!(text, "{HEAD}");
    for check in &findings.checks {
        let _ = writeln!(text, "{}", row(check));
    }
    for Table { text: about, heads, rows } in &findings.tables {
        let _ = writeln!(text, "\n{about}\n\n| {} |\n|{}", heads.join(" | "), "---|".repeat(heads.len()));
        for row in rows {
            let _ = writeln!(text, "| {} |", row.join(" | "));
        }
    }
    for picture in &findings.pictures {
        let caption = &picture.caption;
        let _ = writeln!(text, "\n![{caption}]({pictures}/{})\n\n{caption}", picture.file);
    }
    text
}

/// The row of a comparison.
pub(crate) fn row(check: &Check) -> String {
    let Check { what, error, tolerance, remark } = check;
    let verdict = if check.passes() { "pass" } else { "FAIL" };
    format!("| {what} | {error:.1e} | {tolerance:.0e} | {verdict} | {remark} |")
}

/// Writes the page of a case into `folder/cases`.
///
/// # Errors
/// The file cannot be written.
pub(crate) fn write(case: &Case, findings: &Findings, folder: &Path) -> Result<(), Broken> {
    let path = folder.join(CASES).join(file_name(case));
    let text = section(case, findings, "#", "../../docs/pictures");
    std::fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()).into())
}

/// The table of all cases, from the pages in `folder/cases`: pages of cases that were not run again count as they are.
///
/// # Errors
/// A page cannot be read, or holds no comparison.
pub fn overview(cases: &[Case], folder: &Path) -> Result<String, Broken> {
    let mut text =
        format!("{INTRODUCTION}\n| case | what it shows | comparisons | largest error / tolerance |\n");
    text.push_str("|---|---|---|---|\n");
    for case in cases {
        let file = file_name(case);
        let path = folder.join(CASES).join(&file);
        let page = std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        let rows: Vec<Row> = page.lines().filter_map(Row::read).collect();
        if rows.is_empty() {
            return Err(format!("{}: expected rows of comparisons", path.display()).into());
        }
        let failed = rows.iter().filter(|row| !row.passes).count();
        let verdict = if failed == 0 { String::new() } else { format!(", {failed} FAIL") };
        let largest = rows.iter().filter(|row| row.tolerance > 0.0).map(|row| row.error / row.tolerance);
        let largest = largest.reduce(f64::max).map_or("–".into(), |it| format!("{it:.0e}"));
        let _ = writeln!(
            text,
            "| [{}]({CASES}/{file}) | {} | {}{verdict} | {largest} |",
            case.name,
            case.goal,
            rows.len()
        );
    }
    Ok(text)
}

/// A comparison, as a page tells it.
struct Row {
    error: f64,
    tolerance: f64,
    passes: bool,
}

impl Row {
    /// Reads `| what | error | tolerance | verdict | remark |`.
    fn read(line: &str) -> Option<Self> {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let verdict = cells.iter().position(|cell| ["pass", "FAIL"].contains(cell))?;
        let number = |back: usize| cells.get(verdict.checked_sub(back)?)?.parse::<f64>().ok();
        Some(Self { error: number(2)?, tolerance: number(1)?, passes: cells[verdict] == "pass" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_are_named_after_their_cases() {
        let mut names: Vec<String> = crate::CASES.iter().map(file_name).collect();
        assert!(names.contains(&"newtons_rate.md".into()) && names.contains(&"corner_stretch_kite.md".into()));
        names.sort();
        names.dedup();
        assert_eq!(names.len(), crate::CASES.len());
    }

    #[test]
    fn rows_are_read_back() {
        let check = Check::new("a |norm| of it", 2.5e-3, 1e-2).remark("pass | FAIL");
        let read = Row::read(&row(&check)).expect("it is a row");
        assert_eq!((read.error, read.tolerance, read.passes), (2.5e-3, 1e-2, true));
        assert!(Row::read("| basis | points | error |").is_none() && Row::read("|---|---|").is_none());
    }
}

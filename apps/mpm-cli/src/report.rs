//! The report at the end of a run: convergence and cost.

use crate::terminal::Lines;
use mpm_scene::{Scene, unwritten_fields};
use mpm_solver::Summary;
use std::fmt::Write;
use std::path::Path;

/// Load steps shown at the start and at the end of a long run.
const ENDS: usize = 5;
/// A run of so few load steps is shown in full.
const SHORT: usize = 24;

/// One converged load step.
#[derive(Clone, Debug)]
pub struct Row {
    /// Number of the step, from 1.
    pub step: usize,
    /// Load fraction at its end.
    pub fraction: f64,
    /// Relative out-of-balance force of every iterate.
    pub residuals: Vec<f64>,
    /// Free components of displacement.
    pub equations: u64,
    /// 0 LLᵀ, 1 LBLᵀ, 2 LU, 3 conjugate gradients, 4 another solver.
    pub method: u64,
    /// Times the step was halved before it converged.
    pub cuts: u64,
    /// Newton corrections halved.
    pub shortened: u64,
}

/// Names of the columns of [`step`].
pub fn step_names() -> String {
    let [step, fraction, iterations, equations, method, cuts, residuals] = COLUMNS;
    format!("{step:>6}  {fraction:>8}  {iterations}  {equations}  {method}  {cuts}  {residuals}")
}

/// How a load step converged, in a line.
pub fn step(row: &Row) -> String {
    let [step, fraction, iterations, equations, method, cuts, residuals] = cells(row);
    format!("{step:>6}  {fraction:>8}  {iterations:>10}  {equations:>9}  {method:>6}  {cuts:>4}  {residuals}")
}

const COLUMNS: [&str; 7] = ["step", "fraction", "iterations", "equations", "method", "cuts", "residuals"];

fn cells(row: &Row) -> [String; 7] {
    let residuals: Vec<String> = row.residuals.iter().map(|residual| format!("{residual:.0e}")).collect();
    [
        row.step.to_string(),
        format!("{:.6}", row.fraction),
        row.residuals.len().to_string(),
        row.equations.to_string(),
        method(row.method).to_string(),
        row.cuts.to_string(),
        residuals.join(" "),
    ]
}

/// How every load step converged; of a long run the first, the last and the remarkable ones.
pub fn convergence(rows: &[Row]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let mut table = Table::new(COLUMNS);
    let mut left_out = 0;
    for (k, row) in rows.iter().enumerate() {
        let end = k < ENDS || k + ENDS >= rows.len();
        if rows.len() > SHORT && !end && !is_remarkable(row, &rows[k - 1]) {
            left_out += 1;
            continue;
        }
        table.note_left_out(&mut left_out);
        table.push(cells(row));
    }
    table.note_left_out(&mut left_out);
    table.to_string()
}

/// Whether something happened in the step that one would want to know: it was cut, or its tangent
/// began or ceased to be positive definite.
fn is_remarkable(row: &Row, before: &Row) -> bool {
    row.cuts > 0 || row.shortened > 0 || row.method != before.method
}

/// Name of a factorisation.
pub fn method(code: u64) -> &'static str {
    match code {
        0 => "LLᵀ",
        1 => "LBLᵀ",
        2 => "LU",
        3 => "CG",
        5 => "GMRES",
        _ => "another solver",
    }
}

/// Totals of a run that finished.
pub fn summary(summary: &Summary, scene: &Scene, results: &Path) -> String {
    let mut lines = Lines::new();
    let mut line = |name: &str, value: String| lines.add(name, value);
    if !scene.title().is_empty() {
        line("scene", scene.title().to_string());
    }
    line("material points", count(summary.points));
    let mut steps = format!("{}, {} halved", count(summary.steps), count(summary.cuts));
    if summary.relaxed_steps > 0 {
        let _ = write!(steps, ", {} balanced with relaxation", count(summary.relaxed_steps));
    }
    line("load steps", steps);
    let mut iterations =
        format!("{}, {} corrections shortened", count(summary.iterations), count(summary.shortened));
    if summary.dropped_iterations > 0 {
        let _ =
            write!(iterations, "; {} more for guesses that were dropped", count(summary.dropped_iterations));
    }
    line("iterations", iterations);
    line("indefinite steps", count(summary.indefinite_steps));
    match (summary.domains_capped, summary.domains_split) {
        (0, 0) => {}
        (capped, 0) => line("long domains", format!("shortened {} times", count(capped))),
        (_, split) => line("long domains", format!("points split {} times", count(split))),
    }
    line("smallest det ΔF", format!("{:.6}", summary.smallest_determinant));
    line("equilibrium", format!("relative out-of-balance force at most {:.1e}", summary.residual));
    if let Some(ratio) = summary.pressure_over_shear {
        line(
            "pressure",
            format!(
                "up to {ratio:.0} times the shear stress where points yield: `mean_dilatation: Points` lets it move nodes \
                amid a body; compare with `Cell`, where cells are full"
            ),
        );
    }
    if let Some(ratio) = summary.crowding_over_shear {
        line(
            "pressure",
            format!(
                "misjudged by up to {ratio:.0} times the shear stress where points yield: with `mean_dilatation: Cell` cells \
                 that points have crowded or left feel another pressure; use `Points` where points pass from cell to cell"
            ),
        );
    }
    let solutions = summary
        .backward_error
        .map(|error| format!("backward error at most {error:.1e}, {} refinements", count(summary.refinements)));
    let condition = match (summary.condition, summary.pivot_spread) {
        (Some(condition), _) => {
            Some(format!("worst condition number about {condition:.0e} (power and inverse iteration)"))
        }
        (None, Some(spread)) => Some(format!("worst condition number at least {spread:.0e} (pivots)")),
        (None, None) => None,
    };
    // Iterative solvers stop at the accuracy that the Newton iteration needs, and have no pivots: nothing to report.
    let known: Vec<String> = solutions.into_iter().chain(condition).collect();
    line("linear systems", if known.is_empty() { "by iteration".to_owned() } else { known.join("; ") });
    let timings = summary.timings.iter().filter(|timing| timing.count > 0);
    let timings: Vec<String> =
        timings.map(|timing| format!("{} {:.3} s ({}×)", timing.phase, timing.seconds, timing.count)).collect();
    line("time", timings.join(", "));
    let mut skipped: Vec<String> = summary
        .skipped
        .iter()
        .filter(|(_, number)| *number > 0)
        .map(|(name, number)| format!("{} {}", count(*number), name.trim_start_matches("skipped: ")))
        .collect();
    let fields = unwritten_fields(scene);
    if !fields.is_empty() {
        skipped.push(format!("fields not asked for: {}", fields.join(", ")));
    }
    line("skipped", skipped.join("; "));
    line("results", format!("{} (and {})", results.display(), results.with_extension("xdmf").display()));
    format!("\n{}", lines.into_text())
}

/// A number in groups of three digits.
pub fn count(number: impl TryInto<u64>) -> String {
    let digits = number.try_into().unwrap_or(u64::MAX).to_string();
    let mut text = String::new();
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Columns aligned to the right, the last one to the left.
pub struct Table<const N: usize> {
    rows: Vec<Line<N>>,
}

enum Line<const N: usize> {
    Cells([String; N]),
    LeftOut(usize),
}

impl<const N: usize> Table<N> {
    /// With a head.
    pub fn new(head: [&str; N]) -> Self {
        Self { rows: vec![Line::Cells(head.map(str::to_string))] }
    }

    /// Adds a row.
    pub fn push(&mut self, cells: [String; N]) {
        self.rows.push(Line::Cells(cells));
    }

    fn note_left_out(&mut self, number: &mut usize) {
        if *number > 0 {
            self.rows.push(Line::LeftOut(std::mem::take(number)));
        }
    }
}

impl<const N: usize> std::fmt::Display for Table<N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut widths = [0; N];
        for row in &self.rows {
            if let Line::Cells(cells) = row {
                for (width, cell) in widths.iter_mut().zip(cells) {
                    *width = (*width).max(cell.chars().count());
                }
            }
        }
        for row in &self.rows {
            match row {
                Line::Cells(cells) => {
                    for (cell, width) in cells[..N - 1].iter().zip(widths) {
                        write!(f, "{cell:>width$}  ")?;
                    }
                    writeln!(f, "{}", cells[N - 1])?;
                }
                Line::LeftOut(number) => {
                    writeln!(f, "{:>width$}  … {number} more like the one above", "", width = widths[0])?;
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(step: usize, cuts: u64) -> Row {
        Row {
            step,
            fraction: step as f64 / 100.0,
            residuals: vec![1e-2, 1e-10],
            equations: 6,
            method: 0,
            cuts,
            shortened: 0,
        }
    }

    #[test]
    fn long_runs_show_their_ends_and_what_happened_between() {
        let mut rows: Vec<Row> = (1..=100).map(|step| row(step, u64::from(step == 50))).collect();
        rows[69..80].iter_mut().for_each(|row| row.method = 1);
        let text = convergence(&rows);
        let lines: Vec<&str> = text.lines().collect();
        let shown: Vec<&str> = lines.iter().filter_map(|line| line.split_whitespace().next()).collect();
        let expected = "step 1 2 3 4 5 … 50 … 70 … 81 … 96 97 98 99 100";
        assert_eq!(shown.join(" "), expected, "{text}");
        assert!(lines[6].contains("… 44 more"), "{text}");
        assert!(lines[1].ends_with(" LLᵀ     0  1e-2 1e-10"), "{text}");
        assert_eq!(convergence(&rows[..SHORT]).lines().count(), 1 + SHORT);
    }

    #[test]
    fn counts_are_grouped() {
        assert_eq!([count(7_u32), count(1_000_u32), count(1_234_567_u32)], ["7", "1,000", "1,234,567"]);
    }
}

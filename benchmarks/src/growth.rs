//! Growth of time and memory with the number of points.

use crate::phases::{child, one_scene};
use crate::report::{Report, Settings, decades, power_law};
use crate::{Failure, blocks, phases::Run, throughput::method};
use mpm_validation::picture::{Curve, Curves, Legend, Panel, Stroke};
use mpm_validation::{Picture, Table};
use serde::Serialize;

/// Bases that are run; their points share cells, boxes that reach into several, convected corners.
const BASES: [&str; 3] = ["sMPM", "GIMP", "CPDI2q"];
const STEPS: u32 = 2;

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct Growth {
    /// Every run.
    pub rows: Vec<Row>,
    /// Exponents per basis.
    pub fits: Vec<Fit>,
}

/// One run.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Name of the basis.
    pub basis: &'static str,
    /// Material points.
    pub points: usize,
    /// Linear solutions.
    pub iterations: u64,
    /// Processor time of compiling and running, one thread `[s]`.
    pub seconds: f64,
    /// Of it, in order, analysis, factorisation and solution `[s]`.
    pub linear: f64,
    /// Largest resident memory of the process `[B]`.
    pub memory: Option<u64>,
}

/// Fitted exponents of a basis.
#[derive(Clone, Debug, Serialize)]
pub struct Fit {
    /// Name of the basis.
    pub basis: &'static str,
    /// From and to how many points the exponents were fitted.
    pub range: (usize, usize),
    /// Exponent of the total time in the points.
    pub total: f64,
    /// Exponent of what is not linear algebra.
    pub rest: f64,
    /// Exponent of the time of a Newton iteration: without changes in their number.
    pub iteration: f64,
    /// Exponent of memory.
    pub memory: f64,
}

/// Runs the set.
///
/// # Errors
/// A run did not finish.
pub fn run(settings: &Settings) -> Result<Report<Growth>, Failure> {
    // Cells along an edge; 4 points a cell.
    let cells: &[u32] = settings.pick(&[16, 29, 50, 90, 158], &[16, 29, 50, 90, 158, 280, 500]);
    let bases = &BASES[..settings.pick(1, BASES.len())];
    let mut rows = Vec::new();
    for &basis in bases {
        for &cells in cells {
            let arguments = ["block".into(), basis.to_owned(), cells.to_string()];
            let run: Run = child(&arguments)?;
            eprintln!("{basis}, {} points: {:.2} s", run.points, run.processor);
            let linear = ["analyse", "factorise", "solve"];
            let named = run.phases.iter().filter(|it| linear.contains(&it.phase.as_str()));
            rows.push(Row {
                basis,
                points: run.points,
                iterations: run.iterations,
                seconds: run.processor,
                // Phases are timed by wall clock, so that only their shares of the run are used.
                linear: run.processor * named.map(|it| it.seconds).sum::<f64>() / run.wall,
                memory: run.peak_memory,
            });
        }
    }
    let fits: Vec<Fit> = bases.iter().map(|basis| fit(basis, &rows)).collect();
    let tables = vec![runs(&rows), exponents(&fits)];
    let pictures = vec![(picture(bases, &rows), 2)];
    Ok(Report { set: "growth", tables, pictures, results: Growth { rows, fits } })
}

/// One run of a block in this process, on one thread.
///
/// # Errors
/// There is no such basis, or the block does not run to its end.
pub fn block(basis: &str, cells: u32) -> Result<Run, Failure> {
    let method = method(basis).ok_or_else(|| format!("no basis of the plane is called `{basis}`"))?;
    one_scene(&blocks::plane(method, cells, STEPS)?, basis, 1)
}

fn fit(basis: &'static str, rows: &[Row]) -> Fit {
    let fitted: Vec<&Row> = rows.iter().filter(|row| row.basis == basis && row.points >= 9_000).collect();
    let exponent = |of: &dyn Fn(&Row) -> f64| {
        power_law(&fitted.iter().map(|row| (row.points as f64, of(row))).collect::<Vec<_>>()).0
    };
    let points = || fitted.iter().map(|row| row.points);
    Fit {
        basis,
        range: (points().min().unwrap_or(0), points().max().unwrap_or(0)),
        total: exponent(&|row| row.seconds),
        rest: exponent(&|row| row.seconds - row.linear),
        iteration: exponent(&|row| row.seconds / row.iterations as f64),
        memory: exponent(&|row| row.memory.map_or(f64::NAN, |bytes| bytes as f64)),
    }
}

fn runs(rows: &[Row]) -> Table {
    let heads = ["basis", "points", "linear solutions", "seconds", "of them linear algebra", "MB", "kB/pt"];
    let text = format!(
        "Whole runs of a settling block, {STEPS} load steps, one thread, each in its own process (memory: all of the process)."
    );
    let mut table = Table::new(text, &heads);
    for row in rows {
        let memory =
            |scale: f64| row.memory.map_or("unknown".into(), |bytes| format!("{:.2}", bytes as f64 * scale));
        table.push([
            row.basis.to_owned(),
            row.points.to_string(),
            row.iterations.to_string(),
            format!("{:.3}", row.seconds),
            format!("{:.0} %", 100.0 * row.linear / row.seconds),
            memory(1e-6),
            memory(1e-3 / row.points as f64),
        ]);
    }
    table
}

fn exponents(fits: &[Fit]) -> Table {
    let heads = ["basis", "points", "total time", "but linear algebra", "per iteration", "memory"];
    let mut table = Table::new("Exponents fitted from 10⁴ points on.", &heads);
    for fit in fits {
        let [total, rest, iteration, memory] =
            [fit.total, fit.rest, fit.iteration, fit.memory].map(|exponent| format!("{exponent:.3}"));
        let range = format!("{} … {}", fit.range.0, fit.range.1);
        table.push([fit.basis.to_owned(), range, total, rest, iteration, memory]);
    }
    table
}

fn picture(bases: &[&'static str], rows: &[Row]) -> Picture {
    let panel = |title: &str, axis, of: &dyn Fn(&Row) -> f64| {
        let curves = bases.iter().enumerate().map(|(colour, &basis)| Curve {
            name: basis.into(),
            colour,
            stroke: Stroke::MarkedLine,
            points: rows
                .iter()
                .filter(|row| row.basis == basis)
                .map(|row| (row.points as f64, of(row)))
                .filter(|(_, y)| *y > 0.0)
                .collect(),
        });
        Panel::Curves(Curves {
            title: title.into(),
            axes: ["points", axis].map(String::from),
            range: [decades(rows.iter().map(|row| row.points as f64)), decades(rows.iter().map(of))],
            logarithmic: [true; 2],
            legend: Legend::UpperLeft,
            curves: curves.collect(),
        })
    };
    let panels = vec![
        panel("Time", "processor seconds", &|row| row.seconds),
        panel("Peak memory", "MB", &|row| row.memory.map_or(0.0, |bytes| 1e-6 * bytes as f64)),
    ];
    Picture { file: "growth.svg", caption: String::new(), panels }
}

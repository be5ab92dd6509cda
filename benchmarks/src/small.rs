//! Small runs as users start them: how long the program takes before and after the mechanics.

use crate::Failure;
use crate::program::{Program, median, scene};
use crate::report::{Report, Settings};
use mpm_validation::Table;
use serde::Serialize;
use std::path::PathBuf;

/// Cells of the column, of four points each, and load steps.
const RUNS: [(u32, u32); 9] =
    [(16, 10), (16, 40), (16, 400), (16, 4_000), (16, 10_000), (64, 40), (256, 40), (1_024, 10), (1_024, 400)];

/// Repetitions, whose median is taken.
const REPETITIONS: usize = 5;

/// One scene, recorded at every step and at the end alone.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Material points.
    pub points: u32,
    /// Load steps.
    pub steps: u32,
    /// Whether points are recorded at every load step.
    pub is_recorded: bool,
    /// Processor time of the process `[s]`.
    pub seconds: f64,
}

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct Small {
    /// Processor time of `mpm --version`: what starting takes `[s]`.
    pub start: f64,
    /// The runs.
    pub rows: Vec<Row>,
}

/// Runs the set with the program at a path, or that beside this one.
///
/// # Errors
/// There is no program; a run fails.
pub fn run(settings: &Settings, program: Option<PathBuf>) -> Result<Report<Small>, Failure> {
    let program = Program::find(program)?;
    let folder = settings.output.join("small");
    std::fs::create_dir_all(&folder)?;
    let (runs, repetitions) = settings.pick((&RUNS[..1], 1), (&RUNS[..], REPETITIONS));
    // Enough processes to fill some ticks of the clock.
    let start = program.time(&["--version"], &folder, settings.pick(5, 100))?.processor;
    let mut rows = Vec::new();
    for &(cells, steps) in runs {
        for is_recorded in [true, false] {
            let times = settings.pick(2, (4_000 / (steps + cells)).clamp(1, 40));
            let set = [
                format!("mesh.axes[1].cells={cells}"),
                format!("schedule.steps={steps}"),
                format!("output.every={}", if is_recorded { 1 } else { steps }),
            ];
            let once = || Ok::<_, Failure>(program.run(&scene("column"), &set, 1, (&folder, times))?.processor);
            let seconds = (0..repetitions).map(|_| once()).collect::<Result<Vec<_>, _>>()?;
            rows.push(Row { points: 4 * cells, steps, is_recorded, seconds: median(seconds) });
        }
    }
    let results = Small { start, rows };
    Ok(Report { set: "small", tables: vec![table(&results)], pictures: Vec::new(), results })
}

fn table(results: &Small) -> Table {
    let text = format!(
        "Whole processes of `mpm run`, the self-weight column, one thread: milliseconds of processor. `mpm --version` takes {:.1}.",
        1e3 * results.start
    );
    let heads = ["points", "load steps", "recorded at", "ms", "µs a load step beyond the start"];
    let mut table = Table::new(text, &heads);
    for Row { points, steps, is_recorded, seconds } in &results.rows {
        table.push([
            points.to_string(),
            steps.to_string(),
            if *is_recorded { "every step" } else { "the end" }.to_owned(),
            format!("{:.1}", 1e3 * seconds),
            format!("{:.0}", 1e6 * (seconds - results.start) / f64::from(*steps)),
        ]);
    }
    table
}

//! Compaction of cubes in space: seconds per phase, memory and iterations as the mesh is refined, and a run of
//! twenty load steps.

use crate::phases::{PhaseTime, child, points};
use crate::report::{Report, Settings, power_law};
use crate::{Failure, blocks, machine};
use mpm_scene::compile;
use mpm_scene::language::{Positive, Scene, SolidBasis};
use mpm_solver::observe::{Entry, LoadStep, Observer, ObserverError, RunStart};
use mpm_validation::Table;
use serde::{Deserialize, Serialize};

/// Relative out-of-balance force at the end of a load step.
const RESIDUAL: f64 = 1e-9;

/// One run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Run {
    /// Cells along an edge, 8 points each.
    pub cells: u32,
    /// Load steps.
    pub steps: u32,
    /// Threads.
    pub threads: usize,
    /// Material points.
    pub points: usize,
    /// Unknowns.
    pub equations: usize,
    /// Whether systems were solved by iteration.
    pub is_iterative: bool,
    /// Newton iterations.
    pub iterations: u64,
    /// Iterations of conjugate gradients.
    pub linear_iterations: u64,
    /// Processor time of compiling and running `[s]`.
    pub processor: f64,
    /// The same on the wall `[s]`.
    pub wall: f64,
    /// Processor time that was predicted, least and most `[s]`.
    pub predicted_seconds: [f64; 2],
    /// Memory that was predicted `[B]`.
    pub predicted_memory: usize,
    /// Largest resident memory, where the system tells `[B]`.
    pub peak_memory: Option<u64>,
    /// The phases.
    pub phases: Vec<PhaseTime>,
}

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct Space {
    /// Every run.
    pub runs: Vec<Run>,
    /// Exponent of the processor time in the points, one load step, from 10⁵ points on.
    pub exponent: f64,
}

/// Runs the set.
///
/// # Errors
/// A run did not finish.
pub fn run(settings: &Settings) -> Result<Report<Space>, Failure> {
    let cells: &[u32] = settings.pick(&[4, 8], &[16, 24, 32, 48, 64]);
    let mut jobs: Vec<(u32, u32, usize)> = cells.iter().map(|&cells| (cells, 1, 1)).collect();
    jobs.push((settings.pick(4, 16), settings.pick(2, 20), 1));
    jobs.push((cells[cells.len() - 1], 1, 2));
    let mut runs: Vec<Run> = Vec::new();
    for (cells, steps, threads) in jobs {
        let arguments = ["cube".to_owned(), cells.to_string(), steps.to_string(), threads.to_string()];
        let run: Run = child(&arguments)?;
        eprintln!("{cells}³, {steps} steps, {threads} threads: {:.2} s of processors", run.processor);
        runs.push(run);
    }
    let fitted = runs.iter().filter(|run| run.steps == 1 && run.threads == 1 && run.points > 100_000);
    let (exponent, _) = power_law(&fitted.map(|run| (run.points as f64, run.processor)).collect::<Vec<_>>());
    let tables = vec![whole(&runs), phases(&runs)];
    Ok(Report { set: "space", tables, pictures: Vec::new(), results: Space { runs, exponent } })
}

/// One run in this process.
///
/// # Errors
/// The cube does not run to its end.
pub fn cube(cells: u32, steps: u32, threads: usize) -> Result<Run, Failure> {
    let mut scene = blocks::solid(SolidBasis::Smpm, cells, steps)?;
    if let Scene::Solid(scene) = &mut scene {
        scene.tolerance.residual = Positive(RESIDUAL);
    }
    // The estimate compiles its own model, so that its memory is not counted as the run's.
    let estimate = compile(&scene)?.estimate()?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let mut counted = Counted::default();
    let work = machine::timed(|| {
        pool.install(|| {
            let mut compiled = compile(&scene)?;
            Ok::<_, Failure>((points(&compiled), compiled.run(&mut counted)?))
        })
    });
    let (points, summary) = work.result?;
    Ok(Run {
        cells,
        steps,
        threads,
        points,
        equations: estimate.equations,
        is_iterative: estimate.is_iterative,
        iterations: summary.iterations,
        linear_iterations: counted.iterations,
        processor: work.processor,
        wall: work.wall,
        predicted_seconds: estimate.seconds.range(0, 1),
        predicted_memory: estimate.memory.total(),
        peak_memory: machine::peak_memory(),
        phases: summary.timings.iter().map(PhaseTime::from).collect(),
    })
}

/// Adds up iterations of conjugate gradients.
#[derive(Default)]
struct Counted {
    column: Option<usize>,
    iterations: u64,
}

impl Observer for Counted {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        self.column = run.columns.iter().position(|it| it.name == "linear_iterations");
        Ok(())
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        if let Some(Entry::Count(counts)) = self.column.map(|column| &step.row[column]) {
            self.iterations += counts.iter().sum::<u64>();
        }
        Ok(())
    }
}

fn whole(runs: &[Run]) -> Table {
    let heads = [
        "cells",
        "steps",
        "threads",
        "points",
        "equations",
        "solver",
        "Newton",
        "CG per Newton",
        "seconds",
        "predicted s",
        "µs/pt",
        "MB",
        "predicted MB",
        "kB/pt",
        "kB/eq",
    ];
    let text = format!(
        "Cubes of unit cells, standard MPM, 8 points a cell, to a residual of {RESIDUAL:e}; seconds are processor time, each run in its own process."
    );
    let mut table = Table::new(text, &heads);
    for run in runs {
        let memory = |scale: f64| {
            run.peak_memory.map_or("unknown".into(), |bytes| format!("{:.2}", bytes as f64 * scale))
        };
        table.push([
            format!("{}³", run.cells),
            run.steps.to_string(),
            run.threads.to_string(),
            run.points.to_string(),
            run.equations.to_string(),
            if run.is_iterative { "CG" } else { "LLᵀ" }.to_owned(),
            run.iterations.to_string(),
            format!("{:.1}", run.linear_iterations as f64 / run.iterations as f64),
            format!("{:.2}", run.processor),
            format!("{:.2} to {:.2}", run.predicted_seconds[0], run.predicted_seconds[1]),
            format!("{:.2}", 1e6 * run.processor / run.points as f64),
            memory(1e-6),
            format!("{:.2}", 1e-6 * run.predicted_memory as f64),
            memory(1e-3 / run.points as f64),
            memory(1e-3 / run.equations as f64),
        ]);
    }
    table
}

fn phases(runs: &[Run]) -> Table {
    let names: Vec<&str> = runs[0].phases.iter().map(|it| it.phase.as_str()).collect();
    let heads: Vec<&str> = ["cells", "steps", "threads"].into_iter().chain(names).collect();
    let mut table = Table::new("Seconds of each phase on the wall.", &heads);
    for run in runs {
        let first = [format!("{}³", run.cells), run.steps.to_string(), run.threads.to_string()];
        let seconds = run.phases.iter().map(|it| format!("{:.3}", it.seconds));
        table.rows.push(first.into_iter().chain(seconds).collect());
    }
    table
}

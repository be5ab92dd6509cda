//! Seconds per phase and peak memory of whole runs of any scene, on one thread and on two.
//!
//! Every run is a process of its own, so that its peak memory is its own too.

use crate::report::{Report, Settings};
use crate::{Failure, machine};
use mpm_scene::{Compiled, Scene, compile};
use mpm_solver::observe::Timing;
use mpm_validation::Table;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::process::Command;

const THREADS: [usize; 2] = [1, 2];

/// One run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Run {
    /// File of the scene.
    pub scene: String,
    /// Threads.
    pub threads: usize,
    /// Material points at the start.
    pub points: usize,
    /// Load steps.
    pub steps: usize,
    /// Linear solutions.
    pub iterations: u64,
    /// Time of the run on the wall `[s]`.
    pub wall: f64,
    /// Processor time of the run, all threads together `[s]`.
    pub processor: f64,
    /// Largest resident memory, where the system tells `[B]`.
    pub peak_memory: Option<u64>,
    /// The phases.
    pub phases: Vec<PhaseTime>,
    /// What the run did not have to do, and how often.
    pub skipped: Vec<(String, u64)>,
}

/// A phase of a run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct PhaseTime {
    /// Its name.
    pub phase: String,
    /// Wall seconds.
    pub seconds: f64,
    /// Times the phase was entered.
    pub count: u64,
}

impl From<&Timing> for PhaseTime {
    fn from(timing: &Timing) -> Self {
        Self { phase: timing.phase.into(), seconds: timing.seconds, count: timing.count }
    }
}

/// Runs every scene on every number of threads, each in its own process.
///
/// # Errors
/// A run did not finish.
pub fn run(scenes: &[PathBuf], settings: &Settings) -> Result<Report<Vec<Run>>, Failure> {
    let shipped = if scenes.is_empty() { shipped()? } else { Vec::new() };
    let mut runs = Vec::new();
    for scene in scenes.iter().chain(&shipped) {
        for threads in THREADS {
            let arguments = ["one".into(), scene.display().to_string(), threads.to_string()];
            runs.push(child::<Run>(&arguments)?);
        }
    }
    let tables = runs.iter().map(table).collect();
    Ok(Report {
        set: if settings.quick { "phases_quick" } else { "phases" },
        tables,
        pictures: Vec::new(),
        results: runs,
    })
}

fn shipped() -> Result<Vec<PathBuf>, Failure> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let mut scenes: Vec<PathBuf> =
        std::fs::read_dir(folder)?.map(|entry| entry.map(|it| it.path())).collect::<Result<_, _>>()?;
    scenes.sort();
    Ok(scenes)
}

/// Runs this program again with these arguments and reads what it prints as JSON.
///
/// # Errors
/// It fails, or prints something else.
pub fn child<T: for<'a> Deserialize<'a>>(arguments: &[String]) -> Result<T, Failure> {
    let output = Command::new(std::env::current_exe()?).args(arguments).output()?;
    let said = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        return Err(format!("`{}` failed: {}", arguments.join(" "), said.trim()).into());
    }
    Ok(serde_json::from_slice(&output.stdout)?)
}

/// One run in this process.
///
/// # Errors
/// The scene cannot be read or does not run to its end.
pub fn one(scene: &Path, threads: usize) -> Result<Run, Failure> {
    let text = std::fs::read_to_string(scene).map_err(|it| format!("{}: {it}", scene.display()))?;
    one_scene(&Scene::from_ron(&text)?, &scene.display().to_string(), threads)
}

/// One run of a scene in this process.
///
/// # Errors
/// The scene does not compile or run to its end.
pub fn one_scene(scene: &Scene, name: &str, threads: usize) -> Result<Run, Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let work = machine::timed(|| {
        pool.install(|| {
            let mut compiled = compile(scene)?;
            Ok::<_, Failure>((points(&compiled), compiled.run(&mut ())?))
        })
    });
    let (points, summary) = work.result?;
    Ok(Run {
        scene: name.into(),
        threads,
        points,
        steps: summary.steps,
        iterations: summary.iterations,
        wall: work.wall,
        processor: work.processor,
        peak_memory: machine::peak_memory(),
        phases: summary.timings.iter().map(PhaseTime::from).collect(),
        skipped: summary.skipped.iter().map(|&(name, count)| (name.to_owned(), count)).collect(),
    })
}

/// Material points of all bodies.
pub fn points(compiled: &Compiled) -> usize {
    match compiled {
        Compiled::Plane(model) => model.bodies.iter().map(|named| named.body.n_points()).sum(),
        Compiled::Solid(model) => model.bodies.iter().map(|named| named.body.n_points()).sum(),
    }
}

fn table(run: &Run) -> Table {
    let memory = run.peak_memory.map_or("unknown".into(), |bytes| (bytes / 1_000_000).to_string());
    let text = format!(
        "{}: {} points, {} load steps, {} linear solutions, {} threads: {:.2} s ({:.2} s of processors), peak memory {memory} MB",
        run.scene, run.points, run.steps, run.iterations, run.threads, run.wall, run.processor
    );
    let mut table = Table::new(text, &["phase", "entered", "seconds", "ns per point and entry"]);
    for PhaseTime { phase, seconds, count } in &run.phases {
        let each = seconds * 1e9 / (run.points as f64 * (*count).max(1) as f64);
        table.push([phase.clone(), count.to_string(), format!("{seconds:.3}"), format!("{each:.1}")]);
    }
    table
}

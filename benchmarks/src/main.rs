//! Benchmarks: seconds per phase and peak memory of whole runs, on one thread and on two.
//!
//! ```sh
//! cargo run --release -p mpm-benchmarks                      # the shipped scenes
//! cargo run --release -p mpm-benchmarks -- path/to/scene.ron # any other
//! ```
//!
//! Every run is a process of its own, so that its peak memory is its own too. Machines are noisy:
//! read ratios within one table.

use mpm_solver::observe::Timing;
use mpm_solver::{Compiled, Summary, compile, scene::Scene};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

type Failure = Box<dyn std::error::Error>;

const THREADS: [usize; 2] = [1, 2];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let result = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["--one", scene, threads] => one_run(Path::new(scene), threads),
        [] => shipped_scenes().and_then(|scenes| compare(&scenes)),
        _ => compare(&arguments.iter().map(PathBuf::from).collect::<Vec<_>>()),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("{failure}");
            ExitCode::FAILURE
        }
    }
}

fn shipped_scenes() -> Result<Vec<PathBuf>, Failure> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let mut scenes: Vec<PathBuf> =
        std::fs::read_dir(folder)?.map(|entry| entry.map(|it| it.path())).collect::<Result<_, _>>()?;
    scenes.sort();
    Ok(scenes)
}

/// Runs every scene on every number of threads, each in its own process, and prints their tables.
fn compare(scenes: &[PathBuf]) -> Result<(), Failure> {
    for scene in scenes {
        println!("## {}", scene.display());
        for threads in THREADS {
            let status = Command::new(std::env::current_exe()?)
                .args(["--one".as_ref(), scene.as_os_str(), threads.to_string().as_ref()])
                .status()?;
            if !status.success() {
                return Err(format!("{} did not finish on {threads} threads", scene.display()).into());
            }
        }
    }
    Ok(())
}

/// One run in this process.
fn one_run(scene: &Path, threads: &str) -> Result<(), Failure> {
    let threads: usize = threads.parse()?;
    let text = std::fs::read_to_string(scene).map_err(|it| format!("{}: {it}", scene.display()))?;
    let mut compiled = compile(&Scene::from_ron(&text)?)?;
    let points = points(&compiled);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let start = std::time::Instant::now();
    let summary = pool.install(|| compiled.run(&mut ()))?;
    report(&summary, points, threads, start.elapsed().as_secs_f64());
    Ok(())
}

fn points(compiled: &Compiled) -> usize {
    match compiled {
        Compiled::Plane(model) => model.bodies.iter().map(|named| named.body.n_points()).sum(),
        Compiled::Solid(model) => model.bodies.iter().map(|named| named.body.n_points()).sum(),
    }
}

fn report(summary: &Summary, points: usize, threads: usize, seconds: f64) {
    println!(
        "\n{points} points, {} load steps, {} linear solutions, {threads} threads: {seconds:.2} s, peak memory {} MB\n",
        summary.steps,
        summary.iterations,
        peak_memory().map_or("unknown".into(), |bytes| (bytes / 1_000_000).to_string()),
    );
    println!("| phase | entered | seconds | ns per point and entry |\n|---|--:|--:|--:|");
    for Timing { phase, seconds, count } in &summary.timings {
        let each = seconds * 1e9 / (points as f64 * (*count).max(1) as f64);
        println!("| {phase} | {count} | {seconds:.3} | {each:.1} |");
    }
    println!();
}

/// Largest resident memory of this process so far, where the system tells.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kilobytes| kilobytes * 1024)
}

//! Hostile input: scenes, the files that they name, checkpoints and results files that are almost right.
//!
//! The input of a case is a function of the seed and the number of the case. Cases run in child processes with bounded memory and
//! bounded time per case. A case that panics, hangs, crashes, or asks for too much memory is reported and its input is kept; the
//! cases after it go on.

mod bodies;
mod bytes;
mod language;
mod random;
mod targets;
mod text;

pub use targets::Target;

use crate::Broken;
use mpm_io::Calls;
use random::Random;
use std::fs;
use std::os::unix::fs::FileExt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use targets::{DEPTHS, Prepared};

/// Memory of a process: addresses, which HDF5 and the stacks of threads reserve more of than they use `[KiB]`.
const MEMORY: u64 = 2 << 20;
/// A case that takes longer of a processor hangs `[s]`.
const LONGEST: u64 = 10;
/// So does one that takes longer by the clock, which also runs while other programs do `[s]`.
const LONGEST_BY_CLOCK: u64 = 300;
/// Exit code of a process that has found a hang.
const HANGS: i32 = 77;
/// Exit code of a process in which HDF5 does not come back from a file: `mpm` reads them in a process that it ends
/// then.
const HDF5_HANGS: i32 = 78;
/// Cases of a process: HDF5 never lets go of some of the files that it could not make sense of.
const PORTION: u64 = 5_000;

/// What is to be run.
pub struct Plan {
    /// What is fed.
    pub target: Target,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Number of cases.
    pub cases: u64,
    /// Processes at a time.
    pub processes: u64,
    /// Where inputs that are findings are kept.
    pub keep: PathBuf,
}

/// What was found.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Cases that came so far as `DEPTHS` says.
    depths: [u64; DEPTHS.len()],
    /// Cases that crashed the HDF5 library itself, and no more than the process that read the file.
    pub crashes_of_hdf5: u64,
    /// Cases in which HDF5 did not come back from a file.
    pub hangs_of_hdf5: u64,
    /// Findings: number of the case, and what happened.
    pub findings: Vec<(u64, String)>,
}

impl Report {
    /// Cases run.
    pub fn executions(&self) -> u64 {
        let ended = self.findings.iter().filter(|it| !it.1.starts_with(PANIC)).count() as u64;
        self.depths.iter().sum::<u64>() + self.crashes_of_hdf5 + self.hangs_of_hdf5 + ended
    }

    fn add(&mut self, other: Self) {
        self.depths.iter_mut().zip(other.depths).for_each(|(all, more)| *all += more);
        self.crashes_of_hdf5 += other.crashes_of_hdf5;
        self.hangs_of_hdf5 += other.hangs_of_hdf5;
        self.findings.extend(other.findings);
    }
}

impl std::fmt::Display for Report {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} executions:", self.executions())?;
        for (name, count) in DEPTHS.iter().zip(self.depths) {
            write!(f, " {count} {name},")?;
        }
        let (crash, hang) = (self.crashes_of_hdf5, self.hangs_of_hdf5);
        write!(
            f,
            " {crash} crash HDF5 itself, {hang} keep it busy without end, {} findings",
            self.findings.len()
        )?;
        for (case, what) in &self.findings {
            write!(f, "\n  case {case}: {what}")?;
        }
        Ok(())
    }
}

const PANIC: &str = "panic";

/// Runs the cases of a plan with the program at `worker`, which must call [`work`] for its arguments.
///
/// # Errors
/// A process cannot be started, or its notes cannot be read.
pub fn fuzz(plan: &Plan, worker: &Path) -> Result<Report, Broken> {
    let next = AtomicU64::new(0);
    let mut report = Report::default();
    let one = || -> Result<Report, Broken> {
        let mut report = Report::default();
        loop {
            let from = next.fetch_add(PORTION, Ordering::Relaxed);
            if from >= plan.cases {
                return Ok(report);
            }
            report.add(portion(plan, worker, from, (from + PORTION).min(plan.cases))?);
        }
    };
    let parts: Vec<Result<Report, Broken>> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..plan.processes.max(1)).map(|_| scope.spawn(one)).collect();
        threads.into_iter().map(|it| it.join().unwrap_or_else(|_| Err("a thread panicked".into()))).collect()
    });
    for part in parts {
        report.add(part?);
    }
    report.findings.sort();
    Ok(report)
}

/// Cases `from..to`, in as many processes as it takes.
fn portion(plan: &Plan, worker: &Path, mut from: u64, to: u64) -> Result<Report, Broken> {
    let folder = folder()?;
    let notes = folder.path().join("notes");
    let mut report = Report::default();
    while from < to {
        fs::write(&notes, [])?;
        // The shell limits its memory and then replaces itself by the program.
        let limited = format!("ulimit -v {MEMORY} && exec \"$0\" \"$@\"");
        let output = Command::new("sh")
            .args(["-c", &limited])
            .arg(worker)
            .args(["--work", plan.target.name(), &plan.seed.to_string(), &from.to_string(), &to.to_string()])
            .arg(folder.path())
            .env("RAYON_NUM_THREADS", "1")
            .output()?;
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        let (case, depths, panics) =
            read_notes(&fs::read_to_string(&notes)?).map_err(|it| format!("{it}; it said: {said}"))?;
        report.depths.iter_mut().zip(depths).for_each(|(all, more)| *all += more);
        if panics > 0 {
            let first = said.lines().filter(|line| line.starts_with("case ")).filter_map(|line| {
                let (case, what) = line.strip_prefix("case ")?.split_once(": ")?;
                Some((case.parse::<u64>().ok()?, what.to_owned()))
            });
            for (case, what) in first {
                keep(plan, case)?;
                report.findings.push((case, what));
            }
        }
        if output.status.success() {
            break;
        }
        if output.status.code() == Some(HDF5_HANGS) {
            report.hangs_of_hdf5 += 1;
            from = case + 1;
            continue;
        }
        let what = match output.status.code() {
            Some(HANGS) => Some(format!("takes longer than {LONGEST} s")),
            Some(code) => return Err(format!("case {case}: exit code {code}: {said}").into()),
            None if said.contains("memory allocation of") => Some("asks for too much memory".into()),
            None if said.contains("overflowed its stack") => Some("overflows the stack".into()),
            None if plan.target.is_hdf5(case) => None,
            None => Some(format!("ends the process: {}", output.status)),
        };
        match what {
            Some(what) => {
                keep(plan, case)?;
                report.findings.push((case, what));
            }
            None => report.crashes_of_hdf5 += 1,
        }
        from = case + 1;
    }
    Ok(report)
}

/// A folder in memory, where there is one.
fn folder() -> Result<tempfile::TempDir, Broken> {
    let memory = Path::new("/dev/shm");
    Ok(if memory.is_dir() { tempfile::tempdir_in(memory)? } else { tempfile::tempdir()? })
}

/// Writes down the input of a case.
fn keep(plan: &Plan, case: u64) -> Result<(), Broken> {
    let folder = folder()?;
    let prepared = Prepared::new(plan.target, folder.path())?;
    fs::create_dir_all(&plan.keep)?;
    let name = format!("{}-{}-{case}", plan.target.name(), plan.seed);
    fs::write(plan.keep.join(name), prepared.input(case, &mut Random::of_case(plan.seed, case)))?;
    Ok(())
}

/// The case at hand, how far those before it came, and how many panicked.
fn read_notes(notes: &str) -> Result<(u64, [u64; DEPTHS.len()], u64), Broken> {
    let numbers: Vec<u64> = notes.split_whitespace().map(str::parse).collect::<Result<_, _>>()?;
    match numbers[..] {
        [case, panics, ref depths @ ..] => Ok((case, depths.try_into()?, panics)),
        _ => Err(format!("a process left no notes but {notes:?}").into()),
    }
}

/// The work of a child process. Arguments: target, seed, first case, last case (exclusive), folder.
///
/// # Errors
/// The arguments are wrong, or nothing can be written.
pub fn work(arguments: &[String]) -> Result<ExitCode, Broken> {
    let [target, seed, from, to, folder] = arguments else {
        return Err("expected a target, a seed, the first case, the one behind the last, a folder".into());
    };
    let target = Target::of_name(target).ok_or("no such target")?;
    let (seed, from, to): (u64, u64, u64) = (seed.parse()?, from.parse()?, to.parse()?);
    let folder = Path::new(folder);
    let notes = fs::OpenOptions::new().write(true).open(folder.join("notes"))?;
    let prepared = Prepared::new(target, folder)?;
    static CASE: AtomicU64 = AtomicU64::new(u64::MAX);
    std::thread::spawn(|| {
        let (mut case, mut clock, mut processor) = (u64::MAX, Instant::now(), 0.0);
        loop {
            std::thread::sleep(Duration::from_millis(200));
            let now = CASE.load(Ordering::Relaxed);
            if now != case {
                (case, clock, processor) = (now, Instant::now(), processor_time());
            }
            let by_clock = clock.elapsed().as_secs() > LONGEST_BY_CLOCK;
            if by_clock || processor_time() - processor > LONGEST as f64 {
                std::process::exit(if Calls::now().is_inside() { HDF5_HANGS } else { HANGS });
            }
        }
    });
    let (mut depths, mut panics) = ([0_u64; DEPTHS.len()], 0_u64);
    for case in from..to {
        let line = |depths: &[u64], panics| {
            let depths: String = depths.iter().map(|it| format!(" {it:>12}")).collect();
            format!("{case:>12} {panics:>12}{depths}\n")
        };
        notes.write_all_at(line(&depths, panics).as_bytes(), 0)?;
        CASE.store(case, Ordering::Relaxed);
        let mut random = Random::of_case(seed, case);
        let input = prepared.input(case, &mut random);
        match catch_unwind(AssertUnwindSafe(|| prepared.execute(case, &input, &mut random))) {
            Ok(depth) => depths[depth] += 1,
            Err(reason) => {
                let text = reason.downcast_ref::<&str>().copied();
                let reason = reason.downcast_ref::<String>().map(String::as_str).or(text);
                eprintln!("case {case}: {PANIC} ({})", reason.unwrap_or("see above"));
                panics += 1;
                depths[0] += 1;
            }
        }
        if case + 1 == to {
            notes.write_all_at(line(&depths, panics).as_bytes(), 0)?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Seconds of a processor that the main thread has taken; 0 where the system does not tell.
fn processor_time() -> f64 {
    let told = fs::read_to_string("/proc/self/schedstat").unwrap_or_default();
    told.split_whitespace().next().and_then(|it| it.parse::<f64>().ok()).map_or(0.0, |it| it * 1e-9)
}

/// Feeds cases within this process, where a panic is the caller's; returns how many came how far.
///
/// # Errors
/// There is nothing to start from.
pub fn here(target: Target, seed: u64, cases: std::ops::Range<u64>) -> Result<[u64; 4], Broken> {
    let folder = folder()?;
    let prepared = Prepared::new(target, folder.path())?;
    let mut depths = [0; DEPTHS.len()];
    for case in cases {
        let mut random = Random::of_case(seed, case);
        let input = prepared.input(case, &mut random);
        depths[prepared.execute(case, &input, &mut random)] += 1;
    }
    Ok(depths)
}

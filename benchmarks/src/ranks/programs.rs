//! The programs `mpm` and `mpm-mpi`, started as processes.

use crate::Failure;
use crate::phases::PhaseTime;
use crate::program::of_children;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// A program that this set starts and does not find.
#[derive(Clone, Debug)]
pub struct NotBuilt(String);

impl fmt::Display for NotBuilt {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str(&self.0)
    }
}

impl std::error::Error for NotBuilt {}

/// The programs that are measured, and the folder in which they run.
pub(crate) struct Programs {
    mpm: PathBuf,
    mpm_mpi: PathBuf,
    folder: PathBuf,
}

/// What one rank, or the one process, has sent, held and taken.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Rank {
    /// Bytes sent by the messages of our own, not by PETSc's.
    pub bytes: f64,
    /// Messages of our own.
    pub messages: f64,
    /// Largest resident memory `[B]`.
    pub memory: f64,
    /// Processor time `[s]`.
    pub processor: f64,
}

/// One run of a scene.
#[derive(Clone, Debug, Serialize)]
pub struct Run {
    /// Ranks; 0 is `mpm` on one thread.
    pub ranks: u32,
    /// Material points.
    pub points: usize,
    /// Newton iterations.
    pub newton: u64,
    /// Out-of-balance force of every Newton iteration, load step by load step.
    pub residuals: Vec<Vec<f64>>,
    /// Iterations of conjugate gradients in the last load step.
    pub linear: f64,
    /// Time of the whole process on the wall `[s]`.
    pub wall: f64,
    /// Seconds on the wall of each phase, on rank 0.
    pub phases: Vec<PhaseTime>,
    /// Of every rank.
    pub each: Vec<Rank>,
}

impl Run {
    /// Processor time of the slowest rank `[s]`.
    pub fn processor(&self) -> f64 {
        self.each.iter().map(|it| it.processor).fold(0.0, f64::max)
    }

    /// Seconds of a phase; zero where it was not entered.
    pub fn seconds(&self, phase: &str) -> f64 {
        self.phases.iter().find(|it| it.phase == phase).map_or(0.0, |it| it.seconds)
    }

    /// Processor time of the slowest rank outside of all phases: start, reading, bodies, end `[s]`.
    pub fn start(&self) -> f64 {
        (self.processor() - self.phases.iter().map(|it| it.seconds).sum::<f64>()).max(0.0)
    }
}

/// What `mpm-mpi check` predicts of a rank.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Predicted {
    /// Material points.
    pub points: f64,
    /// Nodes that its points reach.
    pub nodes: f64,
    /// Nodes that others have as well.
    pub shared: f64,
    /// Memory `[B]`.
    pub memory: f64,
    /// Bytes of messages in a load step.
    pub bytes: f64,
}

impl Programs {
    /// Those at these paths; `mpm` beside this program and `mpm-mpi` in its workspace if none are named.
    ///
    /// # Errors
    /// [`NotBuilt`], which says how to build what is missing.
    pub(crate) fn find([mpm, mpm_mpi]: [Option<PathBuf>; 2], folder: PathBuf) -> Result<Self, Failure> {
        let beside = std::env::current_exe()?;
        let own_workspace =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../apps/mpm-mpi/target/release/mpm-mpi");
        let mpm = mpm.unwrap_or_else(|| beside.with_file_name("mpm"));
        let mpm_mpi = mpm_mpi.unwrap_or_else(|| match beside.with_file_name("mpm-mpi") {
            path if path.is_file() => path,
            _ => own_workspace,
        });
        let missing = |path: &Path, how: &str, option: &str| {
            let path = path.display();
            NotBuilt(format!("there is no program {path}: build it by `{how}`, or name it by `{option}`"))
        };
        if !mpm_mpi.is_file() {
            let how = "sh scripts/mpi.sh && cd apps/mpm-mpi && cargo build --locked --release";
            return Err(missing(&mpm_mpi, how, "--mpm-mpi").into());
        }
        if !mpm.is_file() {
            return Err(missing(&mpm, "cargo build --release -p mpm-cli", "--program").into());
        }
        if Command::new("mpirun").arg("--version").output().is_err() {
            let how =
                "there is no `mpirun`: `sh scripts/mpi.sh` installs it (Debian: apt-get install openmpi-bin)";
            return Err(NotBuilt(how.into()).into());
        }
        std::fs::create_dir_all(&folder)?;
        Ok(Self { mpm: mpm.canonicalize()?, mpm_mpi: mpm_mpi.canonicalize()?, folder: folder.canonicalize()? })
    }

    /// Runs a scene with other values in it on so many ranks, 0 for `mpm` on one thread. Results are in `<name>.h5`.
    ///
    /// # Errors
    /// The run fails, or says something else than expected.
    pub(crate) fn run(&self, ranks: u32, scene: &Path, set: &[String], name: &str) -> Result<Run, Failure> {
        let mut command = self.start(ranks, "run");
        command.arg(scene).args(["--quiet", "--force", "-o"]).arg(format!("{name}.h5"));
        set.iter().for_each(|set| {
            command.args(["--set", set]);
        });
        match ranks {
            0 => command.args(["--threads", "1"]),
            _ => command.args(["--", "-mpm_ranks"]),
        };
        let (before, clock) = (of_children()?, Instant::now());
        let (_, told, peak) = self.watched(command)?;
        let (wall, processor) = (clock.elapsed().as_secs_f64(), of_children()? - before);
        let mut command = Command::new(&self.mpm);
        command.args(["inspect", "--json"]).arg(format!("{name}.h5"));
        let json: Value = serde_json::from_str(&self.watched(command)?.0)?;
        let each = match ranks {
            0 => vec![Rank { bytes: 0.0, messages: 0.0, memory: peak, processor }],
            _ => told.lines().filter_map(rank_told).collect(),
        };
        if each.len() != ranks.max(1) as usize {
            return Err(format!("{} of {ranks} ranks tell what they took", each.len()).into());
        }
        run_told(&json, ranks, wall, each).ok_or_else(|| "`mpm inspect --json` tells something else".into())
    }

    /// What `mpm-mpi check` predicts of every rank.
    ///
    /// # Errors
    /// The scene is refused, or something else is said.
    pub(crate) fn check(&self, ranks: u32, scene: &Path, set: &[String]) -> Result<Vec<Predicted>, Failure> {
        let mut command = self.start(ranks, "check");
        command.arg(scene);
        set.iter().for_each(|set| {
            command.args(["--set", set]);
        });
        let (said, ..) = self.watched(command)?;
        let table = said.lines().skip_while(|line| !line.trim_start().starts_with("rank ")).skip(1);
        let predicted = table.map_while(|line| {
            let numbers: Vec<f64> = line.split_whitespace().filter_map(|it| it.parse().ok()).collect();
            let [_, points, nodes, shared, memory, bytes] = numbers[..] else { return None };
            Some(Predicted { points, nodes, shared, memory: 1e6 * memory, bytes: 1e3 * bytes })
        });
        let predicted: Vec<Predicted> = predicted.collect();
        match predicted.len() == ranks as usize {
            true => Ok(predicted),
            false => Err(format!("`mpm-mpi check` tells of {} ranks, not of {ranks}", predicted.len()).into()),
        }
    }

    /// The columns of the points of a run at its end, each with its name.
    ///
    /// # Errors
    /// The results cannot be exported or read.
    pub(crate) fn points(&self, name: &str) -> Result<BTreeMap<String, Vec<f64>>, Failure> {
        let mut command = Command::new(&self.mpm);
        command.args(["export", "--csv", "-o", name]).arg(format!("{name}.h5"));
        self.watched(command)?;
        let files = std::fs::read_dir(self.folder.join(name))?.collect::<Result<Vec<_>, _>>()?;
        let is_of_points =
            |path: &PathBuf| path.file_name().is_some_and(|it| it.to_string_lossy().starts_with("points_"));
        let last =
            files.iter().map(|it| it.path()).filter(is_of_points).max().ok_or("no points are recorded")?;
        let text = std::fs::read_to_string(last)?;
        let mut lines = text.lines();
        let heads: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
        let mut columns: Vec<Vec<f64>> = vec![Vec::new(); heads.len()];
        for line in lines {
            for (column, number) in columns.iter_mut().zip(line.split(',')) {
                column.push(number.parse()?);
            }
        }
        Ok(heads.into_iter().map(String::from).zip(columns).collect())
    }

    /// A program of a command, on so many ranks.
    fn start(&self, ranks: u32, act: &str) -> Command {
        let mut command = match ranks {
            0 => Command::new(&self.mpm),
            _ => {
                let mut command = Command::new("mpirun");
                command.args(["-n", &ranks.to_string(), "--oversubscribe"]).arg(&self.mpm_mpi);
                // Containers run as root.
                command.env("OMPI_ALLOW_RUN_AS_ROOT", "1").env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1");
                command
            }
        };
        command.arg(act).env("OMP_NUM_THREADS", "1");
        command
    }

    /// What a process says on both streams, and the most memory that it has held, where the system tells `[B]`.
    fn watched(&self, mut command: Command) -> Result<(String, String, f64), Failure> {
        let [said, told] = ["said.txt", "told.txt"].map(|name| self.folder.join(name));
        command.current_dir(&self.folder).stdin(Stdio::null());
        command.stdout(std::fs::File::create(&said)?).stderr(std::fs::File::create(&told)?);
        let mut child = command.spawn()?;
        let peak = watch(&mut child)?;
        let is_well = child.wait()?.success();
        let (said, told) = (std::fs::read_to_string(said)?, std::fs::read_to_string(told)?);
        match is_well {
            true => Ok((said, told, peak)),
            false => Err(format!("{command:?} failed: {}", told.trim()).into()),
        }
    }
}

/// The most memory that a process has held until it ends `[B]`.
fn watch(child: &mut Child) -> Result<f64, Failure> {
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0.0_f64;
    while child.try_wait()?.is_none() {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let held = line.and_then(|it| it.split_whitespace().next()?.parse::<f64>().ok());
        peak = peak.max(1024.0 * held.unwrap_or_default());
        sleep(Duration::from_millis(20));
    }
    Ok(peak)
}

/// What a rank tells by the option `-mpm_ranks`.
fn rank_told(line: &str) -> Option<Rank> {
    let rest = line.strip_prefix("rank ")?;
    let numbers: Vec<f64> = rest.split_whitespace().filter_map(|it| it.parse().ok()).collect();
    let [_, bytes, messages, memory, processor] = numbers[..] else { return None };
    Some(Rank { bytes, messages, memory, processor })
}

/// What `mpm inspect --json` tells.
fn run_told(json: &Value, ranks: u32, wall: f64, each: Vec<Rank>) -> Option<Run> {
    let of_step = |step: &Value| Some(step["residuals"].as_array()?.iter().filter_map(Value::as_f64).collect());
    let of_phase = |(phase, it): (&String, &Value)| {
        let (seconds, count) = (it["seconds"].as_f64()?, it["count"].as_u64()?);
        Some(PhaseTime { phase: phase.clone(), seconds, count })
    };
    Some(Run {
        ranks,
        points: usize::try_from(json["material_points"].as_u64()?).ok()?,
        newton: json["iterations"].as_u64()?,
        residuals: json["newton"].as_array()?.iter().map(of_step).collect::<Option<_>>()?,
        linear: json["history"]["linear_iterations"]["last"][0].as_f64()?,
        wall,
        phases: json["time"].as_object()?.iter().map(of_phase).collect::<Option<_>>()?,
        each,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rank_is_read() {
        let line = "rank 1 sent 53861640 bytes in 141 messages, held 1212000256 bytes, took 12.34 s";
        let rank = rank_told(line).expect("a rank");
        assert_eq!((rank.bytes, rank.messages), (53_861_640.0, 141.0));
        assert_eq!((rank.memory, rank.processor), (1_212_000_256.0, 12.34));
        assert!(rank_told("warning: PETSc has not asked for the option -x").is_none());
    }
}

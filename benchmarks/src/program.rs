//! Whole processes of the program `mpm`: start, reading, running, output, end.

use crate::Failure;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

/// The program whose processes are timed.
pub struct Program {
    path: PathBuf,
}

/// What a process took.
#[derive(Clone, Copy, Debug)]
pub struct Took {
    /// Time on the wall `[s]`.
    pub wall: f64,
    /// Processor time, all threads together `[s]`.
    pub processor: f64,
}

impl Program {
    /// The program at `path`, or that which was built beside this one.
    ///
    /// # Errors
    /// There is none.
    pub fn find(path: Option<PathBuf>) -> Result<Self, Failure> {
        let beside = || Ok::<_, Failure>(std::env::current_exe()?.with_file_name("mpm"));
        let path = path.map_or_else(beside, Ok)?;
        match path.is_file() {
            true => Ok(Self { path }),
            false => Err(format!(
                "there is no program {}: build it by `cargo build --release -p mpm-cli`, or name it by `--program`",
                path.display()
            )
            .into()),
        }
    }

    /// What `times` runs of a scene with other values in it take each, in the mean; results go into a folder.
    ///
    /// # Errors
    /// As [`Self::time`].
    pub fn run(
        &self,
        scene: &Path,
        set: &[String],
        threads: u32,
        (folder, times): (&Path, u32),
    ) -> Result<Took, Failure> {
        let (scene, threads) = (scene.canonicalize()?.display().to_string(), threads.to_string());
        let mut arguments = vec!["run", &scene, "-q", "--force", "-o", "run.h5", "--threads", &threads];
        set.iter().for_each(|set| arguments.extend(["--set", set]));
        self.time(&arguments, folder, times)
    }

    /// Material points of a scene with other values in it.
    ///
    /// # Errors
    /// The program refuses the scene, or says something else.
    pub fn points(&self, scene: &Path, set: &[String]) -> Result<usize, Failure> {
        let set = set.iter().flat_map(|set| ["--set", set]);
        let output = Command::new(&self.path).arg("check").arg(scene).arg("--json").args(set).output()?;
        let told: serde_json::Value = serde_json::from_slice(&output.stdout)
            .map_err(|_| String::from_utf8_lossy(&output.stderr).into_owned())?;
        let points = told["material_points"].as_u64().ok_or("`mpm check --json` tells no points")?;
        Ok(usize::try_from(points)?)
    }

    /// What one of `times` processes with these arguments takes in the mean: processor time of one of them alone is too
    /// short for the clock.
    ///
    /// # Errors
    /// One fails; the clock cannot be read.
    pub fn time(&self, arguments: &[&str], folder: &Path, times: u32) -> Result<Took, Failure> {
        let (before, began) = (of_children()?, Instant::now());
        for _ in 0..times {
            let output = Command::new(&self.path)
                .args(arguments)
                .current_dir(folder)
                .stdout(Stdio::null())
                .stderr(Stdio::piped())
                .output()?;
            if !output.status.success() {
                let said = String::from_utf8_lossy(&output.stderr);
                return Err(format!("`mpm {}` failed: {}", arguments.join(" "), said.trim()).into());
            }
        }
        let per = 1.0 / f64::from(times);
        Ok(Took { wall: began.elapsed().as_secs_f64() * per, processor: (of_children()? - before) * per })
    }
}

/// A scene that is shipped.
pub fn scene(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes").join(name).with_extension("ron")
}

/// Ticks per second of `/proc`, the same on every machine that Linux runs on today (USER_HZ).
const TICKS: f64 = 100.0;

/// Processor time of all children that have ended, from `/proc/self/stat` (proc(5), fields 16 and 17) `[s]`.
pub(crate) fn of_children() -> Result<f64, Failure> {
    let text = std::fs::read_to_string("/proc/self/stat")?;
    // The second field is a name in brackets, which may hold spaces.
    let fields: Vec<&str> = text.rsplit_once(')').map_or("", |(_, rest)| rest).split_whitespace().collect();
    let ticks = |field: usize| fields.get(field - 3).and_then(|it| it.parse::<f64>().ok());
    match (ticks(16), ticks(17)) {
        (Some(user), Some(system)) => Ok((user + system) / TICKS),
        _ => Err("/proc/self/stat does not tell the time of children".into()),
    }
}

/// The middle one of some numbers.
pub fn median(mut of: Vec<f64>) -> f64 {
    of.sort_by(f64::total_cmp);
    of[of.len() / 2]
}

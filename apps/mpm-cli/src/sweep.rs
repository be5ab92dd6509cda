//! `mpm sweep`: a scene over a grid of values, each combination a run of its own, one table of results.

mod table;

use crate::complaint::Complaint;
use crate::reading::{self, Kind};
use crate::say::say;
use crate::{input, keeper};
use clap::Args;
use mpm_io::{FolderFiles, Results};
use mpm_solver::observe::Cancellation;
use serde_json::Value;
use std::ffi::OsStr;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use table::{Row, csv, table};

#[derive(Args)]
pub struct SweepArguments {
    /// The scene, a RON file.
    scene: PathBuf,
    /// Values of a field of the scene, as in `materials.clay.young=1e3,2e3`; given several times, every
    /// combination is run. Fields whose values go together stand in one, apart by semicolons:
    /// `mesh.axes[0].cells=8,16; schedule.steps=10,20`.
    #[arg(long, value_name = "PATH=VALUE,…", required = true)]
    set: Vec<String>,
    /// Columns of the printed table, as `results.csv` names them, or without `last` and `peak` for both [default: the
    /// totals and the peaks of reactions].
    #[arg(long, value_name = "COLUMN", value_delimiter = ',')]
    show: Vec<String>,
    /// Folder of the runs, a folder each, and of the table `results.csv`; what is finished there is not run again
    /// [default: the scene's name with `_sweep`, in this directory].
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Runs at once [default: one per core].
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    /// Print the table as JSON.
    #[arg(long)]
    json: bool,
}

/// One combination of values.
struct Combination {
    /// Path and value, in the order of the arguments.
    settings: Vec<(String, String)>,
    /// The scene with these values.
    text: String,
    folder: PathBuf,
    /// Where the files lie that the scene names.
    files: PathBuf,
}

/// Where a run of a combination stands.
#[derive(Clone, Debug, PartialEq)]
enum Standing {
    Completed,
    /// It ended early for this reason, and would end the same way again.
    Failed(String),
    /// It was interrupted, killed, or has not begun.
    Open(String),
}

/// Runs what is not finished and prints the table.
pub fn sweep(arguments: &SweepArguments) -> Result<(), Complaint> {
    let folder = arguments.output.clone().unwrap_or_else(|| {
        let name = arguments.scene.file_stem().unwrap_or_default().to_string_lossy();
        PathBuf::from(format!("{name}_sweep"))
    });
    let combinations = combinations(&arguments.scene, &arguments.set, &folder)?;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let jobs = arguments.jobs.map_or(cores, usize::from).min(combinations.len());
    let cancellation = Cancellation::default();
    keeper::listen(cancellation.clone())?;
    run_all(&combinations, jobs, (cores / jobs).max(1), &cancellation)?;

    let ended: Vec<(Standing, Row)> = combinations.iter().map(Combination::ended).collect();
    let unfinished = ended.iter().filter(|(standing, _)| *standing != Standing::Completed).count();
    let rows: Vec<Row> = ended.into_iter().map(|(_, row)| row).collect();
    let path = folder.join("results.csv");
    std::fs::write(&path, csv(&rows)).map_err(|error| cannot_write(&path, &error))?;
    if arguments.json {
        let rows: Vec<Value> = rows.iter().map(Row::json).collect();
        say(&format!("{:#}\n", Value::Array(rows)))?;
    } else {
        say(&format!("{}\n{}\n", table(&rows, &arguments.show)?, path.display()))?;
    }
    if unfinished > 0 {
        let n = rows.len();
        return Err(Complaint::unfinished(format!(
            "{unfinished} of {n} runs did not complete; see their status"
        )));
    }
    Ok(())
}

/// Every combination of the values, checked.
fn combinations(scene: &Path, sets: &[String], folder: &Path) -> Result<Vec<Combination>, Complaint> {
    let mut grid: Vec<Vec<(String, String)>> = vec![Vec::new()];
    for set in sets {
        let together = together(set)?;
        if let Some((path, _)) =
            together[0].iter().find(|(path, _)| grid[0].iter().any(|(other, _)| other == path))
        {
            return Err(Complaint::input(format!(
                "--set: {path} is given twice; expected its values as one list"
            )));
        }
        let with = |row: &Vec<(String, String)>| {
            let row = row.clone();
            together.iter().map(move |settings| [row.clone(), settings.clone()].concat())
        };
        grid = grid.iter().flat_map(with).collect();
    }
    let text = input::text(scene)?;
    let files = FolderFiles::beside(scene);
    let beside = files.path(".");
    let beside = beside.canonicalize().unwrap_or(beside);
    let mut combinations: Vec<Combination> = Vec::new();
    for settings in grid {
        let pairs: Vec<String> = settings.iter().map(|(path, value)| format!("{path}={value}")).collect();
        // All are checked before the first one runs.
        let input = input::set(scene, text.clone(), &pairs, &files)?;
        let folder = folder.join(folder_name(&pairs.join(",")));
        if combinations.iter().any(|other| other.folder == folder) {
            return Err(Complaint::input(format!(
                "--set: the combination {} stands there twice",
                pairs.join(" ")
            )));
        }
        combinations.push(Combination { settings, text: input.text, folder, files: beside.clone() });
    }
    Ok(combinations)
}

/// The settings of one `--set`, one after the other: values of several fields go together.
fn together(set: &str) -> Result<Vec<Vec<(String, String)>>, Complaint> {
    let mut settings: Vec<Vec<(String, String)>> = Vec::new();
    for part in split(set, ';') {
        let Some((path, values)) = part.split_once('=') else {
            return Err(Complaint::input(format!(
                "--set: expected PATH=VALUE,VALUE as in schedule.steps=10,20, got {part}"
            )));
        };
        let (path, values) = (path.trim(), split(values, ','));
        if settings.is_empty() {
            settings = vec![Vec::new(); values.len()];
        }
        if settings.len() != values.len() {
            let (n, expected) = (values.len(), settings.len());
            return Err(Complaint::input(format!(
                "--set: {path} has {n} values, expected {expected}, as many as the field that it goes with"
            )));
        }
        if settings[0].iter().any(|(other, _)| other == path) {
            return Err(Complaint::input(format!(
                "--set: {path} is given twice; expected its values as one list"
            )));
        }
        for (settings, value) in settings.iter_mut().zip(values) {
            settings.push((path.to_string(), value.trim().to_string()));
        }
    }
    Ok(settings)
}

/// At separators outside of brackets and quotes.
fn split(values: &str, separator: char) -> Vec<&str> {
    let (mut depth, mut quoted, mut start, mut parts) = (0, false, 0, Vec::new());
    for (at, c) in values.char_indices() {
        match c {
            '"' => quoted = !quoted,
            '(' | '[' | '{' if !quoted => depth += 1,
            ')' | ']' | '}' if !quoted => depth -= 1,
            c if c == separator && depth == 0 && !quoted => {
                parts.push(&values[start..at]);
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&values[start..]);
    parts
}

/// The settings, if they can be the name of a folder; else their beginning and a check sum.
fn folder_name(settings: &str) -> String {
    const LONGEST: usize = 120;
    let plain = |c: char| c.is_ascii_alphanumeric() || "._=+-,[]".contains(c);
    let name: String = settings.chars().map(|c| if plain(c) { c } else { '_' }).take(LONGEST).collect();
    if name == settings { name } else { format!("{name}-{:08x}", crc32fast::hash(settings.as_bytes())) }
}

impl Combination {
    fn results(&self) -> PathBuf {
        self.folder.join("results.h5")
    }

    fn read(&self) -> Result<Results, String> {
        let path = self.results();
        reading::survives(&path, Kind::Results).map_err(|complaint| complaint.to_string())?;
        Results::open(&path).map_err(|error| error.to_string())
    }

    fn standing(&self) -> Standing {
        if !self.results().exists() {
            let log = std::fs::read_to_string(self.folder.join("log.txt")).unwrap_or_default();
            let said =
                log.lines().map(|line| line.trim_start_matches([' ', 'x', '×'])).find(|line| !line.is_empty());
            return Standing::Open(said.map_or("not run".into(), |said| format!("not run: {said}")));
        }
        match self.read() {
            Err(reason) => Standing::Open(reason),
            Ok(results) if results.scene() != self.text => Standing::Open("of another scene".into()),
            Ok(results) => match results.status() {
                "completed" => Standing::Completed,
                status => match status.strip_prefix("failed: ") {
                    Some(reason) if !reason.starts_with("interrupted") => Standing::Failed(reason.into()),
                    _ => Standing::Open(status.into()),
                },
            },
        }
    }

    /// How its run stands, and its row of the table.
    fn ended(&self) -> (Standing, Row) {
        let standing = self.standing();
        let is_ours = matches!(standing, Standing::Completed | Standing::Failed(_));
        let results = Results::open(self.results()).ok().filter(|_| is_ours);
        let row = Row::of(&self.settings, standing.to_string(), results.as_ref());
        (standing, row)
    }

    /// Runs it in a child process, or resumes it from its checkpoint if there is one.
    fn run(&self, threads: usize) -> Result<(), Complaint> {
        let cannot = |error: std::io::Error| cannot_write(&self.folder, &error);
        std::fs::create_dir_all(&self.folder).map_err(cannot)?;
        let is_ours = self.read().is_ok_and(|results| results.scene() == self.text);
        std::fs::write(self.folder.join("scene.ron"), &self.text).map_err(cannot)?;
        let log = std::fs::File::create(self.folder.join("log.txt")).map_err(cannot)?;
        let start = |arguments: &[&OsStr]| {
            let program = std::env::current_exe()?;
            let threads = threads.to_string();
            let mut command = Command::new(program);
            command.args(arguments).args(["--quiet", "--threads", &threads]).current_dir(&self.folder);
            command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(log.try_clone()?).status()
        };
        let run = |arguments: &[&str], files: &Path| {
            let arguments: Vec<&OsStr> = arguments.iter().map(OsStr::new).chain([files.as_os_str()]).collect();
            start(&arguments).map_err(|error| Complaint::unfinished(format!("cannot start a run: {error}")))
        };
        let checkpoint = "results.checkpoint.h5";
        // A checkpoint that cannot be gone on with is refused by exit code 2.
        let gone_on = is_ours
            && self.folder.join(checkpoint).exists()
            && run(&["resume", checkpoint, "--output", "results.h5", "--files"], &self.files)?.code()
                != Some(2);
        if !gone_on {
            // What is open is run anew: it is that of another scene, or cannot be gone on with.
            run(&["run", "scene.ron", "--force", "--output", "results.h5", "--files"], &self.files)?;
        }
        Ok(())
    }
}

fn run_all(
    combinations: &[Combination],
    jobs: usize,
    threads: usize,
    cancellation: &Cancellation,
) -> Result<(), Complaint> {
    let open: Vec<&Combination> =
        combinations.iter().filter(|it| matches!(it.standing(), Standing::Open(_))).collect();
    let n = open.len();
    let next = Mutex::new((open.into_iter(), 0));
    let work = || -> Result<(), Complaint> {
        loop {
            let Some(combination) = next.lock().ok().and_then(|mut next| next.0.next()) else { return Ok(()) };
            if cancellation.is_cancelled() {
                return Ok(());
            }
            combination.run(threads)?;
            if let Ok(mut next) = next.lock() {
                next.1 += 1;
                let name = combination.folder.file_name().unwrap_or_default().to_string_lossy();
                let status = combination.standing().to_string();
                // If standard error is closed, there is nowhere to report it.
                let _ = writeln!(std::io::stderr(), "{} of {n}: {name}: {status}", next.1);
            }
        }
    };
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..jobs).map(|_| scope.spawn(work)).collect();
        let ended: Vec<_> = threads.into_iter().map(|thread| thread.join()).collect();
        let broken = || Complaint::unfinished("a thread of the sweep broke off".into());
        ended.into_iter().try_for_each(|end| end.unwrap_or_else(|_| Err(broken())))
    })
}

fn cannot_write(path: &Path, error: &std::io::Error) -> Complaint {
    Complaint::input(format!("cannot write {}: {error}", path.display()))
}

impl std::fmt::Display for Standing {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Completed => f.write_str("completed"),
            Self::Failed(reason) => write!(f, "failed: {reason}"),
            Self::Open(reason) => write!(f, "unfinished: {reason}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_part_at_commas_outside_of_brackets() {
        assert_eq!(split("1,2,3", ','), ["1", "2", "3"]);
        assert_eq!(
            split("Cap(cells: 1, a: [2,3]),None,\"a,b\"", ','),
            ["Cap(cells: 1, a: [2,3])", "None", "\"a,b\""]
        );
        assert_eq!(split("", ','), [""]);
    }

    #[test]
    fn folders_are_named_by_what_is_set() {
        assert_eq!(
            folder_name("bodies[0].points_per_cell=2,basis=Gimp"),
            "bodies[0].points_per_cell=2,basis=Gimp"
        );
        let [a, b] = ["title=\"a b\"", "title=\"a:b\""].map(folder_name);
        assert!(a.starts_with("title=_a_b_-") && a != b, "{a} {b}");
        assert!(folder_name(&"x".repeat(500)).len() < 140);
    }
}

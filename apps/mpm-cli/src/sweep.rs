//! `mpm sweep`: a scene over a grid of values, each combination a run of its own, one table of results.

use crate::complaint::Complaint;
use crate::reading::{self, Kind};
use crate::say::say;
use crate::{input, keeper};
use clap::Args;
use mpm_grid::six_digits;
use mpm_io::{FolderFiles, Results, component_name, shortest};
use mpm_solver::observe::Cancellation;
use serde_json::{Map, Value, json};
use std::ffi::OsStr;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;

#[derive(Args)]
pub struct SweepArguments {
    /// The scene, a RON file.
    scene: PathBuf,
    /// Values of a field of the scene, as in `materials.clay.young=1e3,2e3`; given several times, every
    /// combination is run.
    #[arg(long, value_name = "PATH=VALUE,…", required = true)]
    set: Vec<String>,
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

    let rows: Vec<Row> = combinations.iter().map(Row::of).collect();
    let path = folder.join("results.csv");
    std::fs::write(&path, csv(&rows)).map_err(|error| cannot_write(&path, &error))?;
    if arguments.json {
        let rows: Vec<Value> = rows.iter().map(Row::json).collect();
        say(&format!("{:#}\n", Value::Array(rows)))?;
    } else {
        say(&format!("{}\n{}\n", table(&rows), path.display()))?;
    }
    let unfinished = rows.iter().filter(|row| row.standing != Standing::Completed).count();
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
        let Some((path, values)) = set.split_once('=') else {
            return Err(Complaint::input(format!(
                "--set: expected PATH=VALUE,VALUE as in schedule.steps=10,20, got {set}"
            )));
        };
        if grid[0].iter().any(|(other, _)| other == path) {
            return Err(Complaint::input(format!(
                "--set: {path} is given twice; expected its values as one list"
            )));
        }
        let values = split(values);
        grid = grid
            .iter()
            .flat_map(|row| {
                values.iter().map(move |value| {
                    let setting = (path.trim().to_string(), value.trim().to_string());
                    row.iter().cloned().chain([setting]).collect()
                })
            })
            .collect();
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

/// At commas outside of brackets and quotes.
fn split(values: &str) -> Vec<&str> {
    let (mut depth, mut quoted, mut start, mut parts) = (0, false, 0, Vec::new());
    for (at, c) in values.char_indices() {
        match c {
            '"' => quoted = !quoted,
            '(' | '[' | '{' if !quoted => depth += 1,
            ')' | ']' | '}' if !quoted => depth -= 1,
            ',' if depth == 0 && !quoted => {
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

/// A line of the table.
struct Row {
    settings: Vec<(String, String)>,
    standing: Standing,
    /// Name and value, in the order of the history.
    numbers: Vec<(String, f64)>,
}

impl Row {
    fn of(combination: &Combination) -> Self {
        let standing = combination.standing();
        let is_ours = matches!(standing, Standing::Completed | Standing::Failed(_));
        let results = Results::open(combination.results()).ok().filter(|_| is_ours);
        let numbers = results.as_ref().map_or(Vec::new(), numbers);
        Self { settings: combination.settings.clone(), standing, numbers }
    }

    fn json(&self) -> Value {
        let settings = self.settings.iter().map(|(path, value)| (path.clone(), json!(value)));
        let numbers = self.numbers.iter().map(|(name, value)| (name.clone(), json!(value)));
        json!({
            "settings": settings.collect::<Map<_, _>>(), "status": self.standing.to_string(),
            "results": numbers.collect::<Map<_, _>>(),
        })
    }
}

/// Totals of the run, and last value and peak of what the history says of supports, energies and probes.
fn numbers(results: &Results) -> Vec<(String, f64)> {
    let sum = |name: &str| results.column(name).map_or(0.0, |table| table.values().iter().sum());
    let reached = results.column("load_fraction").ok().and_then(|table| table.values().last().copied());
    let mut numbers = vec![
        ("load_fraction".to_string(), reached.unwrap_or(0.0)),
        ("load_steps".to_string(), results.rows().saturating_sub(1) as f64),
        ("iterations".to_string(), sum("newton_iterations")),
        ("cuts".to_string(), sum("cuts")),
        ("seconds".to_string(), sum("wall_seconds")),
    ];
    for column in results.columns().iter().filter(|column| column.name.contains('/')) {
        let Ok(table) = results.column(&column.name) else { continue };
        for c in 0..table.width() {
            let values = || (0..table.len()).map(|row| table.row(row)[c]);
            let name = format!("{}{}", column.name, component_name(results.space(), table.width(), c));
            let peak = values().fold(0.0_f64, |peak, x| if x.abs() > peak.abs() { x } else { peak });
            numbers.push((format!("{name} last"), values().next_back().unwrap_or(0.0)));
            numbers.push((format!("{name} peak"), peak));
        }
    }
    numbers
}

/// Names of all numbers of the rows; a run that has not begun has none.
fn names(rows: &[Row]) -> Vec<&String> {
    let longest = rows.iter().max_by_key(|row| row.numbers.len());
    longest.map_or(Vec::new(), |row| row.numbers.iter().map(|(name, _)| name).collect())
}

fn csv(rows: &[Row]) -> String {
    let quoted = |text: &str| match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_string(),
    };
    let names = names(rows);
    let settings = rows[0].settings.iter().map(|(path, _)| path.as_str());
    let heads = settings.chain(["status"]).chain(names.iter().map(|name| name.as_str()));
    let mut text = heads.map(quoted).collect::<Vec<_>>().join(",") + "\n";
    for row in rows {
        let mut cells: Vec<String> = row.settings.iter().map(|(_, value)| quoted(value)).collect();
        cells.push(quoted(&row.standing.to_string()));
        cells.extend(names.iter().map(|name| {
            let found = row.numbers.iter().find(|(other, _)| other == *name);
            found.map_or(String::new(), |(_, value)| shortest(*value))
        }));
        text += &(cells.join(",") + "\n");
    }
    text
}

/// What fits on a screen: values, status, totals, and peaks that are not zero throughout.
fn table(rows: &[Row]) -> String {
    let shown: Vec<&String> = names(rows)
        .into_iter()
        .filter(|name| {
            let is_told = !name.contains('/') || (name.contains("reaction") && name.ends_with(" peak"));
            let of = |row: &Row| row.numbers.iter().find(|(other, _)| other == *name).map_or(0.0, |it| it.1);
            is_told && rows.iter().any(|row| of(row) != 0.0)
        })
        .collect();
    let mut cells: Vec<Vec<String>> = Vec::new();
    let settings = rows[0].settings.iter().map(|(path, _)| path.clone());
    cells.push(
        settings.chain(shown.iter().map(|name| name.to_string())).chain(["status".to_string()]).collect(),
    );
    for row in rows {
        let mut line: Vec<String> = row.settings.iter().map(|(_, value)| value.clone()).collect();
        line.extend(shown.iter().map(|name| {
            let found = row.numbers.iter().find(|(other, _)| other == *name);
            found.map_or(String::new(), |(_, value)| six_digits(*value))
        }));
        line.push(row.standing.to_string());
        cells.push(line);
    }
    let columns = cells[0].len();
    let width = |c: usize| cells.iter().map(|line| line[c].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut text = String::new();
    for line in &cells {
        for (cell, width) in line[..columns - 1].iter().zip(&widths) {
            // Writing to a string cannot fail.
            let _ = write!(text, "{cell:>width$}  ");
        }
        let _ = writeln!(text, "{}", line[columns - 1]);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_part_at_commas_outside_of_brackets() {
        assert_eq!(split("1,2,3"), ["1", "2", "3"]);
        assert_eq!(
            split("Cap(cells: 1, a: [2,3]),None,\"a,b\""),
            ["Cap(cells: 1, a: [2,3])", "None", "\"a,b\""]
        );
        assert_eq!(split(""), [""]);
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

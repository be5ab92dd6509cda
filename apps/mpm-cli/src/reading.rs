//! Reads HDF5 files in a child process, because HDF5 can crash, or loop without end, on a damaged file.
//!
//! Commands that only read (`inspect`, `plot`, `export`) run in the child as a whole. Commands that go on with a file (`resume`,
//! `sweep`, scenes with tables of points) first let a child read it in full.

use crate::complaint::Complaint;
use clap::ValueEnum;
use mpm_geometry::Surface;
use mpm_io::{Calls, Checkpoint, FolderFiles, Results, ResultsError, is_being_written};
use mpm_scene::{NamedColumns, PointTable, SceneFiles};
use std::cell::RefCell;
use std::io;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Environment variable of the child process: seconds that a call into HDF5 may take.
const READER: &str = "MPM_READER";
/// Environment variable of the user that replaces these seconds.
const SECONDS: &str = "MPM_READ_SECONDS";
/// Shortest time limit of a call, enough for a disk to wake up `[s]`.
const AT_LEAST: f64 = 10.0;
/// Reading speed of a slow disk, from which the time limit of large files follows `[B/s]`.
const RATE: f64 = 10e6;

/// Times that results are read while a run writes them: it may change what belongs together.
const ATTEMPTS: usize = 5;
/// Time between two of them.
const PAUSE: Duration = Duration::from_millis(200);

/// What a file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    /// Results of a run.
    Results,
    /// Results of which only the head is wanted.
    Head,
    /// The state of a run.
    Checkpoint,
    /// A table of points in the plane.
    Points2,
    /// A table of points in space.
    Points3,
    /// A table of numbers.
    Columns,
}

/// Runs the whole command in a child process; the child's output and exit code become those of this process.
pub fn apart(file: &Path, read: impl Fn() -> Result<(), Complaint>) -> Result<(), Complaint> {
    if let Some(seconds) = seconds_of(READER) {
        watch(seconds);
        return patiently(file, read);
    }
    let mut command = match itself() {
        Ok(command) => command,
        // No child can be started: read without its protection.
        Err(_) => return read(),
    };
    command.args(std::env::args_os().skip(1));
    match ended(&mut command, file, "results file")?.code() {
        Some(0) => Ok(()),
        code => Err(Complaint::told(code.and_then(|it| u8::try_from(it).ok()).unwrap_or(1))),
    }
}

/// Reads results again where a run has changed them meanwhile.
fn patiently(file: &Path, read: impl Fn() -> Result<(), Complaint>) -> Result<(), Complaint> {
    let mut was_closed = false;
    for _ in 1..ATTEMPTS {
        match read() {
            Err(_) if is_being_written(file) => std::thread::sleep(PAUSE),
            // The run may have ended since.
            Err(_) if !was_closed => was_closed = true,
            done => return done,
        }
    }
    read()
}

/// Lets a child process read a file in full. The contents are checked later, by whoever reads the file in this process.
pub fn survives(file: &Path, kind: Kind) -> Result<(), Complaint> {
    let (Ok(mut command), true) = (itself(), file.is_file()) else { return Ok(()) };
    let value = kind.to_possible_value();
    command.arg("read-back").args(value.iter().map(|it| it.get_name())).arg("--").arg(file);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let what = match kind {
        Kind::Results | Kind::Head => "results file",
        Kind::Checkpoint => "checkpoint",
        Kind::Points2 | Kind::Points3 => "table of points",
        Kind::Columns => "table of numbers",
    };
    ended(&mut command, file, what).map(drop)
}

/// The work of the child process that [`survives`] starts.
pub fn read_back(kind: Kind, file: &Path) -> Result<(), Complaint> {
    watch(seconds_of(READER).unwrap_or_else(|| patience(file)));
    let name = || file.display().to_string();
    match kind {
        Kind::Head => Results::open(file).map(drop).map_err(|error| Complaint::input(error.to_string())),
        Kind::Results => read_results(file).map_err(|error| Complaint::input(error.to_string())),
        Kind::Checkpoint => Checkpoint::open(file)
            .and_then(|checkpoint| checkpoint.read_all())
            .map_err(|error| Complaint::input(error.to_string())),
        Kind::Columns => FolderFiles::default().columns(&name()).map(drop).map_err(Complaint::input),
        Kind::Points2 => FolderFiles::default().points(&name(), 2).map(drop).map_err(Complaint::input),
        Kind::Points3 => FolderFiles::default().points(&name(), 3).map(drop).map_err(Complaint::input),
    }
}

fn read_results(file: &Path) -> Result<(), ResultsError> {
    let results = Results::open(file)?;
    for column in results.columns() {
        results.column(&column.name)?;
    }
    for row in 0..results.rows() {
        results.residuals(row)?;
    }
    results.timings()?;
    let fields = results.fields()?;
    for step in 0..results.fractions().len() {
        results.points(step)?;
        for field in &fields {
            results.field(field, step)?;
        }
    }
    Ok(())
}

/// The files of a scene; a child process reads those in HDF5 first.
pub struct Files<'a> {
    folder: &'a FolderFiles,
    /// What of the files was not read.
    notes: RefCell<Vec<String>>,
}

impl<'a> Files<'a> {
    /// Those in a folder.
    pub fn of(folder: &'a FolderFiles) -> Self {
        Self { folder, notes: RefCell::default() }
    }

    /// What of the files was not read, each once.
    pub fn into_notes(self) -> Vec<String> {
        let mut notes = self.notes.into_inner();
        notes.sort();
        notes.dedup();
        notes
    }
}

impl SceneFiles for Files<'_> {
    fn surface(&self, file: &str) -> Result<Surface, String> {
        self.folder.surface(file)
    }

    fn points(&self, file: &str, dimensions: usize) -> Result<PointTable, String> {
        let path = self.folder.path(file);
        if FolderFiles::is_hdf5(&path) {
            let kind = if dimensions == 2 { Kind::Points2 } else { Kind::Points3 };
            survives(&path, kind).map_err(|complaint| complaint.to_string())?;
        }
        let table = self.folder.points(file, dimensions)?;
        self.notes.borrow_mut().extend(table.notes.iter().map(|note| format!("{}: {note}", table.file)));
        Ok(table)
    }

    fn columns(&self, file: &str) -> Result<NamedColumns, String> {
        let path = self.folder.path(file);
        if FolderFiles::is_hdf5(&path) {
            survives(&path, Kind::Columns).map_err(|complaint| complaint.to_string())?;
        }
        self.folder.columns(file)
    }
}

/// A command that starts this program again.
fn itself() -> io::Result<Command> {
    std::env::current_exe().map(Command::new)
}

/// Starts a child process that reads a file, and waits for its end. A crash or a time-out is an error.
fn ended(command: &mut Command, file: &Path, what: &str) -> Result<ExitStatus, Complaint> {
    let seconds = patience(file);
    let clock = Instant::now();
    let status = command.env(READER, seconds.to_string()).status();
    let status = status.map_err(|error| Complaint::unfinished(format!("cannot start a reader: {error}")))?;
    let name = file.display();
    match how(status, clock.elapsed() >= Duration::from_secs_f64(seconds)) {
        End::Ordered => Ok(status),
        End::Late => Err(Complaint::input(format!(
            "{what} {name}: HDF5 did not come back within {seconds:.0} s from reading it: it is damaged, or lies on a very \
             slow disk ({SECONDS} sets the seconds)"
        ))),
        End::Crashed => Err(Complaint::input(format!(
            "{what} {name}: HDF5 crashes ({status}) where it reads it: it is damaged"
        ))),
    }
}

/// How a child process ended.
enum End {
    Ordered,
    Late,
    Crashed,
}

fn how(status: ExitStatus, late: bool) -> End {
    match status.code() {
        Some(0..=255) => End::Ordered,
        // See `watch`.
        _ if late && has_aborted(status) => End::Late,
        _ => End::Crashed,
    }
}

#[cfg(unix)]
fn has_aborted(status: ExitStatus) -> bool {
    const SIGABRT: i32 = 6;
    std::os::unix::process::ExitStatusExt::signal(&status) == Some(SIGABRT)
}

#[cfg(not(unix))]
fn has_aborted(_: ExitStatus) -> bool {
    true
}

/// Seconds that a call into HDF5 may take in a file.
fn patience(file: &Path) -> f64 {
    let bytes = file.metadata().map_or(0, |it| it.len());
    seconds_of(SECONDS).unwrap_or(AT_LEAST + bytes as f64 / RATE)
}

fn seconds_of(variable: &str) -> Option<f64> {
    let seconds = std::env::var(variable).ok()?.parse().ok()?;
    (0.1..=1e9).contains(&seconds).then_some(seconds)
}

/// Aborts this process when a call into HDF5 exceeds the time limit. It aborts, because an orderly exit would call
/// HDF5's own clean-up, which waits for the call that hangs.
fn watch(seconds: f64) {
    std::thread::spawn(move || {
        let (mut seen, mut clock) = (Calls::now(), Instant::now());
        loop {
            std::thread::sleep(Duration::from_millis(50));
            let calls = Calls::now();
            if calls != seen || !calls.is_inside() {
                (seen, clock) = (calls, Instant::now());
            }
            if clock.elapsed().as_secs_f64() > seconds {
                std::process::abort();
            }
        }
    });
}

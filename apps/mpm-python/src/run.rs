//! Runs.

use crate::errors::Failure;
use crate::foreign::{Foreign, LawInPython, Raised};
use crate::link::{Ended, Event, Link, Request, Shown};
use crate::outputs::{Asked, Outputs, PROGRAM};
use crate::scene::{Scene, Tables, files};
use crate::step::{Known, Step};
use crate::worker::Job;
use mpm_io::{Checkpoint, CheckpointInterval};
use mpm_solver::observe::Cancellation;
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use std::ffi::CString;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// How often a signal (Ctrl-C) is looked for while a load step is awaited.
const LOOK: Duration = Duration::from_millis(50);

/// Stack of the thread that solves, that of a program's first one [B].
const STACK: usize = 8 << 20;

/// Where a run writes and on how many threads it computes, as Python says.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Settings {
    output: Option<PathBuf>,
    checkpoint: Option<PathBuf>,
    checkpoint_every: Option<u32>,
    checkpoint_seconds: Option<f64>,
    force: bool,
    threads: Option<usize>,
}

impl Settings {
    fn asked(&self, is_foreign: bool) -> Asked {
        let interval = CheckpointInterval { steps: self.checkpoint_every, seconds: self.checkpoint_seconds };
        let (output, checkpoint) = (self.output.clone(), self.checkpoint.clone());
        Asked { output, checkpoint, interval, force: self.force, is_foreign }
    }
}

/// Starts a run of a scene; laws and loads in Python are given by the names of bodies.
#[pyfunction]
pub(crate) fn run(
    py: Python<'_>,
    scene: &Scene,
    settings: Settings,
    laws: Vec<(String, LawInPython)>,
    loads: Vec<(String, Py<PyAny>)>,
) -> PyResult<Run> {
    let foreign = Foreign { laws, loads };
    let raised = Raised::default();
    let prepared = py.detach(|| {
        let (mut compiled, _notes) = scene.compiled()?;
        let cancellation = Cancellation::default();
        let is_foreign = !foreign.is_empty();
        foreign.join(scene.language(), &mut compiled, &raised, &cancellation)?;
        let outputs = Outputs::begin(scene, &compiled, &settings.asked(is_foreign))?;
        let known = Known::of(scene.language(), &compiled);
        let cancellation = outputs.cancellation().unwrap_or(cancellation);
        let file = scene.file().to_owned();
        Ok((Job { compiled, state: None, file, outputs, cancellation, threads: settings.threads }, known))
    });
    let (job, known) = prepared.map_err(|failure: Failure| failure.raise(py))?;
    Run::start(py, job, known, raised)
}

/// Goes on with a run from a checkpoint.
#[pyfunction]
pub(crate) fn resume(
    py: Python<'_>,
    file: PathBuf,
    folder: Option<PathBuf>,
    tables: Tables<'_>,
    settings: Settings,
) -> PyResult<Run> {
    // What it says of the folder is known once it is open.
    let opened = py.detach(|| Checkpoint::open(&file).map_err(Failure::input)).map_err(|it| it.raise(py))?;
    let mut head = opened.head().clone();
    if let Some(folder) = folder {
        head.folder = folder;
    }
    let files = files(head.folder.clone(), tables);
    let prepared = py.detach(|| {
        let name = file.display().to_string();
        let scene = Scene::read(head.scene.clone(), name.clone(), files)?;
        let (compiled, _notes) = scene.compiled()?;
        let state = opened.state(&compiled.state_layout()).map_err(Failure::input)?;
        let step = state.progress.rows().saturating_sub(1);
        let known = Known::of(scene.language(), &compiled);
        let written_by = head.program.clone();
        let outputs = Outputs::go_on(&scene, &compiled, (&file, head, step), &settings.asked(false))?;
        let cancellation = outputs.cancellation().unwrap_or_default();
        let (state, threads) = (Some(state), settings.threads);
        Ok((Job { compiled, state, file: name, outputs, cancellation, threads }, known, written_by))
    });
    let (job, known, written_by) = prepared.map_err(|failure: Failure| failure.raise(py))?;
    if written_by != PROGRAM {
        let file = &job.file;
        warn(
            py,
            &format!(
                "{file} was written by {written_by}, this is {PROGRAM}: the rest may differ in its last digits"
            ),
        )?;
    }
    Run::start(py, job, known, Raised::default())
}

fn warn(py: Python<'_>, message: &str) -> PyResult<()> {
    let message = CString::new(message.replace('\0', " "))?;
    PyErr::warn(py, &py.get_type::<PyUserWarning>(), &message, 2)
}

/// A run that goes on as its load steps are asked for.
///
/// It is an iterator over :class:`Step`, the first of which is the initial state. The run computes in a thread of its own
/// without Python's lock, and waits after each load step until the next is asked for: stopping leaves the results at the
/// load step that was looked at. It stops when it is closed: by :meth:`close`, at the end of a ``with`` block, or when nobody
/// refers to it any longer.
#[pyclass(module = "implicit_mpm._native")]
pub(crate) struct Run {
    link: Arc<Link>,
    events: Mutex<Receiver<Event>>,
    thread: Option<JoinHandle<()>>,
    cancellation: Cancellation,
    /// The exception of a law or load in Python, which has stopped the run.
    raised: Raised,
    known: Arc<Known>,
    /// Whether the run waits until the next load step is asked for.
    waits: bool,
    /// The load step that was shown last.
    last: usize,
    status: String,
}

impl Run {
    fn start(py: Python<'_>, job: Job, known: Known, raised: Raised) -> PyResult<Self> {
        let (requests, of_python) = channel();
        let (to_python, events) = channel();
        let cancellation = job.cancellation.clone();
        let thread = std::thread::Builder::new().name("mpm".into()).stack_size(STACK);
        let thread = thread.spawn(move || job.run(to_python, of_python));
        let thread =
            Some(thread.map_err(|error| Failure::input(format!("cannot start a thread: {error}")).raise(py))?);
        let (link, events) = (Link::new(requests), Mutex::new(events));
        let (known, status) = (Arc::new(known), "running".into());
        let mut run = Self { link, events, thread, cancellation, raised, known, waits: false, last: 0, status };
        match run.event(py)? {
            Some(Event::Started(columns)) => {
                run.known = Arc::new(Known::clone(&run.known).with(columns));
                Ok(run)
            }
            _ => Err(Failure::run("the run has not begun").raise(py)),
        }
    }

    fn is_over(&self) -> bool {
        self.thread.is_none()
    }

    /// The next event but warnings, which are told; none at the end.
    fn event(&mut self, py: Python<'_>) -> PyResult<Option<Event>> {
        loop {
            let events = self.events.get_mut().unwrap_or_else(PoisonError::into_inner);
            match py.detach(move || events.recv_timeout(LOOK)) {
                Ok(Event::Warning(message)) => warn(py, &message)?,
                Ok(Event::Ended(ended)) => return self.end(py, ended).map(|()| None),
                Ok(event) => return Ok(Some(event)),
                Err(RecvTimeoutError::Timeout) => {
                    if let Err(interrupt) = py.check_signals() {
                        self.stop(py);
                        return Err(interrupt);
                    }
                }
                Err(RecvTimeoutError::Disconnected) => {
                    let fault = Failure::run("the thread of the run has ended by a fault of the program");
                    return self.end(py, Err(fault)).map(|()| None);
                }
            }
        }
    }

    /// Records how the run has ended.
    fn end(&mut self, py: Python<'_>, ended: Result<Ended, Failure>) -> PyResult<()> {
        // The thread of a run that is complete goes on to hand out the points of the last load step as long as anyone can ask.
        match (self.thread.take(), &ended) {
            (Some(_), Ok(Ended::Completed)) => self.link.waits_at(self.last),
            (Some(thread), _) => {
                // A thread that has panicked has been told of.
                let _ = py.detach(|| thread.join());
            }
            (None, _) => {}
        }
        if let Some(exception) = self.raised.take() {
            self.status = format!("failed: {exception}");
            return Err(exception);
        }
        self.status = match &ended {
            Ok(Ended::Completed) => "completed".into(),
            Ok(Ended::Stopped) => "stopped".into(),
            Err(Failure::Run { reason, .. }) => format!("failed: {reason}"),
            Err(Failure::Input(_)) => "failed".into(),
        };
        ended.map(drop).map_err(|failure| failure.raise(py))
    }

    /// Stops the run and waits for its end; what goes wrong in it is not told.
    fn stop(&mut self, py: Python<'_>) {
        if self.is_over() {
            self.link.send(Request::Stop);
            return;
        }
        self.cancellation.cancel();
        self.link.send(Request::Stop);
        let events = self.events.get_mut().unwrap_or_else(PoisonError::into_inner);
        let (ended, warnings) = py.detach(move || {
            let mut warnings = Vec::new();
            loop {
                match events.recv() {
                    Ok(Event::Ended(ended)) => return (ended, warnings),
                    Ok(Event::Warning(message)) => warnings.push(message),
                    Ok(_) => {}
                    Err(_) => return (Ok(Ended::Stopped), warnings),
                }
            }
        });
        // Exceptions are made for the status only, and warnings that are errors cannot be raised here.
        let _ = warnings.iter().try_for_each(|message| warn(py, message));
        let _ = self.end(py, ended);
    }
}

#[pymethods]
impl Run {
    fn __iter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }

    fn __next__(&mut self, py: Python<'_>) -> PyResult<Option<Step>> {
        if self.is_over() {
            return Ok(None);
        }
        if std::mem::take(&mut self.waits) {
            self.link.send(Request::Next);
        }
        match self.event(py)? {
            Some(Event::Step(shown)) => {
                let Shown { index, .. } = shown;
                self.link.waits_at(index);
                (self.waits, self.last) = (true, index);
                Ok(Some(Step::new(shown, self.known.clone(), self.link.clone())))
            }
            _ => Ok(None),
        }
    }

    /// Stops the run, closes its files, and waits until this is done. A run that is over stays as it is, and lets its points go.
    fn close(&mut self, py: Python<'_>) {
        self.stop(py);
    }

    fn __enter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }

    fn __exit__(
        &mut self,
        py: Python<'_>,
        _kind: &Bound<'_, PyAny>,
        _error: &Bound<'_, PyAny>,
        _traceback: &Bound<'_, PyAny>,
    ) {
        self.stop(py);
    }

    /// ``running``, ``completed``, ``stopped``, or ``failed: <reason>``.
    #[getter]
    fn status(&self) -> &str {
        &self.status
    }

    /// Names of the fields that the points of the run have.
    #[getter]
    fn fields(&self) -> Vec<&'static str> {
        self.known.fields.iter().map(|field| field.name()).collect()
    }

    fn __repr__(&self) -> String {
        format!("<implicit_mpm.Run: {}>", self.status)
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        if !self.is_over() {
            self.cancellation.cancel();
            // Where Python is going away, so does the thread.
            Python::try_attach(|py| self.stop(py));
        }
    }
}

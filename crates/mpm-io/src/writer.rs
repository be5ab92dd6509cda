//! Writes a results file while a run goes.

use std::fs;
use std::mem;
use std::panic;
use std::path::{Path, PathBuf};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use mpm_solver::observe::{
    Counted, Fields, LoadStep, Observer, ObserverError, Outcome, Resumed, RunStart, Timing,
};

use crate::earlier::Earlier;
use crate::error::ResultsError;
use crate::options::Options;
use crate::pending::Pending;
use crate::reader::Results;
use crate::replace::{check_replaceable, part_of};
use crate::run_file::RunFile;
use crate::snapshot::Snapshot;

/// Load steps of fewer bytes are written before the run goes on: starting a thread takes as long.
const WORTH_A_THREAD: usize = 1 << 18;

/// An [`Observer`] that writes a results file (layout: [crate]).
///
/// **Load steps are written together**, at the latest [`Options::keep_back`] (one second) after those before, whenever
/// [`ResultsWriter::flush`] is called, and at the end. A run that is killed loses those that were not written.
///
/// **Readers.** The file holds a shared lock while it is written (`flock` on Unix): other programs can read it at any
/// time, as h5py and ParaView do, and cannot open it for writing.
///
/// **Killed runs.** What is written is flushed, and nothing that is already stored is moved or
/// re-indexed, so a run killed at any moment (also within a flush, also by an error of ours such
/// as a full disk) leaves a file that plain HDF5 opens, with all load steps written before. This rests
/// on five choices:
/// * superblock 2, which has no "open for writing" flag (SWMR needs superblock 3, whose flag
///   survives a kill and then keeps readers out), yet the chunk indices of HDF5 1.10, which only
///   grow, where the older B-trees split and move entries;
/// * metadata in pages of 4096 bytes, the unit in which a kill can tear a write: a checksummed
///   block that straddled two would be lost with all it describes;
/// * every object is created, and flushed, before the first load step;
/// * stored chunks stay where they are: small datasets are plain and filled in place, compressed
///   points start a new chunk each step;
/// * the counts of complete rows (attribute `rows` of `/history`) and of recorded steps
///   (`VTKHDF/Steps/NSteps`) are raised by a flush of their own, after the data.
///
/// Beyond these counts a killed run can leave more rows, in some columns only; where one of them
/// is the first of a new chunk (every 1024th) it can be unreadable. [`Results`] keeps to the
/// counts. Past some 8000 recorded steps (2000 if compressed) blocks of the index outgrow a page,
/// and a kill in the very middle of writing one can cost the steps it describes. Flushing hands
/// the data to the operating system; it does not wait for the disk, so this says nothing of power
/// cuts.
///
/// [`Results`]: crate::Results
pub struct ResultsWriter {
    path: PathBuf,
    options: Options,
    file: Place,
    run: Option<Run>,
    /// Results of the run so far, until they are taken over; the file is then beside its later place.
    earlier: Option<(Results, PathBuf)>,
}

/// Where the file is.
enum Place {
    Here(Box<RunFile>),
    /// With the thread that writes the last load steps; it hands it back with the time that this took.
    WithThread(JoinHandle<(Box<RunFile>, Result<Duration, ResultsError>)>),
    /// Its thread could not be started, or panicked.
    Nowhere,
}

/// What is known of a run while it goes.
struct Run {
    counted: Counted,
    pending: Pending,
    /// Number of the next row.
    next: usize,
    /// Whether the points of the last load step are not recorded: any step can turn out to be the last.
    lacks_last: bool,
}

impl ResultsWriter {
    /// Creates the file; an existing one is replaced only if it can be.
    ///
    /// # Errors
    /// [`ResultsError::Create`] if `path` is a directory, is not writable, lies in no directory,
    /// is being written by another run, or ends in `.xdmf`; if a text holds a NUL character.
    pub fn create(path: impl AsRef<Path>, mut options: Options) -> Result<Self, ResultsError> {
        let path = path.as_ref();
        options.fields.sort();
        options.fields.dedup();
        options.every = options.every.max(1);
        let file = Place::Here(Box::new(RunFile::create(path, &options)?));
        Ok(Self { path: path.into(), options, file, run: None, earlier: None })
    }

    /// Goes on with the results of a run that stopped. Observed from [`Observer::resume`] on, the file of
    /// before is replaced at once by a copy of its rows up to there; until then it is untouched. Without a
    /// file at `path`, the history begins where the run goes on.
    ///
    /// # Errors
    /// As [`Self::create`]; [`ResultsError::Open`] and [`ResultsError::Malformed`] if the file is no results
    /// file of the same scene.
    pub fn resume(path: impl AsRef<Path>, options: Options) -> Result<Self, ResultsError> {
        let path = path.as_ref();
        if !path.exists() {
            return Self::create(path, options);
        }
        drop(check_replaceable(path).map_err(|reason| ResultsError::create(path, reason))?);
        let earlier = Results::open(path)?;
        if earlier.scene() != *options.earlier_scene.as_ref().unwrap_or(&options.scene) {
            return Err(ResultsError::malformed(path, "scene", "is another than that of the run"));
        }
        let mut writer = Self::create(part_of(path), options)?;
        writer.earlier = Some((earlier, path.into()));
        Ok(writer)
    }

    /// Writes the load steps that were kept back, and waits until they are written.
    ///
    /// # Errors
    /// [`ResultsError::Write`]; the file is given up then.
    pub fn flush(&mut self) -> Result<(), ResultsError> {
        let is_open = self.file()?.is_open();
        if !is_open || self.run.as_ref().is_none_or(|run| run.pending.rows() == 0) {
            return Ok(());
        }
        self.commit("the last load steps", None, None)?;
        self.file().map(drop)
    }

    /// Waits until all that was written is on the disk.
    ///
    /// # Errors
    /// [`ResultsError::Write`].
    pub fn sync(&mut self) -> Result<(), ResultsError> {
        self.file()?.sync()
    }

    /// Takes over the rows before `end` and puts the file in the place of that of before.
    fn take_over(&mut self, earlier: Results, path: PathBuf, end: usize) -> Result<(), ObserverError> {
        let fields = self.options.fields.clone();
        let run = self.run.as_mut().expect("a run starts before it goes on");
        let recorded = |row: usize, fraction: f64| run.counted.is_recorded(self.options.every, row, fraction);
        let may_lack = self.options.earlier_scene.is_some();
        let earlier = Earlier::of(earlier, (run.pending.columns(), may_lack), &fields, &recorded, end)?;
        run.next = earlier.first();
        let first = earlier.first();
        self.file()?.begin_at(first)?;
        for row in earlier.rows() {
            let (entries, residuals) = earlier.row(row)?;
            let snapshot = earlier.snapshot(row, &fields)?;
            let run = self.run();
            run.pending.push(&entries, &residuals);
            run.next += 1;
            if let Some(snapshot) = snapshot {
                run.pending.record(snapshot);
            }
            if run.pending.is_much() {
                let batch = run.pending.take();
                self.file()?.append(&batch, &format!("load step {row}"))?;
            }
        }
        drop(earlier);
        let batch = self.run().pending.take();
        let file = self.file()?;
        file.write(&batch, None, "the load steps so far", None)?;
        file.take_place(path.clone())?;
        file.write_xdmf("the load steps so far", Duration::ZERO)?;
        self.path = path;
        Ok(())
    }

    fn run(&mut self) -> &mut Run {
        self.run.as_mut().expect("a run starts before its first load step")
    }

    /// The file, as soon as the thread that writes to it is done.
    fn file(&mut self) -> Result<&mut RunFile, ResultsError> {
        if let Place::WithThread(_) = self.file {
            let Place::WithThread(thread) = mem::replace(&mut self.file, Place::Nowhere) else {
                unreachable!()
            };
            let (file, written) = thread.join().unwrap_or_else(|panicked| panic::resume_unwind(panicked));
            self.file = Place::Here(file);
            let took = written?;
            self.run().pending.is_written(took);
        }
        match &mut self.file {
            Place::Here(file) => Ok(file),
            _ => {
                Err(ResultsError::write(&self.path, "the last load steps", "the thread that writes has ended"))
            }
        }
    }

    /// Whether a thread is still writing the load steps of before.
    fn is_being_written(&self) -> bool {
        matches!(&self.file, Place::WithThread(thread) if !thread.is_finished())
    }

    /// Writes what was kept back, and the XDMF file if so long has passed since the last time: what is worth it in a
    /// thread, once the thread before is done.
    fn commit(
        &mut self,
        item: &str,
        timings: Option<Vec<Timing>>,
        xdmf_after: Option<Duration>,
    ) -> Result<(), ResultsError> {
        self.file()?;
        let batch = self.run().pending.take();
        let may_go_on = self.options.beside && !self.options.keep_back.is_zero();
        let in_thread = may_go_on && batch.bytes() >= WORTH_A_THREAD;
        let Place::Here(mut file) = mem::replace(&mut self.file, Place::Nowhere) else {
            unreachable!("it was waited for");
        };
        let item = item.to_owned();
        let write = move || {
            let began = Instant::now();
            let written = file.write(&batch, timings.as_deref(), &item, xdmf_after);
            (file, written.map(|()| began.elapsed()))
        };
        if in_thread {
            let thread = thread::Builder::new().name("results".into()).spawn(write);
            let failed = |error| ResultsError::write(&self.path, "the last load steps", error);
            self.file = Place::WithThread(thread.map_err(failed)?);
            return Ok(());
        }
        let (file, written) = write();
        self.file = Place::Here(file);
        let took = written?;
        self.run().pending.is_written(took);
        Ok(())
    }

    /// Keeps a load step and, if it is to be recorded, its points; writes all that is kept where it is time.
    fn append(&mut self, step: &LoadStep<'_>) -> Result<(), ResultsError> {
        if !self.is_being_written() {
            self.file()?;
        }
        let (every, keep_back) = (self.options.every, self.options.keep_back);
        let run = self.run.as_mut().expect("a run starts before its first load step");
        assert_eq!(step.index, run.next, "load steps are observed in order");
        run.next += 1;
        run.pending.push(step.row, step.residuals);
        run.lacks_last = !run.counted.is_recorded(every, step.index, step.fraction);
        if !run.lacks_last {
            run.pending.record(Snapshot::of(step.fraction, step.fields, &self.options.fields));
        }
        // The initial state at once, so that the file can be looked at.
        let is_due = run.pending.is_due(keep_back) || step.index == 0;
        let may_wait = !run.pending.is_much() && self.is_being_written();
        if is_due && !may_wait {
            self.commit(&format!("load step {}", step.index), Some(step.timings.to_vec()), Some(keep_back))?;
        }
        Ok(())
    }
}

impl Observer for ResultsWriter {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        assert!(self.run.is_none(), "a writer observes one run");
        let path = self.earlier.as_ref().map_or(&self.path, |(_, path)| path).clone();
        let options = self.options.clone();
        self.file()?.start(run, &options, &path)?;
        let pending = Pending::new(&run.columns);
        self.run = Some(Run { counted: run.counted.clone(), pending, next: 0, lacks_last: false });
        Ok(())
    }

    fn resume(&mut self, run: &RunStart, so_far: &Resumed) -> Result<(), ObserverError> {
        self.start(run)?;
        match self.earlier.take() {
            Some((earlier, path)) => {
                let part = self.path.clone();
                self.take_over(earlier, path, so_far.rows).inspect_err(|_| {
                    let _ = fs::remove_file(part);
                })?;
            }
            None => {
                self.file()?.begin_at(so_far.rows)?;
                self.run().next = so_far.rows;
            }
        }
        let lacks_last = !run.counted.is_recorded(self.options.every, so_far.rows - 1, so_far.fraction);
        self.run().lacks_last = lacks_last;
        Ok(())
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        Ok(self.append(step)?)
    }

    fn last(&mut self, fraction: f64, fields: &dyn Fields) -> Result<(), ObserverError> {
        if let Some(run) = self.run.as_mut().filter(|run| run.lacks_last) {
            run.pending.record(Snapshot::of(fraction, fields, &self.options.fields));
        }
        Ok(())
    }

    fn finish(&mut self, outcome: &Outcome, timings: &[Timing]) -> Result<(), ObserverError> {
        if matches!(self.file, Place::Nowhere) || !self.file()?.is_open() {
            return Ok(()); // given up; the error has been reported
        }
        if self.file()?.has_started() {
            self.commit("the last load steps", None, Some(Duration::ZERO))?;
        }
        self.file()?.close(outcome, timings)?;
        self.run = None;
        Ok(())
    }
}

impl Drop for ResultsWriter {
    fn drop(&mut self) {
        if self.earlier.is_some() {
            // A copy that was never to take its place goes.
            let _ = fs::remove_file(&self.path);
        } else {
            let _ = self.flush();
        }
    }
}

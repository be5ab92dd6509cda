//! Writes a results file while a run goes.

use std::fs;
use std::mem;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use hdf5::plist::file_access::LibraryVersion;
use hdf5::plist::file_create::FileSpaceStrategy;
use hdf5::types::VarLenUnicode;
use hdf5::{Attribute, File, Group};
use mpm_solver::observe::{
    Column, ColumnKind, Counted, Entry, Fields, LoadStep, Observer, ObserverError, Outcome, Resumed, RunStart,
    Timing,
};

use crate::earlier::Earlier;
use crate::error::{ResultsError, reason};
use crate::names::{PhaseName, RESULTS, RESULTS_VERSION, phase_name};
use crate::options::Options;
use crate::pending::{Pending, Values};
use crate::reader::Results;
use crate::replace::{check_replaceable, fill, is_at, keep_from_writing, part_of, put_in_place};
use crate::rows::Rows;
use crate::snapshot::Snapshot;
use crate::vtkhdf::PointCloud;
use crate::xdmf::Xdmf;

/// Unit in which the file grows [bytes]: the page of the operating system, see [`ResultsWriter`].
const PAGE: u64 = 4096;

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
    /// `None` once the run has finished and the file is closed.
    file: Option<File>,
    /// The same file, to see that there is room for what HDF5 is about to write; it holds the lock.
    room: fs::File,
    run: Option<Run>,
    /// Results of the run so far, until they are taken over; the file is then beside its later place.
    earlier: Option<(Results, PathBuf)>,
}

/// Everything that grows during a run.
struct Run {
    counted: Counted,
    columns: Vec<Column>,
    history: Vec<Rows>,
    /// Attribute of `/history`: the rows that are complete.
    rows: Attribute,
    /// Number of the first row.
    first: usize,
    offset: Rows,
    residual: Rows,
    timings: [Rows; 3],
    cloud: PointCloud,
    xdmf: Xdmf,
    pending: Pending,
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
        let fail = |reason: &dyn ToString| ResultsError::create(path, reason.to_string());
        let text = |text: &str| text.parse::<VarLenUnicode>().map_err(|error| fail(&error));
        options.fields.sort();
        options.fields.dedup();
        options.every = options.every.max(1);
        if options.compression > 9 {
            return Err(fail(&format!("compression {} is not in 0 to 9", options.compression)));
        }
        let (scene, program) = (text(&options.scene)?, text(&options.program)?);
        // Held until the lock is a shared one.
        let replaced = check_replaceable(path).map_err(|reason| fail(&reason))?;
        let file = (|| {
            hdf5::silence_errors(true);
            let file = File::with_options()
                .with_fapl(|access| access.libver_v18().file_locking(false))
                .with_fcpl(|create| {
                    let pages =
                        FileSpaceStrategy::FreeSpaceManager { paged: true, persist: false, threshold: 1 };
                    create.obj_track_times(false).file_space_strategy(pages).file_space_page_size(PAGE)
                })
                .create(path)?;
            file.new_attr::<VarLenUnicode>().create("format")?.write_scalar(&plain(RESULTS))?;
            file.new_attr::<i64>().create("version")?.write_scalar(&RESULTS_VERSION)?;
            file.new_attr::<VarLenUnicode>().create("scene")?.write_scalar(&scene)?;
            file.new_attr::<VarLenUnicode>().create("program")?.write_scalar(&program)?;
            file.new_attr::<VarLenUnicode>().create("status")?.write_scalar(&plain("running"))?;
            file.close()?;
            // Opened anew, the file keeps its superblock 2 but new datasets get 1.10's indices.
            File::with_options()
                .with_fapl(|access| {
                    access.libver_bounds(LibraryVersion::V110, LibraryVersion::latest()).file_locking(false)
                })
                .open_rw(path)
        })();
        let file = file.map_err(|error| fail(&reason(&error)))?;
        let room = match replaced {
            Some(room) => room,
            None => fs::OpenOptions::new().write(true).open(path).map_err(|error| fail(&error))?,
        };
        keep_from_writing(&room).map_err(|reason| fail(&reason))?;
        Ok(Self { path: path.into(), options, file: Some(file), room, run: None, earlier: None })
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

    /// Writes the load steps that were kept back.
    ///
    /// # Errors
    /// [`ResultsError::Write`]; the file is given up then.
    pub fn flush(&mut self) -> Result<(), ResultsError> {
        if self.file.is_none() || self.run.as_ref().is_none_or(|run| run.pending.rows() == 0) {
            return Ok(());
        }
        self.commit().map_err(|error| self.give_up("the last load steps", &error))
    }

    /// Waits until all that was written is on the disk.
    ///
    /// # Errors
    /// [`ResultsError::Write`].
    pub fn sync(&self) -> Result<(), ResultsError> {
        self.room.sync_all().map_err(|error| ResultsError::write(&self.path, "to the disk", error))
    }

    /// Takes over the rows before `end` and puts the file in the place of that of before.
    fn take_over(&mut self, earlier: Results, path: PathBuf, end: usize) -> Result<(), ObserverError> {
        let run = self.run.as_mut().expect("a run starts before it goes on");
        let fields = self.options.fields.clone();
        let recorded = |row: usize, fraction: f64| run.counted.is_recorded(self.options.every, row, fraction);
        let may_lack = self.options.earlier_scene.is_some();
        let earlier = Earlier::of(earlier, (&run.columns, may_lack), &fields, &recorded, end)?;
        let first = earlier.first();
        self.begin_at(first).map_err(|error| self.give_up("the number of the first row", &error))?;
        for row in earlier.rows() {
            let item = format!("load step {row}");
            let (entries, residuals) = earlier.row(row)?;
            let snapshot = earlier.snapshot(row, &fields)?;
            let run = self.run.as_mut().expect("it is there");
            run.push(row, &entries, &residuals);
            if let Some(snapshot) = snapshot {
                run.pending.record(snapshot);
            }
            if run.pending.is_much() {
                run.write_pending().map_err(|error| self.give_up(&item, &error))?;
            }
        }
        drop(earlier);
        self.commit().map_err(|error| self.give_up("the load steps so far", &error))?;
        put_in_place(&self.path, &path)
            .map_err(|reason| ResultsError::write(&path, "the load steps so far", reason))?;
        self.path = path;
        self.write_xdmf("the load steps so far", Duration::ZERO)?;
        Ok(())
    }

    fn file(&self) -> &File {
        self.file.as_ref().expect("a run is not observed after its end")
    }

    /// Writes what was kept back, then the counts that make it visible.
    fn commit(&mut self) -> hdf5::Result<()> {
        let began = Instant::now();
        if !is_at(&self.room, &self.path) {
            return Err("it was deleted or replaced by another program".into());
        }
        self.run.as_mut().expect("a run starts before its first load step").write_pending()?;
        self.flush_file()?;
        let run = self.run.as_mut().expect("it is there");
        run.rows.write_scalar(&(run.offset.len() as i64))?;
        run.cloud.count()?;
        self.flush_file()?;
        self.run.as_mut().expect("it is there").pending.is_written(began);
        Ok(())
    }

    /// Extends the file to the length that its header will promise, then flushes.
    ///
    /// If the length is not to be had (a limit on the size of files), HDF5 would find out after
    /// it has written the header, and readers refuse a file that is shorter than promised.
    fn flush_file(&self) -> hdf5::Result<()> {
        let promised = self.file().size();
        let length = self.room.metadata().map_err(|error| error.to_string())?.len();
        if length < promised {
            // Zeros take up space on the disk, which a greater length alone would not.
            let filled = fill(&self.room, length, promised);
            filled.map_err(|error| error.to_string())?;
        }
        self.file().flush()
    }

    /// Keeps a load step and, if it is to be recorded, its points; writes all that is kept where it is time.
    fn append(&mut self, step: &LoadStep<'_>) -> hdf5::Result<()> {
        let run = self.run.as_mut().expect("a run starts before its first load step");
        run.push(step.index, step.row, step.residuals);
        run.lacks_last = !run.counted.is_recorded(self.options.every, step.index, step.fraction);
        if !run.lacks_last {
            run.pending.record(Snapshot::of(step.fraction, step.fields, &self.options.fields));
        }
        // The initial state at once, so that the file can be looked at.
        if run.pending.is_due(self.options.keep_back) || step.index == 0 {
            run.write_timings(step.timings)?;
            self.commit()?;
        }
        Ok(())
    }

    /// Reports an error and gives the file up as it is on disk, as if the run had been killed.
    ///
    /// Closing would make HDF5 write the rest of its metadata, on a full disk some of it, and
    /// could leave a file whose header promises more than was stored.
    fn give_up(&mut self, item: &str, error: &hdf5::Error) -> ResultsError {
        mem::forget((self.file.take(), self.run.take()));
        ResultsError::write(&self.path, item, reason(error))
    }

    /// Makes `row` the first of the history.
    fn begin_at(&mut self, row: usize) -> hdf5::Result<()> {
        let history = self.file().group("history")?;
        if row > 0 {
            history.new_attr::<i64>().create("first_row")?.write_scalar(&(row as i64))?;
        }
        self.run.as_mut().expect("a run starts before it goes on").first = row;
        self.flush_file()
    }

    /// Writes the XDMF file where recorded steps have come, so long after the last time.
    fn write_xdmf(&mut self, item: &str, after: Duration) -> Result<(), ResultsError> {
        let xdmf = match &mut self.run {
            Some(run) if run.xdmf.is_due(after) || (after.is_zero() && run.xdmf.is_behind()) => &mut run.xdmf,
            _ => return Ok(()),
        };
        let written = xdmf.write().map_err(|error| ResultsError::write(xdmf.path(), item, error));
        if written.is_err() {
            // Where a small file has no room, the end of the results may have none.
            mem::forget((self.file.take(), self.run.take()));
        }
        written
    }

    /// Writes how the run ended and closes the file.
    fn close(&mut self, outcome: &Outcome, timings: &[Timing]) -> hdf5::Result<()> {
        let status = match outcome {
            Outcome::Completed => "completed".to_owned(),
            Outcome::Failed(reason) => format!("failed: {}", reason.replace('\0', " ")),
        };
        if let Some(run) = &mut self.run {
            run.write_timings(timings)?;
        }
        self.file().attr("status")?.write_scalar(&plain(&status))?;
        self.flush_file()?;
        self.run = None;
        self.file.take().map_or(Ok(()), File::close)
    }
}

impl Run {
    fn create(file: &Group, start: &RunStart, options: &Options, path: &Path) -> hdf5::Result<Self> {
        let history = file.create_group("history")?;
        let rows = history.new_attr::<i64>().create("rows")?;
        rows.write_scalar(&0_i64)?;
        let create_column = |column: &Column| match column.kind {
            ColumnKind::Count => Rows::create_small::<u64>(&history, &column.name, column.width),
            ColumnKind::Real => Rows::create_small::<f64>(&history, &column.name, column.width),
        };
        let newton = file.create_group("newton")?;
        let timings = file.create_group("timings")?;
        let Options { fields, compression, precision, .. } = options;
        Ok(Self {
            counted: start.counted.clone(),
            columns: start.columns.clone(),
            history: start.columns.iter().map(create_column).collect::<hdf5::Result<_>>()?,
            rows,
            first: 0,
            offset: Rows::create_small::<u64>(&newton, "offset", 1)?,
            residual: Rows::create_small::<f64>(&newton, "residual", 1)?,
            timings: [
                Rows::create_small::<PhaseName>(&timings, "phase", 1)?,
                Rows::create_small::<f64>(&timings, "seconds", 1)?,
                Rows::create_small::<u64>(&timings, "count", 1)?,
            ],
            cloud: PointCloud::create(file, fields, (start.space, start.points), *compression, *precision)?,
            xdmf: Xdmf::beside(path, fields, *precision),
            pending: Pending::new(&start.columns),
            lacks_last: false,
        })
    }

    /// Keeps the row of a load step.
    fn push(&mut self, index: usize, row: &[Entry], residuals: &[f64]) {
        let next = self.first + self.offset.len() + self.pending.rows();
        assert_eq!(index, next, "load steps are observed in order");
        self.pending.push(&self.columns, row, residuals);
    }

    /// Hands what is kept to HDF5.
    fn write_pending(&mut self) -> hdf5::Result<()> {
        let Pending { columns, residuals, ends, snapshots, .. } = &mut self.pending;
        for (rows, values) in self.history.iter_mut().zip(columns) {
            match values {
                Values::Count(values) => rows.append(values)?,
                Values::Real(values) => rows.append(values)?,
            };
        }
        let before = self.residual.len() as u64;
        self.residual.append(residuals)?;
        self.offset.append(&ends.iter().map(|end| before + end).collect::<Vec<_>>())?;
        for (placed, snapshot) in self.cloud.append(snapshots)?.iter().zip(snapshots) {
            self.xdmf.add(snapshot.fraction, snapshot.positions.len() / 3, placed);
        }
        self.pending.clear();
        Ok(())
    }

    fn write_timings(&mut self, timings: &[Timing]) -> hdf5::Result<()> {
        let [phase, seconds, count] = &mut self.timings;
        phase.replace(&timings.iter().map(|t| phase_name(t.phase)).collect::<Vec<_>>())?;
        seconds.replace(&timings.iter().map(|t| t.seconds).collect::<Vec<_>>())?;
        count.replace(&timings.iter().map(|t| t.count).collect::<Vec<_>>())
    }
}

impl Observer for ResultsWriter {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        assert!(self.run.is_none(), "a writer observes one run");
        let path = self.earlier.as_ref().map_or(&self.path, |(_, path)| path);
        let created = Run::create(self.file(), run, &self.options, path);
        let created = created.and_then(|created| self.flush_file().map(|()| created));
        self.run = Some(created.map_err(|error| self.give_up("the layout of the run", &error))?);
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
                let begun = self.begin_at(so_far.rows);
                begun.map_err(|error| self.give_up("the number of the first row", &error))?;
            }
        }
        let lacks_last = !run.counted.is_recorded(self.options.every, so_far.rows - 1, so_far.fraction);
        self.run.as_mut().expect("it was started").lacks_last = lacks_last;
        Ok(())
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        let item = format!("load step {}", step.index);
        self.append(step).map_err(|error| self.give_up(&item, &error))?;
        Ok(self.write_xdmf(&item, self.options.keep_back)?)
    }

    fn last(&mut self, fraction: f64, fields: &dyn Fields) -> Result<(), ObserverError> {
        if let Some(run) = self.run.as_mut().filter(|run| run.lacks_last) {
            run.pending.record(Snapshot::of(fraction, fields, &self.options.fields));
        }
        Ok(())
    }

    fn finish(&mut self, outcome: &Outcome, timings: &[Timing]) -> Result<(), ObserverError> {
        if self.file.is_none() {
            return Ok(()); // given up; the error has been reported
        }
        if self.run.is_some() {
            self.commit().map_err(|error| self.give_up("the last load steps", &error))?;
            self.write_xdmf("the last load steps", Duration::ZERO)?;
        }
        Ok(self.close(outcome, timings).map_err(|error| self.give_up("the outcome", &error))?)
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

fn plain(text: &str) -> VarLenUnicode {
    text.parse().expect("the text has no NUL")
}

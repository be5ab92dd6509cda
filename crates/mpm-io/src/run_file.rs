//! The HDF5 file of a run while it grows.

use std::fs;
use std::mem;
use std::path::{Path, PathBuf};
use std::time::Duration;

use hdf5::plist::file_access::LibraryVersion;
use hdf5::plist::file_create::FileSpaceStrategy;
use hdf5::types::VarLenUnicode;
use hdf5::{Attribute, File, Group};
use mpm_solver::observe::{Column, ColumnKind, Outcome, RunStart, Timing};

use crate::error::{ResultsError, reason};
use crate::names::{PhaseName, RESULTS, RESULTS_VERSION, phase_name};
use crate::options::Options;
use crate::pending::{Batch, Values};
use crate::replace::{check_replaceable, fill, is_at, keep_from_writing, put_in_place};
use crate::rows::Rows;
use crate::vtkhdf::PointCloud;
use crate::xdmf::Xdmf;

/// Unit in which the file grows [bytes]: the page of the operating system, see [`crate::ResultsWriter`].
const PAGE: u64 = 4096;

/// The file of a run. After an error it is given up as it is on disk, as if the run had been killed.
pub(crate) struct RunFile {
    path: PathBuf,
    /// `None` once the file is closed or given up.
    open: Option<Open>,
    /// The same file, to see that there is room for what HDF5 is about to write; it holds the lock.
    room: fs::File,
}

struct Open {
    file: File,
    /// From the start of the run on.
    contents: Option<Contents>,
}

/// Everything that grows during a run.
struct Contents {
    history: Vec<Rows>,
    /// Attribute of `/history`: the rows that are complete.
    rows: Attribute,
    offset: Rows,
    residual: Rows,
    timings: [Rows; 3],
    cloud: PointCloud,
    xdmf: Xdmf,
}

impl RunFile {
    /// Creates the file; an existing one is replaced only if it can be.
    pub(crate) fn create(path: &Path, options: &Options) -> Result<Self, ResultsError> {
        let fail = |reason: &dyn ToString| ResultsError::create(path, reason.to_string());
        let text = |text: &str| text.parse::<VarLenUnicode>().map_err(|error| fail(&error));
        if options.compression > 9 {
            return Err(fail(&format!("compression {} is not in 0 to 9", options.compression)));
        }
        let (scene, program) = (text(&options.scene)?, text(&options.program)?);
        // Held until the lock is a shared one.
        let replaced = check_replaceable(path).map_err(|reason| fail(&reason))?;
        let file = create(path, &scene, &program).map_err(|error| fail(&reason(&error)))?;
        let room = match replaced {
            Some(room) => room,
            None => fs::OpenOptions::new().write(true).open(path).map_err(|error| fail(&error))?,
        };
        keep_from_writing(&room).map_err(|reason| fail(&reason))?;
        Ok(Self { path: path.into(), open: Some(Open { file, contents: None }), room })
    }

    /// Whether it has been neither closed nor given up.
    pub(crate) fn is_open(&self) -> bool {
        self.open.is_some()
    }

    /// Whether the run has started.
    pub(crate) fn has_started(&self) -> bool {
        self.open.as_ref().is_some_and(|open| open.contents.is_some())
    }

    /// Creates every dataset of a run whose results will lie at `path`.
    pub(crate) fn start(
        &mut self,
        start: &RunStart,
        options: &Options,
        path: &Path,
    ) -> Result<(), ResultsError> {
        let created = Contents::create(&self.open().file, start, options, path);
        let created = created.and_then(|created| self.flush().map(|()| created));
        self.open().contents = Some(created.map_err(|error| self.give_up("the layout of the run", &error))?);
        Ok(())
    }

    /// Makes `row` the first of the history.
    pub(crate) fn begin_at(&mut self, row: usize) -> Result<(), ResultsError> {
        let mut begin = || {
            if row > 0 {
                let history = self.open().file.group("history")?;
                history.new_attr::<i64>().create("first_row")?.write_scalar(&(row as i64))?;
            }
            self.flush()
        };
        begin().map_err(|error| self.give_up("the number of the first row", &error))
    }

    /// Hands load steps to HDF5; readers see them after the next [`Self::write`].
    pub(crate) fn append(&mut self, batch: &Batch, item: &str) -> Result<(), ResultsError> {
        self.contents().append(batch).map_err(|error| self.give_up(item, &error))
    }

    /// Writes load steps, then the counts that make them visible, and the XDMF file if that is wanted so long after the
    /// last time.
    pub(crate) fn write(
        &mut self,
        batch: &Batch,
        timings: Option<&[Timing]>,
        item: &str,
        xdmf_after: Option<Duration>,
    ) -> Result<(), ResultsError> {
        let mut write = || {
            if !is_at(&self.room, &self.path) {
                return Err("it was deleted or replaced by another program".into());
            }
            if let Some(timings) = timings {
                self.contents().write_timings(timings)?;
            }
            self.contents().append(batch)?;
            self.flush()?;
            self.contents().count()?;
            self.flush()
        };
        write().map_err(|error| self.give_up(item, &error))?;
        xdmf_after.map_or(Ok(()), |after| self.write_xdmf(item, after))
    }

    /// Waits until all that was written is on the disk.
    pub(crate) fn sync(&self) -> Result<(), ResultsError> {
        self.room.sync_all().map_err(|error| ResultsError::write(&self.path, "to the disk", error))
    }

    /// Takes the place of the file at `path`.
    pub(crate) fn take_place(&mut self, path: PathBuf) -> Result<(), ResultsError> {
        put_in_place(&self.path, &path)
            .map_err(|reason| ResultsError::write(&path, "the load steps so far", reason))?;
        self.path = path;
        Ok(())
    }

    /// Writes how the run ended and closes the file.
    pub(crate) fn close(&mut self, outcome: &Outcome, timings: &[Timing]) -> Result<(), ResultsError> {
        let status = match outcome {
            Outcome::Completed => "completed".to_owned(),
            Outcome::Failed(reason) => format!("failed: {}", reason.replace('\0', " ")),
        };
        let mut close = || {
            if let Some(contents) = &mut self.open().contents {
                contents.write_timings(timings)?;
            }
            self.open().file.attr("status")?.write_scalar(&plain(&status))?;
            self.flush()?;
            let Some(Open { file, contents }) = self.open.take() else { return Ok(()) };
            drop(contents);
            file.close()
        };
        close().map_err(|error| self.give_up("the outcome", &error))
    }

    fn open(&mut self) -> &mut Open {
        self.open.as_mut().expect("a run is not observed after its end")
    }

    fn contents(&mut self) -> &mut Contents {
        self.open().contents.as_mut().expect("a run starts before its first load step")
    }

    /// Extends the file to the length that its header will promise, then flushes.
    ///
    /// If the length is not to be had (a limit on the size of files), HDF5 would find out after
    /// it has written the header, and readers refuse a file that is shorter than promised.
    fn flush(&mut self) -> hdf5::Result<()> {
        let promised = self.open().file.size();
        let length = self.room.metadata().map_err(|error| error.to_string())?.len();
        if length < promised {
            // Zeros take up space on the disk, which a greater length alone would not.
            let filled = fill(&self.room, length, promised);
            filled.map_err(|error| error.to_string())?;
        }
        self.open().file.flush()
    }

    /// Writes the XDMF file where recorded steps have come, so long after the last time.
    pub(crate) fn write_xdmf(&mut self, item: &str, after: Duration) -> Result<(), ResultsError> {
        let xdmf = &mut self.contents().xdmf;
        let is_last = after.is_zero() && xdmf.is_behind();
        if !is_last && !xdmf.is_due(after) {
            return Ok(());
        }
        let written = xdmf.write().map_err(|error| ResultsError::write(xdmf.path(), item, error));
        if written.is_err() {
            // Where a small file has no room, the end of the results may have none.
            mem::forget(self.open.take());
        }
        written
    }

    /// Reports an error and gives the file up as it is on disk.
    ///
    /// Closing would make HDF5 write the rest of its metadata, on a full disk some of it, and
    /// could leave a file whose header promises more than was stored.
    fn give_up(&mut self, item: &str, error: &hdf5::Error) -> ResultsError {
        mem::forget(self.open.take());
        ResultsError::write(&self.path, item, reason(error))
    }
}

fn create(path: &Path, scene: &VarLenUnicode, program: &VarLenUnicode) -> hdf5::Result<File> {
    hdf5::silence_errors(true);
    let file = File::with_options()
        .with_fapl(|access| access.libver_v18().file_locking(false))
        .with_fcpl(|create| {
            let pages = FileSpaceStrategy::FreeSpaceManager { paged: true, persist: false, threshold: 1 };
            create.obj_track_times(false).file_space_strategy(pages).file_space_page_size(PAGE)
        })
        .create(path)?;
    file.new_attr::<VarLenUnicode>().create("format")?.write_scalar(&plain(RESULTS))?;
    file.new_attr::<i64>().create("version")?.write_scalar(&RESULTS_VERSION)?;
    file.new_attr::<VarLenUnicode>().create("scene")?.write_scalar(scene)?;
    file.new_attr::<VarLenUnicode>().create("program")?.write_scalar(program)?;
    file.new_attr::<VarLenUnicode>().create("status")?.write_scalar(&plain("running"))?;
    file.close()?;
    // Opened anew, the file keeps its superblock 2 but new datasets get 1.10's indices.
    File::with_options()
        .with_fapl(|access| {
            access.libver_bounds(LibraryVersion::V110, LibraryVersion::latest()).file_locking(false)
        })
        .open_rw(path)
}

impl Contents {
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
        Ok(Self {
            history: start.columns.iter().map(create_column).collect::<hdf5::Result<_>>()?,
            rows,
            offset: Rows::create_small::<u64>(&newton, "offset", 1)?,
            residual: Rows::create_small::<f64>(&newton, "residual", 1)?,
            timings: [
                Rows::create_small::<PhaseName>(&timings, "phase", 1)?,
                Rows::create_small::<f64>(&timings, "seconds", 1)?,
                Rows::create_small::<u64>(&timings, "count", 1)?,
            ],
            cloud: PointCloud::create(file, (start.space, start.points), options)?,
            xdmf: Xdmf::beside(path, options),
        })
    }

    fn append(&mut self, batch: &Batch) -> hdf5::Result<()> {
        for (rows, values) in self.history.iter_mut().zip(&batch.columns) {
            match values {
                Values::Count(values) => rows.append(values)?,
                Values::Real(values) => rows.append(values)?,
            };
        }
        let before = self.residual.len() as u64;
        self.residual.append(&batch.residuals)?;
        self.offset.append(&batch.ends.iter().map(|end| before + end).collect::<Vec<_>>())?;
        for (placed, snapshot) in self.cloud.append(&batch.snapshots)?.iter().zip(&batch.snapshots) {
            self.xdmf.add(snapshot.fraction, snapshot.positions.len() / 3, placed);
        }
        Ok(())
    }

    /// Counts what was appended, once it is on disk.
    fn count(&self) -> hdf5::Result<()> {
        self.rows.write_scalar(&(self.offset.len() as i64))?;
        self.cloud.count()
    }

    fn write_timings(&mut self, timings: &[Timing]) -> hdf5::Result<()> {
        let [phase, seconds, count] = &mut self.timings;
        phase.replace(&timings.iter().map(|t| phase_name(t.phase)).collect::<Vec<_>>())?;
        seconds.replace(&timings.iter().map(|t| t.seconds).collect::<Vec<_>>())?;
        count.replace(&timings.iter().map(|t| t.count).collect::<Vec<_>>())
    }
}

fn plain(text: &str) -> VarLenUnicode {
    text.parse().expect("the text has no NUL")
}

//! Reads a results file back.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use hdf5::File;
use mpm_solver::observe::{Column, Space};

use crate::calls::{Call, Closing};
use crate::error::{ResultsError, reason};
use crate::in_plane::InPlane;
use crate::names::{CHECKPOINT, PhaseName, RESULTS, RESULTS_VERSION};
use crate::source::Source;
use crate::spaces;
use crate::vtkhdf::{COMPONENTS, ComponentNames, Unit};

/// Numbers in rows of equal width.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    width: usize,
    values: Vec<f64>,
}

impl Table {
    /// A number per row.
    pub(crate) fn scalars(values: Vec<f64>) -> Self {
        Self::new(1, values)
    }

    /// Rows of `width` numbers, one after the other.
    pub(crate) fn new(width: usize, values: Vec<f64>) -> Self {
        Self { width, values }
    }

    /// Numbers per row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.values.len() / self.width
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// One row.
    ///
    /// # Panics
    /// If there is no such row.
    pub fn row(&self, row: usize) -> &[f64] {
        &self.values[row * self.width..(row + 1) * self.width]
    }

    /// All rows, one after the other.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// All rows, one after the other, without a copy.
    pub fn into_values(self) -> Vec<f64> {
        self.values
    }
}

/// Time spent in one phase of the run.
#[derive(Clone, Debug, PartialEq)]
pub struct PhaseTime {
    /// Name of the phase.
    pub phase: String,
    /// Wall seconds.
    pub seconds: f64,
    /// Times the phase was entered.
    pub count: u64,
}

/// A results file opened for reading, of a finished, running or killed run.
#[derive(Debug)]
pub struct Results {
    path: PathBuf,
    file: Closing,
    scene: String,
    space: Space,
    program: String,
    status: String,
    columns: Vec<Column>,
    first_row: usize,
    rows: usize,
    offset: Vec<u64>,
    fractions: Vec<f64>,
    parts: Vec<i64>,
    part_points: Vec<i64>,
}

impl Results {
    /// Opens a results file and checks its format and version.
    ///
    /// # Errors
    /// [`ResultsError::Open`] if HDF5 cannot open it, [`ResultsError::Malformed`] if it is no
    /// results file of version 1.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, ResultsError> {
        let path = path.as_ref().to_path_buf();
        hdf5::silence_errors(true);
        let head = fs::File::open(&path).and_then(|file| {
            let mut head = Vec::new();
            file.take(CHECKPOINT.len() as u64).read_to_end(&mut head).map(|_| head)
        });
        if head.map_err(|error| ResultsError::open(&path, error))? == CHECKPOINT.as_bytes() {
            return Err(ResultsError::open(
                &path,
                "it is a checkpoint, from which a run goes on: `mpm resume`",
            ));
        }
        let _call = Call::begin();
        // A run that writes the file keeps others out of writing only, and is not to be kept out by its readers.
        let file = File::with_options().with_fapl(|access| access.file_locking(false)).open(&path);
        let file = file.map_err(|error| ResultsError::open(&path, reason(&error)))?;
        let file = Closing::new(file);
        let source = Source { path: &path };

        let format = source.text(&file, "format")?;
        if format != RESULTS {
            return Err(source.malformed("format", format!("is {format:?}, not {RESULTS:?}")));
        }
        let version = file.attr("version").and_then(|version| version.read_scalar::<i64>());
        let version = version.map_err(|error| source.malformed("version", reason(&error)))?;
        if version != RESULTS_VERSION {
            return Err(
                source.malformed("version", format!("is {version}; this program reads {RESULTS_VERSION}"))
            );
        }
        let scene = source.text(&file, "scene")?;
        let program = source.text(&file, "program")?;
        let space = spaces::read(&file, &source)?;
        // On a full disk a run may have failed to say how it ended.
        let status = source.text(&file, "status").unwrap_or_else(|_| "running".into());

        // A run that never started has no groups yet.
        let started = file.link_exists("VTKHDF");
        let mut columns = Vec::new();
        let (mut first_row, mut rows, mut offset) = (0, 0, Vec::new());
        let (mut fractions, mut parts, mut part_points) = (Vec::new(), Vec::new(), Vec::new());
        if started {
            // A killed run can leave more than it counted: never look there.
            let history = source.group(&file, "history")?;
            rows = source.count(&history, "rows")?;
            // Only where a run went on without the file of its beginning.
            if history.attr("first_row").is_ok() {
                first_row = source.count(&history, "first_row")?;
            }
            source.find_columns(&history, "", &mut columns)?;
            columns.sort_by(|a, b| a.name.cmp(&b.name));
            offset = source.slice(&file, "newton/offset", 0, rows)?.1;
            let steps = source.count(&source.group(&file, "VTKHDF/Steps")?, "NSteps")?;
            fractions = source.slice(&file, "VTKHDF/Steps/Values", 0, steps)?.1;
            parts = source.slice(&file, "VTKHDF/Steps/PartOffsets", 0, steps)?.1;
            let n_parts = parts
                .iter()
                .max()
                .map_or(0, |&last: &i64| usize::try_from(last).unwrap_or(0).saturating_add(1));
            part_points = source.slice(&file, "VTKHDF/NumberOfPoints", 0, n_parts)?.1;
        }
        Ok(Self {
            path,
            file,
            scene,
            space,
            program,
            status,
            columns,
            first_row,
            rows,
            offset,
            fractions,
            parts,
            part_points,
        })
    }

    /// Text of the scene.
    pub fn scene(&self) -> &str {
        &self.scene
    }

    /// The space of the bodies, which says what coordinates and components are.
    pub fn space(&self) -> Space {
        self.space
    }

    /// Name and version of the program that wrote the file.
    pub fn program(&self) -> &str {
        &self.program
    }

    /// `running` (also of a killed run, and where the disk had no room for more), `completed` or `failed: <reason>`.
    pub fn status(&self) -> &str {
        &self.status
    }

    /// Columns of the history, by name.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Rows of the history: the initial state and one per converged load step.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of the load step of row 0: above 0 where a run went on without the file of its beginning.
    pub fn first_row(&self) -> usize {
        self.first_row
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    pub(crate) fn file(&self) -> &File {
        &self.file
    }

    /// All rows of a history column; counts come as reals (exact below 2⁵³).
    ///
    /// # Errors
    /// [`ResultsError::Missing`] for an unknown name.
    pub fn column(&self, name: &str) -> Result<Table, ResultsError> {
        let column = self.columns.iter().find(|column| column.name == name);
        let column =
            column.ok_or_else(|| ResultsError::missing(&self.path, format!("history column {name:?}")))?;
        self.table(&format!("history/{name}"), 0, self.rows, column.width)
    }

    /// Relative out-of-balance force of every iterate of the load step of a row, first to last.
    ///
    /// # Errors
    /// [`ResultsError::Missing`] for a row that does not exist.
    pub fn residuals(&self, row: usize) -> Result<Vec<f64>, ResultsError> {
        if row >= self.rows {
            return Err(ResultsError::missing(&self.path, format!("row {row}")));
        }
        let first = if row == 0 { 0 } else { self.offset[row - 1] };
        let n = self.offset[row]
            .checked_sub(first)
            .ok_or_else(|| self.source().malformed("newton/offset", format!("decreases at row {row}")))?;
        Ok(self.table("newton/residual", first as usize, n as usize, 1)?.values)
    }

    /// Time spent per phase since the start of the run.
    ///
    /// # Errors
    /// [`ResultsError::Malformed`] if the datasets are not what they should be.
    pub fn timings(&self) -> Result<Vec<PhaseTime>, ResultsError> {
        let _call = Call::begin();
        if !self.file.link_exists("timings") {
            return Ok(Vec::new());
        }
        let phases = self.source().vector::<PhaseName>(&self.file, "timings/phase")?;
        let seconds = self.source().vector::<f64>(&self.file, "timings/seconds")?;
        let counts = self.source().vector::<u64>(&self.file, "timings/count")?;
        let rows = phases.iter().zip(seconds).zip(counts);
        let rows = rows.map(|((phase, seconds), count)| {
            // Stored bytes need not be the UTF-8 that their type says.
            PhaseTime { phase: String::from_utf8_lossy(phase.as_bytes()).into_owned(), seconds, count }
        });
        Ok(rows.collect())
    }

    /// Load fractions of the recorded steps; their indices are the `step` of the methods below.
    pub fn fractions(&self) -> &[f64] {
        &self.fractions
    }

    /// Positions of the material points at a recorded step, three numbers per point \[L\].
    ///
    /// # Errors
    /// [`ResultsError::Missing`] for a step that was not recorded.
    pub fn points(&self, step: usize) -> Result<Table, ResultsError> {
        self.at_step("VTKHDF/Points", "VTKHDF/Steps/PointOffsets", step)
    }

    /// Names of the recorded fields, sorted.
    ///
    /// # Errors
    /// [`ResultsError::Malformed`] if the group cannot be listed.
    pub fn fields(&self) -> Result<Vec<String>, ResultsError> {
        let _call = Call::begin();
        if !self.file.link_exists("VTKHDF") {
            return Ok(Vec::new());
        }
        let names = self.source().group(&self.file, "VTKHDF/PointData")?.member_names();
        let mut names = names.map_err(|error| self.source().malformed("VTKHDF/PointData", reason(&error)))?;
        names.sort();
        Ok(names)
    }

    /// Unit of a field's values in length L, force F and time T; `?` where the file does not say it.
    ///
    /// # Errors
    /// [`ResultsError::Missing`] for an unknown field.
    pub fn unit(&self, field: &str) -> Result<String, ResultsError> {
        if !self.fields()?.iter().any(|known| known == field) {
            return Err(ResultsError::missing(&self.path, format!("field {field:?}")));
        }
        let _call = Call::begin();
        let values = self.file.dataset(&format!("VTKHDF/PointData/{field}"));
        let unit = values.and_then(|values| values.attr("unit")).and_then(|unit| unit.read_scalar::<Unit>());
        Ok(unit.map_or_else(|_| "?".to_owned(), |unit| unit.to_string()))
    }

    /// Values of a field at a recorded step, one row per point with all its components, also where fewer are stored.
    ///
    /// # Errors
    /// [`ResultsError::Missing`] for an unknown field or a step that was not recorded.
    pub fn field(&self, name: &str, step: usize) -> Result<Table, ResultsError> {
        if !self.fields()?.iter().any(|field| field == name) {
            return Err(ResultsError::missing(&self.path, format!("field {name:?}")));
        }
        let (item, offsets) =
            (format!("VTKHDF/PointData/{name}"), format!("VTKHDF/Steps/PointDataOffsets/{name}"));
        let table = self.at_step(&item, &offsets, step)?;
        let Some(stored) = self.stored_components(&item)? else { return Ok(table) };
        if table.width != stored.width() {
            let reason = format!("has {} numbers per point, not {}", table.width, stored.width());
            return Err(self.source().malformed(&item, reason));
        }
        Ok(Table { width: stored.all(), values: stored.expand(&table.values) })
    }

    /// Which components of a field are stored, where not all are.
    fn stored_components(&self, item: &str) -> Result<Option<&'static InPlane>, ResultsError> {
        let _call = Call::begin();
        let Ok(attribute) = self.file.dataset(item).and_then(|values| values.attr(COMPONENTS)) else {
            return Ok(None);
        };
        let item = format!("{item}@{COMPONENTS}");
        let names = attribute.read_scalar::<ComponentNames>();
        let names = names.map_err(|error| self.source().malformed(&item, reason(&error)))?;
        let names = String::from_utf8_lossy(names.as_bytes());
        let stored = InPlane::named(&names);
        stored.map(Some).ok_or_else(|| self.source().malformed(&item, format!("is {names:?}")))
    }

    fn at_step(&self, name: &str, offsets: &str, step: usize) -> Result<Table, ResultsError> {
        if step >= self.fractions.len() {
            return Err(ResultsError::missing(&self.path, format!("recorded step {step}")));
        }
        let outside = |item: &str| self.source().malformed(item, format!("has no valid entry for step {step}"));
        let part = usize::try_from(self.parts[step]).ok();
        let points = part.and_then(|part| self.part_points.get(part)).and_then(|&n| usize::try_from(n).ok());
        let points = points.ok_or_else(|| outside("VTKHDF/NumberOfPoints"))?;
        let offset = self.source().slice::<i64>(&self.file, offsets, step, 1)?.1[0];
        let first = usize::try_from(offset).map_err(|_| outside(offsets))?;
        let (width, values) = self.source().slice::<f64>(&self.file, name, first, points)?;
        Ok(Table { width, values })
    }

    fn table(&self, name: &str, first: usize, rows: usize, width: usize) -> Result<Table, ResultsError> {
        let (stored, values) = self.source().slice::<f64>(&self.file, name, first, rows)?;
        if stored != width {
            return Err(self.source().malformed(name, format!("has {stored} numbers per row, not {width}")));
        }
        Ok(Table { width, values })
    }

    fn source(&self) -> Source<'_> {
        Source { path: &self.path }
    }
}

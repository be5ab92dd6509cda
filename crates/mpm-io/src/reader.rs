//! Reads a results file back.

use std::fs;
use std::path::{Path, PathBuf};

use hdf5::types::{FloatSize, IntSize, TypeDescriptor, VarLenUnicode};
use hdf5::{Dataset, File, Group, H5Type};
use mpm_solver::observe::{Column, ColumnKind};

use crate::error::{ResultsError, reason};
use crate::writer::PhaseName;
use crate::{FORMAT, VERSION};

/// Numbers in rows of equal width.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    width: usize,
    values: Vec<f64>,
}

impl Table {
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
    file: File,
    scene: String,
    program: String,
    status: String,
    columns: Vec<Column>,
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
        fs::File::open(&path).map_err(|error| ResultsError::open(&path, error))?;
        let file = File::open(&path).map_err(|error| ResultsError::open(&path, reason(&error)))?;
        let source = Source { path: &path };

        let format = source.text(&file, "format")?;
        if format != FORMAT {
            return Err(source.malformed("format", format!("is {format:?}, not {FORMAT:?}")));
        }
        let version = file.attr("version").and_then(|version| version.read_scalar::<i64>());
        let version = version.map_err(|error| source.malformed("version", reason(&error)))?;
        if version != VERSION {
            return Err(source.malformed("version", format!("is {version}; this program reads {VERSION}")));
        }
        let scene = source.text(&file, "scene")?;
        let program = source.text(&file, "program")?;
        let status = source.text(&file, "status")?;

        // A run that never started has no groups yet.
        let started = file.link_exists("VTKHDF");
        let mut columns = Vec::new();
        let (mut rows, mut offset) = (0, Vec::new());
        let (mut fractions, mut parts, mut part_points) = (Vec::new(), Vec::new(), Vec::new());
        if started {
            // A killed run can leave more than it counted: never look there.
            let history = source.group(&file, "history")?;
            rows = source.count(&history, "rows")?;
            source.find_columns(&history, "", &mut columns)?;
            columns.sort_by(|a, b| a.name.cmp(&b.name));
            offset = source.slice(&file, "newton/offset", 0, rows)?.1;
            let steps = source.count(&source.group(&file, "VTKHDF/Steps")?, "NSteps")?;
            fractions = source.slice(&file, "VTKHDF/Steps/Values", 0, steps)?.1;
            parts = source.slice(&file, "VTKHDF/Steps/PartOffsets", 0, steps)?.1;
            let n_parts = parts.iter().max().map_or(0, |&last: &i64| usize::try_from(last).unwrap_or(0) + 1);
            part_points = source.slice(&file, "VTKHDF/NumberOfPoints", 0, n_parts)?.1;
        }
        Ok(Self { path, file, scene, program, status, columns, rows, offset, fractions, parts, part_points })
    }

    /// Text of the scene.
    pub fn scene(&self) -> &str {
        &self.scene
    }

    /// Name and version of the program that wrote the file.
    pub fn program(&self) -> &str {
        &self.program
    }

    /// `running` (also of a killed run), `completed` or `failed: <reason>`.
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

    /// All rows of a history column; counts come as reals (exact below 2⁵³).
    ///
    /// # Errors
    /// [`ResultsError::Missing`] for an unknown name.
    pub fn column(&self, name: &str) -> Result<Table, ResultsError> {
        let column = self.columns.iter().find(|column| column.name == name);
        let column = column.ok_or_else(|| ResultsError::missing(&self.path, format!("history column {name:?}")))?;
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
        let n = self.offset[row].checked_sub(first).ok_or_else(|| {
            self.source().malformed("newton/offset", format!("decreases at row {row}"))
        })?;
        Ok(self.table("newton/residual", first as usize, n as usize, 1)?.values)
    }

    /// Time spent per phase since the start of the run.
    ///
    /// # Errors
    /// [`ResultsError::Malformed`] if the datasets are not what they should be.
    pub fn timings(&self) -> Result<Vec<PhaseTime>, ResultsError> {
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

    /// Positions of the material points at a recorded step, three numbers per point [L].
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
        if !self.file.link_exists("VTKHDF") {
            return Ok(Vec::new());
        }
        let names = self.source().group(&self.file, "VTKHDF/PointData")?.member_names();
        let mut names = names.map_err(|error| self.source().malformed("VTKHDF/PointData", reason(&error)))?;
        names.sort();
        Ok(names)
    }

    /// Values of a field at a recorded step, one row per point.
    ///
    /// # Errors
    /// [`ResultsError::Missing`] for an unknown field or a step that was not recorded.
    pub fn field(&self, name: &str, step: usize) -> Result<Table, ResultsError> {
        if !self.fields()?.iter().any(|field| field == name) {
            return Err(ResultsError::missing(&self.path, format!("field {name:?}")));
        }
        let offsets = format!("VTKHDF/Steps/PointDataOffsets/{name}");
        self.at_step(&format!("VTKHDF/PointData/{name}"), &offsets, step)
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

/// Reads with checks; knows the path for its errors.
struct Source<'a> {
    path: &'a Path,
}

impl Source<'_> {
    fn malformed(&self, item: &str, reason: impl ToString) -> ResultsError {
        ResultsError::malformed(self.path, item, reason)
    }

    fn text(&self, file: &File, name: &str) -> Result<String, ResultsError> {
        let text = file.attr(name).and_then(|attribute| attribute.read_scalar::<VarLenUnicode>());
        let text = text.map_err(|error| self.malformed(name, reason(&error)))?;
        Ok(String::from_utf8_lossy(text.as_bytes()).into_owned())
    }

    fn count(&self, group: &Group, name: &str) -> Result<usize, ResultsError> {
        let count = group.attr(name).and_then(|attribute| attribute.read_scalar::<i64>());
        let count = count.map_err(|error| self.malformed(name, reason(&error)))?;
        usize::try_from(count).map_err(|_| self.malformed(name, format!("is {count}")))
    }

    fn group(&self, file: &File, name: &str) -> Result<Group, ResultsError> {
        file.group(name).map_err(|error| self.malformed(name, reason(&error)))
    }

    /// Columns below `group`.
    fn find_columns(
        &self,
        group: &Group,
        prefix: &str,
        found: &mut Vec<Column>,
    ) -> Result<(), ResultsError> {
        const DEEPEST: usize = 8; // links of a hostile file can form a ring
        if prefix.matches('/').count() > DEEPEST {
            return Err(self.malformed("history", "is nested too deeply"));
        }
        let names = group.member_names().map_err(|error| self.malformed("history", reason(&error)))?;
        for name in names {
            let path = format!("{prefix}{name}");
            if let Ok(below) = group.group(&name) {
                self.find_columns(&below, &format!("{path}/"), found)?;
                continue;
            }
            let item = format!("history/{path}");
            let dataset = group.dataset(&name).map_err(|error| self.malformed(&item, reason(&error)))?;
            let kind = dataset.dtype().and_then(|kind| kind.to_descriptor());
            let kind = match kind.map_err(|error| self.malformed(&item, reason(&error)))? {
                TypeDescriptor::Unsigned(IntSize::U8) => ColumnKind::Count,
                TypeDescriptor::Float(FloatSize::U8) => ColumnKind::Real,
                other => return Err(self.malformed(&item, format!("holds {other}, not u64 or f64"))),
            };
            let (_, width) = self.shape(&dataset, &item)?;
            found.push(Column { name: path, kind, width });
        }
        Ok(())
    }

    /// Rows and width of a dataset, after a check that the file can hold that much.
    fn shape(&self, dataset: &Dataset, item: &str) -> Result<(usize, usize), ResultsError> {
        let (rows, width) = match dataset.shape()[..] {
            [rows] => (rows, 1),
            [rows, width] if width > 0 => (rows, width),
            ref shape => return Err(self.malformed(item, format!("has shape {shape:?}"))),
        };
        // Deflate shrinks at most 1032 times, and every chunk of an honest file is stored.
        const MOST_EXPANSION: u64 = 1032;
        const SLACK: u64 = 1 << 16; // a killed run: the last row is counted, its chunk is not
        let size = dataset.dtype().map_err(|error| self.malformed(item, reason(&error)))?.size();
        let bytes = rows.checked_mul(width).and_then(|n| n.checked_mul(size)).map(|n| n as u64);
        match bytes {
            Some(bytes) if bytes / MOST_EXPANSION <= dataset.storage_size() + SLACK => Ok((rows, width)),
            _ => Err(self.malformed(item, format!("claims {rows} rows, more than the file holds"))),
        }
    }

    fn vector<T: H5Type + Clone>(&self, file: &File, name: &str) -> Result<Vec<T>, ResultsError> {
        let dataset = file.dataset(name).map_err(|error| self.malformed(name, reason(&error)))?;
        match self.shape(&dataset, name)? {
            (rows, 1) => Ok(self.slice(file, name, 0, rows)?.1),
            (_, width) => Err(self.malformed(name, format!("has {width} numbers per row, not 1"))),
        }
    }

    /// Rows `first..first + rows` of a dataset, and their width.
    fn slice<T: H5Type + Clone>(
        &self,
        file: &File,
        name: &str,
        first: usize,
        rows: usize,
    ) -> Result<(usize, Vec<T>), ResultsError> {
        let dataset = file.dataset(name).map_err(|error| self.malformed(name, reason(&error)))?;
        let (stored, width) = self.shape(&dataset, name)?;
        let end = first.checked_add(rows).filter(|&end| end <= stored);
        let end = end.ok_or_else(|| {
            self.malformed(name, format!("has {stored} rows; {rows} from row {first} on are needed"))
        })?;
        let values = if dataset.ndim() == 1 {
            dataset.read_slice_1d::<T, _>(first..end).map(|array| array.into_raw_vec_and_offset().0)
        } else {
            dataset.read_slice_2d::<T, _>((first..end, ..)).map(|array| array.into_raw_vec_and_offset().0)
        };
        Ok((width, values.map_err(|error| self.malformed(name, reason(&error)))?))
    }
}

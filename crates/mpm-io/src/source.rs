//! Reads parts of an HDF5 file that may hold anything, with checks before every allocation.

use std::path::Path;

use hdf5::types::{FloatSize, IntSize, TypeDescriptor, VarLenUnicode};
use hdf5::{Dataset, File, Group, H5Type};
use mpm_solver::observe::{Column, ColumnKind};

use crate::calls::Call;
use crate::error::{ResultsError, reason};

/// The path, for errors.
pub(crate) struct Source<'a> {
    pub(crate) path: &'a Path,
}

impl Source<'_> {
    /// An error about one part of the file.
    pub(crate) fn malformed(&self, item: &str, reason: impl ToString) -> ResultsError {
        ResultsError::malformed(self.path, item, reason)
    }

    /// A text attribute of the root.
    pub(crate) fn text(&self, file: &File, name: &str) -> Result<String, ResultsError> {
        let _call = Call::begin();
        let text = file.attr(name).and_then(|attribute| attribute.read_scalar::<VarLenUnicode>());
        let text = text.map_err(|error| self.malformed(name, reason(&error)))?;
        Ok(String::from_utf8_lossy(text.as_bytes()).into_owned())
    }

    /// An attribute that counts something.
    pub(crate) fn count(&self, group: &Group, name: &str) -> Result<usize, ResultsError> {
        let _call = Call::begin();
        let count = group.attr(name).and_then(|attribute| attribute.read_scalar::<i64>());
        let count = count.map_err(|error| self.malformed(name, reason(&error)))?;
        usize::try_from(count).map_err(|_| self.malformed(name, format!("is {count}")))
    }

    /// A group by its path.
    pub(crate) fn group(&self, file: &File, name: &str) -> Result<Group, ResultsError> {
        let _call = Call::begin();
        file.group(name).map_err(|error| self.malformed(name, reason(&error)))
    }

    /// Columns below `group`.
    pub(crate) fn find_columns(
        &self,
        group: &Group,
        prefix: &str,
        found: &mut Vec<Column>,
    ) -> Result<(), ResultsError> {
        const DEEPEST: usize = 8; // links of a hostile file can form a ring
        if prefix.matches('/').count() > DEEPEST {
            return Err(self.malformed("history", "is nested too deeply"));
        }
        let _call = Call::begin();
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
    pub(crate) fn shape(&self, dataset: &Dataset, item: &str) -> Result<(usize, usize), ResultsError> {
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

    /// All of a dataset with one number per row.
    pub(crate) fn vector<T: H5Type + Clone>(&self, file: &File, name: &str) -> Result<Vec<T>, ResultsError> {
        let _call = Call::begin();
        let dataset = file.dataset(name).map_err(|error| self.malformed(name, reason(&error)))?;
        match self.shape(&dataset, name)? {
            (rows, 1) => Ok(self.slice(file, name, 0, rows)?.1),
            (_, width) => Err(self.malformed(name, format!("has {width} numbers per row, not 1"))),
        }
    }

    /// Rows `first..first + rows` of a dataset, and their width.
    pub(crate) fn slice<T: H5Type + Clone>(
        &self,
        file: &File,
        name: &str,
        first: usize,
        rows: usize,
    ) -> Result<(usize, Vec<T>), ResultsError> {
        let _call = Call::begin();
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

//! The results of an interrupted run up to the checkpoint from which it is resumed.

use mpm_solver::observe::{Column, ColumnKind, Entry, Field};

use crate::error::ResultsError;
use crate::reader::Results;
use crate::snapshot::Snapshot;
use crate::source::Source;

/// A results file whose rows up to the checkpoint, and the points recorded at them, are copied.
pub(crate) struct Earlier {
    results: Results,
    /// Number of its first row.
    first: usize,
    /// Number of the first row that is not copied.
    end: usize,
    /// Its rows with points, ascending.
    recorded: Vec<usize>,
    counts: Vec<Option<Vec<u64>>>,
    reals: Vec<Option<Vec<f64>>>,
}

impl Earlier {
    /// Checks that the file holds the rows of these columns and the points that belong to them. If columns may be missing,
    /// they are taken to hold zeros.
    pub(crate) fn of(
        results: Results,
        (columns, may_lack): (&[Column], bool),
        fields: &[Field],
        is_recorded: &dyn Fn(usize, f64) -> bool,
        end: usize,
    ) -> Result<Self, ResultsError> {
        let path = results.path().to_path_buf();
        let source = Source { path: &path };
        let mut expected = columns.to_vec();
        expected.retain(|column| !may_lack || results.columns().contains(column));
        expected.sort_by(|a, b| a.name.cmp(&b.name));
        if results.columns() != expected {
            return Err(source.malformed("history", "its columns are not those of the scene"));
        }
        let mut names: Vec<&str> = fields.iter().map(|field| field.name()).collect();
        names.sort_unstable();
        if results.fields()? != names {
            return Err(
                source.malformed("VTKHDF/PointData", format!("its fields are not {}", names.join(", ")))
            );
        }
        let first = results.first_row();
        let rows = first.saturating_add(results.rows());
        if rows < end || first > end {
            let reason = format!("holds rows {first} up to {rows}, expected all up to {end} of the checkpoint");
            return Err(source.malformed("history", reason));
        }
        let file = results.file();
        let n = end - first;
        let (mut counts, mut reals) = (Vec::new(), Vec::new());
        for column in columns {
            let item = format!("history/{}", column.name);
            let zeros = n * column.width;
            let (count, real) = match column.kind {
                ColumnKind::Count if !expected.contains(column) => (Some(vec![0; zeros]), None),
                ColumnKind::Real if !expected.contains(column) => (None, Some(vec![0.0; zeros])),
                ColumnKind::Count => (Some(source.slice::<u64>(file, &item, 0, n)?.1), None),
                ColumnKind::Real => (None, Some(source.slice::<f64>(file, &item, 0, n)?.1)),
            };
            counts.push(count);
            reals.push(real);
        }
        // The recorded points must belong to the load fractions of their rows.
        let fraction = columns.iter().position(|column| column.name == "load_fraction");
        let fractions = fraction.and_then(|at| reals[at].as_ref());
        let fraction = |row: usize| fractions.and_then(|it| it.get(row - first)).copied();
        let recorded: Vec<usize> =
            (first..end).filter(|&row| is_recorded(row, fraction(row).unwrap_or(f64::NAN))).collect();
        for (k, &row) in recorded.iter().enumerate() {
            let found = results.fractions().get(k).copied();
            let of_row = fraction(row);
            if found.is_none() || (of_row.is_some() && of_row != found) {
                let reason = format!("is {found:?} at {k}, expected {of_row:?}, that of row {row}");
                return Err(source.malformed("VTKHDF/Steps/Values", reason));
            }
        }
        Ok(Self { results, first, end, recorded, counts, reals })
    }

    /// Number of the first row.
    pub(crate) fn first(&self) -> usize {
        self.first
    }

    /// Numbers of the rows to copy.
    pub(crate) fn rows(&self) -> std::ops::Range<usize> {
        self.first..self.end
    }

    /// Entries and residuals of a row.
    pub(crate) fn row(&self, row: usize) -> Result<(Vec<Entry>, Vec<f64>), ResultsError> {
        let k = row - self.first;
        let n = self.end - self.first;
        let entries = self.counts.iter().zip(&self.reals).map(|(counts, reals)| match (counts, reals) {
            (Some(counts), _) => {
                Entry::Count(counts[k * counts.len() / n..(k + 1) * counts.len() / n].to_vec())
            }
            (None, Some(reals)) => Entry::Real(reals[k * reals.len() / n..(k + 1) * reals.len() / n].to_vec()),
            (None, None) => Entry::Real(Vec::new()),
        });
        Ok((entries.collect(), self.results.residuals(k)?))
    }

    /// The points at a row, if they are recorded there.
    pub(crate) fn snapshot(&self, row: usize, fields: &[Field]) -> Result<Option<Snapshot>, ResultsError> {
        let Ok(before) = self.recorded.binary_search(&row) else { return Ok(None) };
        let path = self.results.path();
        let shaped = |item: &str, table: crate::Table, width: usize| {
            if table.width() != width {
                let reason = format!("has {} numbers per point, expected {width}", table.width());
                return Err(ResultsError::malformed(path, item, reason));
            }
            Ok(table.into_values())
        };
        let positions = shaped("VTKHDF/Points", self.results.points(before)?, 3)?;
        let values = fields.iter().map(|field| {
            let item = format!("VTKHDF/PointData/{}", field.name());
            shaped(&item, self.results.field(field.name(), before)?, field.components())
        });
        let fields = values.collect::<Result<_, _>>()?;
        Ok(Some(Snapshot { fraction: self.results.fractions()[before], positions, fields }))
    }
}

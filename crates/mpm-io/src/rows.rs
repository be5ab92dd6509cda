//! A dataset that grows by rows.

use hdf5::{Dataset, Group, H5Type};
use ndarray::ArrayView2;

/// A chunked dataset of shape `[rows]` (width 1) or `[rows, width]`, unlimited in its rows.
pub(crate) struct Rows {
    dataset: Dataset,
    len: usize,
    width: usize,
    chunk: usize,
    compressed: bool,
}

impl Rows {
    /// Creates the dataset, empty; `level` 0 stores plainly, 1 to 9 with shuffle and gzip.
    pub(crate) fn create<T: H5Type>(
        group: &Group,
        name: &str,
        width: usize,
        chunk: usize,
        level: u8,
    ) -> hdf5::Result<Self> {
        let chunk = chunk.max(1);
        // Without a cache of chunks, rows take their place in the file at once, not at a flush.
        // Times of change are not wanted: they would make every write a change of the header.
        let mut builder = group.new_dataset::<T>().chunk_cache(1, 0, 1.0).obj_track_times(false);
        if level > 0 {
            builder = builder.shuffle().deflate(level);
        }
        let dataset = match width {
            1 => builder.chunk(chunk).shape((0..,)).create(name)?,
            _ => builder.chunk((chunk, width)).shape((0.., width)).create(name)?,
        };
        Ok(Self { dataset, len: 0, width, chunk, compressed: level > 0 })
    }

    /// A dataset of small rows, such as a history: plain chunks of up to 1024 rows or 64 KiB.
    ///
    /// A chunk is overwritten in place as it fills, so only its first row changes the index.
    pub(crate) fn create_small<T: H5Type>(group: &Group, name: &str, width: usize) -> hdf5::Result<Self> {
        let bytes = width.max(1) * size_of::<T>();
        Self::create::<T>(group, name, width, (65_536 / bytes).clamp(1, 1024), 0)
    }

    /// Number of rows.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// Appends rows and returns the index of the first.
    ///
    /// Compressed rows start a new chunk: filling up an old one would move it within the file,
    /// and a run killed meanwhile would lose rows of earlier load steps.
    pub(crate) fn append<T: H5Type>(&mut self, values: &[T]) -> hdf5::Result<usize> {
        let first = if self.compressed { self.len.next_multiple_of(self.chunk) } else { self.len };
        self.write_at(first, values)?;
        Ok(first)
    }

    /// Appends parts, one after the other, and returns the index of the first row of each. Compressed parts start new
    /// chunks, others are written as one.
    pub(crate) fn append_each<T: H5Type + Clone>(&mut self, parts: &[&[T]]) -> hdf5::Result<Vec<usize>> {
        if self.compressed || parts.len() < 2 {
            return parts.iter().map(|part| self.append(part)).collect();
        }
        let mut first = self.len;
        let firsts = parts.iter().map(|part| {
            let start = first;
            first += part.len() / self.width;
            start
        });
        let firsts = firsts.collect();
        self.append(&parts.concat())?;
        Ok(firsts)
    }

    /// Replaces all rows.
    pub(crate) fn replace<T: H5Type>(&mut self, values: &[T]) -> hdf5::Result<()> {
        self.write_at(0, values)
    }

    /// Writes `values` from row `first` on; they become the last rows.
    fn write_at<T: H5Type>(&mut self, first: usize, values: &[T]) -> hdf5::Result<()> {
        assert!(self.width > 0 && values.len().is_multiple_of(self.width), "values come in whole rows");
        let rows = values.len() / self.width;
        let end = first + rows;
        if self.width == 1 {
            self.dataset.resize((end,))?;
            self.dataset.write_slice(values, first..end)?;
        } else {
            self.dataset.resize((end, self.width))?;
            let values = ArrayView2::from_shape((rows, self.width), values)?;
            self.dataset.write_slice(values, (first..end, ..))?;
        }
        self.len = end;
        Ok(())
    }
}

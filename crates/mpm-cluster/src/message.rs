//! Numbers as bytes.

use std::ops::Range;

/// Writes numbers one after the other.
#[derive(Clone, Debug, Default)]
pub struct Writer {
    bytes: Vec<u8>,
}

impl Writer {
    /// Adds a count or a number of something.
    pub fn count(&mut self, value: u64) {
        self.bytes.extend(value.to_le_bytes());
    }

    /// Adds a list of counts, with its length.
    pub fn counts(&mut self, values: impl ExactSizeIterator<Item = u64>) {
        self.count(values.len() as u64);
        values.for_each(|value| self.count(value));
    }

    /// Adds a list of numbers, with its length.
    pub fn numbers(&mut self, values: &[f64]) {
        self.count(values.len() as u64);
        self.bytes.reserve(size_of_val(values));
        values.iter().for_each(|value| self.number(*value));
    }

    /// Adds a number.
    pub fn number(&mut self, value: f64) {
        self.bytes.extend(value.to_le_bytes());
    }

    /// Adds bytes, with their length.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.count(bytes.len() as u64);
        self.bytes.extend(bytes);
    }

    /// All that was written.
    pub fn finish(self) -> Vec<u8> {
        self.bytes
    }
}

/// Reads what a [`Writer`] has written, in the same order.
///
/// # Panics
/// Its methods panic where the bytes end: both sides are the same program.
#[derive(Clone, Debug)]
pub struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    /// Begins at the first byte.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    /// Whether all has been read.
    pub fn is_at_end(&self) -> bool {
        self.rest.is_empty()
    }

    fn take(&mut self, length: usize) -> &'a [u8] {
        let (taken, rest) = self.rest.split_at(length);
        self.rest = rest;
        taken
    }

    fn eight(&mut self) -> [u8; 8] {
        self.take(8).try_into().expect("eight bytes")
    }

    /// A count.
    pub fn count(&mut self) -> u64 {
        u64::from_le_bytes(self.eight())
    }

    /// A count as an index.
    pub fn index(&mut self) -> usize {
        self.count() as usize
    }

    /// A list of counts.
    pub fn counts(&mut self) -> Vec<u64> {
        let items: Range<usize> = 0..self.index();
        items.map(|_| self.count()).collect()
    }

    /// A number.
    pub fn number(&mut self) -> f64 {
        f64::from_le_bytes(self.eight())
    }

    /// A list of numbers.
    pub fn numbers(&mut self) -> Vec<f64> {
        let length = self.index();
        let (numbers, _) = self.take(length * size_of::<f64>()).as_chunks();
        numbers.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect()
    }

    /// Bytes.
    pub fn bytes(&mut self) -> &'a [u8] {
        let length = self.index();
        self.take(length)
    }
}

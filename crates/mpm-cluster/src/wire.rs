//! Bytes between ranks.

/// Bytes between ranks: nothing of the Material Point Method.
///
/// All ranks call the methods in the same order.
pub trait Wire {
    /// Number of this rank, from 0.
    fn rank(&self) -> usize;

    /// Number of ranks.
    fn size(&self) -> usize;

    /// Sets `all` to the numbers of all ranks, in the order of the ranks; every rank has as many.
    fn gather(&self, own: &[f64], all: &mut [f64]);

    /// Sends bytes to the ranks that are named, at most once each, this one perhaps among them. Returns what was sent to
    /// this one, in the order of the ranks.
    fn exchange(&self, out: &[(usize, Vec<u8>)]) -> Vec<(usize, Vec<u8>)>;
}

//! Numbers without a pattern, the same in every run.

/// A sequence of numbers between -1 and 1 (multiplicative congruential generator, Lehmer 1951).
pub(crate) struct QuasiRandom(u64);

impl QuasiRandom {
    pub(crate) fn new(seed: u32) -> Self {
        Self(2 * u64::from(seed) + 1)
    }

    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(0xda94_2042_e4dd_58b5);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// A field of D components on `n` nodes, each between `-size` and `size`.
    pub(crate) fn field<const D: usize>(&mut self, n: usize, size: f64) -> Vec<mpm_grid::Vector<D>> {
        (0..n).map(|_| mpm_grid::Vector::from_fn(|_, _| size * self.next())).collect()
    }
}

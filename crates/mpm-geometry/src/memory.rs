//! Memory that may be taken up: asked for here before it is asked of the machine.

use std::fmt::Display;

/// Memory that may be taken up.
#[derive(Clone, Copy, Debug)]
pub struct MemoryLimit {
    /// `[bytes]`.
    pub bytes: u64,
}

impl MemoryLimit {
    /// Refuses `count` things of at least `each` bytes that there is no room for.
    ///
    /// # Errors
    /// A sentence with what they would take and what there is.
    pub fn check(self, what: impl Display, count: f64, each: usize) -> Result<(), String> {
        let needed = count * each as f64;
        if needed <= self.bytes as f64 {
            return Ok(());
        }
        let gigabytes = |bytes: f64| bytes / 1e9;
        Err(format!(
            "{what} would take at least {:.3e} GB of memory, of which there are {:.3e} GB",
            gigabytes(needed),
            gigabytes(self.bytes as f64)
        ))
    }

    /// How many things of `each` bytes there is room for.
    pub fn most(self, each: usize) -> usize {
        usize::try_from(self.bytes / each.max(1) as u64).unwrap_or(usize::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fits_is_let_through_and_the_rest_is_told() {
        let limit = MemoryLimit { bytes: 1_000_000 };
        assert_eq!(limit.check("points", 1e5, 10), Ok(()));
        let refused = limit.check("points", 1e5, 11).unwrap_err();
        assert_eq!(refused, "points would take at least 1.100e-3 GB of memory, of which there are 1.000e-3 GB");
        assert!(limit.check("points", f64::INFINITY, 1).is_err());
        assert!(limit.check("points", f64::NAN, 1).is_err());
    }
}

//! Memory that a scene may take up: asked for here before it is asked of the machine.

use std::fmt::Display;
use std::fs;

/// Nodes among which the nodes of a scene's supports are sought, in all.
const MOST_SOUGHT: f64 = 2e7;

/// Memory that a scene may take up.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Room {
    /// `[bytes]`.
    pub bytes: u64,
}

impl Room {
    /// What this machine has left: as Linux says, and without bounds where nobody says.
    pub(crate) fn of_machine() -> Self {
        let left = fs::read_to_string("/proc/meminfo").ok().and_then(|text| {
            let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
            line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
        });
        let group =
            fs::read_to_string("/sys/fs/cgroup/memory.max").ok().and_then(|text| text.trim().parse().ok());
        Self { bytes: left.unwrap_or(u64::MAX).min(group.unwrap_or(u64::MAX)) }
    }

    /// Refuses `count` things of at least `each` bytes that there is no room for.
    pub(crate) fn check(self, what: impl Display, count: f64, each: usize) -> Result<(), String> {
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
    pub(crate) fn most(self, each: usize) -> usize {
        usize::try_from(self.bytes / each.max(1) as u64).unwrap_or(usize::MAX)
    }

    /// Refuses supports that are sought among more nodes than a run could hold.
    pub(crate) fn check_search(nodes: f64) -> Result<(), String> {
        if nodes <= MOST_SOUGHT {
            return Ok(());
        }
        Err(format!(
            "the nodes of this region and of those before are to be sought among {nodes:e}, expected at most \
            {MOST_SOUGHT:e}: a region confined to a part of the mesh has fewer"
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fits_is_let_through_and_the_rest_is_told() {
        let room = Room { bytes: 1_000_000 };
        assert_eq!(room.check("points", 1e5, 10), Ok(()));
        let refused = room.check("points", 1e5, 11).unwrap_err();
        assert_eq!(refused, "points would take at least 1.100e-3 GB of memory, of which there are 1.000e-3 GB");
        assert!(room.check("points", f64::INFINITY, 1).is_err());
        assert!(room.check("points", f64::NAN, 1).is_err());
        assert!(Room::of_machine().bytes > 1 << 20);
    }
}

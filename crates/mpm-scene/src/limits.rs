//! Memory that a scene may take up, and how long its supports may be sought.

use crate::share::ShareOfPoints;
use mpm_geometry::MemoryLimit;
use std::fs;

/// What a rank has room for, and which points it makes.
#[derive(Clone, Copy)]
pub(crate) struct Room {
    pub memory: MemoryLimit,
    pub share: ShareOfPoints,
}

impl Room {
    /// For all points.
    pub(crate) fn for_all(memory: MemoryLimit) -> Self {
        Self { memory, share: ShareOfPoints::ALL }
    }
}

/// Nodes among which the nodes of a scene's supports are sought, in all.
const MOST_SOUGHT: f64 = 2e7;

/// The memory that this machine has left: as Linux says, and without bounds where nobody says.
pub(crate) fn memory_left() -> MemoryLimit {
    let left = fs::read_to_string("/proc/meminfo").ok().and_then(|text| {
        let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
        line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
    });
    let group = fs::read_to_string("/sys/fs/cgroup/memory.max").ok().and_then(|text| text.trim().parse().ok());
    MemoryLimit { bytes: left.unwrap_or(u64::MAX).min(group.unwrap_or(u64::MAX)) }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_machine_that_runs_tests_has_a_megabyte_left() {
        assert!(memory_left().bytes > 1 << 20);
    }
}

//! Sums by nodes over the groups of a body, parts of the body at once.

use mpm_basis::parallel::each;
use mpm_basis::{Connectivity, Group};
use std::ops::{AddAssign, Range};

/// Points of a part: many enough that what its nodes share with those of the next part costs little.
const PART: usize = 8192;

/// The sums of consecutive nodes.
pub(super) struct Window<'a, T> {
    first: usize,
    sums: &'a mut [T],
}

impl<T> Window<'_, T> {
    /// Of an active node that a group of the part has.
    #[inline(always)]
    pub fn of(&mut self, node: usize) -> &mut T {
        &mut self.sums[node - self.first]
    }
}

/// Adds to the sums of active nodes what `add` adds of each group. Parts are added in their order, whatever the number of threads.
pub(super) fn add_by_node<const D: usize, T: Copy + AddAssign + Send + Sync>(
    connectivity: &Connectivity<D>,
    (sums, zero): (&mut [T], T),
    add: &(impl Fn(&Group<'_, D>, &mut Window<'_, T>) + Sync),
) {
    let parts = parts(connectivity);
    let mut of_all = Window { first: 0, sums };
    if parts.len() < 2 {
        (0..connectivity.n_groups()).for_each(|group| add(&connectivity.group(group), &mut of_all));
        return;
    }
    let of_parts = each(parts.len(), &|part| {
        let nodes = |group: usize| connectivity.group_nodes(group).iter().map(|&node| node as usize);
        let groups = parts[part].clone();
        let first = groups.clone().filter_map(|group| nodes(group).min()).min().unwrap_or(0);
        let end = groups.clone().filter_map(|group| nodes(group).max()).max().map_or(first, |last| last + 1);
        let mut own = vec![zero; end - first];
        let mut window = Window { first, sums: &mut own };
        groups.for_each(|group| add(&connectivity.group(group), &mut window));
        (first, own)
    });
    for (first, own) in of_parts {
        own.into_iter().enumerate().for_each(|(k, of_part)| *of_all.of(first + k) += of_part);
    }
}

/// Runs of groups with about as many points each.
fn parts<const D: usize>(connectivity: &Connectivity<D>) -> Vec<Range<usize>> {
    let (mut parts, mut first) = (Vec::new(), 0);
    for group in 0..connectivity.n_groups() {
        if connectivity.group_points(group).end - connectivity.group_points(first).start >= PART {
            parts.push(first..group + 1);
            first = group + 1;
        }
    }
    if first < connectivity.n_groups() {
        parts.push(first..connectivity.n_groups());
    }
    parts
}

//! Strips of groups that can be summed in parallel with an order fixed by the data.
//!
//! Groups are taken in the order of their lowest node. A strip is a run of them; it writes to the
//! nodes from the lowest of its first group to the highest of any. Strips are cut so that a strip
//! never reaches the nodes of the next but one: all even strips can be summed at once, then all odd
//! ones. Which strip a group is in depends on connectivity alone.

use crate::{Couplings, Linked};
use std::ops::Range;

/// A strip is cut as soon as it holds this many points and may be.
const POINTS: usize = 2048;

/// The strips of one body.
#[derive(Clone, Debug)]
pub(crate) struct Strips {
    /// Groups by lowest node; empty where the groups already stand in that order.
    order: Vec<u32>,
    strips: Vec<Strip>,
}

/// A run of groups and the nodes it writes to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Strip {
    /// Positions in the order of the groups.
    pub groups: Range<usize>,
    /// Active nodes.
    pub nodes: Range<usize>,
}

impl Strips {
    pub(crate) fn of<const D: usize>(links: &Linked<D>) -> Self {
        let lowest = |group: usize| links.set(group).first().copied().unwrap_or(0);
        let sorted = (1..links.n_sets()).all(|group| lowest(group - 1) <= lowest(group));
        let mut order: Vec<u32> = Vec::new();
        if !sorted {
            order.extend((0..links.n_sets()).map(|group| group as u32));
            order.sort_by_key(|&group| lowest(group as usize));
        }
        let mut result = Self { order, strips: Vec::new() };

        let mut points = 0;
        // Ends of the nodes of the strip before the open one, and of the open one.
        let (mut reach_before, mut reach) = (0, 0);
        for position in 0..links.n_sets() {
            let group = result.group(position);
            let nodes = links.set(group);
            let (Some(&low), Some(&high)) = (nodes.first(), nodes.last()) else { continue };
            let (low, end) = (low as usize, high as usize + 1);
            if result.strips.is_empty() || (points >= POINTS && low >= reach_before) {
                reach_before = reach;
                result.strips.push(Strip { groups: position..position, nodes: low..end });
                points = 0;
            }
            let open = result.strips.last_mut().expect("one was just pushed");
            open.groups.end = position + 1;
            open.nodes.end = open.nodes.end.max(end);
            reach = open.nodes.end.max(reach);
            points += links.n_points(group);
        }
        result
    }

    /// The group at a position of the order.
    #[inline]
    pub(crate) fn group(&self, position: usize) -> usize {
        if self.order.is_empty() { position } else { self.order[position] as usize }
    }

    /// Even strips, then odd strips: within each the nodes are disjoint and ascending.
    pub(crate) fn phases(&self) -> [impl Iterator<Item = &Strip>; 2] {
        [self.strips.iter().step_by(2), self.strips.get(1..).unwrap_or_default().iter().step_by(2)]
    }
}

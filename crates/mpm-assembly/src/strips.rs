//! Strips of supports that can be summed in parallel with an order fixed by the data.
//!
//! Supports are taken in the order of their lowest node. A strip is a run of them; it writes to the
//! nodes from the lowest of its first support to the highest of any. Strips are cut so that a strip
//! never reaches the nodes of the next but one: all even strips can be summed at once, then all odd
//! ones. Which strip a support is in depends on connectivity alone.

use mpm_basis::Links;
use std::ops::Range;

/// A strip is cut as soon as it holds this many points and may be.
const POINTS: usize = 2048;

/// A run of supports and the nodes it writes to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Strip {
    pub supports: Range<usize>,
    /// Active nodes.
    pub nodes: Range<usize>,
}

/// The strips of one body: even ones, then odd ones. Within each the nodes are disjoint and ascending.
pub(crate) fn strips<const D: usize>(links: &Links<D>) -> [Vec<Strip>; 2] {
    let mut phases = [Vec::new(), Vec::new()];
    let mut open: Option<Strip> = None;
    let mut points = 0;
    let mut count = 0;
    // Ends of the nodes of the strip before the open one, and of the open one.
    let (mut reach_before, mut reach) = (0, 0);
    for support in 0..links.n_supports() {
        let nodes = links.support_nodes(support);
        let (Some(&low), Some(&high)) = (nodes.first(), nodes.last()) else { continue };
        let (low, end) = (low as usize, high as usize + 1);
        let may_end = points >= POINTS && low >= reach_before;
        let mut strip = match open.take() {
            Some(strip) if !may_end => strip,
            full => {
                reach_before = reach;
                if let Some(strip) = full {
                    phases[count % 2].push(strip);
                    count += 1;
                }
                points = 0;
                Strip { supports: support..support, nodes: low..end }
            }
        };
        strip.supports.end = support + 1;
        strip.nodes.end = strip.nodes.end.max(end);
        reach = strip.nodes.end.max(reach);
        open = Some(strip);
        points +=
            links.support_groups(support).iter().map(|&g| links.group_points(g as usize).len()).sum::<usize>();
    }
    if let Some(strip) = open {
        phases[count % 2].push(strip);
    }
    phases
}

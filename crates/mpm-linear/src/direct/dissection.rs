//! Elimination order: geometric nested dissection of the active lattice nodes, then a post-order.
//!
//! A sparse factor fills in where an eliminated node had uneliminated neighbours, so the order
//! decides memory and time. Nested dissection (A. George, SIAM J. Numer. Anal. 10, 1973) takes a
//! plane of nodes out of the middle, orders the two sides first (recursively) and the plane last.
//! The nodes know their place in the lattice, so planes are found by counting, not by graph search.
//!
//! * The active nodes may be any subset. The chosen plane is the one with the fewest active nodes
//!   for the balance it achieves, so holes and gaps between bodies are used.
//! * A point with a wide domain couples nodes several lattice lines apart. A separator is as many
//!   planes thick as the couplings reach, measured from the pattern direction by direction.
//! * A periodic direction is a ring: its first cut takes two separators, afterwards it is a line.
//! * Sets are cut down to single nodes or until no plane has nodes on both sides: stopping earlier
//!   costs fill (7 % at 16 nodes in two dimensions) and saves no time.
//! * The result is post-ordered by the elimination tree, which leaves the fill as it is and puts
//!   the columns of a supernode next to each other (faer does not do this for a given order).
//!
//! Only the fill depends on this file, never the correctness of a factorisation.

use super::graph::BlockGraph;
use crate::matrix::Pattern;

/// Order of elimination of the equations of a symmetric pattern, new to old: equation `order[k]` is
/// eliminated at step k.
///
/// `lattice` holds the multi-index of each node, `periodic` the number of lattice lines of each
/// direction that closes on itself. Equations of a further field on the nodes (see [`crate::Hints::further`]) follow those
/// of their node; equations that belong to no node come last.
pub(super) fn elimination_order(
    pattern: Pattern<'_>,
    lattice: &[[u32; 3]],
    periodic: [Option<u32>; 3],
    further: impl Fn(usize) -> Option<usize>,
) -> Vec<usize> {
    assert_eq!(pattern.blocks, lattice.len(), "a place on the lattice for each node");
    let graph = BlockGraph::new(pattern);
    let dissected = nested_dissection(&graph, lattice, periodic);
    let nodes = graph.postorder(&dissected);
    let components = pattern.block;
    let behind = components * pattern.blocks..pattern.n_equations();
    let mut fields: Vec<(usize, usize)> =
        behind.clone().filter_map(|equation| Some((further(equation)?, equation))).collect();
    fields.sort_unstable();
    let mut order = Vec::with_capacity(pattern.n_equations());
    for v in nodes.iter().map(|&v| v as usize) {
        order.extend((0..components).map(|i| components * v + i));
        let first = fields.partition_point(|&(node, _)| node < v);
        order.extend(fields[first..].iter().take_while(|&&(node, _)| node == v).map(|&(_, equation)| equation));
    }
    order.extend(behind.filter(|&equation| further(equation).is_none()));
    order
}

/// Order of elimination of the nodes, new to old.
pub(super) fn nested_dissection(
    graph: &BlockGraph,
    lattice: &[[u32; 3]],
    periodic: [Option<u32>; 3],
) -> Vec<u32> {
    let mut order: Vec<u32> = (0..graph.len() as u32).collect();
    let mut dissection = Dissection::new(graph, lattice, periodic);
    dissection.dissect(&mut order, periodic);
    order
}

/// Nested dissection at work.
struct Dissection {
    /// Lattice index of each node, direction by direction; counted from the seam once a ring is cut.
    line: Vec<[u32; 3]>,
    /// Thickness of a separator, per direction.
    reach: [u32; 3],
    /// Nodes put aside while a set is partitioned.
    right: Vec<u32>,
    separator: Vec<u32>,
    /// Nodes on each lattice line of the direction under consideration.
    count: Vec<usize>,
}

/// A separator: lines `at..at + reach` of `direction`, and the seam if that direction is a ring.
struct Cut {
    direction: usize,
    at: u32,
    /// First line of the seam and length of the ring.
    seam: Option<(u32, u32)>,
    /// Nodes of the separator over the product of the nodes left and right: small is good.
    cost: f64,
}

impl Dissection {
    fn new(graph: &BlockGraph, lattice: &[[u32; 3]], periodic: [Option<u32>; 3]) -> Self {
        for index in lattice {
            for d in 0..3 {
                assert!(periodic[d].is_none_or(|p| index[d] < p), "lattice index outside its ring");
            }
        }
        Self {
            line: lattice.to_vec(),
            reach: graph.reach(lattice, periodic),
            right: Vec::new(),
            separator: Vec::new(),
            count: Vec::new(),
        }
    }

    /// Permutes `set` into an elimination order. `ring` holds the lengths of rings not yet cut.
    fn dissect(&mut self, set: &mut [u32], ring: [Option<u32>; 3]) {
        let Some((left, right, ring)) = self.bisect(set, ring) else { return };
        self.dissect(&mut set[..left], ring);
        self.dissect(&mut set[left..left + right], ring);
    }

    /// Permutes `set` into left, right, separator, where no coupling joins left and right.
    /// Returns the sizes of left and right and the rings that remain, or nothing if no plane
    /// leaves nodes on both sides.
    fn bisect(
        &mut self,
        set: &mut [u32],
        mut ring: [Option<u32>; 3],
    ) -> Option<(usize, usize, [Option<u32>; 3])> {
        if set.len() < 2 {
            return None;
        }
        let mut best: Option<Cut> = None;
        for (d, &length) in ring.iter().enumerate() {
            let cut = self.cut(set, d, length);
            if let Some(cut) = cut.filter(|c| best.as_ref().is_none_or(|b| c.cost < b.cost)) {
                best = Some(cut);
            }
        }
        let Cut { direction: d, at, seam, .. } = best?;
        let reach = self.reach[d];
        let mut last = u32::MAX;
        if let Some((seam, length)) = seam {
            // Lines are counted from the end of the seam from now on, so the seam comes last.
            for &v in set.iter() {
                let line = &mut self.line[v as usize][d];
                *line = from_seam(*line, seam, reach, length);
            }
            last = length - reach;
            ring[d] = None;
        }
        self.right.clear();
        self.separator.clear();
        let mut left = 0;
        for i in 0..set.len() {
            let v = set[i];
            let line = self.line[v as usize][d];
            if line < at {
                set[left] = v;
                left += 1;
            } else if line >= at + reach && line < last {
                self.right.push(v);
            } else {
                self.separator.push(v);
            }
        }
        let right = self.right.len();
        set[left..left + right].copy_from_slice(&self.right);
        set[left + right..].copy_from_slice(&self.separator);
        Some((left, right, ring))
    }

    /// The cheapest cut across direction `d`.
    fn cut(&mut self, set: &[u32], d: usize, ring: Option<u32>) -> Option<Cut> {
        let lines = set.iter().map(|&v| self.line[v as usize][d]);
        let (first, length) = match ring {
            Some(length) => (0, length),
            None => {
                let (low, high) = lines.clone().fold((u32::MAX, 0), |(l, h), x| (l.min(x), h.max(x)));
                (low, high - low + 1)
            }
        };
        let (n, reach) = (length as usize, self.reach[d] as usize);
        if n < reach + 2 {
            return None;
        }
        let count = &mut self.count;
        count.clear();
        count.resize(n, 0);
        for line in lines {
            count[(line - first) as usize] += 1;
        }

        let mut seam = None;
        let mut fixed = 0;
        if let Some(length) = ring {
            let window = |w: usize| (w..w + reach).map(|i| count[i % n]).sum::<usize>();
            let start = (0..n).min_by_key(|&w| window(w)).expect("a ring has lines");
            fixed = window(start);
            count.rotate_left((start + reach) % n);
            count.truncate(n - reach);
            seam = Some((start as u32, length));
        }

        let total: usize = count.iter().sum();
        let mut best: Option<(usize, f64)> = None;
        let (mut left, mut separator) = (0, count.iter().take(reach).sum::<usize>());
        for at in 1..count.len().saturating_sub(reach) {
            left += count[at - 1];
            separator = separator + count[at + reach - 1] - count[at - 1];
            let right = total - left - separator;
            if left == 0 || right == 0 {
                continue;
            }
            // The half node makes the most balanced of several free cuts the cheapest.
            let cost = ((separator + fixed) as f64 + 0.5) / (left as f64 * right as f64);
            if best.is_none_or(|(_, least)| cost < least) {
                best = Some((at, cost));
            }
        }
        best.map(|(at, cost)| Cut { direction: d, at: first + at as u32, seam, cost })
    }
}

/// Line number counted around the ring from the first line behind the seam.
fn from_seam(line: u32, seam: u32, reach: u32, length: u32) -> u32 {
    (line + 2 * length - seam - reach) % length
}

#[cfg(test)]
mod tests;

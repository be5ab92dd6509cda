//! Strips of sets of nodes that can be summed in parallel with an order fixed by the data.
//!
//! Sets are taken in the order of their lowest node. A strip is a run of them; it writes to the
//! nodes from the lowest of its first set to the highest of any. Strips are cut so that a strip
//! never reaches the nodes of the next but one: all even strips can be summed at once, then all odd
//! ones. Which strip a set is in depends on connectivity alone.

use super::body_connectivity::BodyConnectivity;
use crate::unknowns::Couplings;
use mpm_basis::parallel::both;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

/// A strip is cut as soon as it holds this part of the body's points and may be.
const PART: usize = 64;

/// Points of a strip: fewer are not worth a task, and more leave threads idle.
const LEAST_POINTS: usize = 256;
const MOST_POINTS: usize = 2048;

/// The strips of one body.
#[derive(Clone, Debug)]
pub(crate) struct Strips {
    /// Sets by lowest node; empty where they already stand in that order.
    order: Vec<u32>,
    /// Even strips, then odd strips: within each the nodes are disjoint and ascending.
    phases: [Vec<Strip>; 2],
}

/// A run of sets and the nodes it writes to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Strip {
    /// Positions in the order of the sets.
    pub sets: Range<usize>,
    /// Active nodes.
    pub nodes: Range<usize>,
}

impl Strips {
    pub(crate) fn of<const D: usize>(body: &BodyConnectivity<D>) -> Self {
        let lowest = |set: usize| body.set(set).first().copied().unwrap_or(0);
        let sorted = (1..body.n_sets()).all(|set| lowest(set - 1) <= lowest(set));
        let mut order: Vec<u32> = Vec::new();
        if !sorted {
            order.extend((0..body.n_sets()).map(|set| set as u32));
            order.sort_by_key(|&set| lowest(set as usize));
        }
        let mut result = Self { order, phases: [Vec::new(), Vec::new()] };

        // A function of the body, never of the number of threads.
        let all: usize = (0..body.n_sets()).map(|set| body.n_points(set)).sum();
        let enough = (all / PART).clamp(LEAST_POINTS, MOST_POINTS);
        let mut open: Option<Strip> = None;
        let (mut points, mut count) = (0, 0);
        // Ends of the nodes of the strip before the open one, and of the open one.
        let (mut reach_before, mut reach) = (0, 0);
        for position in 0..body.n_sets() {
            let set = result.set(position);
            let nodes = body.set(set);
            let (Some(&low), Some(&high)) = (nodes.first(), nodes.last()) else { continue };
            let (low, end) = (low as usize, high as usize + 1);
            let mut strip = match open.take() {
                Some(strip) if points < enough || low < reach_before => strip,
                full => {
                    reach_before = reach;
                    points = 0;
                    if let Some(strip) = full {
                        result.phases[count % 2].push(strip);
                        count += 1;
                    }
                    Strip { sets: position..position, nodes: low..end }
                }
            };
            strip.sets.end = position + 1;
            strip.nodes.end = strip.nodes.end.max(end);
            reach = strip.nodes.end.max(reach);
            points += body.n_points(set);
            open = Some(strip);
        }
        if let Some(strip) = open {
            result.phases[count % 2].push(strip);
        }
        result
    }

    /// The set at a position of the order.
    #[inline]
    pub(crate) fn set(&self, position: usize) -> usize {
        if self.order.is_empty() { position } else { self.order[position] as usize }
    }

    pub(crate) fn phases(&self) -> &[Vec<Strip>; 2] {
        &self.phases
    }
}

/// Sums the strips of a phase, halving the list until there is one task for each scratch; returns the smallest result.
/// `parted` parts what they write to before and from a node on, `sum` sums the strips of a task.
pub(crate) fn sum_strips<P: Send, S: Send, E: Send>(
    strips: &[Strip],
    scratch: &[Mutex<S>],
    part: P,
    parted: &(impl Fn(P, usize) -> (P, P) + Sync),
    sum: &(impl Fn(&[Strip], &mut S, P) -> Result<f64, E> + Sync),
) -> Result<f64, E> {
    if scratch.len() > 1 && strips.len() > 1 {
        let (low, high) = strips.split_at(strips.len() / 2);
        let (low_scratch, high_scratch) = scratch.split_at(scratch.len() / 2);
        let (low_part, high_part) = parted(part, high[0].nodes.start);
        let (low, high) = both(
            || sum_strips(low, low_scratch, low_part, parted, sum),
            || sum_strips(high, high_scratch, high_part, parted, sum),
        );
        return Ok(low?.min(high?));
    }
    // What a task that panicked has left is overwritten.
    let mut scratch = scratch[0].lock().unwrap_or_else(PoisonError::into_inner);
    sum(strips, &mut scratch, part)
}

//! Where the time of a run goes, and what it did not have to do.

use crate::load_step::Kept;
use crate::observe::Timing;
use std::time::Instant;

/// The phases of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    /// Points to nodes: stencils, active nodes, pattern.
    Connect,
    /// Internal force alone.
    Stress,
    /// Internal force and tangent.
    Assemble,
    /// Order and symbolic factorisation.
    Analyse,
    /// Numeric factorisation.
    Factorise,
    /// Forward and backward substitution, refinement.
    Solve,
    /// Points take their new state.
    Advance,
    /// The observer.
    Output,
}

const NAMES: [&str; 8] =
    ["connect", "stress", "assemble", "analyse", "factorise", "solve", "advance", "output"];

/// Seconds and counts per phase, and counters of what was skipped.
#[derive(Clone, Debug)]
pub(crate) struct Timings {
    phases: [Timing; 8],
    pub skipped: Skipped,
}

/// What a run could do without.
#[derive(Clone, Debug, Default)]
pub(crate) struct Skipped {
    /// Passes in which no tangent was summed because convergence was foreseen.
    pub tangents: u64,
    /// Orders and symbolic analyses kept from the step before.
    pub analyses: u64,
    /// Load steps that began with the pattern of the one before, as no point had changed its nodes.
    pub patterns: u64,
    /// Load steps that were cut and began again with the connectivity at hand.
    pub connections: u64,
}

impl Skipped {
    pub(crate) fn count_connection(&mut self, kept: Kept) {
        match kept {
            Kept::Memory => {}
            Kept::Pattern => self.patterns += 1,
            Kept::All => self.connections += 1,
        }
    }
}

impl Timings {
    pub(crate) fn new() -> Self {
        Self {
            phases: NAMES.map(|phase| Timing { phase, seconds: 0.0, count: 0 }),
            skipped: Skipped::default(),
        }
    }

    /// Runs `work` on the clock of `phase`.
    pub(crate) fn time<T>(&mut self, phase: Phase, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        let timing = &mut self.phases[phase as usize];
        timing.seconds += start.elapsed().as_secs_f64();
        timing.count += 1;
        result
    }

    pub(crate) fn phases(&self) -> &[Timing] {
        &self.phases
    }
}

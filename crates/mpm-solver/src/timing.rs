//! Where the time of a run goes, and what it did not have to do.

use crate::observe::Timing;
use crate::record::MOST_COUNTED;
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
    /// Passes in which no tangent was summed because convergence was foreseen.
    pub skip_tangents: u64,
    /// Symbolic analyses kept from the step before.
    pub skip_analyses: u64,
}

/// Time and work of a run so far, as a file keeps it.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Spent {
    phases: Vec<(f64, u64)>,
    tangents: u64,
    analyses: u64,
}

impl Timings {
    pub(crate) fn new() -> Self {
        Self {
            phases: NAMES.map(|phase| Timing { phase, seconds: 0.0, count: 0 }),
            skip_tangents: 0,
            skip_analyses: 0,
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

    /// Seconds and count of every phase, and the counters of what was skipped.
    pub(crate) fn store(&self) -> Spent {
        let phases = self.phases.iter().map(|timing| (timing.seconds, timing.count)).collect();
        Spent { phases, tangents: self.skip_tangents, analyses: self.skip_analyses }
    }

    /// Counts on from there.
    ///
    /// # Errors
    /// Another number of phases.
    pub(crate) fn recall(spent: &Spent) -> Result<Self, String> {
        let mut timings = Self::new();
        if spent.phases.len() != timings.phases.len() {
            return Err(format!(
                "has times of {} phases, expected {}",
                spent.phases.len(),
                timings.phases.len()
            ));
        }
        let counts = spent.phases.iter().map(|phase| phase.1).chain([spent.tangents, spent.analyses]);
        if let Some(count) = counts.into_iter().find(|count| *count > MOST_COUNTED) {
            return Err(format!("has counted {count}, expected at most {MOST_COUNTED}"));
        }
        for (timing, &(seconds, count)) in timings.phases.iter_mut().zip(&spent.phases) {
            (timing.seconds, timing.count) = (seconds, count);
        }
        (timings.skip_tangents, timings.skip_analyses) = (spent.tangents, spent.analyses);
        Ok(timings)
    }

    pub(crate) fn phases(&self) -> &[Timing] {
        &self.phases
    }
}

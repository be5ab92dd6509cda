//! Where the time of a run goes.

use crate::skipped::Skipped;
use std::time::Instant;

/// Time spent in one phase of the run so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Timing {
    /// Name of the phase: connect, stress, assemble, analyse, factorise, solve, advance, output, …
    pub phase: &'static str,
    /// Wall seconds.
    pub seconds: f64,
    /// Times the phase was entered.
    pub count: u64,
}

/// Counts of a state beyond this are none of a run.
pub(crate) const MOST_COUNTED: u64 = 1 << 53;

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

/// Time and work of a run so far, as a file keeps it.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Spent {
    phases: Vec<(f64, u64)>,
    skipped: Skipped,
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

    /// How often a phase was gone through.
    pub(crate) fn count(&self, phase: Phase) -> u64 {
        self.phases[phase as usize].count
    }

    /// Seconds and count of every phase, and the counters of what was skipped.
    pub(crate) fn save(&self) -> Spent {
        let phases = self.phases.iter().map(|timing| (timing.seconds, timing.count)).collect();
        Spent { phases, skipped: self.skipped.clone() }
    }

    /// Counts on from there.
    ///
    /// # Errors
    /// Another number of phases.
    pub(crate) fn restore(spent: &Spent) -> Result<Self, String> {
        let mut timings = Self::new();
        if spent.phases.len() != timings.phases.len() {
            return Err(format!(
                "has times of {} phases, expected {}",
                spent.phases.len(),
                timings.phases.len()
            ));
        }
        let counts = spent.phases.iter().map(|phase| phase.1).chain(spent.skipped.list().map(|it| it.1));
        if let Some(count) = counts.into_iter().find(|count| *count > MOST_COUNTED) {
            return Err(format!("has counted {count}, expected at most {MOST_COUNTED}"));
        }
        for (timing, &(seconds, count)) in timings.phases.iter_mut().zip(&spent.phases) {
            (timing.seconds, timing.count) = (seconds, count);
        }
        timings.skipped = spent.skipped.clone();
        Ok(timings)
    }

    pub(crate) fn phases(&self) -> &[Timing] {
        &self.phases
    }

    /// The phases, then what was skipped, in no seconds.
    pub(crate) fn with_skipped(&self) -> Vec<Timing> {
        let skipped = self.skipped.list();
        let skipped = skipped.into_iter().map(|(phase, count)| Timing { phase, seconds: 0.0, count });
        self.phases.iter().cloned().chain(skipped).collect()
    }
}

//! Where the time of a run goes, and what it did not have to do.

use crate::load_step::Kept;
use crate::observe::Timing;
use crate::record::MOST_COUNTED;
use mpm_assembly::Body;
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
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Skipped {
    /// Grid nodes without material in the last load step.
    pub nodes: u64,
    /// Grid cells without a material point at the end.
    pub cells: u64,
    /// Entries of the tangent above its diagonal in the last load step.
    pub upper_triangle: u64,
    /// Columns of the points that no body stores.
    pub columns: u64,
    /// Load steps in a mesh that does not move.
    pub mesh_moves: u64,
    /// Load steps that were cut and began again with the connectivity at hand.
    pub connections: u64,
    /// Load steps that began with the pattern of the one before, as no point had changed its nodes.
    pub patterns: u64,
    /// Orders and symbolic analyses kept from the step before.
    pub analyses: u64,
    /// Linear solutions with a factorisation that was kept.
    pub factorisations: u64,
    /// Passes in which no tangent was summed because convergence was foreseen.
    pub tangents: u64,
    /// Evaluations of laws that cannot yield.
    pub yield_checks: u64,
    /// Evaluations of laws in plane strain: spectral decompositions in the plane instead of in space.
    pub out_of_plane: u64,
    /// Points that were carried through a load step without a domain.
    pub domains: u64,
}

impl Skipped {
    pub(crate) fn count_connection(&mut self, kept: Kept) {
        match kept {
            Kept::Memory => {}
            Kept::Pattern => self.patterns += 1,
            Kept::All => self.connections += 1,
        }
    }

    /// One pass over the points of a body.
    pub(crate) fn count_pass<const D: usize>(&mut self, body: &dyn Body<D>) {
        let points = body.n_points() as u64;
        if !body.can_yield() {
            self.yield_checks += points;
        }
        if D == 2 {
            self.out_of_plane += points;
        }
    }

    /// Name and number of everything, also of what was not skipped.
    pub(crate) fn list(&self) -> [(&'static str, u64); 13] {
        [
            ("skipped: grid nodes", self.nodes),
            ("skipped: grid cells", self.cells),
            ("skipped: upper triangle", self.upper_triangle),
            ("skipped: columns of points", self.columns),
            ("skipped: mesh moves", self.mesh_moves),
            ("skipped: connections", self.connections),
            ("skipped: patterns", self.patterns),
            ("skipped: orders and analyses", self.analyses),
            ("skipped: factorisations", self.factorisations),
            ("skipped: tangents", self.tangents),
            ("skipped: yield checks", self.yield_checks),
            ("skipped: out-of-plane spectra", self.out_of_plane),
            ("skipped: domains", self.domains),
        ]
    }
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
    pub(crate) fn store(&self) -> Spent {
        let phases = self.phases.iter().map(|timing| (timing.seconds, timing.count)).collect();
        Spent { phases, skipped: self.skipped.clone() }
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

//! What a run leaves behind: the history of its load steps, fields of its points, and a summary.

pub(crate) mod columns;
pub(crate) mod departures;
pub(crate) mod energy;
pub(crate) mod fields;
pub(crate) mod grip;
pub(crate) mod history;
mod probe;
pub(crate) mod summary;
mod supports;

use crate::connection::{Connected, Former};
use crate::equilibrium::problem::Equilibrium;
use crate::progress::DomainCounts;
use energy::StepEnergy;
use mpm_grid::{LoadFraction, Mesh};
use mpm_linear::Analysis;

/// What one converged load step leaves for the record.
pub(crate) struct StepResult<const D: usize> {
    /// The mesh at its start, in which it was balanced.
    pub mesh: Mesh<D>,
    pub connected: Connected<D>,
    pub balanced: Balanced<D>,
    /// Domains that were shortened or split after the step.
    pub domains: DomainCounts,
}

/// A load step in equilibrium.
pub(crate) struct Balanced<const D: usize> {
    /// Load fraction at its end.
    pub end: LoadFraction,
    pub equilibrium: Equilibrium<D>,
    /// Free components of displacement.
    pub equations: u64,
    /// Whether order and structure of the factor could be kept.
    pub analysis: Analysis,
    /// Where energies are recorded.
    pub energy: Option<StepEnergy>,
    /// Estimate of the condition number of the last tangent, where it is asked for.
    pub condition: Option<f64>,
}

impl<const D: usize> StepResult<D> {
    /// The connectivity, for the next step.
    pub(crate) fn into_former(self) -> Former<D> {
        Former { connected: self.connected, start_of_failed_step: None }
    }
}

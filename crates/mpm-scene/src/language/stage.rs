//! The schedule: load steps and stages, and in which of them something acts.

use super::number::{self, Count, Positive};
use mpm_solver::Stage;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Load steps: either `steps`, over which the load fraction goes from 0 to 1, or `stages`, in each of which it does so.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScheduleInput {
    /// Number of equal load steps, where there are no stages.
    #[serde(default)]
    pub steps: Option<Count>,
    /// How often a step that does not converge may be halved before the run ends; steps grow again
    /// by doubling, and every one of the equal steps ends where it would have.
    #[serde(default = "default_cuts", deserialize_with = "number::halvings")]
    #[schemars(range(min = 0, max = Stage::MOST_CUTS))]
    pub cuts: u8,
    /// Where the iteration of a load step begins.
    #[serde(default)]
    pub predictor: PredictorInput,
    /// What sets the load fraction of a load step, where there are no stages.
    #[serde(default)]
    pub control: StepControlInput,
    /// Parts of the schedule, one after the other. `cuts` and `predictor` hold for all that do not say otherwise.
    #[serde(default)]
    pub stages: Vec<StageInput>,
}

impl ScheduleInput {
    /// Equal load steps of all stages.
    pub fn n_steps(&self) -> u64 {
        let stages = self.stages.iter().map(|stage| u64::from(stage.steps.0)).sum::<u64>();
        stages + self.steps.map_or(0, |steps| u64::from(steps.0))
    }
}

/// A stage of the schedule: load steps over which the load fraction goes from 0 to 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StageInput {
    /// Its name, by which ramps, supports and loads refer to it.
    pub name: String,
    /// Number of equal load steps.
    pub steps: Count,
    /// As `cuts` of the schedule.
    #[serde(default, deserialize_with = "number::own_halvings")]
    #[schemars(range(min = 0, max = Stage::MOST_CUTS))]
    pub cuts: Option<u8>,
    /// As `predictor` of the schedule.
    #[serde(default, deserialize_with = "number::chosen")]
    pub predictor: Option<PredictorInput>,
    /// What sets the load fraction of a load step.
    #[serde(default)]
    pub control: StepControlInput,
    /// Whether displacements (those of points, probes and supports) count from its start on; nothing else changes.
    #[serde(default)]
    pub reset_displacements: bool,
}

/// In which stages of the schedule something acts; in all of them if left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ActiveInput {
    /// Name of the stage with which it begins; the first if left out.
    pub from: Option<String>,
    /// Name of the stage in which it ends; it stays to the end if left out.
    pub until: Option<String>,
    /// How it ends.
    pub release: ReleaseInput,
}

/// How a load, or what a support carries, ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum ReleaseInput {
    /// It falls to 0 linearly over the stage in which it ends. The nodes of a support are free from the start of that stage on;
    /// what the support has carried acts on them as a force.
    #[default]
    Linear,
    /// It ends at the start of that stage: the force is out of balance in the first load step.
    AtOnce,
}

/// Where the iteration of a load step begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum PredictorInput {
    /// At the displacement of the step before, in proportion to the change of the load fraction, and on to a
    /// hundredth of the tolerance. Where that does not converge at once, the step begins again at rest.
    #[default]
    LastStep,
    /// At rest, as other codes do. Path control has a guess of its own.
    Rest,
}

/// What sets the load fraction of a load step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum StepControlInput {
    /// It is given: `steps` equal steps.
    #[default]
    Load,
    /// It is found: each step has a given length along the path of equilibria, so that a run passes points
    /// where the load fraction has to decrease (snap-through, snap-back). `steps` is then the largest
    /// number of load steps; the run ends when the load fraction reaches 1. `cuts` limits how often in a
    /// row a step that cannot be solved is halved.
    Path {
        /// Change of the load fraction in the first step.
        first: Positive,
        /// Largest change of the load fraction in a step; as `first` if left out.
        #[serde(default)]
        longest: Option<Positive>,
        /// Newton iterations that a step should need: with fewer the next is longer, with more shorter.
        #[serde(default = "default_path_iterations")]
        iterations: Count,
        /// What the length of a step is.
        #[serde(default)]
        measure: PathMeasureInput,
    },
}

/// What the length of a step along the path is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum PathMeasureInput {
    /// Energy dissipated by yielding; load steps while nothing yields. For limit points caused by
    /// yielding and localisation: it cannot turn back, because a body that unloads dissipates nothing.
    Dissipation {
        /// Longest step `[F L]` (in the plane: per unit thickness); if left out, as the iterations allow.
        #[serde(default)]
        most: Option<Positive>,
    },
    /// Root mean square of the free displacements, each node weighted by its share of the stiffness. For
    /// limit points of elastic bodies (arches, shells).
    ArcLength {
        /// Longest step `[L]`; if left out, as the iterations allow.
        #[serde(default)]
        most: Option<Positive>,
    },
}

impl Default for PathMeasureInput {
    fn default() -> Self {
        Self::Dissipation { most: None }
    }
}

fn default_path_iterations() -> Count {
    Count(6)
}

fn default_cuts() -> u8 {
    Stage::equal(1).cuts
}

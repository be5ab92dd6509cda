//! What a check of a scene finds, for other programs.

use crate::compiled::as_written;
use crate::language::Scene;
use crate::plausibility::implausible;
use mpm_solver::observe::Field;
use mpm_solver::{BodyVolume, Estimate, StageSteps};
use serde::Serialize;

/// What a check of a scene finds: serialised, it is what `mpm check --json` prints.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check<'a> {
    /// What the scene shows.
    pub title: &'a str,
    /// Dimensions of space.
    pub dimensions: usize,
    /// Material points.
    pub material_points: usize,
    /// Cells of the mesh.
    pub cells: usize,
    /// Cells in which a material point lies.
    pub cells_with_material: usize,
    /// Nodes of the mesh.
    pub nodes: usize,
    /// Nodes that carry material.
    pub active_nodes: usize,
    /// Components of displacement to be found.
    pub equations: usize,
    /// Components of displacement of active nodes that supports prescribe.
    pub prescribed: usize,
    /// Stored entries of the tangent.
    pub tangent_entries: usize,
    /// Stored entries of its factor.
    pub factor_entries: usize,
    /// `iterative` or `direct`.
    pub linear_solver: &'static str,
    /// Nominal load steps.
    pub load_steps: u32,
    /// Bytes held at the peak of a load step, by owner.
    pub memory: CheckedMemory,
    /// How long the run and its parts take.
    pub seconds: CheckedSeconds,
    /// Volume and mass of every body.
    pub bodies: Vec<CheckedBody<'a>>,
    /// Rigid tools: of which parts, how large, how they move.
    pub tools: &'a [String],
    /// What in the scene is probably not meant.
    pub remarks: Vec<String>,
    /// Columns of the points that are not stored for any body.
    pub not_stored_per_point: &'a [&'static str],
    /// Fields of the points that the scene does not ask for, as it writes them.
    pub fields_not_written: Vec<String>,
    /// What of the files that the scene names was not read.
    pub notes: &'a [String],
    /// What will end the run, or may do so.
    pub warnings: &'a [String],
    /// Stages that have a name.
    pub stages: Vec<CheckedStage<'a>>,
}

/// Bytes, see [`mpm_solver::Memory`].
#[derive(Clone, Debug, PartialEq, Serialize)]
#[allow(missing_docs, reason = "those of the estimate, one by one")]
pub struct CheckedMemory {
    pub total: usize,
    pub points: usize,
    pub connectivity: usize,
    pub tangent: usize,
    pub solver: usize,
    pub factorised: usize,
    pub contributions: usize,
    pub work: usize,
    pub program: usize,
}

/// Seconds of one processor, see [`mpm_solver::Seconds`].
#[derive(Clone, Debug, PartialEq, Serialize)]
#[allow(missing_docs, reason = "those of the estimate, one by one")]
pub struct CheckedSeconds {
    pub least: f64,
    pub most: f64,
    pub per_load_step: f64,
    pub connect: f64,
    pub analyse: f64,
    pub pass: f64,
    pub tools: f64,
    pub solve: f64,
    pub look: f64,
    pub solution_tried: bool,
    pub iterations_reckoned_with: f64,
}

/// A body, see [`BodyVolume`].
#[derive(Clone, Debug, PartialEq, Serialize)]
#[allow(missing_docs, reason = "those of the estimate, one by one")]
pub struct CheckedBody<'a> {
    pub name: &'a str,
    pub volume: f64,
    pub volume_of_shape: Option<f64>,
    pub mass: Option<f64>,
}

/// A stage, see [`StageSteps`].
#[derive(Clone, Debug, PartialEq, Serialize)]
#[allow(missing_docs, reason = "those of the estimate, one by one")]
pub struct CheckedStage<'a> {
    pub name: &'a str,
    pub load_steps: u32,
    pub supports_begun: &'a [String],
    pub supports_ended: &'a [String],
}

impl<'a> Check<'a> {
    /// What is found in the estimate of a scene; `notes` tells what of its files was not read.
    pub fn of(it: &'a Estimate, scene: &'a Scene, notes: &'a [String]) -> Self {
        let named = |stage: &&StageSteps| !stage.name.is_empty();
        Self {
            title: scene.title(),
            dimensions: it.dimensions,
            material_points: it.points,
            cells: it.cells,
            cells_with_material: it.cells_with_material,
            nodes: it.nodes,
            active_nodes: it.active_nodes,
            equations: it.equations,
            prescribed: it.prescribed,
            tangent_entries: it.tangent_entries,
            factor_entries: it.factor_entries,
            linear_solver: if it.is_iterative { "iterative" } else { "direct" },
            load_steps: it.steps,
            memory: CheckedMemory::of(it),
            seconds: CheckedSeconds::of(it, scene),
            bodies: it.volumes.iter().map(CheckedBody::of).collect(),
            tools: &it.tools,
            remarks: implausible(scene).into_iter().chain(it.remarks.iter().cloned()).collect(),
            not_stored_per_point: &it.columns_not_stored,
            fields_not_written: unwritten_fields(scene),
            notes,
            warnings: &it.warnings,
            stages: it.stages.iter().filter(named).map(CheckedStage::of).collect(),
        }
    }
}

impl CheckedMemory {
    fn of(it: &Estimate) -> Self {
        let memory = &it.memory;
        Self {
            total: memory.total(),
            points: memory.points,
            connectivity: memory.connectivity,
            tangent: memory.tangent,
            solver: memory.solver,
            factorised: memory.factorised,
            contributions: memory.contributions,
            work: memory.work,
            program: memory.program,
        }
    }
}

impl CheckedSeconds {
    fn of(it: &Estimate, scene: &Scene) -> Self {
        let seconds = &it.seconds;
        let [least, most] = seconds_of_run(it, scene);
        Self {
            least,
            most,
            per_load_step: seconds.per_step(),
            connect: seconds.connect,
            analyse: seconds.analyse,
            pass: seconds.pass,
            tools: seconds.tools,
            solve: seconds.solve,
            look: seconds.look,
            solution_tried: seconds.is_tried,
            iterations_reckoned_with: seconds.iterations,
        }
    }
}

impl<'a> CheckedBody<'a> {
    fn of(body: &'a BodyVolume) -> Self {
        Self { name: &body.body, volume: body.points, volume_of_shape: body.shape, mass: body.mass }
    }
}

impl<'a> CheckedStage<'a> {
    fn of(stage: &'a StageSteps) -> Self {
        Self {
            name: &stage.name,
            load_steps: stage.steps,
            supports_begun: &stage.begun,
            supports_ended: &stage.ended,
        }
    }
}

/// Seconds of the run, least and most `[s]`: positions are recorded besides the fields.
pub fn seconds_of_run(it: &Estimate, scene: &Scene) -> [f64; 2] {
    it.seconds.range(1 + scene.output().fields.len(), scene.output().every.0)
}

/// Fields of all points that the scene does not ask for, as it writes them.
pub fn unwritten_fields(scene: &Scene) -> Vec<String> {
    let wanted: Vec<String> = scene.output().fields.iter().map(|field| format!("{field:?}")).collect();
    let known = Field::OF_POINTS.iter().map(|field| as_written(field.name()));
    known.filter(|name| !wanted.contains(name)).collect()
}

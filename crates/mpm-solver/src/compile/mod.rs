//! A scene becomes a model: the only place that asks what kind of thing something is.

mod basis;
mod bodies;
mod loads;
mod mesh;
mod overlap;
mod supports;

use crate::error::{Error, SceneError};
use crate::files::{NoFiles, SceneFiles};
use crate::limits::memory_left;
use crate::load_step::{resume, run, stencils};
use crate::model::{Model, PathControl, PathMeasure, Predictor, Prescribed, Schedule, Tolerance};
use crate::observe::Observer;
use crate::record::Summary;
use crate::scene::{
    PathMeasureInput, PredictorInput, Scene, SceneIn, SolverInput, StabilisationInput, StepControlInput,
    ToleranceInput,
};
use crate::state::{State, StateLayout};
use basis::{FillBody, check_domains, domain_limit};
use bodies::bodies;
use loads::{loads, probes};
use mesh::{layout, motion};
use mpm_basis::ActiveNodes;
use mpm_geometry::MemoryLimit;
use mpm_grid::{LoadFraction, Mesh};
use mpm_linear::Choice;
use supports::supports;

/// A model in the space of its scene.
pub enum Compiled {
    /// Plane strain.
    Plane(Model<2>),
    /// Three dimensions.
    Solid(Model<3>),
}

impl Compiled {
    /// Runs the model, see [`run`].
    ///
    /// # Errors
    /// As [`run`].
    pub fn run(&mut self, observer: &mut dyn Observer) -> Result<Summary, Error> {
        match self {
            Compiled::Plane(model) => run(model, observer),
            Compiled::Solid(model) => run(model, observer),
        }
    }

    /// Goes on from a state, see [`resume`].
    ///
    /// # Errors
    /// As [`resume`].
    pub fn resume(&mut self, state: &State, observer: &mut dyn Observer) -> Result<Summary, Error> {
        match self {
            Compiled::Plane(model) => resume(model, state, observer),
            Compiled::Solid(model) => resume(model, state, observer),
        }
    }

    /// What the states of a model that has not begun to run look like.
    pub fn state_layout(&self) -> StateLayout {
        match self {
            Compiled::Plane(model) => StateLayout::of(model),
            Compiled::Solid(model) => StateLayout::of(model),
        }
    }
}

/// Makes a model of a scene that names no files, see [`compile_with`].
///
/// # Errors
/// As [`compile_with`].
pub fn compile(scene: &Scene) -> Result<Compiled, SceneError> {
    compile_with(scene, &NoFiles)
}

/// Makes a model of a scene and checks all that can be checked before the first load step.
///
/// What would not fit into the memory that this machine has left is refused before any of it is asked for.
///
/// # Errors
/// The first thing that is wrong with the scene, or with a file that it names, with its path.
pub fn compile_with(scene: &Scene, files: &dyn SceneFiles) -> Result<Compiled, SceneError> {
    made(scene, files, memory_left())
}

/// As [`compile_with`], with so many bytes of memory in place of the machine's.
///
/// # Errors
/// As [`compile_with`].
pub fn compile_within(scene: &Scene, files: &dyn SceneFiles, bytes: u64) -> Result<Compiled, SceneError> {
    made(scene, files, MemoryLimit { bytes })
}

fn made(scene: &Scene, files: &dyn SceneFiles, memory: MemoryLimit) -> Result<Compiled, SceneError> {
    Ok(match scene {
        Scene::PlaneStrain(scene) => Compiled::Plane(model(scene, files, memory)?),
        Scene::Solid(scene) => Compiled::Solid(model(scene, files, memory)?),
    })
}

fn model<const D: usize, B: FillBody<D>>(
    scene: &SceneIn<D, B>,
    files: &dyn SceneFiles,
    memory: MemoryLimit,
) -> Result<Model<D>, SceneError> {
    check_domains(&scene.basis, &scene.domains)?;
    if scene.output.checkpoint.as_ref().is_some_and(|it| it.every.is_none() && it.seconds.is_none()) {
        return Err(SceneError::new("output.checkpoint", "expected `every` or `seconds`"));
    }
    let layout = layout(&scene.mesh, memory)?;
    let motion = motion(&scene.motion, &layout, memory)?;
    let mesh = motion.mesh_at(&layout, LoadFraction::START).map_err(|it| SceneError::new("motion", it))?;
    motion.mesh_at(&layout, LoadFraction::END).map_err(|it| SceneError::new("motion", it))?;

    let (bodies, faces) = bodies(scene, &layout, &mesh, files, memory)?;
    let probes = probes(scene, &bodies)?;
    let model = Model {
        supports: supports(scene, &layout)?,
        loads: loads(scene, &bodies, faces)?,
        layout,
        motion,
        domain_limit: domain_limit(&scene.domains, &bodies),
        bodies,
        schedule: schedule(scene)?,
        path: path_control(&scene.schedule.control),
        ghost: scene.stabilisation.map(|StabilisationInput::Ghost { factor }| factor.0),
        domain_history: scene.output.domain_history,
        energies: scene.output.energies,
        probes,
        condition_history: scene.output.condition,
        solver: match scene.solver {
            SolverInput::Auto => Choice::Auto,
            SolverInput::Direct => Choice::Direct,
            SolverInput::Iterative => Choice::Iterative,
        },
        tolerance: tolerance(&scene.tolerance)?,
    };
    check_start(&model, &mesh, memory)?;
    Ok(model)
}

/// What names of supports and probes are.
const A_NAME: &str = "a name of its own, not empty, not `.` or `..`, without `/` and control characters";

/// Whether a name can be that of a dataset.
fn is_name(name: &str) -> bool {
    !(name.is_empty() || [".", ".."].contains(&name) || name.contains('/') || name.contains(char::is_control))
}

fn schedule<const D: usize, B>(scene: &SceneIn<D, B>) -> Result<Schedule, SceneError> {
    let cuts = scene.schedule.cuts;
    if cuts > Schedule::MOST_CUTS {
        let reason = format!("expected at most {} halvings, got {cuts}", Schedule::MOST_CUTS);
        return Err(SceneError::new("schedule.cuts", reason));
    }
    let predictor = match scene.schedule.predictor {
        PredictorInput::LastStep => Predictor::LastStep,
        PredictorInput::Rest => Predictor::Rest,
    };
    Ok(Schedule { steps: scene.schedule.steps.0, cuts, predictor })
}

fn tolerance(input: &ToleranceInput) -> Result<Tolerance, SceneError> {
    let keep_factor_below = input.keep_factor_below.map(|part| part.0);
    if let Some(part) = keep_factor_below.filter(|part| *part >= 1.0) {
        return Err(SceneError::new("tolerance.keep_factor_below", format!("is {part}, expected less than 1")));
    }
    Ok(Tolerance { residual: input.residual.0, iterations: input.iterations.0, keep_factor_below })
}

fn path_control(control: &StepControlInput) -> Option<PathControl> {
    let StepControlInput::Path { first, longest, iterations, measure } = control else { return None };
    let measure = match measure {
        PathMeasureInput::Dissipation { most } => PathMeasure::Dissipation { most: most.map(|it| it.0) },
        PathMeasureInput::ArcLength { most } => PathMeasure::ArcLength { most: most.map(|it| it.0) },
    };
    let longest = longest.as_ref().map_or(first.0, |it| it.0);
    Some(PathControl { measure, first: first.0, longest, iterations: iterations.0 })
}

/// The start of the first load step: the mesh covers every point, and what is driven carries material.
fn check_start<const D: usize>(
    model: &Model<D>,
    mesh: &Mesh<D>,
    memory: MemoryLimit,
) -> Result<(), SceneError> {
    let stencils = stencils(model, mesh).map_err(|it| SceneError::new("bodies", it))?;
    let around = ActiveNodes::nodes_around(mesh.lattice(), &stencils);
    let room_for = memory.check("the part of the mesh around the bodies", around as f64, size_of::<u32>());
    room_for.map_err(|it| SceneError::new("bodies", it))?;
    let active = ActiveNodes::of(mesh.lattice(), &stencils);
    for (k, support) in model.supports.iter().enumerate() {
        let driven = support.components.iter().flatten().any(|it| *it != Prescribed::Held);
        if driven && !support.nodes.iter().any(|&node| active.number(node).is_some()) {
            return Err(SceneError::new(
                format!("supports[{k}].region"),
                format!("support `{}` drives nodes, but none of them carries material", support.name),
            ));
        }
    }
    Ok(())
}

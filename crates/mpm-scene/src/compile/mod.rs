//! A scene becomes a model: the only place that asks what kind of thing something is.

mod axisymmetric;
mod basis;
mod bodies;
mod drawn;
mod drive;
mod gradient;
mod initial;
mod law;
mod loads;
mod mesh;
mod names;
mod outlines;
mod overlap;
mod parameters;
mod quantity;
mod shapes;
mod sides;
mod splines;
mod stages;
mod supports;
mod symmetry;
mod tiling;
mod tool_motion;
mod tool_surfaces;
mod tools;
mod turning;
mod walls;

use crate::compiled::{Compiled, fields};
use crate::error::SceneError;
use crate::files::{NoFiles, SceneFiles};
use crate::language::{
    ControlInput, OutputInput, PlaneBasis, Scene, SceneIn, SolverInput, StabilisationInput, ToleranceInput,
    UnheldMotionInput,
};
use crate::limits::{Room, memory_left};
use crate::share::ShareOfPoints;
pub use axisymmetric::in_plane;
pub use drawn::{Acting, ActingOn, Along, BodyShares, DrawnLoad, DrawnSide, acting, shares_at_rest};
pub use drive::{DrivenPath, drive};
pub use tool_surfaces::{ToolSurface, tool_surfaces};

use basis::{FillBody, check_domains, domain_limit};
use bodies::{Bodies, bodies};
use loads::{Torque, loads, probes};
use mesh::{layout, motion};
use mpm_assembly::{GhostStabilisation, MarkerLoad, Space, ToolContact, WallContact};
use mpm_basis::{ActiveNodes, Stencils};
use mpm_geometry::MemoryLimit;
use mpm_grid::{Layout, LoadFraction, Mesh, MeshMotion, NodeKind, NodeSpace};
use mpm_linear::Choice;
use mpm_solver::{Model, NamedBody, Prescribed, SolverChoice, StepFailure, Tolerance, UnheldMotion};
use sides::side_loads;
use stages::{Stages, refuse_jumps_along_a_path, refuse_resets, stages};
use supports::{check_supports, supports};
use symmetry::{Sides, check_planes};
use tools::{ToolParts, tools};
use turning::{OfSection, turning};
use walls::walls;

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
    made(scene, files, Room::for_all(memory_left()))
}

/// As [`compile_with`], of the points that one of several ranks makes. The model can be run by ranks that share it,
/// [`mpm_solver::run_on`], and by nobody else.
///
/// # Errors
/// As [`compile_with`]; what is wrong with a point is told by the rank that makes it.
pub fn compile_share(
    scene: &Scene,
    files: &dyn SceneFiles,
    share: ShareOfPoints,
) -> Result<Compiled, SceneError> {
    compile_share_within(scene, files, share, memory_left().bytes / share.on_machine.max(1) as u64)
}

/// As [`compile_share`], with so many bytes of memory in place of the rank's part of the machine's.
///
/// # Errors
/// As [`compile_share`].
pub fn compile_share_within(
    scene: &Scene,
    files: &dyn SceneFiles,
    share: ShareOfPoints,
    bytes: u64,
) -> Result<Compiled, SceneError> {
    made(scene, files, Room { memory: MemoryLimit { bytes }, share })
}

/// As [`compile_with`], with so many bytes of memory in place of the machine's.
///
/// # Errors
/// As [`compile_with`].
pub fn compile_within(scene: &Scene, files: &dyn SceneFiles, bytes: u64) -> Result<Compiled, SceneError> {
    made(scene, files, Room::for_all(MemoryLimit { bytes }))
}

/// The mesh of a scene and how it moves; files that the scene names are not asked for.
///
/// # Errors
/// What is wrong with either, with its path.
pub fn mesh_of<const D: usize, B>(scene: &SceneIn<D, B>) -> Result<(Layout<D>, MeshMotion<D>), SceneError> {
    let memory = memory_left();
    let layout = layout(&scene.mesh, memory)?;
    let motion = motion(&scene.motion, Stages::of(&scene.schedule), (&layout, Space::default()), memory)?;
    Ok((layout, motion))
}

fn made(scene: &Scene, files: &dyn SceneFiles, room: Room) -> Result<Compiled, SceneError> {
    Ok(match scene {
        Scene::PlaneStrain(scene) => {
            Compiled::Plane(model(scene, Space::Cartesian, files, room)?.whole(&scene.output)?)
        }
        Scene::Axisymmetric(scene) => {
            let made = model(&in_plane(scene)?, Space::Axisymmetric, files, room)?;
            match scene.twist {
                true => Compiled::Solid(made.turning(scene)?),
                false => Compiled::Plane(made.whole(&scene.output)?),
            }
        }
        Scene::Solid(scene) => {
            Compiled::Solid(model(scene, Space::Cartesian, files, room)?.whole(&scene.output)?)
        }
    })
}

/// What is made of a scene, until its contributions are put together.
struct Made<const D: usize> {
    /// The model without contributions.
    model: Model<D>,
    ghost: Option<f64>,
    tools: Vec<ToolContact<D>>,
    walls: Vec<WallContact<D>>,
    /// Loads on sides, with their numbers.
    side_loads: Vec<(usize, MarkerLoad<D>)>,
    torques: Vec<Torque<D>>,
    /// The sides on which bodies are cut by the ends of the mesh.
    cuts: Vec<Sides<D>>,
    memory: MemoryLimit,
}

impl<const D: usize> Made<D> {
    /// The model with its contributions, checked.
    fn whole(mut self, output: &OutputInput) -> Result<Model<D>, SceneError> {
        if let Some(factor) = self.ghost {
            self.model.add_contribution("ghost", GhostStabilisation::new(factor).into());
        }
        for contact in std::mem::take(&mut self.tools) {
            self.model.add_contribution(format!("tool {}", contact.name()), contact.into());
        }
        for contact in std::mem::take(&mut self.walls) {
            self.model.add_contribution(format!("wall {}", contact.name()), contact.into());
        }
        for (k, load) in std::mem::take(&mut self.side_loads) {
            self.model.add_contribution(format!("load {k}"), load.into());
        }
        fields(&self.model, output)?;
        self.check()?;
        Ok(self.model)
    }

    fn check(&self) -> Result<(), SceneError> {
        let Self { model, cuts, memory, .. } = self;
        let mesh = model.motion.mesh_at(&model.layout, LoadFraction::START);
        let mesh = mesh.map_err(|it| SceneError::new("motion", it))?;
        model.check_nodes().map_err(|it| SceneError::new("basis", it))?;
        axisymmetric::check(model)?;
        check_start(model, &mesh, *memory)?;
        check_planes(cuts, model, &mesh)
    }
}

impl Made<2> {
    /// The model of bodies that turn about their axis; `scene` is that in R and Z.
    fn turning(self, scene: &SceneIn<2, PlaneBasis>) -> Result<Model<3>, SceneError> {
        self.check()?;
        let Self { model, ghost, tools, torques, memory, .. } = self;
        let model = turning(OfSection { model, tools, torques, ghost }, scene)?;
        let (tools, walls, side_loads) = (Vec::new(), Vec::new(), Vec::new());
        let (torques, cuts) = (Vec::new(), Vec::new());
        Made { model, ghost: None, tools, walls, side_loads, torques, cuts, memory }.whole(&scene.output)
    }
}

fn model<const D: usize, B: FillBody<D> + ToolParts<D>>(
    scene: &SceneIn<D, B>,
    space: Space,
    files: &dyn SceneFiles,
    room: Room,
) -> Result<Made<D>, SceneError> {
    let memory = room.memory;
    if scene.twist && !space.is_axisymmetric() {
        return Err(SceneError::new("twist", "bodies turn about an axis in `Axisymmetric` scenes only"));
    }
    check_domains(&scene.basis, &scene.domains)?;
    if scene.output.checkpoint.as_ref().is_some_and(|it| it.every.is_none() && it.seconds.is_none()) {
        return Err(SceneError::new("output.checkpoint", "expected `every` or `seconds`"));
    }
    let made = stages(&scene.schedule)?;
    let stages = Stages::of(&scene.schedule);
    let layout = layout(&scene.mesh, memory)?;
    let motion = motion(&scene.motion, stages, (&layout, space), memory)?;
    let mesh = motion.mesh_at(&layout, LoadFraction::START).map_err(|it| SceneError::new("motion", it))?;
    for end in stages.ends() {
        motion.mesh_at(&layout, end).map_err(|it| SceneError::new("motion", it))?;
    }

    splines::check(scene, &mesh)?;
    if scene.twist && mesh.functions() != NodeKind::Vertices {
        return Err(SceneError::new(
            "twist",
            "bodies that turn about their axis have `Linear` functions of the mesh",
        ));
    }
    let Bodies { bodies, faces, boundaries, cuts, places, numbers } =
        bodies(scene, (&layout, &mesh, space), files, room)?;
    let probes = probes(scene, (&bodies, &places), &mesh)?;
    let kind = bodies.first().map_or(mesh.functions(), |named| named.body.node_kind(&mesh));
    let nodes = NodeSpace::of(kind, &mesh).map_err(|it| SceneError::new("basis", it))?;
    let mut model = Model::on(layout, nodes);
    model.motion = motion;
    model.supports = supports(scene, (&model.layout, &model.nodes), space)?;
    let torques;
    (model.loads, torques) = loads(scene, (&bodies, &places), &mesh, faces)?;
    model.domain_limit = domain_limit(&scene.domains, &places);
    drop(places);
    model.bodies = bodies;
    model.share = numbers.into_iter().collect();
    model.stages = made;
    check_supports(&model)?;
    refuse_jumps_along_a_path(&model)?;
    refuse_resets(&model, matches!(scene.domains.control, Some(ControlInput::Split { .. })))?;
    if !scene.tools.is_empty() {
        splines::check_tools(&model.bodies, &mesh)?;
    }
    let tools = tools(scene, &model, files)?;
    let sides = sides::Sides { inputs: &scene.bodies, boundaries: &boundaries };
    let walls = walls(scene, &sides, &model, files)?;
    let side_loads = side_loads(scene, &sides, (&model, &mesh))?;
    model.domain_history = scene.output.domain_history;
    model.energies = scene.output.energies;
    model.probes = probes;
    model.condition_history = scene.output.condition;
    model.unheld_motion = match scene.unheld_motion {
        UnheldMotionInput::Refuse => UnheldMotion::Refuse,
        UnheldMotionInput::Zero => UnheldMotion::Zero,
    };
    model.solver = SolverChoice::from(match scene.solver {
        SolverInput::Auto => Choice::Auto,
        SolverInput::Direct => Choice::Direct,
        SolverInput::Iterative => Choice::Iterative,
    });
    model.tolerance = tolerance(&scene.tolerance)?;
    let usual = || GhostStabilisation::<D>::usual_factor(mesh.functions());
    let ghost = scene
        .stabilisation
        .as_ref()
        .map(|StabilisationInput::Ghost { factor }| factor.map_or_else(usual, |it| it.0));
    Ok(Made { model, ghost, tools, walls, side_loads, torques, cuts, memory })
}

fn tolerance(input: &ToleranceInput) -> Result<Tolerance, SceneError> {
    if input.residual.0 >= 1.0 {
        let reason =
            format!("is {}, expected less than 1: no force would have to be balanced", input.residual.0);
        return Err(SceneError::new("tolerance.residual", reason));
    }
    let keep_factor_below = input.keep_factor_below.map(|part| part.0);
    if let Some(part) = keep_factor_below.filter(|part| *part >= 1.0) {
        return Err(SceneError::new("tolerance.keep_factor_below", format!("is {part}, expected less than 1")));
    }
    Ok(Tolerance { residual: input.residual.0, iterations: input.iterations.0, keep_factor_below })
}

/// The start of the first load step: the mesh covers every point, and what is driven carries material.
fn check_start<const D: usize>(
    model: &Model<D>,
    mesh: &Mesh<D>,
    memory: MemoryLimit,
) -> Result<(), SceneError> {
    let stencils: Vec<Stencils<D>> =
        model.bodies.iter().map(|body| nodes(body, mesh)).collect::<Result<_, _>>()?;
    let around = ActiveNodes::nodes_around(&model.nodes, &stencils);
    let room_for = memory.check("the part of the mesh around the bodies", around as f64, size_of::<u32>());
    room_for.map_err(|it| SceneError::new("bodies", it))?;
    let active = ActiveNodes::of(&model.nodes, &stencils);
    // Where other ranks make points, too, the run looks at the points of all.
    let all = model.share.is_none();
    for (k, support) in model.supports.iter().enumerate().filter(|(_, it)| all && it.acts_in(0)) {
        let driven = support.components.iter().flatten().any(|it| *it != Prescribed::Held);
        if driven && !support.nodes.iter().any(|&node| active.number(node).is_some()) {
            return Err(SceneError::new(
                format!("supports[{k}].region"),
                format!("support `{}` drives nodes, but none of them carries material", support.name),
            ));
        }
        let mut carrying = support.nodes.iter().filter(|&&node| active.number(node).is_some());
        if let Some(Prescribed::Turned(turn)) = support.components.iter().flatten().find(|it| it.is_turn())
            && carrying.all(|&node| turn.is_at_axis(&model.nodes.position(mesh, node), mesh))
        {
            return Err(SceneError::new(
                format!("supports[{k}].turn"),
                format!(
                    "every node of support `{}` that carries material lies on the axis: nothing turns",
                    support.name
                ),
            ));
        }
    }
    Ok(())
}

fn nodes<const D: usize>(named: &NamedBody<D>, mesh: &Mesh<D>) -> Result<Stencils<D>, SceneError> {
    named.body.nodes(mesh).map_err(|it| {
        let (body, basis, reason) = (named.name.clone(), named.body.basis(), it.to_string());
        SceneError::new("bodies", StepFailure::Outside { body, basis, reason })
    })
}

//! Bodies of revolution that turn about their axis: what has been made of the half plane (r, z), in its layer.

use super::loads::Torque;
use super::stages::Stages;
use super::supports::check_supports;
use super::tool_motion::ramp;
use crate::error::SceneError;
use crate::language::{Direction, PlaneBasis, SceneIn, SupportInput, ToolInput, ToolMotionInput};
use mpm_assembly::{GhostStabilisation, RigidTool, ToolContact, ToolLoad};
use mpm_contact::{InLayer, Shape, Tool, ToolMotion};
use mpm_grid::{LoadFraction, NodeSpace, Ramp, Vector, raised};
use mpm_solver::{Loads, Model, NamedBody, PointLoad, Prescribed, Probe, Share, Side, SideLoad, Support};
use nalgebra::Vector3;

/// What has been made of a scene in its half plane.
pub(super) struct OfSection {
    /// The model without its contributions.
    pub model: Model<2>,
    pub tools: Vec<ToolContact<2>>,
    pub torques: Vec<Torque>,
    /// Factor of the ghost stabilisation, where there is one.
    pub ghost: Option<f64>,
}

/// The model of the bodies that turn; `scene` is that in R and Z.
///
/// # Errors
/// What the scene says of turns is wrong, or the mesh has too many nodes.
pub(super) fn turning(of: OfSection, scene: &SceneIn<2, PlaneBasis>) -> Result<Model<3>, SceneError> {
    let OfSection { model: section, tools, torques, ghost } = of;
    let stages = Stages::of(&scene.schedule);
    let layout = section.layout.as_layer().map_err(|it| SceneError::new("mesh", it))?;
    let motion = section.motion.as_layer().expect("scenes have no motions that someone else has written");
    let mesh = motion.mesh_at(&layout, LoadFraction::START).map_err(|it| SceneError::new("motion", it))?;
    let nodes = NodeSpace::of(section.nodes.kind(), &mesh).map_err(|it| SceneError::new("basis", it))?;
    let mut model = Model::on(layout, nodes);
    model.motion = motion;
    let pairs = section.supports.into_iter().zip(&scene.supports).enumerate();
    let support = |(k, (support, input))| turned_support(support, input, stages, &format!("supports[{k}]"));
    model.supports = pairs.map(support).collect::<Result<_, _>>()?;
    model.loads = loads(section.loads, torques);
    model.domain_limit = section.domain_limit;
    model.probes = section.probes.into_iter().map(probe).collect();
    model.bodies = section.bodies.into_iter().map(body).collect();
    model.stages = section.stages;
    check_supports(&model)?;
    if let Some(factor) = ghost {
        model.add_contribution("ghost", GhostStabilisation::new(factor).into());
    }
    for (k, (contact, input)) in tools.into_iter().zip(&scene.tools).enumerate() {
        let (name, rigid) = contact.into_rigid();
        let rigid = turned_tool(rigid, input, stages, &format!("tools[{k}].motion"))?;
        model.add_contribution(format!("tool {name}"), ToolContact::new(name, rigid).into());
    }
    (model.domain_history, model.energies) = (section.domain_history, section.energies);
    (model.condition_history, model.needs_grip) = (section.condition_history, section.needs_grip);
    (model.unheld_motion, model.tolerance) = (section.unheld_motion, section.tolerance);
    model.solver = section.solver;
    model.share = section.share;
    Ok(model)
}

fn body(named: NamedBody<2>) -> NamedBody<3> {
    let NamedBody { name, body, shape_volume, density } = named;
    let body = body.with_twist().expect("the bodies of the scene are bodies of revolution");
    NamedBody { name, body, shape_volume, density }
}

fn probe(probe: Probe<2>) -> Probe<3> {
    let Probe { name, body, points, rest } = probe;
    Probe { name, body, points, rest: raised(&rest) }
}

/// A support with what it prescribes of the angle.
fn turned_support(
    support: Support<2>,
    input: &SupportInput<2>,
    stages: Stages<'_>,
    path: &str,
) -> Result<Support<3>, SceneError> {
    let Support { name, nodes, components: [r, z], active, .. } = support;
    let held = input.fix.iter().filter(|it| **it == Direction::Theta).map(|_| Ok(Prescribed::Held));
    let driven = input.displace.iter().enumerate().filter(|(_, it)| it.axis == Direction::Theta);
    let driven = driven.map(|(k, displace)| {
        let path = format!("{path}.displace[{k}].ramp");
        Ok(Prescribed::Driven(stages.ramp(&displace.ramp, displace.by.0.to_radians(), active, &path)?))
    });
    let mut angles = held.chain(driven).collect::<Result<Vec<Prescribed>, SceneError>>()?;
    let angle = angles.pop();
    if !angles.is_empty() {
        return Err(SceneError::new(path, "component Theta is prescribed twice"));
    }
    Ok(Support { name, nodes, components: [r, z, angle], moment_about: None, active })
}

fn loads(of: Loads<2>, torques: Vec<Torque>) -> Loads<3> {
    let Loads { body_forces, point_loads, side_loads, fields } = of;
    assert!(fields.is_empty(), "no scene of bodies of revolution has a force that is a field");
    let share = |Share { point, part, arm }: Share<2>| Share { point, part, arm: raised(&arm) };
    let point_load = |PointLoad { body, shares, force, ramp }| {
        let shares = shares.into_iter().map(share).collect();
        PointLoad { body, shares, force: raised(&force), ramp }
    };
    let side = |Side { point, arms, parts }: Side<2>| Side { point, arms: arms.map(|arm| raised(&arm)), parts };
    let of_sides = |body, sides: Vec<Side<2>>, force: Vector<3>, ramp: Ramp| SideLoad {
        body,
        sides: sides.into_iter().map(side).collect(),
        force,
        ramp,
    };
    let forces = side_loads
        .into_iter()
        .map(|SideLoad { body, sides, force, ramp }| of_sides(body, sides, raised(&force), ramp));
    let torques = torques.into_iter().map(|Torque { body, sides, moment, ramp }| {
        of_sides(body, sides, Vector::<3>::new(0.0, 0.0, moment), ramp)
    });
    Loads {
        body_forces: body_forces.iter().map(|(force, ramp)| (raised(force), ramp.clone())).collect(),
        point_loads: point_loads.into_iter().map(point_load).collect(),
        side_loads: forces.chain(torques).collect(),
        fields: Vec::new(),
    }
}

/// A tool with what the scene says of its turn about the axis: a shift along the angle.
fn turned_tool(
    rigid: RigidTool<2>,
    input: &ToolInput<2>,
    stages: Stages<'_>,
    path: &str,
) -> Result<RigidTool<3>, SceneError> {
    let RigidTool { tool, motion, load, interface, exact_friction, bodies, cut_bodies, moment_about, .. } =
        rigid;
    let in_layer = |part| Box::new(InLayer(part)) as Box<dyn Shape<3>>;
    let tool = Tool::new(tool.into_parts().into_iter().map(in_layer).collect());
    let angle = match &input.motion {
        ToolMotionInput::Move { turn: Some(turn), .. } => {
            ramp(stages, &turn.ramp, turn.angle.0.to_radians(), &format!("{path}.turn.ramp"))?
        }
        _ => Ramp::constant(0.0),
    };
    let motion = match motion.displacement() {
        Some([r, z]) => ToolMotion::shifted([r.clone(), z.clone(), angle]),
        None => Ok(ToolMotion::rest()),
    };
    let load = load.map(|ToolLoad { free, force, moment, ramp, follows }| ToolLoad {
        // The turn in the plane has the number of the third shift.
        free,
        force: Vector::<3>::new(force[0], force[1], moment.z),
        moment: Vector3::zeros(),
        ramp,
        follows,
    });
    Ok(RigidTool {
        tool: tool.map_err(|it| SceneError::new(path, it.to_string()))?,
        motion: motion.map_err(|it| SceneError::new(path, it.to_string()))?,
        load,
        interface,
        exact_friction,
        bodies,
        cut_bodies,
        turns: true,
        moment_about: raised(&moment_about),
    })
}

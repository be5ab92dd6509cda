//! Supports: which nodes, and what is prescribed of them.

use super::mesh::{component, plane_point};
use super::names::{A_NAME, is_name};
use super::stages::Stages;
use crate::error::SceneError;
use crate::language::{Direction, RegionInput, SceneIn, SupportInput, TurnInput};
use crate::limits::check_search;
use mpm_assembly::Space;
use mpm_grid::{Axis, Layout, LoadFraction, Mesh, NodeId, NodeKind, NodeSpace, Position, Region, Vector};
use mpm_solver::{Active, Model, Prescribed, Release, Support, Turn, across};
use std::cell::OnceCell;

fn region<const D: usize>(input: &RegionInput<D>, path: &str) -> Result<Region<D>, SceneError> {
    Ok(match input {
        RegionInput::Plane { axis, at } => {
            Region::Plane { axis: component::<D>(*axis, &format!("{path}.axis"))?, at: at.0 }
        }
        RegionInput::Box { from, to } => Region::Box { from: Vector::from(from.0), to: Vector::from(to.0) },
        RegionInput::Point(x) => Region::Point(Vector::from(x.0)),
        RegionInput::Circle { centre, radius } => {
            Region::Circle { centre: plane_point(centre), radius: radius.0 }
        }
        RegionInput::Annulus { centre, inner, outer } => {
            Region::Annulus { centre: plane_point(centre), inner: inner.0, outer: outer.0 }
        }
        RegionInput::Ray { centre, angle } => {
            let (sine, cosine) = angle.0.to_radians().sin_cos();
            // At right angles exactly along the axes.
            let along = [cosine, sine].map(|x| if x.abs() < 1e-15 { 0.0 } else { x });
            Region::Ray { centre: plane_point(centre), along }
        }
        RegionInput::Everywhere => Region::Everywhere,
        RegionInput::All(regions) => Region::All(
            regions
                .iter()
                .enumerate()
                .map(|(k, input)| region(input, &format!("{path}[{k}]")))
                .collect::<Result<_, _>>()?,
        ),
    })
}

pub(super) fn supports<const D: usize, B>(
    scene: &SceneIn<D, B>,
    (layout, space): (&Layout<D>, &NodeSpace<D>),
    bodies: Space,
) -> Result<Vec<Support<D>>, SceneError> {
    let stages = Stages::of(&scene.schedule);
    let mut supports: Vec<Support<D>> = Vec::with_capacity(scene.supports.len());
    let mut sought = 0.0;
    for (k, input) in scene.supports.iter().enumerate() {
        let path = format!("supports[{k}]");
        let name = &input.name;
        if !is_name(name) || supports.iter().any(|it| it.name == *name) {
            let reason = format!("expected {A_NAME}, got {name:?}");
            return Err(SceneError::new(format!("{path}.name"), reason));
        }
        if name == "total" {
            let reason = "`total` is the sum of all reactions, expected another name";
            return Err(SceneError::new(format!("{path}.name"), reason));
        }
        let region = region(&input.region, &format!("{path}.region"))?;
        sought += region.candidates(space, layout);
        check_search(sought).map_err(|it| SceneError::new(format!("{path}.region"), it))?;
        let nodes = region.nodes(space, layout);
        if nodes.is_empty() {
            return Err(SceneError::new(format!("{path}.region"), no_node(&region, layout, bodies.axes())));
        }
        super::splines::check_region(&region, &nodes, (layout, space))
            .map_err(|it| SceneError::new(format!("{path}.region"), it))?;
        let active = stages.active(&input.active, &path)?;
        if let Some(until) = active.until.filter(|&until| stages.follows_path(until))
            && active.release == Release::AtOnce
        {
            return Err(stages.at_once_on_a_path(until, &path));
        }
        supports.push(Support {
            name: input.name.clone(),
            nodes,
            components: components(input, (stages, active), (bodies, scene.twist), &path)?,
            moment_about: moment_about::<D>(input, &path)?,
            active,
        });
    }
    Ok(supports)
}

/// Why a region holds no node: where nodes stand instead, if that can be said.
fn no_node<const D: usize>(region: &Region<D>, layout: &Layout<D>, names: [&str; 3]) -> String {
    if let NodeKind::ControlPoints { .. } = layout.functions() {
        return super::splines::off_faces(layout);
    }
    let missed = "the region holds no node of the mesh";
    let beside = |what: &str, axis: &Axis, at: f64| {
        let (cell, _) = axis.locate(at.clamp(axis.first(), axis.last()));
        let (before, after) = (axis.node(cell), axis.node(cell + 1));
        format!("{missed}: it is at {what} = {at}, nodes are at {before} and {after}")
    };
    match (region, layout) {
        (Region::Plane { axis, at }, Layout::Box { axes, .. }) => beside(names[*axis], &axes[*axis], *at),
        (Region::Plane { axis: 2, at }, Layout::Ring { height: Some(axis), .. }) => beside("z", axis, *at),
        (Region::Point(x), Layout::Box { axes, .. }) => {
            let nearest = Vector::<D>::from_fn(|d, _| {
                let (cell, _) = axes[d].locate(x[d].clamp(axes[d].first(), axes[d].last()));
                let ends = [axes[d].node(cell), axes[d].node(cell + 1)];
                if x[d] - ends[0] < ends[1] - x[d] { ends[0] } else { ends[1] }
            });
            format!("{missed}: the nearest node is at {}", Position(&nearest))
        }
        (Region::Circle { centre, radius }, Layout::Ring { radii, centre: of_mesh, .. })
            if centre == of_mesh =>
        {
            beside("radius", radii, *radius)
        }
        _ => missed.into(),
    }
}

fn components<const D: usize>(
    input: &SupportInput<D>,
    (stages, active): (Stages<'_>, Active),
    (bodies, twist): (Space, bool),
    path: &str,
) -> Result<[Option<Prescribed>; D], SceneError> {
    let held = input.fix.iter().map(|axis| Ok((*axis, Prescribed::Held)));
    let following = input.follow_mesh.iter().map(|axis| Ok((*axis, Prescribed::FollowMesh)));
    let driven = input.displace.iter().enumerate().map(|(k, displace)| {
        let ramp = stages.ramp(&displace.ramp, displace.by.0, active, &format!("{path}.displace[{k}].ramp"))?;
        Ok((displace.axis, Prescribed::Driven(ramp)))
    });
    let turned = input.turn.as_ref().map(|it| turn::<D>(it, (stages, active), &format!("{path}.turn")));
    let turned = turned.transpose()?;
    let turned = turned.iter().flat_map(|turn| {
        let directions = [Direction::X, Direction::Y, Direction::Z];
        turn.across().map(|axis| Ok((directions[axis], Prescribed::Turned(turn.clone()))))
    });
    let (names, mut turns) = (bodies.directions(), false);
    let mut components = [const { None }; D];
    for entry in held.chain(following).chain(driven).chain(turned) {
        let (axis, prescribed) = entry?;
        if axis == Direction::Theta && twist {
            // What is prescribed of the angle is no component in the half plane, see `turning.rs`.
            turns = true;
            continue;
        }
        let component = component::<D>(axis, path)?;
        if components[component].is_some() {
            let reason = format!("component {} is prescribed twice", names[component]);
            return Err(SceneError::new(path, reason));
        }
        components[component] = Some(prescribed);
    }
    if components.iter().all(Option::is_none) && !turns {
        return Err(SceneError::new(
            path,
            "expected `fix`, `displace` or `follow_mesh` with at least one direction, or `turn`",
        ));
    }
    Ok(components)
}

/// Point about which the moment of the reaction is recorded, if it is; 0 along the axis.
fn moment_about<const D: usize>(input: &SupportInput<D>, path: &str) -> Result<Option<[f64; 3]>, SceneError> {
    let turn = input.turn.as_ref();
    let axis = input.moment_axis.or(turn.map(|turn| turn.axis)).unwrap_or(Direction::Z);
    if D == 2 && axis != Direction::Z {
        return Err(SceneError::new(format!("{path}.moment_axis"), "in the plane moments are about `Z`"));
    }
    // Without a point, the axis is that of the turn.
    let of_turn = turn.filter(|turn| turn.axis == axis).map(|turn| &turn.centre);
    let Some(centre) = input.moment_about.as_ref().or(of_turn) else {
        if input.moment_axis.is_some() {
            let reason = "expected `moment_about`, where the axis passes";
            return Err(SceneError::new(format!("{path}.moment_axis"), reason));
        }
        return Ok(None);
    };
    let (across, centre) = (across(axis.index()), plane_point(centre));
    let mut about = [0.0; 3];
    (about[across[0]], about[across[1]]) = (centre[0], centre[1]);
    Ok(Some(about))
}

fn turn<const D: usize>(
    input: &TurnInput,
    (stages, active): (Stages<'_>, Active),
    path: &str,
) -> Result<Turn, SceneError> {
    if D == 2 && input.axis != Direction::Z {
        return Err(SceneError::new(format!("{path}.axis"), "in the plane nodes turn about `Z`"));
    }
    let angle = stages.ramp(&input.ramp, input.angle.0.to_radians(), active, &format!("{path}.ramp"))?;
    Ok(Turn { axis: input.axis.index(), centre: plane_point(&input.centre), angle })
}

/// Refuses supports that prescribe different displacements of a node in any stage.
///
/// # Errors
/// The first pair of supports.
pub(super) fn check_supports<const D: usize>(model: &Model<D>) -> Result<(), SceneError> {
    (0..model.stages.len() as u32).try_for_each(|stage| refuse_contradictions(model, stage))
}

fn refuse_contradictions<const D: usize>(model: &Model<D>, stage: u32) -> Result<(), SceneError> {
    let supports = &model.supports;
    let parts = OnceCell::new();
    for (component, axis) in model.space().axes().into_iter().enumerate().take(D) {
        let mut claims: Vec<(NodeId, usize)> = supports
            .iter()
            .enumerate()
            .filter(|(_, support)| support.acts_in(stage) && support.components[component].is_some())
            .flat_map(|(k, support)| support.nodes.iter().map(move |&node| (node, k)))
            .collect();
        claims.sort_unstable();
        for pair in claims.windows(2) {
            let [(node, first), (other, second)] = [pair[0], pair[1]];
            let (a, b) = (&supports[first], &supports[second]);
            let [said, again] = [a, b].map(|support| support.components[component].as_ref());
            if node != other || said == again {
                continue;
            }
            let moves = |prescribed| {
                increments(model, prescribed, (node, component), parts.get_or_init(|| parts_of(model, stage)))
            };
            let is_same = |(a, b): (f64, f64)| (a - b).abs() <= SAME * model_size(model);
            let agree = said.and_then(moves).zip(again.and_then(moves));
            if agree.is_none_or(|(a, b)| !a.into_iter().zip(b).all(is_same)) {
                return Err(SceneError::new(
                    format!("supports[{second}]"),
                    format!(
                        "supports `{}` and `{}` prescribe different displacements along {} of the node at {}",
                        a.name,
                        b.name,
                        axis,
                        Position(&model.nodes.position(&Mesh::at_rest(&model.layout), node))
                    ),
                ));
            }
        }
    }
    Ok(())
}

/// Part of the size of a mesh by which displacements of a node may differ that are the same.
const SAME: f64 = 1e-10;

/// Parts of a stage in which displacements are compared.
const PARTS: u32 = 16;

/// A part of a stage, and the mesh at its start.
type StagePart<const D: usize> = (LoadFraction, LoadFraction, Mesh<D>);

fn model_size<const D: usize>(model: &Model<D>) -> f64 {
    Mesh::at_rest(&model.layout).diagonal()
}

fn parts_of<const D: usize>(model: &Model<D>, stage: u32) -> Vec<StagePart<D>> {
    let part = |k: u32| {
        let at = |k: u32| LoadFraction::in_stage(stage, f64::from(k) / f64::from(PARTS)).ok();
        let (from, to) = (at(k)?, at(k + 1)?);
        Some((from, to, model.motion.mesh_at(&model.layout, from).ok()?))
    };
    (0..PARTS).filter_map(part).collect()
}

/// What is prescribed of a component of a node in every part of a stage `[L]`; none where it depends on more than the load
/// fraction and the mesh.
fn increments<const D: usize>(
    model: &Model<D>,
    prescribed: &Prescribed,
    (node, component): (NodeId, usize),
    parts: &[StagePart<D>],
) -> Option<Vec<f64>> {
    let of = |(from, to, mesh): &StagePart<D>| match prescribed {
        Prescribed::Held => Some(0.0),
        Prescribed::Driven(ramp) => Some(ramp.from_rest(*to) - ramp.from_rest(*from)),
        Prescribed::FollowMesh => {
            let moved = model.nodes.displacement((&model.motion, &model.layout), node, mesh, (*from, *to));
            Some(moved.ok()?[component])
        }
        Prescribed::Turned(_) => None,
    };
    parts.iter().map(of).collect()
}

//! Bodies of revolution: what a scene in (r, z) is as one in the coordinates (x, y) of a plane mesh, and what such a scene
//! cannot have.

use super::loads::NO_MOMENT;
use crate::error::SceneError;
use crate::language::{
    BodyInput, Coordinates, CornerWeightsInput, Direction, Finite, FreeInput, LoadInput, MeanDilatationInput,
    MotionInput, PlaneBasis, PlanePoint, RegionInput, SceneIn, ShapeInput, SupportInput, ToolInput,
    ToolMotionInput, ToolPartInput, ToolTurnInput,
};

use mpm_solver::{Model, ModelError};

/// Why bodies of revolution have no walls and no loads on sides.
const NO_SIDES: &str = "sides of bodies of revolution have no names, expected a scene in the plane or in space";

type RingScene = SceneIn<2, PlaneBasis>;

/// The scene with its directions R and Z as the first and second one, and its shapes and tools as sections.
///
/// # Errors
/// The first thing that is no figure of revolution, or would turn or push about the axis.
pub fn in_plane(scene: &RingScene) -> Result<RingScene, SceneError> {
    let mut scene = scene.clone();
    if scene.domains.corner_weights == Some(CornerWeightsInput::Frozen) {
        let reason =
            "weights at rest do not balance the hoop stress: expected `Current` in `Axisymmetric` scenes";
        return Err(SceneError::new("domains.corner_weights", reason));
    }
    motion(&mut scene.motion)?;
    let twist = scene.twist;
    for (k, body) in scene.bodies.iter_mut().enumerate() {
        let path = format!("bodies[{k}]");
        if twist && body.mean_dilatation == Some(MeanDilatationInput::Cell) {
            let reason = "is that of cells, expected `Points` for bodies that turn about their axis";
            return refuse(format!("{path}.mean_dilatation"), reason);
        }
        self::body(body, &path)?;
    }
    for (k, support) in scene.supports.iter_mut().enumerate() {
        self::support(support, twist, &format!("supports[{k}]"))?;
    }
    for (k, load) in scene.loads.iter_mut().enumerate() {
        self::load(load, twist, &format!("loads[{k}]"))?;
    }
    if !scene.walls.is_empty() {
        return refuse("walls[0].side", NO_SIDES);
    }
    for (k, tool) in scene.tools.iter_mut().enumerate() {
        self::tool(tool, twist, &format!("tools[{k}]"))?;
    }
    Ok(scene)
}

/// Refuses a model whose mesh or supports leave the half plane r ≥ 0.
///
/// # Errors
/// What leaves it.
pub(super) fn check<const D: usize>(model: &Model<D>) -> Result<(), SceneError> {
    if !model.space().is_axisymmetric() {
        return Ok(());
    }
    model.check_axis().map_err(|it| {
        let path = match &it {
            ModelError::DrivenAxis { support } => {
                let place = model.supports.iter().position(|it| it.name == *support);
                format!("supports[{}]", place.unwrap_or(0))
            }
            _ => "mesh".into(),
        };
        SceneError::new(path, it)
    })
}

fn refuse<T>(path: impl Into<String>, reason: impl Into<String>) -> Result<T, SceneError> {
    Err(SceneError::new(path, reason.into()))
}

/// R is the first direction, Z the second.
fn turned(direction: &mut Direction, path: &str) -> Result<(), SceneError> {
    *direction = match direction {
        Direction::R => Direction::X,
        Direction::Z => Direction::Y,
        Direction::X | Direction::Y => {
            let reason = format!("{direction:?} is no direction of an `Axisymmetric` scene, expected R or Z");
            return refuse(path, reason);
        }
        Direction::Theta => return refuse(path, "Theta is no direction in the half plane, expected R or Z"),
    };
    Ok(())
}

fn motion(motion: &mut MotionInput<2>) -> Result<(), SceneError> {
    match motion {
        MotionInput::Stretch(stretches) => {
            for (k, stretch) in stretches.iter_mut().enumerate() {
                turned(&mut stretch.axis, &format!("motion[{k}].axis"))?;
            }
            Ok(())
        }
        MotionInput::Rotate { .. } | MotionInput::Twist { .. } => {
            refuse("motion", "turns the plane (r, z), which no figure of revolution does")
        }
        MotionInput::Fixed | MotionInput::Corners(_) | MotionInput::Expand { .. } => Ok(()),
    }
}

fn body(body: &mut BodyInput<2>, path: &str) -> Result<(), SceneError> {
    for (k, direction) in body.symmetry.iter_mut().enumerate() {
        turned(direction, &format!("{path}.symmetry[{k}]"))?;
    }
    let is_ball = matches!(body.shape, ShapeInput::Sphere { .. });
    section(&mut body.shape, &format!("{path}.shape"))?;
    // A disc that the axis cuts in half.
    if is_ball && !body.symmetry.contains(&Direction::X) {
        body.symmetry.push(Direction::X);
    }
    Ok(())
}

/// A shape of revolution as its section.
fn section(shape: &mut ShapeInput<2>, path: &str) -> Result<(), SceneError> {
    match shape {
        ShapeInput::Box { from, cutouts, .. } => {
            if from.0[0] < 0.0 {
                let reason = format!("begins at r = {}, expected r of at least 0", from.0[0]);
                return refuse(format!("{path}.from"), reason);
            }
            let mut cutouts = cutouts.iter_mut().enumerate();
            cutouts.try_for_each(|(k, cutout)| section(cutout, &format!("{path}.cutouts[{k}]")))
        }
        ShapeInput::Sphere { centre, radius } => {
            if centre.0[0] != 0.0 {
                let reason =
                    format!("lies at r = {}, expected 0: a disc beside the axis is no sphere", centre.0[0]);
                return refuse(format!("{path}.centre"), reason);
            }
            let centre = PlanePoint((Finite(0.0), Finite(centre.0[1])));
            *shape = ShapeInput::Cylinder { axis: Direction::Z, centre, radius: *radius, extent: None };
            Ok(())
        }
        ShapeInput::Polygon { vertices, .. } if vertices.iter().any(|point| point.0.0.0 < 0.0) => {
            refuse(format!("{path}.vertices"), "a corner has a negative r, expected r of at least 0")
        }
        ShapeInput::Cylinder { .. } | ShapeInput::Tube { .. } => {
            let reason = "in (r, z) a cylinder or a tube is a `Box`, and a ball a `Sphere`";
            refuse(path, reason)
        }
        _ => Ok(()),
    }
}

fn region(region: &mut RegionInput<2>, path: &str) -> Result<(), SceneError> {
    match region {
        RegionInput::Plane { axis, .. } => turned(axis, &format!("{path}.axis")),
        RegionInput::All(regions) => {
            for (k, region) in regions.iter_mut().enumerate() {
                self::region(region, &format!("{path}[{k}]"))?;
            }
            Ok(())
        }
        _ => Ok(()),
    }
}

/// As [`turned`]; the angle about the axis is left as it is.
fn turned_or_angle(direction: &mut Direction, twist: bool, path: &str) -> Result<(), SceneError> {
    match direction {
        Direction::Theta if twist => Ok(()),
        Direction::Theta => {
            refuse(path, "is the angle about the axis, which bodies turn by with `twist: true` only")
        }
        _ => turned(direction, path),
    }
}

fn support(support: &mut SupportInput<2>, twist: bool, path: &str) -> Result<(), SceneError> {
    region(&mut support.region, &format!("{path}.region"))?;
    for (k, direction) in support.fix.iter_mut().enumerate() {
        turned_or_angle(direction, twist, &format!("{path}.fix[{k}]"))?;
    }
    for (k, direction) in support.follow_mesh.iter_mut().enumerate() {
        turned(direction, &format!("{path}.follow_mesh[{k}]"))?;
    }
    for (k, displace) in support.displace.iter_mut().enumerate() {
        turned_or_angle(&mut displace.axis, twist, &format!("{path}.displace[{k}].axis"))?;
    }
    if support.turn.is_some() {
        return refuse(
            format!("{path}.turn"),
            "turns nodes in the plane (r, z), which no figure of revolution does",
        );
    }
    if support.moment_about.is_some() || support.moment_axis.is_some() {
        return refuse(
            format!("{path}.moment_about"),
            "forces on a whole ring have no moment about a point of (r, z)",
        );
    }
    Ok(())
}

fn load(load: &mut LoadInput<2>, twist: bool, path: &str) -> Result<(), SceneError> {
    match load {
        LoadInput::Traction { moment: Some(_), .. } if !twist => refuse(format!("{path}.moment"), NO_MOMENT),
        LoadInput::BodyForce { acceleration, .. } if acceleration.0[0] != 0.0 => {
            let reason =
                format!("is {} along r, expected 0: a body force acts along the axis", acceleration.0[0]);
            refuse(format!("{path}.acceleration"), reason)
        }
        LoadInput::Vortex { .. } => {
            refuse(path, "a vortex turns the plane (r, z), which no figure of revolution does")
        }
        LoadInput::Traction { side: Some(_), .. } | LoadInput::Pressure { .. } => {
            refuse(format!("{path}.side"), NO_SIDES)
        }
        LoadInput::Traction { axis, resultant, .. } => {
            if let Some(axis) = axis {
                turned(axis, &format!("{path}.axis"))?;
            }
            match resultant {
                Some(resultant) if resultant.0[0] != 0.0 => {
                    let reason =
                        "the force of a whole ring has no part along r, expected `value`, the traction";
                    refuse(format!("{path}.resultant"), reason)
                }
                _ => Ok(()),
            }
        }
        LoadInput::PointForce { near, force, .. } if near.0[0] <= 0.0 && force.0[0] != 0.0 => {
            refuse(format!("{path}.force"), "acts at r = 0, where nothing can be pushed along r")
        }
        LoadInput::BodyForce { .. } | LoadInput::PointForce { .. } => Ok(()),
    }
}

fn tool(tool: &mut ToolInput<2>, twist: bool, path: &str) -> Result<(), SceneError> {
    let no_turn =
        |path: String| refuse(path, "turns the tool, which takes bodies along with `twist: true` only");
    let along_r = |by: &Coordinates<2>, path: String| match by.0[0] {
        0.0 => Ok(()),
        r => refuse(path, format!("moves the tool by {r} along r, expected 0: it moves along the axis")),
    };
    match &mut tool.motion {
        ToolMotionInput::Rest => {}
        ToolMotionInput::Move { by, then, turn, .. } => {
            along_r(by, format!("{path}.motion.by"))?;
            for (k, shift) in then.iter().enumerate() {
                along_r(&shift.by, format!("{path}.motion.then[{k}].by"))?;
            }
            match turn.take() {
                None => {}
                Some(_) if !twist => return no_turn(format!("{path}.motion.turn")),
                // The turn itself is no motion in the half plane, see `turning.rs`.
                Some(ToolTurnInput { axis: Direction::Z, centre, .. }) if centre.0[0] == 0.0 => {}
                Some(ToolTurnInput { axis, centre, .. }) => {
                    let reason = format!(
                        "is a turn about {axis:?} through r = {}, expected one about Z through 0",
                        centre.0[0]
                    );
                    return refuse(format!("{path}.motion.turn"), reason);
                }
            }
        }
        ToolMotionInput::Screw { .. } => {
            let reason =
                "is no motion of a figure of revolution, expected `Move`, which can turn with `twist: true`";
            return refuse(format!("{path}.motion"), reason);
        }
        ToolMotionInput::Loaded { free, by, force, follows, moment, .. } => {
            along_r(by, format!("{path}.motion.by"))?;
            if *follows || force.0[0] != 0.0 || (moment.0 != 0.0 && !twist) {
                return refuse(
                    format!("{path}.motion"),
                    "a load on a figure of revolution acts along the axis",
                );
            }
            for (k, free) in free.iter_mut().enumerate() {
                *free = match free {
                    FreeInput::Z => FreeInput::Y,
                    FreeInput::Turn if twist => FreeInput::Turn,
                    _ => {
                        let reason = format!("{free:?} is no motion of a figure of revolution, expected Z");
                        return refuse(format!("{path}.motion.free[{k}]"), reason);
                    }
                };
            }
        }
    }
    for (k, part) in tool.parts.iter_mut().enumerate() {
        self::part(part, &format!("{path}.parts[{k}]"))?;
    }
    Ok(())
}

/// A part as its whole section, on both sides of the axis.
fn part(part: &mut ToolPartInput<2>, path: &str) -> Result<(), SceneError> {
    let on_axis = |axis: &Direction, r: f64, field: &str| match axis {
        Direction::Z if r == 0.0 => Ok(()),
        Direction::Z => refuse(format!("{path}.{field}"), format!("lies at r = {r}, expected 0: on the axis")),
        _ => refuse(format!("{path}.axis"), format!("is along {axis:?}, expected Z: about the axis")),
    };
    let point = |r: f64, z: f64| PlanePoint((Finite(r), Finite(z)));
    match part {
        ToolPartInput::Plane { normal, .. } => match normal.0[0] {
            0.0 => Ok(()),
            _ => refuse(format!("{path}.normal"), "leans against the axis, expected a normal along it"),
        },
        ToolPartInput::Disc { centre, .. } => on_axis(&Direction::Z, centre.0[0], "centre"),
        ToolPartInput::Polygon { vertices } => {
            if let Some(k) = vertices.iter().position(|vertex| vertex.0.0.0 < 0.0) {
                let reason = format!("lies at r = {}, expected r of at least 0", vertices[k].0.0.0);
                return refuse(format!("{path}.vertices[{k}]"), reason);
            }
            *vertices = whole(vertices);
            Ok(())
        }
        ToolPartInput::Cylinder { axis, centre, radius, extent: (from, to) } => {
            on_axis(axis, centre.0.0.0, "centre")?;
            let (r, from, to) = (radius.0, from.0, to.0);
            let vertices = vec![point(-r, from), point(r, from), point(r, to), point(-r, to)];
            *part = ToolPartInput::Polygon { vertices };
            Ok(())
        }
        ToolPartInput::Cone { axis, tip, radius, tip_radius, length } => {
            on_axis(axis, tip.0[0], "tip")?;
            let (r, blunt, from) = (radius.0, tip_radius.0, tip.0[1]);
            let to = from + length.0;
            let mut vertices = vec![point(r, to), point(-r, to)];
            if blunt > 0.0 {
                vertices.extend([point(-blunt, from), point(blunt, from)]);
            } else {
                vertices.push(point(0.0, from));
            }
            *part = ToolPartInput::Polygon { vertices };
            Ok(())
        }
        ToolPartInput::Helix { .. } | ToolPartInput::Surface { .. } => refuse(
            path,
            "is no figure of revolution, expected `Plane`, `Disc`, `Polygon`, `Cylinder` or `Cone`",
        ),
    }
}

/// A polygon that has an edge on the axis with its mirror image; any other one as it is.
fn whole(vertices: &[PlanePoint]) -> Vec<PlanePoint> {
    let n = vertices.len();
    let is_on_axis = |k: usize| vertices[k % n].0.0.0 == 0.0;
    let Some(edge) = (0..n).find(|&k| is_on_axis(k) && is_on_axis(k + 1)) else { return vertices.to_vec() };
    // From the end of that edge round to its start, and back on the other side.
    let half: Vec<PlanePoint> = (1..=n).map(|k| vertices[(edge + k) % n]).collect();
    let mirrored = half.iter().rev().filter(|vertex| vertex.0.0.0 > 0.0);
    let mirrored = mirrored.map(|PlanePoint((r, z))| PlanePoint((Finite(-r.0), *z)));
    half.iter().cloned().chain(mirrored).collect()
}

//! Walls.

use super::names::{A_NAME, is_name};
use super::sides::Sides;
use super::stages::Stages;
use super::tool_motion::{load, motion};
use super::tools::{ToolParts, smallest_edge};
use crate::error::SceneError;
use crate::files::SceneFiles;
use crate::language::{HoldInput, SceneIn, ToolPartInput, WallInput};
use mpm_assembly::{Hold, Wall, WallContact};
use mpm_contact::{Increment, Tool};
use mpm_grid::{Vector, six_digits};
use mpm_solver::Model;

/// Part of the smallest edge of a cell within which a side at rest lies on its wall.
const ON: f64 = 1e-6;

/// The walls of a scene, whose bodies are made.
pub(super) fn walls<const D: usize, B: ToolParts<D>>(
    scene: &SceneIn<D, B>,
    sides: &Sides<'_, D>,
    model: &Model<D>,
    files: &dyn SceneFiles,
) -> Result<Vec<WallContact<D>>, SceneError> {
    if !scene.walls.is_empty() && scene.stabilisation.is_none() {
        let reason =
            "walls hold functions of cells that bodies barely reach into: expected `stabilisation: Ghost()`";
        return Err(SceneError::new("walls", reason));
    }
    let mut walls = Vec::with_capacity(scene.walls.len());
    for (k, input) in scene.walls.iter().enumerate() {
        let path = format!("walls[{k}]");
        let is_taken = scene.walls[..k].iter().any(|before| before.name == input.name);
        if !is_name(&input.name) || is_taken {
            let reason = format!("expected {A_NAME}, got {:?}", input.name);
            return Err(SceneError::new(format!("{path}.name"), reason));
        }
        walls.push(wall::<D, B>(scene, (input, &path), sides, model, files)?);
    }
    Ok(walls)
}

fn wall<const D: usize, B: ToolParts<D>>(
    scene: &SceneIn<D, B>,
    (input, path): (&WallInput<D>, &str),
    sides: &Sides<'_, D>,
    model: &Model<D>,
    files: &dyn SceneFiles,
) -> Result<WallContact<D>, SceneError> {
    let stages = Stages::of(&scene.schedule);
    let side = sides.find(model, (&input.body, &input.side), true, path)?;
    let of_motion = format!("{path}.motion");
    let load = load(&input.motion, stages, &of_motion)?;
    if load.is_some() && input.hold != HoldInput::All {
        return Err(SceneError::new(of_motion, "a load moves walls that hold all: expected `hold: All`"));
    }
    let turns = |k: &usize| D == 3 && Increment::<D>::turn_axis(*k).is_some();
    if load.iter().flat_map(|load| &load.free).any(turns) {
        return Err(SceneError::new(
            of_motion,
            "in space a load shifts walls and turns none: expected `X`, `Y` or `Z`",
        ));
    }
    if input.exact && model.stages.iter().any(|stage| stage.path.is_some()) {
        let reason = "expected `false` under path control, which cannot balance a step again";
        return Err(SceneError::new(format!("{path}.exact"), reason));
    }
    let smallest = smallest_edge(&model.layout);
    let hold = match (input.hold, &input.surface) {
        (HoldInput::All, None) => Hold::All,
        (HoldInput::All, Some(_)) => {
            let reason = "stands beside `hold: All`, which holds the side as it is: expected none";
            return Err(SceneError::new(format!("{path}.surface"), reason));
        }
        (_, None) => {
            let reason =
                format!("expected `surface`, along which the side slides under `hold: {:?}`", input.hold);
            return Err(SceneError::new(path, reason));
        }
        (hold, Some(part)) => {
            let at = format!("{path}.surface");
            if !matches!(
                part,
                ToolPartInput::Plane { .. } | ToolPartInput::Disc { .. } | ToolPartInput::Cylinder { .. }
            ) {
                let reason = "expected `Plane`, `Disc` or, in space, `Cylinder`: a wall has no edges";
                return Err(SceneError::new(at, reason));
            }
            let part = B::part(part, 0.0, files).map_err(|it| SceneError::new(&at, it))?;
            let tool = Tool::new(vec![part]).map_err(|it| SceneError::new(&at, it.to_string()))?;
            if hold == HoldInput::Normal { Hold::Normal(tool) } else { Hold::Contact(tool) }
        }
    };
    let wall = Wall {
        side,
        hold,
        motion: motion(&input.motion, stages, &of_motion)?,
        load,
        stiffness: input.stiffness.0,
        exact: input.exact,
        moment_about: Vector::from(input.moment_about.0),
    };
    let contact = WallContact::new(&input.name, wall);
    let gap = contact.gap_at_rest();
    if gap > ON * smallest {
        let reason = format!(
            "the side `{}` of body `{}` is up to {} away from the wall at rest, expected on it",
            input.side,
            input.body,
            six_digits(gap)
        );
        return Err(SceneError::new(format!("{path}.surface"), reason));
    }
    Ok(contact)
}

//! How tools move: prescribed motions and loads.

use super::stages::Stages;
use crate::error::SceneError;
use crate::language::{
    Coordinates, Direction, FreeInput, PlanePoint, RampInput, ToolMotionInput, ToolTurnInput,
};
use mpm_assembly::ToolLoad;
use mpm_contact::{ContactError, ToolMotion};
use mpm_grid::{LoadFraction, Ramp, Vector};
use mpm_solver::Active;
use nalgebra::Vector3;

/// A point of an axis, by the coordinates across it and the one along it.
pub(super) fn on_axis(axis: Direction, centre: &PlanePoint, along: f64) -> Vector<3> {
    let PlanePoint((a, b)) = centre;
    match axis {
        Direction::X | Direction::R => Vector3::new(along, a.0, b.0),
        Direction::Y => Vector3::new(a.0, along, b.0),
        Direction::Z | Direction::Theta => Vector3::new(a.0, b.0, along),
    }
}

/// The motion that is prescribed.
pub(super) fn motion<const D: usize>(
    input: &ToolMotionInput<D>,
    stages: Stages<'_>,
    path: &str,
) -> Result<ToolMotion<D>, SceneError> {
    let (shifts, turn): (Vec<(&Coordinates<D>, &RampInput)>, _) = match input {
        ToolMotionInput::Rest => return Ok(ToolMotion::rest()),
        ToolMotionInput::Move { by, ramp: first, then, turn } => {
            let then = then.iter().map(|shift| (&shift.by, &shift.ramp));
            (std::iter::once((by, first)).chain(then).collect(), turn.as_ref())
        }
        ToolMotionInput::Loaded { by, by_ramp, .. } => (vec![(by, by_ramp)], None),
        ToolMotionInput::Screw { axis, through, angle, advance, ramp: input } => {
            return screw((*axis, through), [angle.0.to_radians(), advance.0], (stages, input), path);
        }
    };
    let along = |d: usize| sum(&shifts, stages, d, path);
    let along: Vec<Ramp> = (0..D).map(along).collect::<Result<_, _>>()?;
    let along: [Ramp; D] = along.try_into().expect("one for each direction");
    let refuse = |it: ContactError| SceneError::new(path, it.to_string());
    let Some(ToolTurnInput { axis, centre, angle, ramp: input }) = turn else {
        return ToolMotion::shifted(along).map_err(refuse);
    };
    if D == 2 && *axis != Direction::Z {
        return Err(SceneError::new(format!("{path}.turn.axis"), "in the plane a tool turns about `Z` only"));
    }
    let angle = ramp(stages, input, angle.0.to_radians(), &format!("{path}.turn.ramp"))?;
    let axis = Vector3::ith(axis.index(), 1.0);
    ToolMotion::turning(along, Vector::from(centre.0), axis, angle).map_err(refuse)
}

/// A turn about an axis with an advance along it.
fn screw<const D: usize>(
    (axis, through): (Direction, &PlanePoint),
    [angle, advance]: [f64; 2],
    (stages, input): (Stages<'_>, &RampInput),
    path: &str,
) -> Result<ToolMotion<D>, SceneError> {
    if D == 2 {
        return Err(SceneError::new(path, "a screw moves in space only"));
    }
    let through = on_axis(axis, through, 0.0);
    let [angle, advance] = [ramp(stages, input, angle, path)?, ramp(stages, input, advance, path)?];
    let along = Vector3::ith(axis.index(), 1.0);
    let through = Vector::from_fn(|d, _| through[d]);
    ToolMotion::screw(through, along, angle, advance).map_err(|it| SceneError::new(path, it.to_string()))
}

/// The load on a tool that is moved by one.
pub(super) fn load<const D: usize>(
    input: &ToolMotionInput<D>,
    stages: Stages<'_>,
    path: &str,
) -> Result<Option<ToolLoad<D>>, SceneError> {
    let ToolMotionInput::Loaded { free, force, follows, moment, ramp: input, by, .. } = input else {
        return Ok(None);
    };
    let mut components = Vec::new();
    for (k, component) in free.iter().enumerate() {
        let at = format!("{path}.free[{k}]");
        let number = match (component, D) {
            (FreeInput::X, _) => 0,
            (FreeInput::Y, _) => 1,
            (FreeInput::Z, 3) => 2,
            (FreeInput::TurnX, 3) => 3,
            (FreeInput::TurnY, 3) => 4,
            (FreeInput::Turn, 3) => 5,
            (FreeInput::Turn, _) => 2,
            _ => return Err(SceneError::new(at, format!("{component:?} is no motion in the plane"))),
        };
        if components.contains(&number) {
            return Err(SceneError::new(at, format!("{component:?} is named twice")));
        }
        if by.0.get(number).is_some_and(|by| *by != 0.0) {
            return Err(SceneError::new(at, format!("{component:?} is prescribed by `by`, too")));
        }
        components.push(number);
    }
    if components.is_empty() {
        return Err(SceneError::new(format!("{path}.free"), "expected at least one component"));
    }
    components.sort_unstable();
    Ok(Some(ToolLoad {
        free: components,
        force: Vector::from(force.0),
        moment: Vector3::new(0.0, 0.0, moment.0),
        ramp: ramp(stages, input, 1.0, &format!("{path}.ramp"))?,
        follows: *follows,
    }))
}

/// The ramp of a tool, which is there in all stages.
pub(super) fn ramp(stages: Stages<'_>, input: &RampInput, scale: f64, path: &str) -> Result<Ramp, SceneError> {
    stages.ramp(input, scale, Active::default(), path)
}

/// The sum of displacements along a direction, each with its ramp.
fn sum<const D: usize>(
    shifts: &[(&Coordinates<D>, &RampInput)],
    stages: Stages<'_>,
    d: usize,
    path: &str,
) -> Result<Ramp, SceneError> {
    let moving = shifts.iter().filter(|(by, _)| by.0[d] != 0.0);
    let ramps = moving.map(|(by, input)| ramp(stages, input, by.0[d], &format!("{path}.ramp")));
    let ramps: Vec<Ramp> = ramps.collect::<Result<_, _>>()?;
    let mut knots: Vec<LoadFraction> = ramps.iter().flat_map(|ramp| ramp.knots().map(|knot| knot.0)).collect();
    // In a stage in which one of them has knots, the others hold from its start to its end.
    let ends = knots.iter().flat_map(|at| [at.with_value(0.0), at.with_value(1.0)]);
    knots.extend(ends.collect::<Vec<_>>());
    knots.sort_by(|a, b| a.total().total_cmp(&b.total()).then(a.stage().cmp(&b.stage())));
    knots.dedup();
    if knots.is_empty() {
        return Ok(Ramp::constant(0.0));
    }
    let value = |at: &LoadFraction| (at.get(), ramps.iter().map(|ramp| ramp.value(*at)).sum());
    let of_stages = knots.chunk_by(|a, b| a.stage() == b.stage());
    let pieces = of_stages.map(|knots| (knots[0].stage(), knots.iter().map(value).collect()));
    Ramp::of_stages(pieces).map_err(|it| SceneError::new(path, it))
}

//! The bodies connected and supported as at the start of a run.

use crate::clock::processor_seconds;
use crate::connection::{Connected, Interval, connect};
use crate::error::Error;
use crate::failure::StepFailure;
use crate::model::Model;
use crate::ranks::{Alone, Ranks};
use mpm_assembly::Constraints;
use mpm_basis::ActiveNodes;
use mpm_grid::{LoadFraction, Mesh};
use std::rc::Rc;

/// Shortest load step, as a part of the load, with which an estimate tries to begin.
const SHORTEST: f64 = 1e-6;

/// The points connected, and what that takes; if it is quick the shorter of two times, for the first one meets cold
/// memory `[s]`.
pub(super) fn connected<const D: usize>(
    model: &mut Model<D>,
    mesh: &Mesh<D>,
) -> Result<(Connected<D>, f64), Error> {
    let steps = model.stages.first().map_or(1, |stage| stage.steps);
    let mut length = 1.0 / f64::from(steps);
    let alone: Rc<dyn Ranks<D>> = Rc::new(Alone);
    let mut once = || loop {
        let clock = processor_seconds();
        let interval = Interval { from: LoadFraction::START, to: LoadFraction::START.with_value(length) };
        match connect(model, mesh, interval, None, &alone) {
            Ok((connected, _)) => return Ok((connected, processor_seconds() - clock)),
            // The run will cut the step, too.
            Err(StepFailure::Refused { is_step_too_long: true, .. }) if length > SHORTEST => length *= 0.5,
            Err(failure) => return Err(Error::Start(failure)),
        }
    };
    let (first, cold) = once()?;
    if cold > 0.05 {
        return Ok((first, cold));
    }
    drop(first);
    let (connected, warm) = once()?;
    Ok((connected, warm.min(cold)))
}

/// The components of active nodes that supports prescribe in a stage.
pub(super) fn supported<const D: usize>(
    model: &Model<D>,
    active: &ActiveNodes<D>,
    stage: u32,
) -> Constraints<D> {
    let mut constraints = Constraints::none(active.len());
    for support in model.supports.iter().filter(|support| support.acts_in(stage)) {
        for number in support.nodes.iter().filter_map(|&node| active.number(node)) {
            for component in (0..D).filter(|&i| support.components[i].is_some()) {
                constraints.prescribe(number, component, 0.0);
            }
        }
    }
    constraints
}

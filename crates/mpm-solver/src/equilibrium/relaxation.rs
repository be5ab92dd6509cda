//! Equilibrium in parts: the unbalanced forces of a load step are released one part after the other.
//!
//! Where points meet other cells than in the step before, forces are out of balance that do not become
//! smaller with the step. Where these throw Newton's first correction too far, shorter steps are no help.

use super::newton::{Patience, Start, iterate};
use super::problem::{Equilibrium, Iterate, Problem, Wanted};
use super::system::Solver;
use crate::failure::StepFailure;
use mpm_grid::Vector;

/// Part of the unbalanced force that is released first.
const FIRST_PART: f64 = 0.25;

/// Relative out-of-balance force up to which all parts but the last are balanced.
const RESIDUAL: f64 = 1e-4;

/// Smallest part of the unbalanced force that is released at once.
const LEAST_PART: f64 = 1.0 / 16384.0;

/// Balances the forces of a load step in parts. What is out of balance at the start of the step is held at first and
/// released more and more; each part is balanced from where the one before ended. The first part makes the prescribed
/// increments alone; the last is the step itself.
///
/// # Errors
/// The smallest part cannot be balanced.
pub(crate) fn solve<const D: usize>(
    problem: &Problem<'_, D>,
    solver: &mut Solver<D>,
) -> Result<Equilibrium<D>, StepFailure> {
    let mut state = solver.at_rest(problem);
    solver.evaluate(problem, &mut state, Wanted::Force, None)?;
    let imbalance = state.out_of_balance.nodes.clone();
    let mut residuals = Vec::new();
    let mut lift = Some(problem.constraints.increment());
    // Parts grow until one is too large.
    let (mut released, mut part, mut growth) = (0.0, 0.0, 2.0);
    loop {
        let aim = f64::min(released + part, 1.0);
        let held = problem.external.iter().zip(&imbalance).map(|(f, r)| f - r * (1.0 - aim));
        let external: Vec<Vector<D>> = held.collect();
        let mut tolerance = problem.tolerance;
        if aim < 1.0 {
            tolerance.residual = tolerance.residual.max(RESIDUAL);
        }
        let partly = Problem { external: &external, tolerance, ..*problem };
        let start = Start { iterate: next_part(&state), lift, patience: Patience::ToTheEnd };
        match iterate(start, &partly, solver) {
            Ok(balanced) => {
                residuals.extend(&balanced.effort.residuals);
                state = balanced;
                if aim == 1.0 {
                    state.effort.residuals = residuals;
                    return Ok(state.into_equilibrium());
                }
                part = if lift.is_none() { growth * part } else { FIRST_PART };
                released = aim;
                lift = None;
            }
            Err(StepFailure::Cancelled) => return Err(StepFailure::Cancelled),
            Err(failure) if 0.5 * part < LEAST_PART => return Err(failure),
            Err(_) => {
                solver.restart();
                (part, growth) = (0.5 * part, 1.0);
            }
        }
    }
}

/// The iterate from which the next part is balanced.
fn next_part<const D: usize>(state: &Iterate<D>) -> Iterate<D> {
    let mut next = state.clone();
    next.effort.residuals = Vec::new();
    next.effort.relaxations += 1;
    next
}

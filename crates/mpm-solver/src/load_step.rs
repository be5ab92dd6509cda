//! One load step: **read this file first**.
//!
//! Each load step (Coombs & Augarde 2020, figure 3; Wang et al. 2018, slides 8-9):
//! 1. *connect*: take the mesh of this step and connect the points to its nodes,
//! 2. *balance*: find the nodal displacements that balance the forces,
//! 3. *advance*: carry the points with these displacements,
//! 4. *replace the mesh*: the next load step takes the mesh of its own load fraction.
//!
//! `run.rs` calls [`load_step`] in a loop and commits what it has prepared. Until then the points are those of the last
//! converged step, so that a step that fails can be tried again in another way.

use crate::connection::{Connected, Former, connect_step, lines, periods};
use crate::equilibrium::problem::{Equilibrium, Problem};
use crate::equilibrium::system::Solver;
use crate::equilibrium::{newton, path, relaxation};
use crate::error::StepFailure;
use crate::loading::StepLoading;
use crate::model::Model;
use crate::progress::DomainCounts;
use crate::record::StepResult;
use crate::record::energy::StepEnergy;
use crate::steps::plan::{Plan, StepKind};
use crate::timing::{Phase, Timings};
use mpm_assembly::Converged;
use mpm_grid::{LoadFraction, Mesh};
use mpm_linear::{Analysis, Place};

/// What load steps hand on to each other.
pub(crate) struct Tools<const D: usize> {
    pub solver: Solver<D>,
    /// The connectivity of the last load step that was tried.
    pub former: Option<Former<D>>,
}

/// Finds the equilibrium of one load step and prepares the points for it; commits nothing.
///
/// # Errors
/// Why the step failed; the points are still those of its start.
pub(crate) fn load_step<const D: usize>(
    model: &mut Model<D>,
    plan: &mut Plan<D>,
    tools: &mut Tools<D>,
) -> Result<StepResult<D>, StepFailure> {
    let mesh =
        model.motion.mesh_at(&model.layout, plan.start).map_err(|it| StepFailure::Mesh(it.to_string()))?;
    let Tools { solver, former } = tools;
    let connected = connect_step(model, &mesh, plan.start, former, &mut solver.timings)?;
    let balanced = balance(model, &mesh, &connected, plan, solver).and_then(|balanced| {
        advance(model, &mesh, &connected, &balanced.equilibrium, &mut solver.timings)?;
        Ok(balanced)
    });
    match balanced {
        Ok(Balanced { end, equilibrium, equations, analysis, energy, condition }) => {
            let domains = DomainCounts::default();
            Ok(StepResult {
                end,
                mesh,
                connected,
                equilibrium,
                equations,
                analysis,
                energy,
                condition,
                domains,
            })
        }
        Err(failure) => {
            *former = Some(Former { connected, start_of_failed_step: Some(plan.start) });
            Err(failure)
        }
    }
}

/// A load step in equilibrium; the fields are those of [`StepResult`].
struct Balanced<const D: usize> {
    end: LoadFraction,
    equilibrium: Equilibrium<D>,
    equations: usize,
    analysis: Analysis,
    energy: Option<StepEnergy>,
    condition: Option<f64>,
}

/// Finds the displacements that balance the forces.
fn balance<const D: usize>(
    model: &Model<D>,
    mesh: &Mesh<D>,
    connected: &Connected<D>,
    plan: &mut Plan<D>,
    solver: &mut Solver<D>,
) -> Result<Balanced<D>, StepFailure> {
    let loading = StepLoading { model, mesh, connected, start: plan.start };
    let (constraints, external) = (loading.constraints(plan.end)?, loading.external_force(plan.end));
    let problem = Problem {
        bodies: &model.bodies,
        mesh,
        connected,
        constraints: &constraints,
        external: &external,
        round_off: loading.round_off(),
        tolerance: model.tolerance,
    };
    let lines = lines(&model.layout);
    let place = Place { index: &connected.active.lattice_indices(), lines: &lines, periodic: periods(mesh) };
    let analysis = solver.analyse(&connected.pattern, place)?;

    let (mut end, span) = (plan.end, plan.end.get() - plan.start.get());
    let equilibrium = match &mut plan.kind {
        StepKind::Load(predictor) => {
            let guess = predictor.as_ref().map(|last| last.displacement(connected, span, &constraints));
            newton::solve(&problem, guess, solver)?
        }
        StepKind::Relaxed => relaxation::solve(&problem, solver)?,
        StepKind::Measured(step) => path::solve_measured(&problem, step, plan.end, solver)?,
        StepKind::Along(step) => {
            let equilibrium = path::solve(&problem, &loading, step, solver)?;
            end = LoadFraction::clamped(step.end);
            equilibrium
        }
    };

    let energy = model.energies.then(|| {
        let (before, after) = (loading.external_force(plan.start), loading.external_force(end));
        StepEnergy::of(&Problem { external: &after, ..problem }, &before, &equilibrium)
    });
    let energy = energy.transpose()?;
    let condition = if model.condition_history { solver.condition() } else { None };
    Ok(Balanced { end, equilibrium, equations: constraints.n_free(), analysis, energy, condition })
}

/// Prepares the points for the equilibrium that has been found.
fn advance<const D: usize>(
    model: &mut Model<D>,
    mesh: &Mesh<D>,
    connected: &Connected<D>,
    equilibrium: &Equilibrium<D>,
    timings: &mut Timings,
) -> Result<(), StepFailure> {
    timings.time(Phase::Advance, || {
        let converged = Converged { mesh, active: &connected.active, increment: &equilibrium.increment };
        for (named, connection) in model.bodies.iter_mut().zip(&connected.connections) {
            named.body.prepare(connection, converged).map_err(|reason| StepFailure::Advance {
                body: named.name.clone(),
                basis: named.body.basis(),
                reason,
            })?;
        }
        Ok(())
    })?;
    let without_domain = model.bodies.iter().filter(|named| !named.body.has_domains());
    timings.skipped.domains += without_domain.map(|named| named.body.n_points() as u64).sum::<u64>();
    Ok(())
}

//! One load step: **read this file first**.
//!
//! Each load step (Coombs & Augarde 2020, figure 3; Wang et al. 2018, slides 8-9):
//! 1. *connect*: take the mesh of this step and connect the points to its nodes,
//! 2. *balance*: find the nodal displacements that balance the forces,
//! 3. *advance*: carry the points with these displacements,
//! 4. *replace the mesh*: the next load step takes the mesh of its own load fraction.
//!
//! `run.rs` calls [`load_step`] in a loop and commits what it prepared; a step that fails leaves the points as they were.

use crate::connection::{Connected, Former, Interval, connect_step, contributions, lines, places, position};
use crate::equilibrium::problem::{Equilibrium, Problem, refuse};
use crate::equilibrium::system::Solver;
use crate::equilibrium::{newton, path, relaxation};
use crate::failure::StepFailure;
use crate::loading::StepLoading;
use crate::model::Model;
use crate::progress::DomainCounts;
use crate::ranks::{Ranks, agreed, any, count};
use crate::record::energy::StepEnergy;
use crate::record::{Balanced, StepResult};
use crate::release::carried;
use crate::rigid::rest::unheld;
use crate::steps::plan::{Plan, StepKind};
use crate::timing::{Phase, Timings};
use mpm_assembly::{Constraints, Converged, Trial};
use mpm_grid::{LoadFraction, Mesh};
use mpm_linear::Hints;
use std::rc::Rc;

/// What load steps hand on to each other.
pub(crate) struct Tools<const D: usize> {
    pub solver: Solver<D>,
    /// The connectivity of the last load step that was tried.
    pub former: Option<Former<D>>,
    /// Who computes the model together.
    pub ranks: Rc<dyn Ranks<D>>,
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
    let Tools { solver, former, ranks } = tools;
    let interval = Interval { from: plan.start, to: plan.end };
    let connected = connect_step(model, &mesh, interval, former, (ranks, &mut solver.timings))?;
    let balanced = balance(model, &mesh, &connected, plan, None, solver).and_then(|mut balanced| {
        let mut round = 0;
        while augment(model, &mesh, &connected, plan, &balanced, round)? {
            balanced = balance(model, &mesh, &connected, plan, Some(balanced.equilibrium), solver)?;
            round += 1;
        }
        advance(model, &mesh, &connected, plan.start, &balanced, &mut solver.timings)?;
        Ok(balanced)
    });
    match balanced {
        Ok(balanced) => Ok(StepResult { mesh, connected, balanced, domains: DomainCounts::default() }),
        Err(failure) => {
            *former = Some(Former { connected, start_of_failed_step: Some(plan.start) });
            Err(failure)
        }
    }
}

/// Finds the displacements that balance the forces; from `found` on, where the step was balanced before contributions
/// changed what they hold fixed.
fn balance<const D: usize>(
    model: &Model<D>,
    mesh: &Mesh<D>,
    connected: &Connected<D>,
    plan: &mut Plan<D>,
    found: Option<Equilibrium<D>>,
    solver: &mut Solver<D>,
) -> Result<Balanced<D>, StepFailure> {
    let loading = StepLoading { model, mesh, connected, start: plan.start, pins: &[], carried: &[] };
    let (ranks, constraints) = (&*connected.shared.ranks, loading.constraints(plan.end)?);
    let loading = StepLoading { carried: &carried(&loading, &constraints)?, ..loading };
    let external = loading.external_force(plan.end);
    let bodies = connected.bodies(&model.bodies);
    let problem = Problem {
        bodies: &model.bodies,
        contributions: &contributions(&bodies, &model.contributions),
        named: &model.contributions,
        mesh,
        connected,
        constraints: &constraints,
        end: plan.end,
        external: &external,
        round_off: &loading.round_off(),
        tolerance: model.tolerance,
    };
    let rest = unheld(model, &problem)?;
    let constraints = rest.constraints(&constraints);
    let loading = StepLoading { pins: rest.pins(), ..loading };
    let problem = Problem { constraints: &constraints, ..problem };
    let lines = lines(model);
    let index = connected.active.lattice_indices();
    let hints = Hints {
        lattice: Some(places(model, &index, &lines)),
        position: Some(&|node| position(model, mesh, connected.active.nodes()[node])),
        further: Some(&|equation| connected.field_node(equation)),
        is_held: Some(&|equation| constraints.is_held(connected.unknowns(), equation)),
        is_kept: connected.is_analysed.get(),
        owned: None,
    };
    let analysis = agreed(ranks, solver.analyse(&connected.pattern, &hints))?;
    connected.is_analysed.set(true);
    let (mut end, span) = (plan.end, plan.end.get() - plan.start.get());
    let mut equilibrium = match (found, &mut plan.kind) {
        (Some(found), _) => newton::go_on(&problem, found, solver)?,
        (None, StepKind::Load(predictor)) => {
            let guess = predictor.as_ref().and_then(|last| last.unknowns(connected, span, &constraints));
            newton::solve(&problem, guess, solver)?
        }
        (None, StepKind::Relaxed) => relaxation::solve(&problem, solver)?,
        (None, StepKind::Measured(step)) => path::solve_measured(&problem, step, plan.end, solver)?,
        (None, StepKind::Along(step)) => {
            let equilibrium = path::solve(&problem, &loading, step, solver)?;
            end = plan.end.with_value(step.end);
            equilibrium
        }
    };
    rest.settle(model, &problem, &mut equilibrium)?;
    let energy = || StepEnergy::of_step(&problem, &loading, [plan.start, end], &equilibrium);
    let energy = model.energies.then(energy).transpose()?;
    let condition = if model.condition_history { solver.condition(&problem) } else { None };
    let equations = n_free(connected, &constraints);
    Ok(Balanced { end, equilibrium, equations, analysis, energy, condition })
}

/// Number of components that are not prescribed, of the nodes of all ranks.
fn n_free<const D: usize>(connected: &Connected<D>, constraints: &Constraints<D>) -> u64 {
    let nodes = connected.shared.counted(0..constraints.n_nodes());
    let free = nodes.map(|(node, _)| (0..D).filter(|&i| !constraints.is_prescribed(node, i)).count());
    count(&*connected.shared.ranks, free.sum::<usize>() as u64)
}

/// Lets contributions change what they hold fixed in a balanced step of a given load fraction; whether any did.
fn augment<const D: usize>(
    model: &mut Model<D>,
    mesh: &Mesh<D>,
    connected: &Connected<D>,
    plan: &Plan<D>,
    balanced: &Balanced<D>,
    round: u32,
) -> Result<bool, StepFailure> {
    if model.contributions.is_empty() || !matches!(plan.kind, StepKind::Load(_) | StepKind::Relaxed) {
        return Ok(false);
    }
    let loading = StepLoading { model, mesh, connected, start: plan.start, pins: &[], carried: &[] };
    let (pattern, constraints) = (&connected.pattern, &loading.constraints(balanced.end)?);
    let increment = &balanced.equilibrium.increment;
    let trial = Trial { pattern, constraints, increment, end: balanced.end, is_first: false };
    let ranks = &*connected.shared.ranks;
    let augmented = model.contributions.iter_mut().map(|it| it.contribution.augment(&trial, round, ranks));
    let changed = augmented.fold(false, |any, changed| any | changed);
    Ok(any(ranks, changed))
}

/// Prepares the points, and what contributions remember, for the equilibrium that has been found.
fn advance<const D: usize>(
    model: &mut Model<D>,
    mesh: &Mesh<D>,
    connected: &Connected<D>,
    start: LoadFraction,
    balanced: &Balanced<D>,
    timings: &mut Timings,
) -> Result<(), StepFailure> {
    let (increment, ranks) = (&balanced.equilibrium.increment, &*connected.shared.ranks);
    if !model.contributions.is_empty() {
        let loading = StepLoading { model, mesh, connected, start, pins: &[], carried: &[] };
        let (pattern, constraints) = (&connected.pattern, &loading.constraints(balanced.end)?);
        let trial = Trial { pattern, constraints, increment, end: balanced.end, is_first: false };
        for k in 0..model.contributions.len() {
            let prepared = model.contributions[k].contribution.prepare(&trial);
            let all = (&model.bodies[..], &model.contributions[..]);
            agreed(ranks, prepared.map_err(|it| refuse(all, model.bodies.len() + k, it, ranks)))?;
        }
    }
    let without_domain = model.bodies.iter().filter(|named| !named.body.has_domains());
    timings.skipped.domains += without_domain.map(|named| named.body.n_points() as u64).sum::<u64>();
    timings.time(Phase::Advance, || {
        let (active, own) = (&connected.active, &increment.own[..]);
        let converged = Converged { mesh, active, increment: &increment.nodes, own };
        let bodies = model.bodies.iter_mut().zip(&connected.assembly_plans).enumerate();
        let prepared = bodies.map(|(index, (named, assembly_plan))| {
            named.body.prepare(assembly_plan, converged).map_err(|reason| StepFailure::Advance {
                body: named.name.clone(),
                basis: named.body.basis(),
                reason: reason.renumbered(|point| ranks.number_of_point(index, point)),
            })
        });
        let prepared = prepared.collect();
        agreed(ranks, prepared)
    })
}

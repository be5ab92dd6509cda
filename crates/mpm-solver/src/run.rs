//! A run through the load steps: the only loop over them.

use crate::connection::stencils;
use crate::domain_control::control_domains;
use crate::equilibrium::system::Solver;
use crate::error::Error;
use crate::estimate::{cells_without_material, columns_not_stored};
use crate::load_step::{Tools, load_step};
use crate::model::{Model, Support};
use crate::observe::{Moment, Observer, Outcome};
use crate::ranks::{Alone, Ranks, any};
use crate::record::history::Record;
use crate::record::summary::Summary;
use crate::remedy::with_remedy;
use crate::state::{State, StateError};
use crate::steps::Steps;
use crate::steps::plan::{Plan, StepKind};
use crate::timing::Timings;
use mpm_grid::LoadFraction;
use mpm_linear::LinearSolver;
use std::rc::Rc;

/// See [`crate::run()`].
pub(crate) fn run<const D: usize>(
    model: &mut Model<D>,
    ranks: Rc<dyn Ranks<D>>,
    observer: &mut dyn Observer,
) -> Result<Summary, Error> {
    model.check()?;
    let is_share = model.share.is_some();
    ranks.divide(model, LoadFraction::START).map_err(Error::Ranks)?;
    model.check_whole()?;
    if is_share {
        check_begun(model, 0, &*ranks)?;
    }
    let record = Record::new(model, &*ranks);
    observer.start(&record.start()).map_err(Error::Observer)?;
    let solver = Solver::new(linear_solver(model, &*ranks), observer.cancellation(), Timings::new());
    let state = RunState { record, steps: Steps::new(model), tools: Tools { solver, former: None, ranks } };
    state.finish(model, observer)
}

/// That of the ranks, or else that of the model.
fn linear_solver<const D: usize>(model: &Model<D>, ranks: &dyn Ranks<D>) -> Box<dyn LinearSolver> {
    ranks.solver(model).unwrap_or_else(|| model.linear_solver())
}

/// See [`crate::resume()`].
pub(crate) fn resume<const D: usize>(
    model: &mut Model<D>,
    ranks: Rc<dyn Ranks<D>>,
    state: &State,
    observer: &mut dyn Observer,
) -> Result<Summary, Error> {
    let wrong = |reason: String| StateError::new("progress", reason);
    model.check()?;
    model.check_whole()?;
    let mut record = Record::new(model, &Alone);
    state.restore(model)?;
    record.restore(&state.progress).map_err(wrong)?;
    let timings = Timings::restore(&state.progress.spent).map_err(wrong)?;
    let steps = Steps::restore(model, &state.progress, &state.predictor).map_err(wrong)?;
    check_covered(model, steps.at())?;
    ranks.divide(model, steps.at()).map_err(Error::Ranks)?;
    let mut solver = Solver::new(linear_solver(model, &*ranks), observer.cancellation(), timings);
    if let Some(saved) = &state.linear_solver {
        solver.restore(saved.clone()).map_err(|it| StateError::new("linear_solver", it))?;
    }
    record.show_resumed(steps.at(), observer)?;
    RunState { record, steps, tools: Tools { solver, former: None, ranks } }.finish(model, observer)
}

/// Refuses points that the mesh at a load fraction does not cover.
fn check_covered<const D: usize>(model: &Model<D>, at: LoadFraction) -> Result<(), Error> {
    let mesh = model.motion.mesh_at(&model.layout, at).map_err(|it| StateError::new("the mesh", it))?;
    stencils(model, &mesh, &Alone).map_err(|it| StateError::new("bodies", it))?;
    Ok(())
}

/// Refuses a stage with which a support begins that would move nodes none of which carries material.
fn check_begun<const D: usize>(model: &Model<D>, number: u32, ranks: &dyn Ranks<D>) -> Result<(), Error> {
    let begins = |support: &&Support<D>| support.active.from == number && support.drives();
    let mut begun = model.supports.iter().filter(begins).peekable();
    if begun.peek().is_none() {
        return Ok(());
    }
    let mesh = model.motion.mesh_at(&model.layout, LoadFraction::start_of(number));
    // Where there is no mesh, or it does not cover the points, the first load step says so.
    let Ok(mesh) = mesh else { return Ok(()) };
    let Ok(stencils) = stencils(model, &mesh, ranks) else { return Ok(()) };
    let active = ranks.activate(model, &mesh, &stencils);
    let carries = |support: &Support<D>| support.nodes.iter().any(|&node| active.number(node).is_some());
    match begun.find(|support| !any(ranks, carries(support))) {
        None => Ok(()),
        Some(support) => Err(Error::EmptySupport {
            stage: model.stages[number as usize].name.clone(),
            support: support.name.clone(),
        }),
    }
}

/// Makes the present positions those from which displacements count.
fn reset_displacements<const D: usize>(model: &mut Model<D>, ranks: &dyn Ranks<D>) {
    model.bodies.iter_mut().for_each(|named| named.body.reset_displacements());
    for k in 0..model.probes.len() {
        model.probes[k].rest = model.probes[k].mean_position(&model.bodies, ranks);
    }
}

/// A run between two load steps, without its model.
struct RunState<const D: usize> {
    record: Record,
    steps: Steps<D>,
    tools: Tools<D>,
}

impl<const D: usize> RunState<D> {
    /// Runs to the end, and tells the observer how the run ended.
    fn finish(mut self, model: &mut Model<D>, observer: &mut dyn Observer) -> Result<Summary, Error> {
        let outcome = match self.take_steps(model, observer) {
            // The points and the record are still those of the last load step.
            Err(
                error @ (Error::Step { .. }
                | Error::StepLimit { .. }
                | Error::EmptySupport { .. }
                | Error::Cancelled { .. }),
            ) => self.offer(Moment::End, model, observer).and(Err(error)),
            outcome => outcome,
        };
        let outcome = outcome.and(self.record.show_last(model, observer));
        let said = match &outcome {
            Ok(()) => Outcome::Completed,
            Err(error) => Outcome::Failed(error.to_string()),
        };
        let timings = &mut self.tools.solver.timings;
        timings.skipped.cells = cells_without_material(model, self.record.at(), &*self.tools.ranks);
        timings.skipped.columns = columns_not_stored(&model.bodies).len() as u64;
        let closed = observer.finish(&said, &timings.with_skipped()).map_err(Error::Observer);
        outcome.and(closed)?;
        Ok(self.record.summary(model, timings, &*self.tools.ranks))
    }

    /// The loop over load steps.
    fn take_steps(&mut self, model: &mut Model<D>, observer: &mut dyn Observer) -> Result<(), Error> {
        if self.record.rows() == 0 {
            let Tools { solver, ranks, .. } = &mut self.tools;
            self.record.show_initial(model, observer, (&mut solver.timings, &**ranks))?;
        }
        while let Some(mut plan) = self.next(model)? {
            self.record.check_grips(model, plan.start.stage(), &*self.tools.ranks)?;
            // Relaxation goes on with what has been analysed for the step that it tries again.
            if !matches!(plan.kind, StepKind::Relaxed) {
                self.tools.solver.end_step();
            }
            match load_step(model, &mut plan, &mut self.tools) {
                Ok(mut done) => {
                    model.commit();
                    let sharing = &*self.tools.ranks;
                    model.contributions.iter_mut().for_each(|named| named.contribution.hear(sharing));
                    self.steps.accept(&plan, &done);
                    let at = (done.balanced.end, self.record.rows());
                    let controlled = control_domains(model, at, &*self.tools.ranks);
                    done.domains = *controlled.as_ref().unwrap_or(&done.domains);
                    let Tools { solver, former, ranks } = &mut self.tools;
                    self.record.show_step(model, &done, self.steps.cuts(), observer, &mut solver.timings)?;
                    let at = done.balanced.end;
                    *former = Some(done.into_former());
                    controlled?;
                    ranks.settle(model, at);
                    solver.end_step();
                    let taken = self.record.rows() - 1;
                    self.offer(Moment::Step(taken), model, observer)?;
                    if self.record.at().get() == 1.0 && model.has_named_stages() {
                        self.offer(Moment::StageEnd(taken), model, observer)?;
                    }
                }
                Err(failure) => {
                    let connected = self.tools.former.as_ref().map(|former| &former.connected);
                    let rejected = self.steps.reject(&plan, failure);
                    rejected.map_err(|error| with_remedy(error, model, connected, &*self.tools.ranks))?;
                }
            }
        }
        Ok(())
    }

    /// The step to be tried next, that of the next stage where one has come to its end; none at the end of the run.
    fn next(&mut self, model: &mut Model<D>) -> Result<Option<Plan<D>>, Error> {
        loop {
            if let Some(plan) = self.steps.next()? {
                return Ok(Some(plan));
            }
            let Some(number) = self.steps.next_stage(model) else { return Ok(None) };
            check_begun(model, number, &*self.tools.ranks)?;
            self.steps.begin_stage(model, number, self.record.rows() - 1);
            if model.stages[number as usize].resets_displacements {
                reset_displacements(model, &*self.tools.ranks);
            }
            self.record.begin_stage(model, number, &*self.tools.ranks);
            // Other supports may hold the nodes: what was found out about the connectivity does not hold.
            self.tools.former = None;
        }
    }

    /// Offers the observer the state of the run.
    fn offer(&self, at: Moment, model: &Model<D>, observer: &mut dyn Observer) -> Result<(), Error> {
        let Self { record, steps, tools } = self;
        let state = || {
            let mut state = State::of(model, steps.save(), tools.solver.save());
            record.save(&mut state.progress);
            state.progress.spent = tools.solver.timings.save();
            state
        };
        observer.save(at, &state).map_err(Error::Observer)
    }
}

//! A run through the load steps: the file to read first.

use crate::course::{Course, Next};
use crate::domains::{self, DomainCounts};
use crate::energy::StepEnergy;
use crate::error::{Error, PathFailure, StepFailure};
use crate::estimate::{cells_without_material, columns_not_stored};
use crate::model::{Model, NamedBody, Predictor, Prescribed};
use crate::newton::{self, Equilibrium, Ghost, Problem, Workspace};
use crate::observe::{Moment, Observer, Outcome};
use crate::path::{self, Attempt, Length};
use crate::record::{Record, StepResult, Summary};
use crate::schedule::{Pace, Step};
use crate::secant::Secant;
use crate::state::{ControlProgress, State, StateError, StoredSecant, check_covered};
use crate::timing::{Phase, Timings};
use mpm_assembly::{BodyLoads, Connection, Constraints, Converged, GhostFaces, Linked, Pattern};
use mpm_basis::{ActiveNodes, Links, Stencils, UnconnectedPoint};
use mpm_grid::{Layout, LoadFraction, Mesh, MeshMotion, Vector};
use mpm_linear::{Analysis, LinearSolver, Method, Place};

/// Runs a model through its load steps.
///
/// Each load step (Coombs & Augarde 2020, figure 3; Wang et al. 2018, slides 8-9):
/// 1. take the mesh of this step and connect points to nodes,
/// 2. find the nodal displacements that balance the forces,
/// 3. advance the points (and shorten or split domains too long for their cells, where asked to),
/// 4. let the observer look. The mesh is then replaced by that of the next step.
///
/// A step that cannot be solved is halved, and at its shortest balanced in stages; the points are those of
/// the last converged step until the next one has converged.
///
/// # Errors
/// [`Error::Step`] where a step fails at its smallest length, [`Error::TooManyPoints`] where domains
/// would be split into too many, [`Error::Observer`] where the record cannot be written. All load steps before have been shown to the observer.
pub fn run<const D: usize>(model: &mut Model<D>, observer: &mut dyn Observer) -> Result<Summary, Error> {
    let record = Record::new(model);
    observer.start(&record.start()).map_err(Error::Observer)?;
    let control = match model.path {
        None => Control::Pace(Pace::new(model.schedule), None),
        Some(control) => Control::Course(Course::new(control, model.schedule.cuts)),
    };
    let so_far =
        SoFar { record, control, linear: LinearSolver::new(model.linear_solver()), timings: Timings::new() };
    go_on(model, so_far, observer)
}

/// As [`run`], from a state of an earlier run of the same model on. What follows is bit for bit what would
/// have followed there.
///
/// # Errors
/// [`Error::State`] where the state is none of the model; else as [`run`].
pub fn resume<const D: usize>(
    model: &mut Model<D>,
    state: &State,
    observer: &mut dyn Observer,
) -> Result<Summary, Error> {
    let wrong = |reason: String| StateError::new("progress", reason);
    let mut record = Record::new(model);
    state.recall(model)?;
    record.recall(&state.progress).map_err(wrong)?;
    let timings = Timings::recall(&state.progress.spent).map_err(wrong)?;
    let progress = &state.progress.control;
    let control = match model.path {
        None => {
            let pace = Pace::recall(model.schedule, progress).map_err(wrong)?;
            let measures = match progress {
                ControlProgress::Load { last, .. } => last.map(|fraction| (fraction, 0.0)),
                ControlProgress::Path { .. } => None,
            };
            let nodes = model.layout.lattice().n_nodes();
            Control::Pace(pace, Secant::recall(measures, &state.secant, nodes).map_err(wrong)?)
        }
        Some(control) => {
            let (floor, nodes) = (model.schedule.cuts, model.layout.lattice().n_nodes());
            if record.rows() - 1 > model.schedule.steps as usize {
                let reason =
                    format!("has {} rows of history, expected at most one more than steps", record.rows());
                return Err(wrong(reason).into());
            }
            Control::Course(Course::recall(control, floor, progress, &state.secant, nodes).map_err(wrong)?)
        }
    };
    let at = match &control {
        Control::Pace(pace, _) => pace.at(),
        Control::Course(course) => fraction(course.at()),
    };
    check_covered(model, at)?;
    let mut linear = LinearSolver::new(model.linear_solver());
    linear.recall(state.order.clone());
    record.show_resumed(model, at, observer)?;
    go_on(model, SoFar { record, control, linear, timings }, observer)
}

/// A run so far, without its model.
struct SoFar<const D: usize> {
    record: Record,
    control: Control<D>,
    linear: LinearSolver<D>,
    timings: Timings,
}

/// What chooses the load steps.
enum Control<const D: usize> {
    /// Equal load steps, and the last one, where the next one is guessed from it.
    Pace(Pace, Option<Secant<D>>),
    Course(Course<D>),
}

/// Runs to the end, and tells the observer how it ended.
fn go_on<const D: usize>(
    model: &mut Model<D>,
    so_far: SoFar<D>,
    observer: &mut dyn Observer,
) -> Result<Summary, Error> {
    let SoFar { mut record, mut control, mut linear, mut timings } = so_far;
    let outcome = match &mut control {
        Control::Pace(pace, last) => steps(pace, last, &mut linear, model, observer, &mut record, &mut timings),
        Control::Course(course) => steps_along(course, &mut linear, model, observer, &mut record, &mut timings),
    };
    // The state of the last load step, where the points still are and the record has come.
    let outcome = match outcome {
        Err(error @ (Error::Step { .. } | Error::StepLimit { .. } | Error::Cancelled { .. })) => {
            let state = || {
                let control = match &control {
                    Control::Pace(pace, last) => store(pace, last.as_ref()),
                    Control::Course(course) => course.store(),
                };
                State::of(model, &record, control, &linear, &timings)
            };
            observer.keep(Moment::End, &state).map_err(Error::Observer).and(Err(error))
        }
        outcome => outcome,
    };
    let said = match &outcome {
        Ok(()) => Outcome::Completed,
        Err(error) => Outcome::Failed(error.to_string()),
    };
    timings.skipped.cells = cells_without_material(model, record.at());
    timings.skipped.columns = columns_not_stored(&model.bodies).len() as u64;
    let closed = observer.finish(&said, &timings.with_skipped()).map_err(Error::Observer);
    outcome.and(closed)?;
    Ok(record.summary(model, &timings))
}

/// The progress of equal load steps.
fn store<const D: usize>(pace: &Pace, last: Option<&Secant<D>>) -> (ControlProgress, StoredSecant) {
    (pace.store(last.map(|it| it.fraction)), last.map(Secant::store).unwrap_or_default())
}

fn steps<const D: usize>(
    pace: &mut Pace,
    last: &mut Option<Secant<D>>,
    linear: &mut LinearSolver<D>,
    model: &mut Model<D>,
    observer: &mut dyn Observer,
    record: &mut Record,
    timings: &mut Timings,
) -> Result<(), Error> {
    let mut workspace = Workspace::new(observer.cancellation());
    if record.rows() == 0 {
        record.show_initial(model, observer, timings)?;
    }

    while let Some(step) = pace.next() {
        linear.settle();
        let mut attempt = |drive| load_step(model, &step, drive, linear, &mut workspace, timings);
        let result = attempt(Drive::Load(last.as_ref())).or_else(|reason| {
            // Where shorter steps are no help, stages may be; else the first reason is the reason.
            let is_last = !reason.is_at_start() && reason != StepFailure::Cancelled && pace.is_at_floor();
            let first = |it| if it == StepFailure::Cancelled { it } else { reason.clone() };
            if is_last { attempt(Drive::Stages).map_err(first) } else { Err(reason) }
        });
        match result {
            Ok(mut result) => {
                for named in &mut model.bodies {
                    named.body.commit();
                }
                pace.succeed();
                // Nobody guesses from the last step of a run.
                *last = (model.schedule.predictor == Predictor::LastStep && pace.next().is_some()).then(|| {
                    let increment = result.equilibrium.increment.iter().copied();
                    let change = step.end.get() - step.start.get();
                    Secant::of(&result.connected.active, increment, change, 0.0)
                });
                let controlled = domains::control(model, step.end, record.rows());
                result.domains = *controlled.as_ref().unwrap_or(&DomainCounts::default());
                record.show_step(model, &step, &result, pace.cuts(), observer, timings)?;
                workspace.connected = Some((result.connected, None));
                controlled?;
                linear.settle();
                let state = || State::of(model, record, store(pace, last.as_ref()), linear, timings);
                observer.keep(Moment::Step(record.rows() - 1), &state).map_err(Error::Observer)?;
            }
            Err(StepFailure::Cancelled) => {
                return Err(Error::Cancelled { steps: record.rows() - 1, fraction: pace.at().get() });
            }
            Err(reason) => {
                // What is wrong at the start of a step is wrong however short it is.
                if reason.is_at_start() || !pace.cut() {
                    return Err(Error::Step {
                        step: record.rows(),
                        from: step.start.get(),
                        to: step.end.get(),
                        level: step.level,
                        reason,
                    });
                }
            }
        }
    }
    Ok(())
}

/// As [`steps`], at load fractions that the path decides.
fn steps_along<const D: usize>(
    course: &mut Course<D>,
    linear: &mut LinearSolver<D>,
    model: &mut Model<D>,
    observer: &mut dyn Observer,
    record: &mut Record,
    timings: &mut Timings,
) -> Result<(), Error> {
    let mut workspace = Workspace::new(observer.cancellation());
    if record.rows() == 0 {
        record.show_initial(model, observer, timings)?;
    }

    while let Some(next) = course.next() {
        linear.settle();
        let taken = record.rows() as u32 - 1;
        if taken == model.schedule.steps {
            return Err(Error::StepLimit { steps: taken, fraction: course.at() });
        }
        let start = fraction(course.at());
        let mut step = Step { start, end: start, nominal: taken + 1, level: course.level() };
        let mut attempt = course.attempt();
        let drive = match next {
            Next::Load(end) => {
                step.end = fraction(end);
                Drive::Measured(&mut attempt)
            }
            Next::Along => Drive::Path(&mut attempt),
        };
        let result = load_step(model, &step, drive, linear, &mut workspace, timings);
        let Attempt { aim, end, length, origin, .. } = attempt;
        match result {
            Ok(mut result) => {
                for named in &mut model.bodies {
                    named.body.commit();
                }
                step.end = fraction(end);
                let controlled = domains::control(model, step.end, record.rows());
                result.domains = *controlled.as_ref().unwrap_or(&DomainCounts::default());
                let increment = result.equilibrium.increment.iter().enumerate();
                let increment =
                    increment.map(|(v, u)| u - origin.get(v).copied().unwrap_or_else(Vector::zeros));
                let secant = Secant::of(&result.connected.active, increment, end - start.get(), length);
                course.succeed(secant, end, result.equilibrium.residuals.len());
                record.show_step(model, &step, &result, course.cuts(), observer, timings)?;
                workspace.connected = Some((result.connected, None));
                controlled?;
                linear.settle();
                let state = || State::of(model, record, course.store(), linear, timings);
                observer.keep(Moment::Step(record.rows() - 1), &state).map_err(Error::Observer)?;
            }
            Err(StepFailure::Cancelled) => {
                return Err(Error::Cancelled { steps: record.rows() - 1, fraction: course.at() });
            }
            Err(StepFailure::Path(PathFailure::Leaves { fraction })) if fraction > 1.0 => course.land(aim),
            Err(reason) => {
                let no_length = matches!(reason, StepFailure::Path(PathFailure::NoLength));
                if !course.cut(aim, no_length) {
                    let (from, level) = (step.start.get(), step.level);
                    return Err(Error::Step { step: record.rows(), from, to: end, level, reason });
                }
            }
        }
    }
    Ok(())
}

/// The load fraction next to a number.
fn fraction(value: f64) -> LoadFraction {
    LoadFraction::new(value.clamp(0.0, 1.0)).expect("clamped")
}

/// What decides the load fraction at the end of a load step.
enum Drive<'a, 'b, const D: usize> {
    /// The step, guessed from the last one where there is one.
    Load(Option<&'a Secant<D>>),
    /// The step, balanced in stages.
    Stages,
    /// The step; its length is measured.
    Measured(&'a mut Attempt<'b, D>),
    /// The length that it should have.
    Path(&'a mut Attempt<'b, D>),
}

/// Finds the equilibrium of one load step and prepares the points for it; commits nothing.
fn load_step<const D: usize>(
    model: &mut Model<D>,
    step: &Step,
    drive: Drive<'_, '_, D>,
    linear: &mut LinearSolver<D>,
    workspace: &mut Workspace<D>,
    timings: &mut Timings,
) -> Result<StepResult<D>, StepFailure> {
    let mesh =
        model.motion.mesh_at(&model.layout, step.start).map_err(|it| StepFailure::Mesh(it.to_string()))?;
    let former = workspace.connected.take();
    let (connected, kept) = match former {
        // A step that has been cut starts again where it did.
        Some((connected, start)) if start == Some(step.start) => (connected, Kept::All),
        former => timings.time(Phase::Connect, || connect(model, &mesh, former.map(|it| it.0)))?,
    };
    timings.skipped.count_connection(kept);
    let skipped = &mut timings.skipped;
    skipped.nodes = (mesh.lattice().n_nodes() - connected.active.len()) as u64;
    skipped.upper_triangle = (connected.pattern.n_entries() - connected.pattern.n_equations()) as u64;
    skipped.mesh_moves += u64::from(model.motion == MeshMotion::Fixed);
    let result = balance(model, &mesh, &connected, step, drive, linear, workspace, timings);
    match result {
        Ok((equilibrium, equations, analysis, energy)) => Ok(StepResult {
            mesh,
            connected,
            equilibrium,
            equations,
            analysis,
            energy,
            domains: DomainCounts::default(),
        }),
        Err(failure) => {
            workspace.connected = Some((connected, Some(step.start)));
            Err(failure)
        }
    }
}

/// Finds the equilibrium of a load step whose points are connected, and prepares the points for it.
#[expect(clippy::too_many_arguments, reason = "a load step from its connection on")]
fn balance<const D: usize>(
    model: &mut Model<D>,
    mesh: &Mesh<D>,
    connected: &Connected<D>,
    step: &Step,
    drive: Drive<'_, '_, D>,
    linear: &mut LinearSolver<D>,
    workspace: &mut Workspace<D>,
    timings: &mut Timings,
) -> Result<(Equilibrium<D>, usize, Analysis, Option<StepEnergy>), StepFailure> {
    let Connected { active, connections, pattern, ghost } = connected;
    let constraints = constrain(model, mesh, active, step)?;
    let external = external_force(model, connections, active.len(), step);
    let round_off = round_off(model, connections, active.len());

    let analysis = timings.time(Phase::Analyse, || {
        let lines = lines(&model.layout);
        let place = Place { index: &active.lattice_indices(), lines: &lines, periodic: periods(mesh) };
        linear.analyse(newton::columns(pattern), place)
    });
    let analysis = analysis.map_err(|it| StepFailure::Linear(it.to_string()))?;
    if analysis == Analysis::Reused {
        timings.skipped.analyses += 1;
    }

    let problem = Problem {
        bodies: &model.bodies,
        connections,
        mesh,
        active,
        pattern,
        ghost: ghost.as_ref(),
        constraints: &constraints,
        external: &external,
        round_off,
        tolerance: model.tolerance,
    };
    // Where the step ends; along a path, only its solution says.
    let mut reached = step.end;
    let mut equilibrium = match drive {
        Drive::Load(last) => {
            let guess = last.map(|last| {
                let scale = (step.end.get() - step.start.get()) / last.fraction;
                let mut guess = last.carried(&problem);
                guess.iter_mut().for_each(|u| *u *= scale);
                path::impose(&constraints, constraints.increment(), &mut guess);
                guess
            });
            newton::solve(&problem, guess, linear, workspace, timings)?
        }
        Drive::Stages => newton::solve_in_stages(&problem, linear, workspace, timings)?,
        Drive::Measured(attempt) => {
            attempt.end = step.end.get();
            let equilibrium = newton::solve(&problem, None, linear, workspace, timings)?;
            if attempt.measure == Length::Dissipation
                && equilibrium.method > Method::Llt
                && step.end.get() < 1.0
            {
                return Err(StepFailure::Path(PathFailure::LimitPoint));
            }
            attempt.length = path::length(&problem, attempt.measure, &equilibrium.increment)?;
            equilibrium
        }
        Drive::Path(attempt) => {
            let loading = |end| {
                let step = Step { end, ..*step };
                let constraints = constrain(model, mesh, active, &step)?;
                Ok((constraints, external_force(model, connections, active.len(), &step)))
            };
            let equilibrium = path::solve(&problem, &loading, attempt, linear, workspace, timings)?;
            if !(0.0..=1.0).contains(&attempt.end) {
                return Err(StepFailure::Path(PathFailure::Leaves { fraction: attempt.end }));
            }
            let change = attempt.end - attempt.start;
            if change.abs() > attempt.reach {
                return Err(StepFailure::Path(PathFailure::Jump { change }));
            }
            reached = fraction(attempt.end);
            equilibrium
        }
    };

    let energy = if model.energies {
        let force = |at| external_force(model, connections, active.len(), &Step { end: at, ..*step });
        let (before, after) = (force(step.start), force(reached));
        Some(StepEnergy::of(&Problem { external: &after, ..problem }, &before, &equilibrium)?)
    } else {
        None
    };
    if model.condition_history {
        equilibrium.accuracy.condition = linear.condition(&workspace.values);
    }

    timings.time(Phase::Advance, || {
        let converged = Converged { mesh, active, increment: &equilibrium.increment };
        for (named, connection) in model.bodies.iter_mut().zip(connections) {
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
    let equations = constraints.n_free();
    Ok((equilibrium, equations, analysis, energy))
}

/// Points to nodes: the active nodes, each body's connection to them, and the tangent's pattern.
pub(crate) struct Connected<const D: usize> {
    pub active: ActiveNodes<D>,
    /// Of every body.
    pub connections: Vec<Connection<D>>,
    pub pattern: Pattern<D>,
    pub ghost: Option<Ghost<D>>,
}

/// Influences of all bodies' points on the nodes of `mesh`.
pub(crate) fn stencils<const D: usize>(
    model: &Model<D>,
    mesh: &Mesh<D>,
) -> Result<Vec<Stencils<D>>, StepFailure> {
    model.bodies.iter().map(|named| named.body.stencils(mesh).map_err(|it| outside(named, &it))).collect()
}

fn outside<const D: usize>(named: &NamedBody<D>, it: &UnconnectedPoint<D>) -> StepFailure {
    StepFailure::Outside { body: named.name.clone(), basis: named.body.basis(), reason: it.to_string() }
}

/// How much of the connectivity before could be kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kept {
    /// Its memory.
    Memory,
    /// The pattern and the order of sums: no point has changed its nodes.
    Pattern,
    /// All of it: neither points nor mesh have changed.
    All,
}

/// Connects the points to the nodes of `mesh`; `former` is the connectivity of the step before.
pub(crate) fn connect<const D: usize>(
    model: &Model<D>,
    mesh: &Mesh<D>,
    former: Option<Connected<D>>,
) -> Result<(Connected<D>, Kept), StepFailure> {
    let stencils = stencils(model, mesh)?;
    let active = ActiveNodes::of(mesh.lattice(), &stencils);
    let linked: Vec<Linked<D>> = stencils
        .into_iter()
        .zip(&model.bodies)
        .map(|(stencils, named)| {
            let links = Links::of(stencils, &active);
            let dilatation = named.body.dilatation(&links, mesh, &active).map_err(|it| outside(named, &it))?;
            Ok(Linked { links, dilatation })
        })
        .collect::<Result<_, _>>()?;
    let faces = model.ghost.map(|factor| {
        let mut cells = Vec::new();
        for (named, linked) in model.bodies.iter().zip(&linked) {
            named.body.occupied_cells(&linked.links, mesh.lattice(), &active, &mut cells);
        }
        GhostFaces::of(mesh, &active, cells, factor)
    });
    // Faces are taken anew, and with them what they couple.
    let same = faces.is_none()
        && former.as_ref().is_some_and(|former| {
            former.active == active
                && linked.iter().zip(&former.connections).all(|(now, before)| before.is_connected_as(now))
        });
    match former {
        Some(Connected { connections, pattern, .. }) if same => {
            let connections =
                connections.into_iter().zip(linked).map(|(kept, now)| kept.relinked(now.links)).collect();
            Ok((Connected { active, connections, pattern, ghost: None }, Kept::Pattern))
        }
        former => {
            let former = former.map(|former| former.pattern);
            let pattern = Pattern::reusing(former, active.len(), &linked, faces.as_ref());
            let connections = linked.into_iter().map(|linked| Connection::new(linked, &pattern)).collect();
            let ghost = faces.map(|faces| Ghost { slots: faces.slots(&pattern), faces });
            Ok((Connected { active, connections, pattern, ghost }, Kept::Memory))
        }
    }
}

/// What the supports prescribe on the active nodes over the step.
fn constrain<const D: usize>(
    model: &Model<D>,
    mesh: &Mesh<D>,
    active: &ActiveNodes<D>,
    step: &Step,
) -> Result<Constraints<D>, StepFailure> {
    let mut constraints = Constraints::none(active.len());
    for support in &model.supports {
        for &node in &support.nodes {
            let Some(number) = active.number(node) else { continue };
            for (component, prescribed) in support.components.iter().enumerate() {
                let increment = match prescribed {
                    None => continue,
                    Some(Prescribed::Held) => 0.0,
                    Some(Prescribed::Driven(ramp)) => ramp.value(step.end) - ramp.value(step.start),
                    Some(Prescribed::Turned(turn)) => {
                        turn.displacement(&mesh.position(node), step.start, step.end)[component]
                    }
                    Some(Prescribed::FollowMesh) => model
                        .motion
                        .displacement(&model.layout, node, mesh, step.start, step.end)
                        .map_err(|it| StepFailure::Mesh(it.to_string()))?[component],
                };
                constraints.prescribe(number, component, increment);
            }
        }
    }
    Ok(constraints)
}

/// `f_ext` of every active node at the end of the step `[F]`.
fn external_force<const D: usize>(
    model: &Model<D>,
    connections: &[Connection<D>],
    n_active: usize,
    step: &Step,
) -> Vec<Vector<D>> {
    let mut external = vec![Vector::zeros(); n_active];
    let acceleration = model.loads.acceleration(step.end);
    for (index, (named, connection)) in model.bodies.iter().zip(connections).enumerate() {
        let point_forces = model.loads.point_forces(index, &*named.body, step.end);
        let loads = BodyLoads { acceleration, point_forces: &point_forces };
        named.body.external_force(connection.links(), &loads, &mut external);
    }
    external
}

/// Out-of-balance force that rounding alone can cause: a few units in the last place of strain in
/// every point `[F]`.
fn round_off<const D: usize>(model: &Model<D>, connections: &[Connection<D>], n_active: usize) -> f64 {
    let mut scale = vec![0.0; n_active];
    for (named, connection) in model.bodies.iter().zip(connections) {
        named.body.stiffness_force(connection.links(), &mut scale);
    }
    2.0 * f64::EPSILON * scale.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Where the lattice lines of each direction stand at rest `[L]`; in directions that do not exist there is one.
pub(crate) fn lines<const D: usize>(layout: &Layout<D>) -> [Vec<f64>; 3] {
    let mut lines: [Vec<f64>; 3] = std::array::from_fn(|_| vec![0.0]);
    for (padded, lines) in lines.iter_mut().zip(layout.lines()) {
        *padded = lines;
    }
    lines
}

/// Lattice lines of the directions that close on themselves.
pub(crate) fn periods<const D: usize>(mesh: &Mesh<D>) -> [Option<u32>; 3] {
    let (periodic, nodes) = (mesh.lattice().periodic(), mesh.lattice().nodes());
    std::array::from_fn(|d| (d < D && periodic[d]).then(|| nodes[d]))
}

//! How long a run will take, found by doing each of its parts once where that is quick.

use crate::clock::processor_seconds;
use crate::connection::Connected;
use crate::equilibrium::problem::refuse;
use crate::error::Error;
use crate::failure::StepFailure;
use crate::model::Model;
use crate::ranks::Alone;
use mpm_assembly::{
    Constraints, Contribution, SystemSums, SystemTangent, Trial, UnknownVector, finish_tangent, views,
};
use mpm_grid::{Block, LoadFraction, Mesh};
use mpm_linear::{
    Automatic, FactorSize, Hints, LatticePlaces, Matrix, Prediction, dense_operation, predict_factor,
};
use std::hint::black_box;

/// Newton iterations of a load step that are reckoned with: the shipped scenes take 1 to 5.3, whether anything yields or not.
const ITERATIONS: f64 = 5.0;

/// The same where something comes into contact and parts: the plough takes 9 to 13, the weaker its ghost faces the more.
const ITERATIONS_OF_CONTACT: f64 = 11.0;

/// A linear system of a later step against one at the start: bodies reach into more cells than at rest, and tangents
/// of material that yields are stiff and hard to iterate on.
const HARDER: f64 = 2.0;

/// Runs take between these parts of what is reckoned: the shipped scenes 0.3 to 3.1 (`apps/mpm-cli/tests/prediction.rs`),
/// most where a body comes to reach into more cells, so that systems grow.
const RANGE: [f64; 2] = [0.25, 4.0];

/// Passes over the points beside those of the iterations: the forces in the end, and what advances the points.
const PASSES_BESIDE: f64 = 1.0;

/// Strain under which the points are summed: most of what can yield does.
const STRAIN: f64 = 0.02;

/// Operations of a factorisation that is tried.
const MOST_OPERATIONS: f64 = 3e8;

/// Bytes that an iterative solution moves that is tried `[bytes]`.
const MOST_TRAFFIC: f64 = 1e9;

/// Part of its first residual that an inexact linear solution leaves, as most of Newton's do.
const LEFT: f64 = 1e-5;

/// Time of an operation of a factorisation, in that of an operation of a small dense one.
const SPARSE_SHARE: f64 = 1.6;

/// The same of a byte that an iterative solution is said to move.
const BYTE_SHARE: f64 = 1.75;

/// The same of an entry of the factor, to find its structure.
const ENTRY_SHARE: f64 = 100.0;

/// A part that is quicker is done twice: the first one meets cold memory `[s]`.
const QUICK: f64 = 0.02;

/// A part that is as quick as this is done as often as there is time `[s]`.
const VERY_QUICK: f64 = 0.002;

/// What the program takes to begin and to end: least and most `[s]`.
const PROGRAM: [f64; 2] = [0.03, 0.06];

/// What a load step takes besides its parts, its row in the results included: least, as in 20,000 small steps, and most
/// `[s]`.
const BESIDE: [f64; 2] = [2e-5, 2e-4];

/// Seconds of processors that the parts of a run take on this machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seconds {
    /// Connecting points to nodes, once per load step `[s]`.
    pub connect: f64,
    /// Preparing the linear solver, once per load step `[s]`.
    pub analyse: f64,
    /// A pass over the points that sums force and tangent `[s]`.
    pub pass: f64,
    /// The same of rigid tools `[s]`.
    pub tools: f64,
    /// Solving a linear system `[s]`.
    pub solve: f64,
    /// Looking at all points, for each field that is recorded `[s]`.
    pub look: f64,
    /// Whether solving was tried; else it is counted and multiplied by what the machine does in small.
    pub is_tried: bool,
    /// Nominal load steps.
    pub steps: f64,
    /// Newton iterations of a load step that are reckoned with.
    pub iterations: f64,
}

impl Seconds {
    /// Of a load step, without the record `[s]`.
    pub fn per_step(&self) -> f64 {
        self.connect + self.analyse + self.per_connected_step()
    }

    /// The same where no point has left its nodes, so that the connectivity of the step before is kept.
    fn per_connected_step(&self) -> f64 {
        self.iterations * (self.pass + self.tools + HARDER * self.solve) + PASSES_BESIDE * self.pass
    }

    /// Least and most of the run, with `fields` columns of the points (their positions are one) recorded every so many
    /// steps. More is taken where load steps are halved `[s]`.
    pub fn range(&self, fields: usize, every: u32) -> [f64; 2] {
        let records = 1.0 + self.steps / f64::from(every.max(1));
        let looks = records * fields as f64 * self.look;
        let total =
            |k: usize, per_step: f64| RANGE[k] * (PROGRAM[k] + looks + self.steps * (BESIDE[k] + per_step));
        [total(0, self.per_connected_step()), total(1, self.per_step())]
    }
}

/// What is at hand for a rehearsal.
pub(crate) struct Rehearsal<'a, const D: usize> {
    pub model: &'a Model<D>,
    pub mesh: &'a Mesh<D>,
    pub connected: &'a Connected<D>,
    /// What connecting took `[s]`.
    pub connect: f64,
    pub constraints: &'a Constraints<D>,
    pub places: LatticePlaces<'a>,
    pub prediction: &'a Prediction,
}

/// Does the parts of a Newton iteration.
///
/// # Errors
/// The bodies cannot be assembled.
pub(crate) fn rehearse<const D: usize>(stage: &Rehearsal<'_, D>) -> Result<Seconds, Error> {
    let Rehearsal { model, connected, constraints, .. } = *stage;
    let pattern = &connected.pattern;
    let mut values = vec![0.0; pattern.n_entries()];
    // At rest laws have less to do: nothing yields, and no direction is a principal one.
    let is_ring = model.space().is_axisymmetric();
    let strain = Block::<D>::from_fn(|i, j| match i == j {
        true => STRAIN / (1.0 + i as f64),
        // A radial displacement away from the axis alone would carry points through it.
        false if is_ring && i == 0 => 0.0,
        false => STRAIN,
    });
    let nodes = connected.active.nodes().iter();
    let rest = connected.at_rest();
    let strained = nodes.map(|&node| strain * connected.active.space().position(stage.mesh, node)).collect();
    let strained = UnknownVector { nodes: strained, ..rest.clone() };
    let mut force = rest.clone();
    let bodies = connected.bodies(&model.bodies);
    let mut assemble = |increment: &UnknownVector<D>, values: &mut [f64]| {
        values.fill(0.0);
        let tangent = Some(SystemTangent { values, lift: None });
        let mut sums = SystemSums::new(&mut force, tangent);
        let trial = Trial { pattern, constraints, increment, end: LoadFraction::START, is_first: false };
        for (index, connected) in bodies.iter().enumerate() {
            let summed = connected.add(&trial, &mut sums);
            summed.map_err(|it| refuse((&model.bodies, &model.contributions), index, it, &Alone))?;
        }
        Ok::<_, StepFailure>(())
    };
    let pass = shortest(|| assemble(&strained, &mut values)).map_err(Error::Start)?;
    assemble(&rest, &mut values).map_err(Error::Start)?;
    let are_pushed = are_pushed(model);
    let tools = if are_pushed {
        let (mut sums, mut force) = (vec![0.0; pattern.n_entries()], rest.clone());
        shortest(|| sum_tools(stage, &rest, &mut sums, &mut force)).map_err(Error::Start)?
    } else {
        0.0
    };
    finish_tangent(pattern, constraints, &mut values);
    let tried = try_solution(stage, &values);
    let is_tried = tried.is_some();
    let (analyse, solve) = tried.unwrap_or_else(|| counted(stage));

    let look = shortest(|| {
        for view in model.bodies.iter().flat_map(|named| views(&*named.body)) {
            black_box(view);
        }
        Ok::<_, Error>(())
    })?;
    Ok(Seconds {
        connect: stage.connect,
        analyse,
        pass,
        tools,
        solve,
        look,
        is_tried,
        steps: model.stages.iter().map(|stage| f64::from(stage.steps)).sum(),
        iterations: if are_pushed { ITERATIONS_OF_CONTACT } else { ITERATIONS },
    })
}

/// Whether tools or walls push the bodies: contact that opens and closes leaves tangents that are not positive definite.
pub(super) fn are_pushed<const D: usize>(model: &Model<D>) -> bool {
    let moves = |it: &dyn Contribution<D>| it.moves_with_load() && !it.is_load();
    model.contributions.iter().any(|named| moves(&*named.contribution))
}

/// Force and tangent of what moves with the load, where nothing has moved yet.
fn sum_tools<const D: usize>(
    stage: &Rehearsal<'_, D>,
    increment: &UnknownVector<D>,
    values: &mut [f64],
    force: &mut UnknownVector<D>,
) -> Result<(), StepFailure> {
    let Rehearsal { model, connected, constraints, .. } = *stage;
    let pattern = &connected.pattern;
    let tangent = Some(SystemTangent { values, lift: None });
    let mut sums = SystemSums::new(force, tangent);
    let trial = Trial { pattern, constraints, increment, end: LoadFraction::START, is_first: true };
    for named in model.contributions.iter().filter(|named| named.contribution.moves_with_load()) {
        named.contribution.add(&trial, &mut sums).map_err(|it| StepFailure::Linear(it.to_string()))?;
    }
    Ok(())
}

/// Seconds of preparing for a pattern and of a solution, where they are few and the matrix can be solved at all.
fn try_solution<const D: usize>(stage: &Rehearsal<'_, D>, values: &[f64]) -> Option<(f64, f64)> {
    let Prediction { factor_operations, iterative_traffic, .. } = *stage.prediction;
    let is_quick = match is_iterative(stage) {
        true => iterative_traffic <= MOST_TRAFFIC,
        false => factor_operations <= MOST_OPERATIONS,
    };
    if !is_quick {
        return None;
    }
    let pattern = stage.connected.pattern.for_solver();
    let matrix = Matrix { pattern, values };
    let mut linear = stage.model.linear_solver();
    let further = |equation| stage.connected.field_node(equation);
    let clock = processor_seconds();
    linear.analyse(pattern, &Hints { further: Some(&further), ..Hints::on_lattice(stage.places) }).ok()?;
    let analyse = processor_seconds() - clock;
    let solve = shortest(|| {
        let mut rhs = vec![1.0; pattern.n_equations()];
        linear.restart();
        linear.factorise(matrix)?;
        linear.solve(matrix, &mut rhs, LEFT)
    });
    let solve = solve.ok()?;
    Some((analyse, solve))
}

/// Size of the factor.
///
/// # Errors
/// Not even its structure fits into memory.
pub(super) fn factor_size<const D: usize>(stage: &Rehearsal<'_, D>) -> Result<FactorSize, Error> {
    let further = |equation| stage.connected.field_node(equation);
    let hints = Hints { further: Some(&further), ..Hints::on_lattice(stage.places) };
    let size = predict_factor(stage.connected.pattern.for_solver(), &hints);
    size.map_err(|it| Error::TooLarge(it.to_string()))
}

/// Whether the linear systems are solved by iteration.
pub(super) fn is_iterative<const D: usize>(stage: &Rehearsal<'_, D>) -> bool {
    let further = |equation| stage.connected.field_node(equation);
    let hints = Hints { further: Some(&further), ..Hints::on_lattice(stage.places) };
    let can_be = Automatic::can_iterate(stage.connected.pattern.for_solver(), &hints);
    can_be && stage.model.choice().is_some_and(|choice| choice.is_iterative(stage.prediction))
}

/// The same from operations and bytes, and from what the machine does with small ones.
fn counted<const D: usize>(stage: &Rehearsal<'_, D>) -> (f64, f64) {
    let Prediction { factor_operations, factor_entries, iterative_traffic, .. } = *stage.prediction;
    let operation = dense_operation(processor_seconds);
    if is_iterative(stage) {
        let solve = BYTE_SHARE * iterative_traffic * operation;
        return (solve, solve);
    }
    (ENTRY_SHARE * factor_entries * operation, SPARSE_SHARE * factor_operations * operation)
}

/// Seconds that some work takes, the shortest of a few times if it is quick.
fn shortest<T, E>(mut work: impl FnMut() -> Result<T, E>) -> Result<f64, E> {
    let (mut shortest, start) = (f64::INFINITY, processor_seconds());
    for times in 1.. {
        let clock = processor_seconds();
        work()?;
        let now = processor_seconds();
        shortest = shortest.min(now - clock);
        if now - start > if times == 1 { QUICK } else { VERY_QUICK } {
            break;
        }
    }
    Ok(shortest)
}

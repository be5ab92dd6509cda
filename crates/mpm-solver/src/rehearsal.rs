//! How long a run will take, found by doing each of its parts once where that is quick.

use crate::error::{Error, SceneError};
use crate::linear::{Choice, LinearSolver, Place, Prediction, SymmetricPattern};
use crate::load_step::Connected;
use crate::model::Model;
use crate::newton::columns;
use mpm_assembly::{Constraints, PassInput, Sums, TangentSums, finish_tangent, views};
use mpm_grid::Vector;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Newton iterations of a load step that are reckoned with: elastic bodies, and those that can yield.
const ITERATIONS: (f64, f64) = (4.0, 6.0);

/// Passes over the points beside those of the iterations: the forces in the end, and what advances the points.
const PASSES_BESIDE: f64 = 1.0;

/// Operations of a factorisation that is tried.
const MOST_OPERATIONS: f64 = 3e8;

/// Bytes that an iterative solution moves that is tried `[bytes]`.
const MOST_TRAFFIC: f64 = 1e9;

/// Part of its first residual that an inexact linear solution leaves, as most of Newton's do.
const LEFT: f64 = 1e-5;

/// What a large system takes for each operation of its factorisation, in steps of a small dense one of the machine.
const DENSE_SHARE: f64 = 1.6;

/// What an iterative solution takes for the bytes it is said to move, in seconds that the machine needs to copy them.
const COPY_SHARE: f64 = 0.6;

/// Seconds that the parts of a run take on this machine, with the threads at hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seconds {
    /// Connecting points to nodes, once per load step `[s]`.
    pub connect: f64,
    /// Preparing the linear solver, once per load step `[s]`.
    pub analyse: f64,
    /// A pass over the points that sums force and tangent `[s]`.
    pub pass: f64,
    /// Solving a linear system `[s]`.
    pub solve: f64,
    /// Looking at all points, for each field that is recorded `[s]`.
    pub look: f64,
    /// Whether solving was tried; else it is counted and multiplied by what the machine does in small.
    pub is_tried: bool,
    /// Newton iterations of a load step that are reckoned with.
    pub iterations: f64,
    /// Nominal load steps.
    pub steps: f64,
}

impl Seconds {
    /// Of a load step, without the record `[s]`.
    pub fn per_step(&self) -> f64 {
        self.connect + self.analyse + self.iterations * (self.pass + self.solve) + PASSES_BESIDE * self.pass
    }

    /// Of the run, with `fields` columns of the points (their positions are one) recorded every so many steps `[s]`.
    pub fn total(&self, fields: usize, every: u32) -> f64 {
        let records = 1.0 + self.steps / f64::from(every.max(1));
        self.steps * self.per_step() + records * fields as f64 * self.look
    }
}

/// What is at hand for a rehearsal.
pub(crate) struct Stage<'a, const D: usize> {
    pub model: &'a Model<D>,
    pub connected: &'a Connected<D>,
    /// What connecting took `[s]`.
    pub connect: f64,
    pub constraints: &'a Constraints<D>,
    pub place: Place<'a>,
    pub prediction: &'a Prediction,
}

/// Does the parts of a Newton iteration.
///
/// # Errors
/// The bodies cannot be assembled.
pub(crate) fn rehearse<const D: usize>(stage: &Stage<'_, D>) -> Result<Seconds, Error> {
    let Stage { model, connected, constraints, .. } = *stage;
    let pattern = &connected.pattern;
    let mut values = vec![0.0; pattern.n_entries()];
    let mut internal = vec![Vector::zeros(); pattern.n_equations() / D];
    let increment = vec![Vector::zeros(); internal.len()];
    // The first pass meets cold memory.
    let mut pass = f64::INFINITY;
    for _ in 0..2 {
        let clock = Instant::now();
        values.fill(0.0);
        for (named, connection) in model.bodies.iter().zip(&connected.connections) {
            let tangent = Some(TangentSums { values: &mut values, lift: None });
            let input = PassInput { pattern, constraints, increment: &increment };
            let summed = named.body.assemble(connection, input, Sums { internal: &mut internal, tangent });
            summed.map_err(|it| SceneError::new("bodies", it))?;
        }
        pass = pass.min(clock.elapsed().as_secs_f64());
    }
    finish_tangent(pattern, constraints, &mut values);
    let tried = try_solution(stage, &values);
    let is_tried = tried.is_some();
    let (analyse, solve) = tried.unwrap_or_else(|| counted(stage));

    let clock = Instant::now();
    for named in &model.bodies {
        for view in views(&*named.body) {
            black_box(view);
        }
    }
    let look = clock.elapsed().as_secs_f64();
    let yields = model
        .bodies
        .iter()
        .any(|named| named.body.columns().iter().any(|(name, bytes)| *name == "plastic state" && *bytes > 0));
    Ok(Seconds {
        connect: stage.connect,
        analyse,
        pass,
        solve,
        look,
        is_tried,
        iterations: if yields { ITERATIONS.1 } else { ITERATIONS.0 },
        steps: f64::from(model.schedule.steps),
    })
}

/// Seconds of preparing for a pattern and of a solution, where they are few and the matrix can be solved at all.
fn try_solution<const D: usize>(stage: &Stage<'_, D>, values: &[f64]) -> Option<(f64, f64)> {
    let Prediction { factor_operations, iterative_traffic, .. } = *stage.prediction;
    let choice: Choice = stage.model.solver;
    let is_quick = match choice.is_iterative::<D>(stage.prediction) {
        true => iterative_traffic <= MOST_TRAFFIC,
        false => factor_operations <= MOST_OPERATIONS,
    };
    if !is_quick {
        return None;
    }
    let pattern: SymmetricPattern<'_> = columns(&stage.connected.pattern);
    let mut linear = LinearSolver::<D>::new(choice);
    let clock = Instant::now();
    linear.analyse(pattern, stage.place).ok()?;
    let analyse = clock.elapsed().as_secs_f64();
    let mut solve = f64::INFINITY;
    for _ in 0..2 {
        let mut rhs = vec![1.0; stage.connected.pattern.n_equations()];
        let clock = Instant::now();
        linear.factorise(pattern, values, linear.first_method()).ok()?;
        linear.solve(pattern, values, &mut rhs, LEFT).ok()?;
        solve = solve.min(clock.elapsed().as_secs_f64());
    }
    Some((analyse, solve))
}

/// The same from operations and bytes, and from what the machine does with small ones.
fn counted<const D: usize>(stage: &Stage<'_, D>) -> (f64, f64) {
    let Prediction { factor_operations, factor_entries, iterative_traffic, .. } = *stage.prediction;
    let copied = copying();
    if stage.model.solver.is_iterative::<D>(stage.prediction) {
        let solve = COPY_SHARE * iterative_traffic * copied;
        return (solve, solve);
    }
    // The factor is read twice to solve, and its structure is about as much work as that.
    let through = 2.0 * size_of::<f64>() as f64 * factor_entries * copied;
    (through, DENSE_SHARE * factor_operations * crate::linear::dense_operation() + through)
}

/// Seconds to read or write a byte of memory, one thread: a copy of more than caches hold.
fn copying() -> f64 {
    const NUMBERS: usize = 4 << 20;
    let from = vec![1.0_f64; NUMBERS];
    let mut to = vec![0.0_f64; NUMBERS];
    let mut shortest = Duration::MAX;
    for _ in 0..3 {
        let clock = Instant::now();
        to.copy_from_slice(black_box(&from));
        black_box(&mut to);
        shortest = shortest.min(clock.elapsed());
    }
    shortest.as_secs_f64() / (2 * NUMBERS * size_of::<f64>()) as f64
}

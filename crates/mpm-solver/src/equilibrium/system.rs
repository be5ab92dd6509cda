//! Linear systems with the tangent of a load step, also with a border of a few more unknowns.
//!
//! A border holds unknowns λ that are no displacements of nodes (the load fraction under path control, say), each with
//! a column and a row:
//!
//! ```text
//! K δu - B δλ = f          one column of B per border unknown
//! C δu + E δλ = g          one row of C and E per border unknown
//! ```
//!
//! One factorisation of K serves all right-hand sides, and the border unknowns follow from the small dense Schur
//! complement: `(E + C K⁻¹B) δλ = g - C K⁻¹f`, then `δu = K⁻¹f + K⁻¹B δλ`.

use super::problem::{Effort, Iterate, Problem, TangentTarget, Wanted, larger};
use crate::cancellation::Cancellation;
use crate::failure::StepFailure;
use crate::ranks::{Shared, agreed, any, largest, least};
use crate::timing::{Phase, Timings};
use mpm_assembly::{Space, SparsityPattern, UnknownVector};
use mpm_basis::parallel;
use mpm_grid::{NodeId, Vector};
use mpm_linear::{Analysis, Cause, Hints, LinearSolver, Matrix, NotSavedHere, Pivot, Saved, Singular};

/// Part of the right-hand side that the linear solutions of a bordered system leave.
const LEFT_BESIDE_BORDER: f64 = 1e-9;

/// Entries of a tangent below this, or above its reciprocal, are scaled.
const SMALL: f64 = 1e-100;

/// What solves the systems of a run; it is kept from step to step.
pub(crate) struct Solver<const D: usize> {
    linear: Box<dyn LinearSolver>,
    /// Entries of the tangent that was summed last.
    values: Vec<f64>,
    rhs: Vec<f64>,
    /// Power of two by which `values` and right-hand sides are multiplied: see [`scale`].
    scale: f64,
    /// The weakest pivot of the last factorisation, if it had pivots.
    pub weakest_pivot: Option<Pivot>,
    cancellation: Cancellation,
    pub timings: Timings,
}

impl<const D: usize> Solver<D> {
    pub(crate) fn new(linear: Box<dyn LinearSolver>, cancellation: Cancellation, timings: Timings) -> Self {
        Self {
            linear,
            values: Vec::new(),
            rhs: Vec::new(),
            scale: 1.0,
            weakest_pivot: None,
            cancellation,
            timings,
        }
    }

    /// Prepares the linear solver for tangents of this pattern.
    ///
    /// # Errors
    /// The factor does not fit into memory.
    pub(crate) fn analyse(
        &mut self,
        pattern: &SparsityPattern<D>,
        hints: &Hints<'_>,
    ) -> Result<Analysis, StepFailure> {
        let analysis = self.timings.time(Phase::Analyse, || self.linear.analyse(pattern.for_solver(), hints));
        let analysis = analysis.map_err(|it| StepFailure::Linear(it.to_string()))?;
        if analysis == Analysis::Reused {
            self.timings.skipped.analyses += 1;
        }
        Ok(analysis)
    }

    /// The load steps that were solved so far are done: see [`LinearSolver::end_step`].
    pub(crate) fn end_step(&mut self) {
        self.linear.end_step();
    }

    /// The iteration begins anew from another state: see [`LinearSolver::restart`].
    pub(crate) fn restart(&mut self) {
        self.linear.restart();
    }

    /// What a resumed run needs of the linear solver: see [`LinearSolver::save`].
    pub(crate) fn save(&self) -> Option<Saved> {
        self.linear.save()
    }

    /// # Errors
    /// See [`LinearSolver::restore`].
    pub(crate) fn restore(&mut self, saved: Saved) -> Result<(), NotSavedHere> {
        self.linear.restore(saved)
    }

    /// No node has moved.
    pub(crate) fn at_rest(&self, problem: &Problem<'_, D>) -> Iterate<D> {
        Iterate::at_rest(problem.connected, self.linear.first_method())
    }

    /// Estimate of the condition number of the last tangent, if it can be had.
    pub(crate) fn condition(&mut self, problem: &Problem<'_, D>) -> Option<f64> {
        self.linear.condition(Matrix { pattern: problem.connected.pattern.for_solver(), values: &self.values })
    }

    /// # Errors
    /// The run was asked to stop.
    pub(crate) fn check_cancellation(&self, problem: &Problem<'_, D>) -> Result<(), StepFailure> {
        let is_cancelled = any(&*problem.connected.shared.ranks, self.cancellation.is_cancelled());
        if is_cancelled { Err(StepFailure::Cancelled) } else { Ok(()) }
    }

    /// Forces of the iterate, and the tangent, whose product with the prescribed increments goes to `lift`, if there is
    /// one.
    ///
    /// # Errors
    /// As [`Problem::evaluate`].
    pub(crate) fn evaluate(
        &mut self,
        problem: &Problem<'_, D>,
        iterate: &mut Iterate<D>,
        wanted: Wanted,
        lift: Option<&mut UnknownVector<D>>,
    ) -> Result<(), StepFailure> {
        parallel::resize(&mut self.values, problem.connected.pattern.n_entries());
        let target = TangentTarget { values: &mut self.values, lift };
        problem.evaluate(iterate, wanted, target, &mut self.timings)
    }

    /// Factorises the tangent that was summed last.
    ///
    /// # Errors
    /// The tangent is singular or not finite, or the run was asked to stop.
    pub(crate) fn factorise(
        &mut self,
        problem: &Problem<'_, D>,
        effort: &mut Effort,
    ) -> Result<(), StepFailure> {
        self.check_cancellation(problem)?;
        let ranks = &*problem.connected.shared.ranks;
        self.scale = scale(largest(ranks, parallel::largest_size(&self.values)));
        if self.scale != 1.0 {
            parallel::multiply(&mut self.values, self.scale);
        }
        let matrix = Matrix { pattern: problem.connected.pattern.for_solver(), values: &self.values };
        let factored = self.timings.time(Phase::Factorise, || self.linear.factorise(matrix));
        let factored = agreed(ranks, factored.map_err(|error| linear_failure(problem, error)))?;
        effort.method = factored.method;
        effort.is_unstable |= factored.shows_instability();
        self.weakest_pivot = factored.weakest;
        effort.pivot_spread = larger(effort.pivot_spread, factored.pivot_ratio.map(f64::recip));
        if let Some(equation) = factored.not_positive.map(|pivot| pivot.equation).or(factored.indefinite_at) {
            let node = problem.unknowns().node_of(equation).map(|(node, _)| node);
            let node = node.or_else(|| problem.connected.field_node(equation));
            // A rank may not have the node.
            let number = node.map(|node| problem.connected.active.nodes()[node].index() as f64);
            let number = least(ranks, number.unwrap_or(f64::INFINITY));
            effort.unstable_node = number.is_finite().then(|| NodeId::from_index(number as usize)).flatten();
        }
        Ok(())
    }

    /// `K⁻¹ f` with the factorisation at hand, zero on prescribed components; an iterative solver may leave
    /// `accuracy · |f|`.
    ///
    /// # Errors
    /// No solution is accurate, or the force is not finite.
    pub(crate) fn substitute(
        &mut self,
        problem: &Problem<'_, D>,
        force: &UnknownVector<D>,
        accuracy: f64,
        solution: &mut UnknownVector<D>,
        effort: &mut Effort,
    ) -> Result<(), StepFailure> {
        let Self { linear, values, rhs, scale, timings, .. } = self;
        force.write_equations(rhs);
        if *scale != 1.0 {
            rhs.iter_mut().for_each(|force| *force *= *scale);
        }
        let matrix = Matrix { pattern: problem.connected.pattern.for_solver(), values };
        let solved = timings.time(Phase::Solve, || linear.solve(matrix, rhs, accuracy));
        let ranks = &*problem.connected.shared.ranks;
        let solved = agreed(ranks, solved.map_err(|error| linear_failure(problem, error)))?;
        effort.linear_iterations += u64::from(solved.iterations);
        effort.method = solved.method;
        effort.is_unstable |= solved.taken_over.is_some_and(|factored| factored.shows_instability());
        effort.backward_error = larger(effort.backward_error, solved.backward_error);
        effort.refinements += solved.refinements as u32;
        solution.read_equations(rhs);
        Ok(())
    }

    /// Factorises the tangent that was summed last, and solves for a force and for the columns of a border.
    ///
    /// # Errors
    /// As [`Self::factorise`] and [`Self::substitute`].
    pub(crate) fn solve_bordered(
        &mut self,
        problem: &Problem<'_, D>,
        force: &UnknownVector<D>,
        columns: &[&UnknownVector<D>],
        effort: &mut Effort,
    ) -> Result<BorderedSolution<D>, StepFailure> {
        self.factorise(problem, effort)?;
        let mut solve = |force: &UnknownVector<D>| {
            let mut solution = UnknownVector::zeros(problem.unknowns());
            self.substitute(problem, force, LEFT_BESIDE_BORDER, &mut solution, effort)?;
            Ok(solution)
        };
        let of_force = solve(force)?;
        let of_columns = columns.iter().map(|column| solve(column)).collect::<Result<_, _>>()?;
        Ok(BorderedSolution { of_force, of_columns })
    }
}

/// The parts of the solution of a bordered system.
pub(crate) struct BorderedSolution<const D: usize> {
    /// `K⁻¹ f` `[L]`.
    pub of_force: UnknownVector<D>,
    /// `K⁻¹ B`, column by column `[L]` per unit of the border unknown.
    pub of_columns: Vec<UnknownVector<D>>,
}

/// The equation of a border unknown.
pub(crate) struct BorderRow<'a, const D: usize> {
    /// Its row of C: derivative with respect to nodal displacements.
    pub gradient: &'a [Vector<D>],
    /// Its row of E: derivatives with respect to the border unknowns.
    pub border: Vec<f64>,
    /// Its right-hand side g.
    pub wanted: f64,
}

impl<const D: usize> BorderedSolution<D> {
    /// The border unknowns δλ; none where the Schur complement is singular.
    pub(crate) fn border_unknowns(&self, rows: &[BorderRow<'_, D>], shared: &Shared<D>) -> Option<Vec<f64>> {
        let dot = |a: &[Vector<D>], b: &[Vector<D>]| shared.dot_nodes(a, b);
        let slopes = |row: &BorderRow<'_, D>| {
            self.of_columns
                .iter()
                .zip(&row.border)
                .map(|(column, e)| dot(row.gradient, &column.nodes) + e)
                .collect()
        };
        let complement: Vec<Vec<f64>> = rows.iter().map(slopes).collect();
        let rhs = rows.iter().map(|row| row.wanted - dot(row.gradient, &self.of_force.nodes)).collect();
        solve_dense(complement, rhs)
    }

    /// `δu = K⁻¹f + K⁻¹B δλ` of a node.
    pub(crate) fn displacement(&self, node: usize, border_unknowns: &[f64]) -> Vector<D> {
        let columns = self.of_columns.iter().zip(border_unknowns);
        columns.fold(self.of_force.nodes[node], |sum, (column, unknown)| sum + column.nodes[node] * *unknown)
    }

    /// The displacement of a change of the only border unknown, and what it makes of the other unknowns, from `rest` on.
    pub(crate) fn changed(&self, rest: UnknownVector<D>, change: f64) -> UnknownVector<D> {
        let mut changed = rest;
        for (v, increment) in changed.nodes.iter_mut().enumerate() {
            *increment = self.displacement(v, &[change]);
        }
        for (k, increment) in changed.own.iter_mut().enumerate() {
            *increment += self.own(k, &[change]);
        }
        changed
    }

    /// The change of an unknown that belongs to no node's displacement.
    pub(crate) fn own(&self, unknown: usize, border_unknowns: &[f64]) -> f64 {
        let columns = self.of_columns.iter().zip(border_unknowns);
        columns.fold(self.of_force.own[unknown], |sum, (column, it)| sum + column.own[unknown] * it)
    }
}

/// Size of the largest entry.
/// Power of two that brings the largest entry near 1, if squares of entries could overflow or vanish; else 1.
///
/// Solutions of a system and its bits stay what they are under a power of two.
fn scale(largest: f64) -> f64 {
    if largest == 0.0 || !largest.is_finite() || (SMALL..=SMALL.recip()).contains(&largest) {
        return 1.0;
    }
    // The reciprocal of a subnormal number would overflow.
    (-largest.log2().floor()).clamp(-1000.0, 1000.0).exp2()
}

/// Solution of a small dense system by elimination with partial pivoting; none where a pivot is zero.
pub(crate) fn solve_dense(mut rows: Vec<Vec<f64>>, mut rhs: Vec<f64>) -> Option<Vec<f64>> {
    let n = rhs.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|&i, &j| rows[i][k].abs().total_cmp(&rows[j][k].abs()))?;
        if rows[pivot][k] == 0.0 {
            return None;
        }
        rows.swap(k, pivot);
        rhs.swap(k, pivot);
        for i in k + 1..n {
            let (above, below) = rows.split_at_mut(i);
            let (upper, lower) = (&above[k][k..], &mut below[0][k..]);
            let factor = lower[0] / upper[0];
            for (lower, upper) in lower.iter_mut().zip(upper) {
                *lower -= factor * upper;
            }
            rhs[i] -= factor * rhs[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| rows[k][j] * rhs[j]).sum();
        rhs[k] = (rhs[k] - known) / rows[k][k];
    }
    Some(rhs)
}

fn linear_failure<const D: usize>(problem: &Problem<'_, D>, error: Singular) -> StepFailure {
    match error.cause {
        Cause::EmptyRow | Cause::NoPivot | Cause::Inaccurate { .. } => {
            singular(problem, error.equation, error.cause.to_string())
        }
        Cause::MatrixNotFinite
        | Cause::RightHandSideNotFinite
        | Cause::TooLargeToFactorise { .. }
        | Cause::NoMemory { .. } => StepFailure::Linear(error.to_string()),
        Cause::Unsuitable(reason) => StepFailure::Unsuitable(reason),
    }
}

/// The failure of a tangent that is singular in one of its equations.
pub(crate) fn singular<const D: usize>(
    problem: &Problem<'_, D>,
    equation: usize,
    cause: String,
) -> StepFailure {
    let unknowns = problem.unknowns();
    let axes = problem.bodies.first().map_or(Space::default(), |named| named.body.space()).axes();
    if let Some(node) = problem.connected.field_node(equation) {
        let node = problem.connected.active.nodes()[node];
        let position = problem.connected.active.space().position(problem.mesh, node);
        return StepFailure::SingularField {
            node: node.index(),
            position: position.iter().copied().collect(),
            cause,
        };
    }
    let Some((node, component)) = unknowns.node_of(equation) else {
        let own = equation - unknowns.displacement(unknowns.n_nodes(), 0).equation();
        let owner = problem.connected.own.iter().position(|range| range.contains(&own));
        let Some(owner) = owner else { return StepFailure::Linear(cause) };
        let named = &problem.named[owner];
        let unknown = named.contribution.describe_unknown(own - problem.connected.own[owner].start, axes);
        return StepFailure::SingularContribution { unknown, contribution: named.name.clone(), cause };
    };
    let node = problem.connected.active.nodes()[node];
    StepFailure::Singular {
        node: node.index(),
        position: problem.connected.active.space().position(problem.mesh, node).iter().copied().collect(),
        component,
        axis: axes[component],
        cause,
        can_be_stabilised: problem.connected.active.space().kind() == problem.mesh.functions()
            && !problem.contributions.iter().any(|it| it.stabilises()),
        has_apex: problem.bodies.iter().any(|named| named.body.points_at_apex().is_some()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ranks::{Alone, Ranks};
    use std::rc::Rc;

    #[test]
    fn a_border_of_two_unknowns_is_solved_as_the_whole_system() {
        // K = diag(2, 4, 5, 10), which BorderedSolution has applied already.
        let field = |x: [f64; 4]| vec![Vector::<2>::new(x[0], x[1]), Vector::<2>::new(x[2], x[3])];
        let k = [2.0, 4.0, 5.0, 10.0];
        let inverse =
            |x: [f64; 4]| UnknownVector { nodes: field(std::array::from_fn(|i| x[i] / k[i])), own: Vec::new() };
        let (f, b) = ([1.0, 2.0, 3.0, 4.0], [[1.0, 0.0, 2.0, 0.0], [0.0, 3.0, 0.0, 1.0]]);
        let (c, e, g) = ([[0.0, 2.0, 1.0, 0.0], [1.0, 0.0, 0.0, 4.0]], [[0.0, 3.0], [1.0, 0.0]], [5.0, 6.0]);
        let solution = BorderedSolution { of_force: inverse(f), of_columns: b.map(inverse).to_vec() };
        let gradients = c.map(field);
        let row = |i: usize| BorderRow { gradient: &gradients[i], border: e[i].to_vec(), wanted: g[i] };
        let alone: Rc<dyn Ranks<2>> = Rc::new(Alone);
        let lambda = solution.border_unknowns(&[row(0), row(1)], &Shared::of(&alone)).unwrap();
        let u: Vec<f64> = (0..2)
            .flat_map(|node| solution.displacement(node, &lambda).iter().copied().collect::<Vec<_>>())
            .collect();
        for i in 0..4 {
            let left = k[i] * u[i] - b[0][i] * lambda[0] - b[1][i] * lambda[1];
            assert!((left - f[i]).abs() < 1e-13, "equation {i}");
        }
        for i in 0..2 {
            let left: f64 =
                (0..4).map(|j| c[i][j] * u[j]).sum::<f64>() + e[i][0] * lambda[0] + e[i][1] * lambda[1];
            assert!((left - g[i]).abs() < 1e-13, "border {i}");
        }
    }

    #[test]
    fn a_singular_border_has_no_solution() {
        assert_eq!(solve_dense(vec![vec![0.0]], vec![1.0]), None);
        assert_eq!(solve_dense(vec![vec![1.0, 2.0], vec![2.0, 4.0]], vec![1.0, 1.0]), None);
        assert_eq!(solve_dense(vec![vec![0.0, 2.0], vec![4.0, 0.0]], vec![6.0, 8.0]), Some(vec![2.0, 3.0]));
    }
}

//! Systems with a few unknowns that belong to no node, such as the motion of loaded tools, by a solver that knows nodes only:
//!
//! ```text
//! A x + B λ = f      x = A⁻¹f - A⁻¹B λ
//! C x + E λ = g      (E - C A⁻¹B) λ = g - C A⁻¹f
//! ```

mod parts;

use crate::exchange::Exchange;
use crate::wire::Wire;
use mpm_linear::{
    Analysis, Cause, Factored, Hints, LinearSolver, Matrix, Method, NotSavedHere, OutOfMemory, Pattern, Saved,
    Singular, Solved,
};
use parts::{Parts, Reduced};
use std::rc::Rc;

/// Part of a column of B that its solution leaves.
const LEFT: f64 = 1e-11;

/// Solves for the unknowns of nodes by another solver of the ranks, and for the others, which all ranks have alike, by a small
/// dense system. Without any it is the other solver.
pub struct Bordered<const D: usize, W> {
    inner: Box<dyn LinearSolver>,
    exchange: Rc<Exchange<D, W>>,
    border: Option<Border>,
}

/// The border of a pattern, and of the matrix at hand.
struct Border {
    parts: Parts,
    /// Values of A.
    values: Vec<f64>,
    /// Values of the rows of C that this rank has.
    rows: Vec<Vec<(usize, f64)>>,
    /// `A⁻¹B`, column by column.
    solutions: Vec<Vec<f64>>,
    reduced: Reduced,
    /// Iterations for the columns of B that no solution has told of yet.
    iterations: u32,
}

impl<const D: usize, W: Wire> Bordered<D, W> {
    /// `inner` is given the equations of nodes.
    pub fn new(inner: Box<dyn LinearSolver>, exchange: Rc<Exchange<D, W>>) -> Self {
        Self { inner, exchange, border: None }
    }

    /// Whether any rank has failed.
    fn any<T>(&self, here: &Result<T, Singular>) -> bool {
        let mut failed = [f64::from(u8::from(here.is_err()))];
        self.exchange.sum(&mut failed);
        failed[0] > 0.0
    }

    fn border(&mut self) -> &mut Border {
        self.border.as_mut().expect("the pattern has a border")
    }

    /// `A⁻¹B`; false where a rank has failed that is not this one.
    fn solve_columns(&mut self, mut columns: Vec<Vec<f64>>) -> Result<bool, Singular> {
        self.border().iterations = 0;
        for column in &mut columns {
            self.exchange.complete(column, D);
            let mut size = [column.iter().map(|x| x * x).sum::<f64>()];
            self.exchange.sum(&mut size);
            if size[0] == 0.0 {
                continue;
            }
            let Border { parts, values, .. } = self.border.as_ref().expect("the pattern has a border");
            let matrix = Matrix { pattern: parts.of_nodes(), values };
            let solved = self.inner.solve(matrix, column, LEFT);
            if self.any(&solved) {
                return solved.map(|_| false);
            }
            self.border().iterations += solved?.iterations;
        }
        self.border().solutions = columns;
        Ok(true)
    }
}

impl<const D: usize, W: Wire> LinearSolver for Bordered<D, W> {
    fn analyse(&mut self, pattern: Pattern<'_>, hints: &Hints<'_>) -> Result<Analysis, OutOfMemory> {
        if pattern.has_blocks_only() {
            self.border = None;
            return self.inner.analyse(pattern, hints);
        }
        let parts = Parts::of(pattern);
        let analysis = self.inner.analyse(parts.of_nodes(), hints);
        let (values, rows, solutions) = (Vec::new(), Vec::new(), Vec::new());
        let reduced = Reduced::default();
        self.border = Some(Border { parts, values, rows, solutions, reduced, iterations: 0 });
        analysis
    }

    fn factorise(&mut self, matrix: Matrix<'_>) -> Result<Factored, Singular> {
        let Some(border) = &mut self.border else { return self.inner.factorise(matrix) };
        border.values = border.parts.values_of_nodes(matrix.values);
        border.rows = border.parts.rows(matrix.values);
        let columns = border.parts.columns(matrix.values);
        let mut corner = border.parts.corner(matrix.values);
        let factored =
            self.inner.factorise(Matrix { pattern: border.parts.of_nodes(), values: &border.values });
        if self.any(&factored) {
            return factored;
        }
        let factored = Factored { inertia: None, determinant_sign: None, ..factored? };
        self.exchange.sum(&mut corner);
        if !self.solve_columns(columns)? {
            return Ok(factored);
        }
        let Border { rows, solutions, .. } = self.border();
        let mut products: Vec<f64> =
            rows.iter().flat_map(|row| solutions.iter().map(|it| product(row, it))).collect();
        self.exchange.sum(&mut products);
        let complement = corner.iter().zip(&products).map(|(of_corner, product)| of_corner - product);
        let border = self.border.as_mut().expect("the pattern has a border");
        border.reduced = Reduced::of(complement.collect(), &corner).map_err(|k| {
            let equation = border.parts.n_of_nodes() + k;
            Singular { equation, pivot: Some(0.0), cause: Cause::NoPivot }
        })?;
        Ok(factored)
    }

    fn solve(&mut self, matrix: Matrix<'_>, rhs: &mut [f64], tolerance: f64) -> Result<Solved, Singular> {
        let Some(border) = &self.border else { return self.inner.solve(matrix, rhs, tolerance) };
        let n = border.parts.n_of_nodes();
        let mut of_force = rhs[..n].to_vec();
        let of_nodes = Matrix { pattern: border.parts.of_nodes(), values: &border.values };
        let solved = self.inner.solve(of_nodes, &mut of_force, tolerance);
        if self.any(&solved) {
            return solved;
        }
        let mut solved = solved?;
        let Border { rows, solutions, reduced, iterations, .. } =
            self.border.as_mut().expect("the pattern has a border");
        let mut products: Vec<f64> = rows.iter().map(|row| product(row, &of_force)).collect();
        self.exchange.sum(&mut products);
        let wanted = rhs[n..].iter().zip(&products).map(|(g, product)| g - product).collect();
        let own = reduced.solve(wanted);
        for (solution, own) in solutions.iter().zip(&own) {
            of_force.iter_mut().zip(solution).for_each(|(x, of)| *x -= of * own);
        }
        rhs[..n].copy_from_slice(&of_force);
        rhs[n..].copy_from_slice(&own);
        solved.iterations += std::mem::take(iterations);
        Ok(solved)
    }

    fn first_method(&self) -> Method {
        self.inner.first_method()
    }

    fn restart(&mut self) {
        self.inner.restart();
    }

    fn end_step(&mut self) {
        self.inner.end_step();
    }

    fn save(&self) -> Option<Saved> {
        self.inner.save()
    }

    fn restore(&mut self, saved: Saved) -> Result<(), NotSavedHere> {
        self.inner.restore(saved)
    }
}

/// A row of C times a solution, of the entries that this rank has.
fn product(row: &[(usize, f64)], solution: &[f64]) -> f64 {
    row.iter().map(|(equation, value)| value * solution[*equation]).sum()
}

//! A linear solver of one's own: dense LU factorisation, for small problems only.

use mpm_linear::{
    Analysis, Cause, Factored, Hints, LinearSolver, Matrix, Method, OutOfMemory, Pattern, Sign, Singular,
    Solved,
};
use mpm_scene::{Compiled, Scene, compile};
use mpm_solver::{SolverChoice, run};
use nalgebra::{DMatrix, DVector, Dyn, LU};
use std::error::Error;

const DENSE: Method = Method::Other("dense LU");

/// Keeps the factors of the last matrix.
#[derive(Default)]
struct DenseLu {
    factors: Option<LU<f64, Dyn, Dyn>>,
}

impl LinearSolver for DenseLu {
    /// A dense factor depends on no pattern and no order: there is nothing to prepare.
    fn analyse(&mut self, _: Pattern<'_>, _: &Hints<'_>) -> Result<Analysis, OutOfMemory> {
        Ok(Analysis::New)
    }

    fn factorise(&mut self, matrix: Matrix<'_>) -> Result<Factored, Singular> {
        let factors = dense(matrix).lu();
        let pivots = factors.u().diagonal();
        if let Some(equation) = pivots.iter().position(|pivot| *pivot == 0.0 || !pivot.is_finite()) {
            return Err(Singular { equation, pivot: Some(pivots[equation]), cause: Cause::NoPivot });
        }
        let exchanges: f64 = factors.p().determinant();
        let negative = pivots.iter().filter(|pivot| **pivot < 0.0).count() % 2 == 1;
        let sign = if negative == (exchanges > 0.0) { Sign::Negative } else { Sign::Positive };
        self.factors = Some(factors);
        Ok(Factored { determinant_sign: Some(sign), ..Factored::by(DENSE) })
    }

    fn solve(&mut self, matrix: Matrix<'_>, rhs: &mut [f64], _: f64) -> Result<Solved, Singular> {
        let factors = self.factors.as_ref().expect("factorise comes before solve");
        let b = DVector::from_column_slice(rhs);
        let x = factors.solve(&b).expect("every pivot is a number other than 0");
        rhs.copy_from_slice(x.as_slice());
        let left = (&b - DVector::from(matrix.times(rhs))).norm();
        Ok(Solved {
            method: DENSE,
            backward_error: None,
            residual: Some(if left == 0.0 { 0.0 } else { left / b.norm() }),
            refinements: 0,
            iterations: 0,
            taken_over: None,
        })
    }

    fn first_method(&self) -> Method {
        DENSE
    }
}

/// All entries of a sparse matrix; of a symmetric one only the lower triangle is stored.
fn dense(Matrix { pattern, values }: Matrix<'_>) -> DMatrix<f64> {
    let n = pattern.n_equations();
    let mut dense = DMatrix::zeros(n, n);
    for column in 0..n {
        let entries = pattern.column_start[column]..pattern.column_start[column + 1];
        for (&row, &value) in pattern.row[entries.clone()].iter().zip(&values[entries]) {
            dense[(row, column)] = value;
            if pattern.is_symmetric() {
                dense[(column, row)] = value;
            }
        }
    }
    dense
}

/// Displacements of all points at the end of a shipped scene `[L]`.
fn displacements(solver: SolverChoice) -> Result<Vec<f64>, Box<dyn Error>> {
    let scene = Scene::from_ron(include_str!("../../../scenes/doughnut_elastic.ron"))?;
    let Compiled::Plane(mut model) = compile(&scene)? else {
        return Err("the scene is one in plane strain".into());
    };
    model.solver = solver;
    let body = |model: &mpm_solver::Model<2>| {
        let body = &model.bodies[0].body;
        (0..body.n_points()).flat_map(|point| <[f64; 2]>::from(body.point(point).position)).collect::<Vec<_>>()
    };
    let start = body(&model);
    run(&mut model, &mut ())?;
    Ok(body(&model).iter().zip(start).map(|(end, start)| end - start).collect())
}

fn main() -> Result<(), Box<dyn Error>> {
    let displacements = displacements(SolverChoice::custom(DenseLu::default))?;
    let largest = displacements.iter().fold(0.0_f64, |most, u| most.max(u.abs()));
    println!("largest component of displacement: {largest}");
    Ok(())
}

#[cfg(test)]
#[path = "../tests/own_linear_solver.rs"]
mod tests;

//! Unsymmetric systems against dense LU.

use super::problem::random;
use crate::automatic::{Automatic, Choice};
use crate::direct::{Factorization, predict_factor};
use crate::matrix::{Matrix, Pattern};
use crate::report::{Analysis, Cause, Method, Sign, Singular};
use crate::solver::{Hints, LatticePlaces, LinearSolver};
use nalgebra::{DMatrix, DVector};

/// A matrix of both triangles, whose nodes stand on a lattice.
struct System {
    column_start: Vec<usize>,
    row: Vec<usize>,
    values: Vec<f64>,
    index: Vec<[u32; 3]>,
    block: usize,
}

impl System {
    /// Random couplings of nodes in a box with the diagonals `diagonal(equation, sum of the other entries' sizes)`:
    /// the structure of a symmetric problem with independent values in its upper triangle.
    fn random(n: [u32; 3], reach: u32, block: usize, diagonal: impl Fn(usize, f64) -> f64) -> Self {
        let lower = random(n, reach, block, diagonal);
        let size = lower.n();
        let mut columns: Vec<Vec<(usize, f64)>> = vec![Vec::new(); size];
        for j in 0..size {
            for entry in lower.column_start[j]..lower.column_start[j + 1] {
                let (i, value) = (lower.row[entry], lower.values[entry]);
                columns[j].push((i, value));
                if i != j {
                    // Uncorrelated with the entry below the diagonal, and no larger.
                    columns[i].push((j, 0.9 * value * (entry as f64 * 2.4).cos()));
                }
            }
        }
        Self::of_columns(columns, lower.lattice, block)
    }

    fn of_columns(columns: Vec<Vec<(usize, f64)>>, index: Vec<[u32; 3]>, block: usize) -> Self {
        let (mut column_start, mut row, mut values) = (vec![0], Vec::new(), Vec::new());
        for mut column in columns {
            column.sort_unstable_by_key(|&(i, _)| i);
            for (i, value) in column {
                row.push(i);
                values.push(value);
            }
            column_start.push(row.len());
        }
        Self { column_start, row, values, index, block }
    }

    fn n(&self) -> usize {
        self.column_start.len() - 1
    }

    fn pattern(&self) -> Pattern<'_> {
        let (block, blocks) = (self.block, self.index.len());
        Pattern { block, blocks, ..Pattern::unsymmetric(&self.column_start, &self.row, 1) }
    }

    fn matrix(&self) -> Matrix<'_> {
        Matrix { pattern: self.pattern(), values: &self.values }
    }

    fn dense(&self) -> DMatrix<f64> {
        let mut dense = DMatrix::zeros(self.n(), self.n());
        for j in 0..self.n() {
            for entry in self.column_start[j]..self.column_start[j + 1] {
                dense[(self.row[entry], j)] = self.values[entry];
            }
        }
        dense
    }

    fn analysed(&self, solver: &mut dyn LinearSolver) -> Analysis {
        let lines = std::array::from_fn(|_| (0..80).map(f64::from).collect());
        let places = LatticePlaces { index: &self.index, lines: &lines, periods: [None; 3], degree: [1; 3] };
        solver.analyse(self.pattern(), &Hints::on_lattice(places)).unwrap()
    }

    /// Solves with a residual of 1e-12 at most, and checks solution and sign of the determinant by dense LU.
    fn check(&self, solver: &mut dyn LinearSolver) {
        let factored = solver.factorise(self.matrix()).unwrap();
        let lu = self.dense().lu();
        let determinant_sign =
            (0..self.n()).fold(lu.p().determinant::<f64>(), |sign, k| sign * lu.u()[(k, k)].signum());
        let expected = if determinant_sign < 0.0 { Sign::Negative } else { Sign::Positive };
        assert_eq!((factored.method, factored.determinant_sign), (Method::Lu, Some(expected)));
        assert_eq!((factored.inertia, factored.not_positive), (None, None));
        assert_eq!(factored.shows_instability(), expected == Sign::Negative);
        let b: Vec<f64> = (0..self.n()).map(|i| ((i * 7919) % 1000) as f64 / 1000.0 - 0.3).collect();
        let mut x = b.clone();
        let solved = solver.solve(self.matrix(), &mut x, 0.0).unwrap();
        assert!(solved.backward_error.unwrap() <= 1e-12, "{solved:?}");
        let b = DVector::from(b);
        let residual = (&b - DVector::from(self.matrix().times(&x))).norm() / b.norm();
        assert!(residual <= 1e-12, "{residual}");
        let exact = lu.solve(&b).unwrap();
        let error = (DVector::from(x) - &exact).norm() / exact.norm();
        assert!(error < 1e-9, "{error}");
    }
}

/// Diagonals that dominate, with the sign of every fifth reversed.
fn with_signs(equation: usize, sum: f64) -> f64 {
    (1.1 * sum + 0.1) * if equation % 5 == 2 { -1.0 } else { 1.0 }
}

#[test]
fn random_systems_are_those_of_dense_lu() {
    for (n, reach, block) in [([12, 9, 1], 1, 2), ([5, 4, 4], 1, 3), ([7, 7, 1], 2, 1), ([4, 1, 1], 1, 4)] {
        for diagonal in
            [|_, sum| 1.1 * sum + 0.1, with_signs, |_, _| 0.3, |e, _| if e % 2 == 0 { 0.0 } else { 0.3 }]
        {
            let system = System::random(n, reach, block, diagonal);
            let mut solver = Factorization::new();
            system.analysed(&mut solver);
            system.check(&mut solver);
        }
    }
}

#[test]
fn the_automatic_choice_is_lu() {
    let system = System::random([10, 9, 1], 1, 2, with_signs);
    for choice in [Choice::Auto, Choice::Direct] {
        let mut solver = Automatic::new(choice);
        system.analysed(&mut solver);
        assert_eq!(solver.first_method(), Method::Lu);
        system.check(&mut solver);
    }
}

#[test]
fn systems_without_a_lattice_and_with_equations_of_no_node_are_solved() {
    let mut system = System::random([6, 5, 1], 1, 2, with_signs);
    let mut solver = Automatic::new(Choice::Auto);
    solver.analyse(system.pattern(), &Hints::default()).unwrap();
    system.check(&mut solver);
    // The last node's equations are said to be of none.
    system.index.pop();
    system.analysed(&mut solver);
    system.check(&mut solver);
}

#[test]
fn the_structure_is_kept_while_the_pattern_is_equal_and_restored() {
    let (a, b) = (System::random([6, 5, 1], 1, 2, with_signs), System::random([5, 6, 1], 1, 2, with_signs));
    let mut solver = Automatic::new(Choice::Auto);
    let seen = [&a, &a, &b, &a].map(|system| {
        let analysis = system.analysed(&mut solver);
        system.check(&mut solver);
        analysis
    });
    assert_eq!(seen, [Analysis::New, Analysis::Reused, Analysis::New, Analysis::New]);
    assert_eq!(solver.save(), None, "the step has not ended");
    solver.end_step();
    let saved = solver.save().unwrap();
    let mut resumed = Automatic::new(Choice::Auto);
    resumed.restore(saved).unwrap();
    assert_eq!(a.analysed(&mut resumed), Analysis::Reused);
    a.check(&mut resumed);
}

#[test]
fn entries_of_both_factors_are_predicted() {
    let system = System::random([14, 13, 1], 1, 2, |_, sum| 1.1 * sum + 0.1);
    let lower = random([14, 13, 1], 1, 2, |_, sum| 1.1 * sum + 0.1);
    let hints = lower.hints();
    let predicted = predict_factor(system.pattern(), &hints).unwrap().entries;
    // The blocks on the diagonal hold both triangles.
    let of_triangle = predict_factor(lower.pattern(), &hints).unwrap().entries;
    assert!(of_triangle < predicted && predicted < 2 * of_triangle, "{predicted} {of_triangle}");
    let mut solver = Factorization::new();
    system.analysed(&mut solver);
    system.check(&mut solver);
    assert_eq!(solver.factor_entries(), predicted);
}

#[test]
fn singular_systems_are_named() {
    let named = |system: &System| {
        let mut solver = Factorization::new();
        system.analysed(&mut solver);
        solver.factorise(system.matrix()).unwrap_err()
    };
    // A row of zeros.
    let mut system = System::random([6, 5, 1], 1, 2, with_signs);
    for (row, value) in system.row.iter().zip(&mut system.values) {
        *value *= f64::from(*row != 17);
    }
    assert_eq!(named(&system), Singular { equation: 17, pivot: Some(0.0), cause: Cause::EmptyRow });
    // A column of zeros.
    let mut system = System::random([6, 5, 1], 1, 2, with_signs);
    let column = system.column_start[23]..system.column_start[24];
    system.values[column].fill(0.0);
    let error = named(&system);
    assert_eq!((error.equation, error.cause), (23, Cause::NoPivot));
    // A node both of whose equations are the same.
    let mut system = System::random([6, 5, 1], 1, 2, with_signs);
    for j in 0..system.n() {
        let first = system.column_start[j];
        let rows = &system.row[first..system.column_start[j + 1]];
        if let (Ok(one), Ok(other)) = (rows.binary_search(&20), rows.binary_search(&21)) {
            system.values[first + other] = 3.0 * system.values[first + one];
        }
    }
    let error = named(&system);
    assert_eq!(error.cause, Cause::NoPivot);
    assert!(error.pivot.unwrap().abs() < 1e-13);
    // Entries that are no numbers.
    let mut system = System::random([6, 5, 1], 1, 2, with_signs);
    let entry = system.column_start[11] + 3;
    system.values[entry] = f64::NAN;
    let error = named(&system);
    assert_eq!((error.equation, error.cause), (11, Cause::MatrixNotFinite));
}

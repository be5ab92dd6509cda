//! The same matrices made unsymmetric: GMRES, and the choice between it and LU.

use super::{System, lines, same_bits_on_all_threads};
use mpm_linear::multigrid::{Failure, Multigrid};
use mpm_linear::{
    Automatic, Cause, Choice, Hints, LatticePlaces, LinearSolver, Matrix, Method, Pattern, predict,
};
use nalgebra::{DMatrix, DVector};

/// Both triangles of (1 + skew) L + D + (1 - skew) Lᵀ, of K = L + D + Lᵀ. With `skew` 1 it is triangular.
struct Unsymmetric {
    of: System,
    column_start: Vec<usize>,
    row: Vec<usize>,
    values: Vec<f64>,
}

impl Unsymmetric {
    fn new(of: System, skew: f64) -> Self {
        let n = of.column_start.len() - 1;
        let mut columns: Vec<Vec<(usize, f64)>> = vec![Vec::new(); n];
        for j in 0..n {
            for entry in of.column_start[j]..of.column_start[j + 1] {
                let (i, value) = (of.row[entry], of.values[entry]);
                let [below, above] =
                    if i == j { [value; 2] } else { [(1.0 + skew) * value, (1.0 - skew) * value] };
                columns[j].push((i, below));
                if i != j {
                    columns[i].push((j, above));
                }
            }
        }
        let (mut column_start, mut row, mut values) = (vec![0], Vec::new(), Vec::new());
        for column in &mut columns {
            column.sort_unstable_by_key(|it| it.0);
            row.extend(column.iter().map(|it| it.0));
            values.extend(column.iter().map(|it| it.1));
            column_start.push(row.len());
        }
        Self { of, column_start, row, values }
    }

    fn cube(n: u32, skew: f64) -> Self {
        Self::new(System::cube(n, 0.3), skew)
    }

    fn matrix(&self) -> Matrix<'_> {
        Matrix { pattern: Pattern::unsymmetric(&self.column_start, &self.row, 3), values: &self.values }
    }

    fn places(&self) -> LatticePlaces<'_> {
        LatticePlaces {
            index: &self.of.index,
            lines: &self.of.lines,
            periods: self.of.periodic,
            degree: [1; 3],
        }
    }

    fn solve(&self, tolerance: f64) -> (Vec<f64>, u32) {
        let mut multigrid = Multigrid::<3>::analyse(self.matrix().pattern, self.places()).expect("blocks only");
        multigrid.prepare(self.matrix()).expect("no coarse matrix is singular");
        let mut x = self.of.load();
        let solved = multigrid.solve(&mut x, tolerance, 500).expect("converges");
        assert!(solved.residual <= tolerance);
        assert!(self.residual(&x) <= 1.0001 * tolerance, "{:e}", self.residual(&x));
        (x, solved.iterations)
    }

    fn residual(&self, x: &[f64]) -> f64 {
        let (b, image) = (DVector::from(self.of.load()), DVector::from(self.matrix().times(x)));
        (&b - image).norm() / b.norm()
    }

    fn solver(&self, choice: Choice) -> Automatic {
        let mut solver = Automatic::new(choice);
        solver.analyse(self.matrix().pattern, &Hints::on_lattice(self.places())).unwrap();
        solver
    }
}

#[test]
fn the_solution_is_that_of_a_dense_factorisation() {
    for skew in [0.1, 0.6] {
        let system = Unsymmetric::cube(5, skew);
        let (x, iterations) = system.solve(1e-12);
        let n = x.len();
        let mut dense = DMatrix::zeros(n, n);
        for j in 0..n {
            for entry in system.column_start[j]..system.column_start[j + 1] {
                dense[(system.row[entry], j)] = system.values[entry];
            }
        }
        let expected = dense.lu().solve(&DVector::from(system.of.load())).unwrap();
        let error = x.iter().zip(expected.iter()).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        assert!(error < 1e-9 * expected.amax(), "{skew}: {error:e} after {iterations}");
    }
}

/// Without skewness the Krylov space is that of conjugate gradients, and minimal residuals are no larger.
#[test]
fn a_symmetric_matrix_takes_no_more_iterations_than_conjugate_gradients() {
    for tolerance in [1e-4, 1e-8, 1e-12] {
        let by_gradients = System::cube(12, 0.3).solve(tolerance).1;
        let by_residuals = Unsymmetric::cube(12, 0.0).solve(tolerance).1;
        assert!(by_residuals <= by_gradients, "{tolerance:e}: {by_residuals} of {by_gradients}");
    }
}

#[test]
fn iterations_hardly_grow_with_the_mesh() {
    let iterations: Vec<u32> = [8, 16, 24].map(|n| Unsymmetric::cube(n, 0.1).solve(1e-8).1).to_vec();
    println!("{iterations:?}");
    assert!(iterations[2] <= 30 && 2 * iterations[2] <= 3 * iterations[0], "{iterations:?}");
}

#[test]
fn a_krylov_space_begun_anew_goes_on() {
    // Nearly incompressible: more iterations than one space has.
    let system = Unsymmetric::new(System::cube(8, 0.4999), 0.002);
    let (_, iterations) = system.solve(1e-8);
    assert!(iterations > 60, "{iterations}");
}

#[test]
fn threads_do_not_change_a_bit() {
    let system = Unsymmetric::cube(12, 0.2);
    same_bits_on_all_threads(|| system.solve(1e-10).0);
}

#[test]
fn what_is_not_solved_is_told_and_nothing_is_made_up() {
    let mut system = Unsymmetric::cube(6, 0.2);
    let mut multigrid = Multigrid::<3>::analyse(system.matrix().pattern, system.places()).unwrap();
    multigrid.prepare(system.matrix()).unwrap();
    let mut x = system.of.load();
    match multigrid.solve(&mut x, 1e-12, 3) {
        Err(Failure::NotConverged { iterations: 3, residual }) => {
            assert!(residual < 0.5 && (residual / system.residual(&x) - 1.0).abs() < 1e-9, "{residual}");
        }
        other => panic!("{other:?}"),
    }
    let mut zero = vec![0.0; x.len()];
    assert_eq!(multigrid.solve(&mut zero, 1e-12, 3).unwrap().iterations, 0);
    // A row of zeros, which nothing can balance.
    let free = system.of.index.iter().position(|&index| index == [3, 3, 3]).unwrap() * 3;
    let row = system.row.clone();
    system.values.iter_mut().zip(&row).filter(|(_, row)| **row == free).for_each(|(value, _)| *value = 0.0);
    multigrid.prepare(system.matrix()).unwrap();
    let failed = multigrid.solve(&mut system.of.load(), 1e-8, 500);
    assert!(matches!(failed, Err(Failure::NotConverged { .. })), "{failed:?}");
    let mut solver = system.solver(Choice::Iterative);
    solver.factorise(system.matrix()).unwrap();
    let failed = solver.solve(system.matrix(), &mut system.of.load(), 1e-8).unwrap_err();
    assert_eq!((failed.equation, failed.cause), (free, Cause::EmptyRow));
    system.values[7] = f64::NAN;
    let failed = multigrid.prepare(system.matrix());
    assert!(matches!(failed, Err(Failure::NotFinite { .. })), "{failed:?}");
}

#[test]
fn the_quicker_solver_is_chosen_and_lu_takes_over() {
    let small = Unsymmetric::cube(8, 0.1);
    assert_eq!(small.solver(Choice::Auto).first_method(), Method::Lu);
    let mut solver = small.solver(Choice::Iterative);
    assert_eq!(solver.factorise(small.matrix()).unwrap().method, Method::Gmres);
    let mut x = small.of.load();
    let solved = solver.solve(small.matrix(), &mut x, 1e-8).unwrap();
    assert!(solved.method == Method::Gmres && solved.taken_over.is_none() && small.residual(&x) < 1e-8);
    // So far from symmetric that 400 iterations do not suffice.
    let hard =
        Unsymmetric::new(System::new(lines([8; 3]), [None; 3], 0.4999, |_| 1.0, |[_, _, z], _| z == 0), 1.5);
    let mut solver = hard.solver(Choice::Iterative);
    let factored = solver.factorise(hard.matrix()).unwrap();
    let mut x = hard.of.load();
    let solved = solver.solve(hard.matrix(), &mut x, 1e-8).unwrap();
    assert_eq!((factored.method, solved.method), (Method::Gmres, Method::Lu));
    assert!(solved.taken_over.is_some() && hard.residual(&x) < 1e-8);
    // The next matrix of the same load step goes there at once.
    assert_eq!(solver.factorise(hard.matrix()).unwrap().method, Method::Lu);
    solver.restart();
    assert_eq!(solver.factorise(hard.matrix()).unwrap().method, Method::Gmres);
}

#[test]
fn large_systems_in_space_are_iterated_on_and_those_in_the_plane_are_not() {
    let prefers = |n: usize, dimensions: usize| {
        let side = (n as f64).powf(1.0 / dimensions as f64).round() as u32;
        let range = |d: usize| if d < dimensions { side } else { 1 };
        let index: Vec<[u32; 3]> = (0..range(2))
            .flat_map(|z| (0..range(1)).flat_map(move |y| (0..range(0)).map(move |x| [x, y, z])))
            .collect();
        let lines: [Vec<f64>; 3] = std::array::from_fn(|d| (0..range(d)).map(f64::from).collect());
        let places = LatticePlaces { index: &index, lines: &lines, periods: [None; 3], degree: [1; 3] };
        // Only the number of entries counts.
        let equations = index.len() * dimensions;
        let entries = index.len() * dimensions * dimensions * 3_usize.pow(dimensions as u32);
        let column_start: Vec<usize> = (0..=equations).map(|j| j * (entries / equations)).collect();
        let row = vec![0; entries];
        predict(Pattern::unsymmetric(&column_start, &row, dimensions), places).prefers_iterative()
    };
    assert!(!prefers(13_usize.pow(3), 3) && prefers(30_usize.pow(3), 3));
    assert!(!prefers(400_usize.pow(2), 2));
}

//! Factorisations in parallel: the same bits on any number of threads.

use super::problem::{Problem, elasticity};
use crate::direct::Factorization;
use crate::direct::order::StoredOrder;
use crate::matrix::{Matrix, Pattern};
use crate::report::Method;
use crate::solver::{Hints, LinearSolver};

/// What comes of a matrix on a number of threads: method, bits of the solution, and how many steps were refined.
fn on_threads(threads: usize, solve: impl Fn() -> (Method, Vec<f64>) + Send + Sync) -> (Method, Vec<u64>) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let (method, x) = pool.install(solve);
    (method, x.into_iter().map(f64::to_bits).collect())
}

fn check(expected: Method, solve: impl Fn() -> (Method, Vec<f64>) + Send + Sync) {
    let one = on_threads(1, &solve);
    assert_eq!(one.0, expected);
    for threads in [2, 3, 7] {
        assert!(on_threads(threads, &solve) == one, "{threads} threads, {expected:?}");
    }
}

/// By a factorisation that begins with `start`.
fn solution(problem: &Problem, start: Method) -> (Method, Vec<f64>) {
    let mut factorization = problem.analysed();
    let factored = factorization.factorise_from(problem.matrix(), start).unwrap();
    let mut x: Vec<f64> = (0..problem.n()).map(|i| (i as f64).sin()).collect();
    let solved = factorization.solve(problem.matrix(), &mut x, 0.0).unwrap();
    assert!(solved.backward_error.unwrap() < 1e-12 && solved.method == factored.method, "{solved:?}");
    (factored.method, x)
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    // Wide enough for tasks, and in space for fronts in tiles and columns in panels.
    for problem in [elasticity([50, 40], false), elasticity([12, 13, 13], false)] {
        for start in [Method::Llt, Method::Lblt] {
            check(start, || solution(&problem, start));
        }
        let mut indefinite = problem;
        for equation in (0..indefinite.n()).step_by(11) {
            indefinite.values[indefinite.column_start[equation]] *= -1.0;
        }
        check(Method::Lblt, || solution(&indefinite, Method::Llt));
        let unsymmetric = indefinite.unsymmetric(|i, j, k| if i > j { 1.1 * k } else { k });
        check(Method::Lu, || solution(&unsymmetric, Method::Lu));
    }
}

#[test]
fn the_first_pivot_that_fails_is_told_on_any_number_of_threads() {
    let mut problem = elasticity([60, 60], false);
    for equation in (0..problem.n()).step_by(501) {
        problem.detach(equation, -1.0 - equation as f64);
    }
    let failed = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| problem.analysed().factorise_from(problem.matrix(), Method::Llt).unwrap())
    };
    let one = failed(1);
    assert!(one.not_positive.is_some_and(|pivot| pivot.value == -1.0 - pivot.equation as f64), "{one:?}");
    for _ in 0..5 {
        assert_eq!(failed(4), one);
    }
}

#[test]
fn long_chains_of_fronts_and_forests_are_factorised() {
    // In their natural sequence the equations of a strip make a chain of fronts.
    let strip = elasticity([9, 900], false);
    let natural: Vec<usize> = (0..strip.n()).collect();
    let plain = Pattern { block: 1, blocks: 0, ..strip.pattern() };
    let in_sequence = || {
        let mut factorization = Factorization::new();
        factorization.restore(StoredOrder::of(plain, &natural).save()).unwrap();
        factorization.analyse(plain, &Hints::default()).unwrap();
        let matrix = Matrix { pattern: plain, values: &strip.values };
        let factored = factorization.factorise(matrix).unwrap();
        let mut x = strip.matrix().times(&vec![1.0; strip.n()]);
        factorization.solve(matrix, &mut x, 0.0).unwrap();
        assert!(x.iter().all(|x| (x - 1.0).abs() < 1e-6));
        (factored.method, x)
    };
    check(Method::Llt, in_sequence);
    // Thousands of parts that do not couple.
    let entries = (0..4000).flat_map(|node| {
        let first = 2 * node;
        [((first, first), 2.0), ((first, first + 1), 1.0), ((first + 1, first + 1), 3.0)]
    });
    let lattice = (0..4000).map(|node| [node % 80, node / 80, 0]).collect();
    let parts = Problem::new(lattice, 2, &entries.collect());
    check(Method::Llt, || solution(&parts, Method::Llt));
}

//! Symmetric matrices that are not positive definite: GMRES goes on where conjugate gradients stop.

use super::System;
use mpm_linear::{Automatic, Choice, Factored, Hints, LatticePlaces, LinearSolver, Method};

/// A cube of n³ cells with a soft spring of the wrong sign at each of some nodes of its top; all diagonal blocks stay positive
/// where `part` is less than 1.
fn softened(n: u32, springs: &[[u32; 2]], part: f64) -> System {
    let mut system = System::cube(n, 0.3);
    for &[x, y] in springs {
        let node = system.index.iter().position(|&index| index == [x, y, n]).unwrap();
        for i in 0..3 {
            let diagonal = system.column_start[3 * node + i];
            system.values[diagonal] *= 1.0 - part;
        }
    }
    system
}

/// What a choice of solver finds of a system, and x.
fn solved(system: &System, choice: Choice) -> (Factored, mpm_linear::Solved, Vec<f64>) {
    let mut solver = Automatic::new(choice);
    let matrix = system.matrix();
    let places =
        LatticePlaces { index: &system.index, lines: &system.lines, periods: [None; 3], degree: [1; 3] };
    solver.analyse(matrix.pattern, &Hints::on_lattice(places)).unwrap();
    let factored = solver.factorise(matrix).unwrap();
    let mut x = system.load();
    let solved = solver.solve(matrix, &mut x, 1e-10).unwrap();
    (factored, solved, x)
}

#[test]
fn gmres_goes_on_and_agrees_with_a_factorisation() {
    // Where springs leave diagonal blocks positive, conjugate gradients meet a direction; else preparing sees it at once.
    for (springs, part) in [(&[[3, 3]][..], 0.9), (&[[3, 3], [1, 5], [6, 2]], 0.9), (&[[3, 3], [5, 5]], 1.2)] {
        let system = softened(8, springs, part);
        let (_, direct, expected) = solved(&system, Choice::Direct);
        let (factored, iterated, x) = solved(&system, Choice::Iterative);
        assert_eq!((direct.method, iterated.method), (Method::Lblt, Method::Gmres));
        let seen = iterated.taken_over.unwrap_or(factored);
        assert!(seen.shows_instability() && seen.indefinite_at.is_some(), "{seen:?}");
        let most = expected.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let error = x.iter().zip(&expected).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        assert!(error < 1e-8 * most, "{error:e} of {most:e} in {} iterations", iterated.iterations);
        println!("{} springs, {part}: {} iterations", springs.len(), iterated.iterations);
    }
}

#[test]
fn a_small_system_is_left_to_the_factorisation() {
    let system = softened(8, &[[3, 3]], 0.9);
    let (_, solved, _) = solved(&system, Choice::Auto);
    assert_eq!(solved.method, Method::Lblt);
}

#[test]
fn conjugate_gradients_begin_again_after_a_restart() {
    let (soft, plain) = (softened(8, &[[3, 3]], 0.9), System::cube(8, 0.3));
    let mut solver = Automatic::new(Choice::Iterative);
    let places = LatticePlaces { index: &plain.index, lines: &plain.lines, periods: [None; 3], degree: [1; 3] };
    solver.analyse(plain.matrix().pattern, &Hints::on_lattice(places)).unwrap();
    let solve = |solver: &mut Automatic, system: &System| {
        solver.factorise(system.matrix()).unwrap();
        let mut x = system.load();
        (solver.solve(system.matrix(), &mut x, 1e-8).unwrap().method, x)
    };
    let (method, first) = solve(&mut solver, &plain);
    assert_eq!(method, Method::ConjugateGradients);
    assert_eq!(solve(&mut solver, &soft).0, Method::Gmres);
    // What comes next is probably not positive definite, either.
    assert_eq!(solve(&mut solver, &plain).0, Method::Gmres);
    solver.restart();
    let (method, again) = solve(&mut solver, &plain);
    assert_eq!(method, Method::ConjugateGradients);
    assert!(first == again, "the same bits as at first");
}

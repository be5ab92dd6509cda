//! The cycle in single precision, and coarse matrices that are kept from one matrix to the next.

use super::{System, lines};
use mpm_linear::multigrid::{Failure, Multigrid};
use mpm_linear::{Automatic, Choice, Hints, LatticePlaces, LinearSolver, Method};

impl System {
    fn solver(&self) -> Automatic {
        let places =
            LatticePlaces { index: &self.index, lines: &self.lines, periods: self.periodic, degree: [1; 3] };
        let mut solver = Automatic::new(Choice::Iterative);
        solver.analyse(self.matrix().pattern, &Hints::on_lattice(places)).unwrap();
        solver
    }

    /// `|b − K x| / |b|`.
    fn residual(&self, x: &[f64]) -> f64 {
        let norm = |x: &mut dyn Iterator<Item = f64>| x.map(|x| x * x).sum::<f64>().sqrt();
        let b = self.load();
        norm(&mut self.matrix().times(x).iter().zip(&b).map(|(kx, b)| b - kx)) / norm(&mut b.iter().copied())
    }
}

/// A cube whose cells right of the middle are `ratio` times as stiff as the others.
fn halves(n: u32, ratio: f64) -> System {
    let weight = |[x, ..]: [u32; 3]| if 2 * x < n { 1.0 } else { ratio };
    System::new(lines([n; 3]), [None; 3], 0.3, weight, |[_, _, z], _| z == 0)
}

#[test]
fn the_last_digits_take_no_more_iterations_than_the_first() {
    let iterations = [1e-4, 1e-8, 1e-12].map(|tolerance| System::cube(16, 0.3).solve(tolerance).1);
    println!("{iterations:?}");
    assert!(iterations[2] - iterations[1] <= iterations[1] - iterations[0] + 2, "{iterations:?}");
}

#[test]
fn powers_of_two_change_nothing_but_the_exponent() {
    let system = System::cube(9, 0.3);
    let (x, iterations) = system.solve(1e-10);
    for power in [-300, 140, 300] {
        let mut scaled = System::cube(9, 0.3);
        scaled.values.iter_mut().for_each(|value| *value *= 2.0_f64.powi(power));
        let (y, of_scaled) = scaled.solve(1e-10);
        let is_scaled = |(x, y): (&f64, &f64)| x * 2.0_f64.powi(-power) == *y;
        assert!(of_scaled == iterations && x.iter().zip(&y).all(is_scaled), "2^{power}");
    }
}

#[test]
fn what_single_precision_cannot_hold_is_factorised() {
    for (ratio, by) in [(1e-20, Method::ConjugateGradients), (1e-60, Method::Llt), (1e60, Method::Llt)] {
        let system = halves(8, ratio);
        let mut solver = system.solver();
        let factored = solver.factorise(system.matrix()).unwrap();
        // The load on the soft half is as large as that on the other: it must be small to be balanced to many digits.
        let mut x = system.load();
        let solved = solver.solve(system.matrix(), &mut x, 1e-10).unwrap();
        assert_eq!((factored.method, solved.method), (by, by), "{ratio}");
        assert!(system.residual(&x) < 1e-9, "{ratio}: {:e}", system.residual(&x));
    }
    let beyond = halves(8, 1e-60);
    let failed = beyond.multigrid().prepare(beyond.matrix());
    assert!(matches!(failed, Err(Failure::OutOfRange { .. })), "{failed:?}");
}

#[test]
fn coarse_matrices_serve_a_matrix_near_theirs() {
    let (before, after) = (halves(16, 1.0), halves(16, 1.05));
    let mut multigrid: Multigrid<3> = before.multigrid();
    // Nothing is kept yet.
    multigrid.update(after.matrix()).unwrap();
    let mut x = after.load();
    let own = multigrid.solve(&mut x, 1e-8, 100).unwrap();
    multigrid.prepare(before.matrix()).unwrap();
    multigrid.update(after.matrix()).unwrap();
    let mut x = after.load();
    let kept = multigrid.solve(&mut x, 1e-8, 100).unwrap();
    assert!(kept.iterations <= own.iterations + 2, "{kept:?}, {own:?}");
    assert!(kept.residual <= 1e-8 && after.residual(&x) < 1.001e-8);
}

#[test]
fn coarse_matrices_are_renewed_when_they_no_longer_serve() {
    let [first, near, far] = [1.0, 1.02, 30.0].map(|ratio| halves(12, ratio));
    let mut solver = first.solver();
    let mut iterations = |system: &System| {
        solver.factorise(system.matrix()).unwrap();
        let mut x = system.load();
        let solved = solver.solve(system.matrix(), &mut x, 1e-8).unwrap();
        assert!(solved.taken_over.is_none() && system.residual(&x) < 1.001e-8);
        solved.iterations
    };
    let own = iterations(&first);
    assert!(iterations(&near) <= own + 1);
    let with_coarse_matrices_of_another = iterations(&far);
    let renewed = iterations(&far);
    assert!(with_coarse_matrices_of_another as f64 > 1.3 * own as f64, "{with_coarse_matrices_of_another}");
    assert_eq!(renewed, far.solve(1e-8).1);
    assert!(renewed < with_coarse_matrices_of_another);
    // A new attempt begins with matrices of its own, as that of a run that is resumed.
    solver.restart();
    solver.factorise(first.matrix()).unwrap();
    let mut x = first.load();
    assert_eq!(solver.solve(first.matrix(), &mut x, 1e-8).unwrap().iterations, own);
    assert_eq!(x, first.solve(1e-8).0);
}

#[test]
fn what_kept_coarse_matrices_cannot_solve_is_solved_with_new_ones() {
    let (first, far) = (halves(10, 1e-9), halves(10, 1e9));
    let mut solver = first.solver();
    for system in [&first, &far] {
        solver.factorise(system.matrix()).unwrap();
        let mut x = system.load();
        let solved = solver.solve(system.matrix(), &mut x, 1e-6).unwrap();
        assert_eq!((solved.method, solved.taken_over), (Method::ConjugateGradients, None));
        assert!(system.residual(&x) < 1.001e-6);
    }
}

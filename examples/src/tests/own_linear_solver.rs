//! The dense solver against the direct one, on a scene and on matrices that are known.

use super::*;
use mpm_linear::Choice;
use mpm_solver::{PathControl, PathMeasure};

#[test]
fn a_scene_has_the_displacements_of_the_direct_solver() -> Result<(), Box<dyn Error>> {
    let dense = displacements(SolverChoice::custom(DenseLu::default))?;
    let direct = displacements(Choice::Direct.into())?;
    let largest = direct.iter().fold(0.0_f64, |most, u| most.max(u.abs()));
    assert!(largest > 1.0, "the inner edge is turned");
    let error = dense.iter().zip(&direct).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
    assert!(error < 1e-10 * largest, "{error:e}");
    Ok(())
}

#[test]
fn an_unsymmetric_system_is_solved_and_the_sign_of_its_determinant_known() -> Result<(), Box<dyn Error>> {
    // [[0, 2], [3, 4]]: det = -6.
    let pattern = Pattern::unsymmetric(&[0, 2, 4], &[0, 1, 0, 1], 1);
    let matrix = Matrix { pattern, values: &[0.0, 3.0, 2.0, 4.0] };
    let mut solver = DenseLu::default();
    assert_eq!(solver.factorise(matrix)?.determinant_sign, Some(Sign::Negative));
    let mut x = [4.0, 11.0];
    solver.solve(matrix, &mut x, 0.0)?;
    assert!((x[0] - 1.0).abs() < 1e-15 && (x[1] - 2.0).abs() < 1e-15);
    let singular = Matrix { pattern, values: &[1.0, 2.0, 1.0, 2.0] };
    assert_eq!(solver.factorise(singular).unwrap_err().cause, Cause::NoPivot);
    Ok(())
}

/// A solver that takes no unsymmetric matrices, as conjugate gradients of one's own.
#[derive(Default)]
struct Declining(DenseLu);

impl LinearSolver for Declining {
    fn analyse(&mut self, pattern: Pattern<'_>, hints: &Hints<'_>) -> Result<Analysis, OutOfMemory> {
        self.0.analyse(pattern, hints)
    }

    fn factorise(&mut self, matrix: Matrix<'_>) -> Result<Factored, Singular> {
        if !matrix.pattern.is_symmetric() {
            let cause = Cause::Unsuitable("it is not symmetric; conjugate gradients need ψ = φ");
            return Err(Singular { equation: 0, pivot: None, cause });
        }
        self.0.factorise(matrix)
    }

    fn solve(&mut self, matrix: Matrix<'_>, rhs: &mut [f64], tolerance: f64) -> Result<Solved, Singular> {
        self.0.solve(matrix, rhs, tolerance)
    }

    fn first_method(&self) -> Method {
        DENSE
    }
}

#[test]
fn a_solver_that_declines_a_kind_of_matrix_ends_the_run_at_once_with_its_sentence() -> Result<(), Box<dyn Error>>
{
    let scene = Scene::from_ron(include_str!("../../../scenes/laws/mohr_coulomb.ron"))?;
    for path in [false, true] {
        let Compiled::Plane(mut model) = compile(&scene)? else {
            return Err("the scene is one in plane strain".into());
        };
        if path {
            let measure = PathMeasure::ArcLength { most: None };
            model.stages[0].path = Some(PathControl { measure, first: 0.1, longest: 0.5, iterations: 5 });
        }
        model.solver = SolverChoice::custom(Declining::default);
        let failed = run(&mut model, &mut ()).unwrap_err().to_string();
        assert!(
            failed.contains("the linear solver does not take this system: it is not symmetric"),
            "{failed}"
        );
        assert!(failed.contains("halved 0 times") && !failed.contains("not held"), "{failed}");
    }
    Ok(())
}

#[test]
fn what_a_solver_does_not_tell_is_not_in_the_summary() -> Result<(), Box<dyn Error>> {
    let scene = Scene::from_ron(include_str!("../../../scenes/laws/mohr_coulomb.ron"))?;
    let Compiled::Plane(mut model) = compile(&scene)? else {
        return Err("the scene is one in plane strain".into());
    };
    model.solver = SolverChoice::custom(DenseLu::default);
    let summary = run(&mut model, &mut ())?;
    assert_eq!((summary.backward_error, summary.pivot_spread), (None, None));
    Ok(())
}

//! The dense solver against the direct one, on a scene and on matrices that are known.

use super::*;
use mpm_linear::Choice;

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

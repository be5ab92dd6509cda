//! Tangents against differences (of the law, and of a body in the plane and in space), symmetry, Newton's order.

use super::*;
use mpm_assembly::{MaterialBody, MeanDilatation, body_stiffness_error};
use mpm_basis::seed_cells;
use mpm_grid::{Axis, Layout, Mesh, Vector};
use mpm_material::derivative_error;

#[test]
fn the_tangent_is_the_derivative_of_the_stress() -> Result<(), Box<dyn Error>> {
    let history = PlasticShear(0.05);
    for (dilation, is_symmetric) in [(0.2, false), (0.8, true)] {
        let law = law(dilation)?;
        assert_eq!(law.has_symmetric_tangent(), is_symmetric);
        for trial in [Vector3::new(0.1, -0.16, 0.01), Vector3::new(0.004, 0.0, -0.005)] {
            let error = derivative_error(&law, &trial, &history)?;
            assert!(error.tangent < 1e-8 && error.secant < 1e-9, "{trial}: {error:?}");
            let plastic = law.update(&trial, &history)?.plastic;
            assert_eq!(error.asymmetry > 1e-12, plastic && !is_symmetric);
        }
    }
    let beyond = law(0.2)?.update(&Vector3::new(0.1, 0.1, 0.099), &history);
    assert!(beyond.is_err_and(|it| it.to_string().contains("apex")));
    Ok(())
}

/// Pressed along x, and sheared.
fn body_error<const D: usize>(mean: Option<MeanDilatation>) -> Result<f64, Box<dyn Error>> {
    let axis = Axis::uniform(0.0, 1.0, 2)?;
    let mesh = Mesh::at_rest(&Layout::<D>::on_axes(std::array::from_fn(|_| axis.clone()))?);
    let seeds = seed_cells(&Cpdi1, &mesh, mesh.cells(), 1);
    let body = MaterialBody::new(Cpdi1, law(0.2)?, seeds).with_mean_dilatation(mean);
    let pressed = |x: &Vector<D>| Vector::from_fn(|i, _| if i == 0 { 0.05 * x[1] - 0.1 * x[0] } else { 0.0 });
    Ok(body_stiffness_error(&body, &mesh, pressed)?)
}

#[test]
fn the_stiffness_matrix_is_the_derivative_of_the_force() -> Result<(), Box<dyn Error>> {
    for mean in [None, Some(MeanDilatation::Points), Some(MeanDilatation::Cell)] {
        for error in [body_error::<2>(mean)?, body_error::<3>(mean)?] {
            assert!(error < 1e-7, "{mean:?}: {error:e}");
        }
    }
    Ok(())
}

#[test]
fn the_square_yields_and_newton_is_quadratic() -> Result<(), Box<dyn Error>> {
    let (strain, residuals) = drive(-0.1, Region::Plane { axis: 1, at: 0.0 })?;
    assert!(strain > 0.05, "{strain}");
    let last = &residuals.0[residuals.0.len() - 1];
    let order = |k: usize| (last[k + 1] / last[k]).ln() / (last[k] / last[k - 1]).ln();
    // The last iterate may be rounding; the one before it is not.
    let k = last.len() - 3;
    assert!(order(k) > 1.8, "residuals {last:?}");
    Ok(())
}

#[test]
fn where_the_law_finds_no_stress_the_run_ends_and_says_so() {
    let failure = drive(0.3, Region::Everywhere).map(|_| ()).expect_err("pulled beyond the apex");
    let mut reasons = failure.to_string();
    let mut cause = failure.source();
    while let Some(it) = cause {
        reasons = format!("{reasons}: {it}");
        cause = it.source();
    }
    for part in ["`square`", "material point", "beyond the apex of the cone"] {
        assert!(reasons.contains(part), "{reasons}");
    }
}

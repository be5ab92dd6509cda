//! Tangents against differences (of the law, and of a body in the plane and in space), symmetry, Newton's order.

use super::*;
use mpm_assembly::{
    AssemblyPlan, Body, BodyConnectivity, Constraints, MaterialBody, MeanDilatation, PassInput,
    SparsityPattern, Sums, TangentSums,
};
use mpm_basis::{ActiveNodes, Basis, Connectivity};
use mpm_grid::{Axis, CellId, Layout, Mesh, NodeSpace, Vector};

#[test]
fn the_tangent_is_the_derivative_of_the_stress() -> Result<(), Box<dyn Error>> {
    let history = PlasticShear(0.05);
    for (dilation, is_symmetric) in [(0.2, false), (0.8, true)] {
        let law = law(dilation)?;
        assert_eq!(law.has_symmetric_tangent(), is_symmetric);
        for trial in [Vector3::new(0.1, -0.16, 0.01), Vector3::new(0.004, 0.0, -0.005)] {
            let update = law.update(&trial, &history)?;
            for b in 0..3 {
                let at = |by: f64| {
                    let mut strain = trial;
                    strain[b] += by;
                    law.update(&strain, &history).map(|it| it.kirchhoff)
                };
                let difference = (at(1e-6)? - at(-1e-6)?) / 2e-6;
                let error = (difference - update.tangent.column(b)).norm() / law.elasticity.p_wave();
                assert!(error < 1e-8, "{trial}, column {b}: {error:e}");
            }
            let skew = (update.tangent - update.tangent.transpose()).norm();
            assert_eq!(skew > 1e-12 * law.elasticity.p_wave(), update.plastic && !is_symmetric);
            let pair = (update.kirchhoff[1] - update.kirchhoff[2]) / (trial[1] - trial[2]);
            assert!((pair - update.secant[1]).abs() < 1e-9 * law.elasticity.p_wave());
        }
    }
    let beyond = law(0.2)?.update(&Vector3::new(0.1, 0.1, 0.099), &history);
    assert!(beyond.is_err_and(|it| it.to_string().contains("apex")));
    Ok(())
}

/// The stiffness matrix times a direction against differences of the force, over the largest entry.
fn body_error<const D: usize>(mean: Option<MeanDilatation>) -> Result<f64, Box<dyn Error>> {
    let axis = Axis::uniform(0.0, 1.0, 2)?;
    let mesh = Mesh::at_rest(&Layout::<D>::on_axes(std::array::from_fn(|_| axis.clone()))?);
    let mut seeds = Vec::new();
    for cell in (0..mesh.lattice().n_cells()).filter_map(CellId::from_index) {
        Cpdi1.seed(&mesh.linear_cell(mesh.lattice().cell_index(cell)), &mut |seed| seeds.push(seed));
    }
    let body = MaterialBody::new(Cpdi1, law(0.2)?, seeds).with_mean_dilatation(mean);
    let stencils = body.stencils(&mesh)?;
    let active = ActiveNodes::of(&NodeSpace::vertices(mesh.lattice().clone()), std::slice::from_ref(&stencils));
    let connectivity = Connectivity::of(stencils, &active);
    let linked = BodyConnectivity { dilatation: body.dilatation(&connectivity, &mesh, &active)?, connectivity };
    let pattern = SparsityPattern::of(active.len(), body.symmetry(), &[&linked]);
    let plan = AssemblyPlan::new(linked, &pattern);
    let constraints = Constraints::none(active.len());
    let direction: Vec<Vector<D>> =
        (0..active.len()).map(|v| Vector::from_fn(|i, _| (1.7 * v as f64 + 2.3 * i as f64).sin())).collect();
    let mut values = vec![0.0; pattern.n_entries()];
    let mut force = |by: f64| -> Result<Vec<Vector<D>>, Box<dyn Error>> {
        // Pressed along x, and sheared.
        let trial = |x: Vector<D>| Vector::from_fn(|i, _| if i == 0 { 0.05 * x[1] - 0.1 * x[0] } else { 0.0 });
        let nodes = active.nodes().iter().zip(&direction);
        let increment: Vec<_> = nodes.map(|(&node, d)| trial(mesh.position(node)) + d * by).collect();
        let mut internal = vec![Vector::zeros(); active.len()];
        values.fill(0.0);
        let tangent = Some(TangentSums { values: &mut values, lift: None });
        let input = PassInput { pattern: &pattern, constraints: &constraints, increment: &increment };
        body.assemble(&plan, input, Sums { internal: &mut internal, tangent })?;
        Ok(internal)
    };
    // The tangent that is kept is that of the last call.
    let (above, below, _) = (force(1e-6)?, force(-1e-6)?, force(0.0)?);
    let mut error: Vec<f64> = above
        .iter()
        .zip(&below)
        .flat_map(|(a, b)| ((a - b) / 2e-6).iter().copied().collect::<Vec<_>>())
        .collect();
    let scale = error.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    for column in 0..pattern.n_equations() {
        for at in pattern.column_start()[column]..pattern.column_start()[column + 1] {
            error[pattern.row()[at]] -= values[at] * direction[column / D][column % D];
        }
    }
    Ok(error.iter().fold(0.0, |m: f64, x| m.max(x.abs())) / scale)
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

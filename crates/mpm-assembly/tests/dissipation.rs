//! The energy that a trial displacement dissipates, and its gradient.

use mpm_assembly::{AssemblyPlan, Body, MaterialBody, SparsityPattern};
use mpm_basis::{ActiveNodes, Connectivity, Smpm, seed_cells};
use mpm_grid::{Axis, Layout, LoadFraction, MeshMotion, NodeSpace, Vector};
use mpm_material::{Elasticity, Material, MohrCoulomb, Undrained, VonMises};

const YIELD_RADIUS: f64 = 10.0;

/// Four points in four cells, on a square of two by two.
fn square<M: Material + 'static>(law: M) -> (impl Body<2>, AssemblyPlan<2>, Vec<Vector<2>>) {
    let axis = Axis::uniform(0.0, 2.0, 2).unwrap();
    let layout = Layout::on_axes([axis.clone(), axis]).unwrap();
    let mesh = MeshMotion::Fixed.mesh_at(&layout, LoadFraction::START).unwrap();
    let points = seed_cells(&Smpm, &mesh, mesh.cells(), 1);
    let body = MaterialBody::new(Smpm, law, points);
    let stencils = body.stencils(&mesh).unwrap();
    let active = ActiveNodes::of(&NodeSpace::vertices(mesh.lattice().clone()), std::slice::from_ref(&stencils));
    let connectivity = Connectivity::of(stencils, &active);
    let pattern = SparsityPattern::of(active.len(), body.symmetry(), &[&connectivity]);
    let positions = active.nodes().iter().map(|&node| mesh.position(node)).collect();
    (body, AssemblyPlan::new(connectivity, &pattern), positions)
}

fn von_mises() -> VonMises {
    VonMises::new(Elasticity::from_young_poisson(1000.0, 0.3).unwrap(), YIELD_RADIUS).unwrap()
}

#[test]
fn pure_stretch_dissipates_the_yield_radius_times_the_plastic_strain() {
    let (body, plan, positions) = square(von_mises());
    let stretch = 1.2_f64;
    let increment: Vec<_> = positions
        .iter()
        .map(|x| Vector::<2>::new((stretch - 1.0) * x[0], (1.0 / stretch - 1.0) * x[1]))
        .collect();
    let mut gradient = vec![Vector::zeros(); increment.len()];
    let energy = body.dissipation(&plan, (&increment, &[]), &mut gradient).unwrap();
    // ε = ± ln λ; |ε| = √2 ln λ, of which ρ_y / 2G is elastic.
    let shear = 1000.0 / 2.6;
    let plastic = 2.0_f64.sqrt() * stretch.ln() - YIELD_RADIUS / (2.0 * shear);
    assert!((energy - 4.0 * YIELD_RADIUS * plastic).abs() < 1e-10 * energy, "{energy}");
}

#[test]
fn the_gradient_is_the_derivative() {
    let (body, plan, positions) = square(von_mises());
    let mut increment: Vec<_> = positions
        .iter()
        .map(|x| Vector::<2>::new(0.2 * x[1] + 0.05 * x[0] * x[1], 0.1 * x[0] - 0.03 * x[1] * x[1]))
        .collect();
    let mut gradient = vec![Vector::zeros(); increment.len()];
    let mut unused = gradient.clone();
    let energy = body.dissipation(&plan, (&increment, &[]), &mut gradient).unwrap();
    assert!(energy > 0.0);
    let scale = gradient.iter().map(|g| g.norm()).fold(0.0, f64::max);
    let h = 1e-6;
    for v in 0..increment.len() {
        for i in 0..2 {
            let here = increment[v][i];
            increment[v][i] = here + h;
            let high = body.dissipation(&plan, (&increment, &[]), &mut unused).unwrap();
            increment[v][i] = here - h;
            let low = body.dissipation(&plan, (&increment, &[]), &mut unused).unwrap();
            increment[v][i] = here;
            let slope = (high - low) / (2.0 * h);
            assert!((slope - gradient[v][i]).abs() < 1e-6 * scale, "node {v}: {slope} {}", gradient[v][i]);
        }
    }
}

#[test]
fn below_yield_nothing_is_dissipated() {
    let (body, plan, positions) = square(von_mises());
    let increment: Vec<_> = positions.iter().map(|x| Vector::<2>::new(0.001 * x[0], 0.0)).collect();
    let mut gradient = vec![Vector::zeros(); increment.len()];
    assert_eq!(body.dissipation(&plan, (&increment, &[]), &mut gradient).unwrap(), 0.0);
    assert!(gradient.iter().all(|g| *g == Vector::<2>::zeros()));
}

/// Pore fluid stores all of its work, so that it dissipates nothing however much the skeleton dilates.
#[test]
fn pore_fluid_dissipates_nothing() {
    let elasticity = Elasticity::from_young_poisson(1000.0, 0.3).unwrap();
    let sand = MohrCoulomb::new(elasticity, 5.0, 30.0, 20.0).unwrap();
    let (dry, plan, positions) = square(sand);
    let (wet, ..) = square(Undrained::new(sand, 1e5).unwrap());
    let increment: Vec<_> =
        positions.iter().map(|x| Vector::<2>::new(-0.08 * x[0] + 0.05 * x[1], 0.06 * x[1])).collect();
    let energy = |body: &dyn Body<2>| {
        let mut gradient = vec![Vector::zeros(); increment.len()];
        body.dissipation(&plan, (&increment, &[]), &mut gradient).unwrap()
    };
    let (dry, wet) = (energy(&dry), energy(&wet));
    assert!(dry > 0.1 && (wet - dry).abs() < 1e-9 * dry, "{dry} {wet}");
}

//! A body on a grid, and its sums.

use mpm_assembly::{
    AssemblyPlan, Body, BodyConnectivity, Constraints, MaterialBody, MeanDilatation, PassInput,
    SparsityPattern, Sums, TangentSums, finish_tangent,
};
use mpm_basis::{ActiveNodes, Basis, Connectivity, seed_cells};
use mpm_grid::{Axis, Layout, Mesh, NodeSpace, Vector};
use mpm_linear::Symmetry;
use mpm_material::{Elasticity, Material, VonMises};

/// A body on a grid, ready to be summed.
pub struct Setup<const D: usize> {
    pub body: Box<dyn Body<D>>,
    pub active: ActiveNodes<D>,
    pub pattern: SparsityPattern<D>,
    pub plan: AssemblyPlan<D>,
    pub mesh: Mesh<D>,
}

/// Yields in a part of the points under [`field`] of size 0.02.
pub fn law() -> VonMises {
    VonMises::new(Elasticity::from_young_poisson(1e3, 0.3).unwrap(), 15.0).unwrap()
}

/// Fills all but the outer cells of a grid with 2^D points a cell; every `stride`-th point first, so
/// that neighbours are far apart in the list.
pub fn setup<const D: usize, B: Basis<D> + 'static, M: Material + 'static>(
    basis: B,
    law: M,
    cells: u32,
    stride: usize,
    mean: Option<MeanDilatation>,
) -> Setup<D> {
    let axes = std::array::from_fn(|d| Axis::geometric(0.0, 3.0, cells + d as u32, 1.5).unwrap());
    let layout = Layout::<D>::on_axes(axes).unwrap();
    let mesh = Mesh::at_rest(&layout);
    let extent = mesh.lattice().cells();
    let inner = mesh.cells().filter(|index| (0..D).all(|d| index[d] > 0 && index[d] + 1 < extent[d]));
    let seeds = seed_cells(&basis, &mesh, inner, 2);
    let points: Vec<_> =
        (0..stride).flat_map(|start| seeds.iter().skip(start).step_by(stride).cloned()).collect();
    connect(Box::new(MaterialBody::new(basis, law, points).with_mean_dilatation(mean)), mesh)
}

/// Connects a body to a mesh.
pub fn connect<const D: usize>(body: Box<dyn Body<D>>, mesh: Mesh<D>) -> Setup<D> {
    let symmetry = body.symmetry();
    connect_as(body, mesh, symmetry)
}

/// Connects a body to a mesh, in a pattern of a symmetry that may be worse than its own.
pub fn connect_as<const D: usize>(body: Box<dyn Body<D>>, mesh: Mesh<D>, symmetry: Symmetry) -> Setup<D> {
    let stencils = body.stencils(&mesh).unwrap();
    let active = ActiveNodes::of(&NodeSpace::vertices(mesh.lattice().clone()), std::slice::from_ref(&stencils));
    let connectivity = Connectivity::of(stencils, &active);
    let dilatation = body.dilatation(&connectivity, &mesh, &active).unwrap();
    let linked = BodyConnectivity { connectivity, dilatation };
    let pattern = SparsityPattern::of(active.len(), symmetry, &[&linked]);
    let plan = AssemblyPlan::new(linked, &pattern);
    Setup { body, active, pattern, plan, mesh }
}

/// A smooth displacement, large enough for a part of the points to yield.
pub fn field<const D: usize>(setup: &Setup<D>, size: f64) -> Vec<Vector<D>> {
    setup.active.nodes().iter().map(|&node| wave(size, &setup.mesh.position(node))).collect()
}

/// The displacement of [`field`] at a position.
pub fn wave<const D: usize>(size: f64, x: &Vector<D>) -> Vector<D> {
    Vector::from_fn(|i, _| size * (1.3 * x[i] + 0.7 * x[(i + 1) % D] + i as f64).sin())
}

/// Internal force, stored tangent and its product with the prescribed increments.
pub fn sum<const D: usize>(
    setup: &Setup<D>,
    increment: &[Vector<D>],
    constraints: &Constraints<D>,
) -> (Vec<Vector<D>>, Vec<f64>, Vec<Vector<D>>) {
    let mut internal = vec![Vector::zeros(); increment.len()];
    let mut lift = internal.clone();
    let mut values = vec![0.0; setup.pattern.n_entries()];
    let tangent = TangentSums { values: &mut values, lift: Some(&mut lift), own_lift: &mut [] };
    let input = PassInput { pattern: &setup.pattern, constraints, increment, own: &[] };
    let sums = Sums { internal: &mut internal, own: &mut [], tangent: Some(tangent) };
    setup.body.assemble(&setup.plan, input, sums).unwrap();
    finish_tangent(&setup.pattern, constraints, &mut values);
    (internal, values, lift)
}

pub fn times<const D: usize>(
    pattern: &SparsityPattern<D>,
    values: &[f64],
    direction: &[Vector<D>],
) -> Vec<f64> {
    let x: Vec<f64> = direction.iter().flat_map(|x| x.iter().copied()).collect();
    let mut product = vec![0.0; x.len()];
    for column in 0..pattern.n_equations() {
        let entries = pattern.column_start()[column]..pattern.column_start()[column + 1];
        for (&row, value) in pattern.row()[entries.clone()].iter().zip(&values[entries]) {
            product[row] += value * x[column];
            if pattern.symmetry() == Symmetry::Symmetric && row != column {
                product[column] += value * x[row];
            }
        }
    }
    product
}

pub fn flat<const D: usize>(field: &[Vector<D>]) -> Vec<f64> {
    field.iter().flat_map(|x| x.iter().copied()).collect()
}

pub fn apart(a: &[f64], b: &[f64]) -> f64 {
    let scale = a.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / scale
}

//! The sums over points against point-by-point scatter, finite differences and themselves on other
//! numbers of threads.

use mpm_assembly::{
    Body, Connection, Constraints, MaterialBody, PassInput, Pattern, Points, Sums, TangentSums, finish_tangent,
};
use mpm_basis::{ActiveNodes, Basis, Cpdi1, Gimp, Links, Smpm};
use mpm_grid::{Axis, Layout, Mesh, Vector};
use mpm_material::{Elasticity, VonMises};

/// A body on a grid, ready to be summed.
struct Setup<const D: usize> {
    body: Box<dyn Body<D>>,
    active: ActiveNodes<D>,
    pattern: Pattern<D>,
    connection: Connection<D>,
    mesh: Mesh<D>,
}

fn law() -> VonMises {
    VonMises::new(Elasticity::from_young_poisson(1e3, 0.3).unwrap(), 40.0).unwrap()
}

/// Fills all but the outer cells of a grid with 2^D points a cell; every `stride`-th point first, so
/// that neighbours are far apart in the list.
fn setup<const D: usize, B: Basis<D> + 'static>(basis: B, cells: u32, stride: usize) -> Setup<D> {
    let axes = std::array::from_fn(|d| Axis::geometric(0.0, 3.0, cells + d as u32, 1.5).unwrap());
    let layout = Layout::<D>::on_axes(axes).unwrap();
    let mesh = Mesh::at_rest(&layout);
    let mut seeds = Vec::new();
    let extent = mesh.lattice().cells();
    for cell in 0..mesh.lattice().n_cells() {
        let index = mesh.lattice().cell_index(mpm_grid::CellId::from_index(cell).unwrap());
        if (0..D).any(|d| index[d] == 0 || index[d] + 1 == extent[d]) {
            continue;
        }
        for piece in 0..1 << D {
            let low = Vector::<D>::from_fn(|d, _| if piece >> d & 1 == 1 { 0.0 } else { -1.0 });
            let high = low.add_scalar(1.0);
            basis.seed(&mesh.piece(index, &low, &high), &mut |seed| seeds.push(seed));
        }
    }
    let mut points = Points::<D, B, VonMises>::default();
    for start in 0..stride {
        seeds.iter().skip(start).step_by(stride).for_each(|seed| points.push(seed.clone()));
    }
    let body: Box<dyn Body<D>> = Box::new(MaterialBody::new(basis, law(), points));
    let stencils = body.stencils(&mesh).unwrap();
    let active = ActiveNodes::of(mesh.lattice(), std::slice::from_ref(&stencils));
    let links = [Links::of(stencils, &active)];
    let pattern = Pattern::of(active.len(), &links);
    let [links] = links;
    let connection = Connection::new(links, &pattern);
    Setup { body, active, pattern, connection, mesh }
}

/// A smooth displacement, large enough for a part of the points to yield.
fn field<const D: usize>(setup: &Setup<D>, size: f64) -> Vec<Vector<D>> {
    let wave =
        |x: Vector<D>| Vector::from_fn(|i, _| size * (1.3 * x[i] + 0.7 * x[(i + 1) % D] + i as f64).sin());
    setup.active.nodes().iter().map(|&node| wave(setup.mesh.position(node))).collect()
}

/// Internal force, tangent (lower triangle) and its product with the prescribed increments.
fn sum<const D: usize>(
    setup: &Setup<D>,
    increment: &[Vector<D>],
    constraints: &Constraints<D>,
) -> (Vec<Vector<D>>, Vec<f64>, Vec<Vector<D>>) {
    let mut internal = vec![Vector::zeros(); increment.len()];
    let mut lift = internal.clone();
    let mut values = vec![0.0; setup.pattern.n_entries()];
    let tangent = TangentSums { values: &mut values, lift: Some(&mut lift) };
    let input = PassInput { pattern: &setup.pattern, constraints, increment };
    let sums = Sums { internal: &mut internal, tangent: Some(tangent) };
    setup.body.assemble(&setup.connection, input, sums).unwrap();
    finish_tangent(&setup.pattern, constraints, &mut values);
    (internal, values, lift)
}

fn times<const D: usize>(pattern: &Pattern<D>, values: &[f64], direction: &[Vector<D>]) -> Vec<f64> {
    let x: Vec<f64> = direction.iter().flat_map(|x| x.iter().copied()).collect();
    let mut product = vec![0.0; x.len()];
    for column in 0..pattern.n_equations() {
        let entries = pattern.column_start()[column]..pattern.column_start()[column + 1];
        for (&row, value) in pattern.row()[entries.clone()].iter().zip(&values[entries]) {
            product[row] += value * x[column];
            if row != column {
                product[column] += value * x[row];
            }
        }
    }
    product
}

fn flat<const D: usize>(field: &[Vector<D>]) -> Vec<f64> {
    field.iter().flat_map(|x| x.iter().copied()).collect()
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    let scale = a.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / scale
}

fn tangent_is_the_derivative<const D: usize, B: Basis<D> + 'static>(basis: B, cells: u32) {
    let setup = setup(basis, cells, 3);
    let free = Constraints::none(setup.active.len());
    let (increment, direction) = (field(&setup, 0.02), field(&setup, 1.0));
    let (_, values, _) = sum(&setup, &increment, &free);
    let step = 1e-6;
    let moved = |by: f64| {
        let moved: Vec<Vector<D>> = increment.iter().zip(&direction).map(|(u, d)| u + d * by).collect();
        flat(&sum(&setup, &moved, &free).0)
    };
    let difference: Vec<f64> =
        moved(step).iter().zip(&moved(-step)).map(|(a, b)| (a - b) / (2.0 * step)).collect();
    assert!(apart(&times(&setup.pattern, &values, &direction), &difference) < 1e-6);
}

#[test]
fn the_tangent_is_the_derivative_of_the_internal_force() {
    tangent_is_the_derivative::<2, _>(Smpm, 7);
    tangent_is_the_derivative::<2, _>(Gimp::default(), 7);
    tangent_is_the_derivative::<2, _>(Cpdi1, 7);
    tangent_is_the_derivative::<3, _>(Smpm, 5);
    tangent_is_the_derivative::<3, _>(Cpdi1, 5);
}

#[test]
fn the_order_of_points_changes_sums_by_rounding_only() {
    for stride in [2, 7] {
        let (sorted, shuffled) =
            (setup::<2, _>(Gimp::default(), 40, 1), setup::<2, _>(Gimp::default(), 40, stride));
        let free = Constraints::none(sorted.active.len());
        let increment = field(&sorted, 0.02);
        let (force, tangent, _) = sum(&sorted, &increment, &free);
        let (other_force, other_tangent, _) = sum(&shuffled, &increment, &free);
        assert!(apart(&flat(&force), &flat(&other_force)) < 1e-13);
        assert!(apart(&tangent, &other_tangent) < 1e-13);
    }
}

#[test]
fn prescribed_components_stand_alone_and_their_columns_are_lifted() {
    let setup = setup::<2, _>(Gimp::default(), 8, 1);
    let n = setup.active.len();
    let increment = field(&setup, 0.02);
    let (force, full, _) = sum(&setup, &increment, &Constraints::none(n));
    let mut constraints = Constraints::none(n);
    let mut prescribed = vec![Vector::<2>::zeros(); n];
    for (node, component, by) in [(0, 0, 0.1), (5, 1, -0.2), (5, 0, 0.0), (n - 1, 1, 0.05)] {
        constraints.prescribe(node, component, by);
        prescribed[node][component] = by;
    }
    let (constrained_force, values, lift) = sum(&setup, &increment, &constraints);
    assert_eq!(force, constrained_force);
    assert!(apart(&times(&setup.pattern, &full, &prescribed), &flat(&lift)) < 1e-14);
    for column in 0..2 * n {
        let is_prescribed = |equation: usize| constraints.is_prescribed(equation / 2, equation % 2);
        for entry in setup.pattern.column_start()[column]..setup.pattern.column_start()[column + 1] {
            let row = setup.pattern.row()[entry];
            if row != column && (is_prescribed(row) || is_prescribed(column)) {
                assert_eq!(values[entry], 0.0);
            } else if row == column {
                assert!(!is_prescribed(row) || values[entry] > 0.0);
            } else {
                assert_eq!(values[entry], full[entry]);
            }
        }
    }
}

#[test]
fn bits_do_not_depend_on_the_number_of_threads() {
    // Some dozen strips, and a list of points in an order that makes them overlap.
    for stride in [1, 5] {
        let setup = setup::<2, _>(Gimp::default(), 150, stride);
        let free = Constraints::none(setup.active.len());
        let increment = field(&setup, 0.02);
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| sum(&setup, &increment, &free))
        };
        let one = on(1);
        for threads in [2, 3, 8] {
            assert!(on(threads) == one, "{threads} threads");
        }
    }
}

#[test]
fn an_inverting_trial_names_its_first_point() {
    let setup = setup::<2, _>(Smpm, 6, 1);
    let inwards: Vec<Vector<2>> =
        setup.active.nodes().iter().map(|&node| setup.mesh.position(node) * -1.5).collect();
    let mut internal = vec![Vector::zeros(); inwards.len()];
    let constraints = Constraints::none(inwards.len());
    let input = PassInput { pattern: &setup.pattern, constraints: &constraints, increment: &inwards };
    let sums = Sums { internal: &mut internal, tangent: None };
    // ΔF = -½ I is a proper rotation and shrink in the plane: its determinant is positive.
    assert!(setup.body.assemble(&setup.connection, input, sums).is_ok());
    let mirrored: Vec<Vector<2>> = inwards.iter().map(|u| Vector::<2>::new(u.x, 0.0)).collect();
    let input = PassInput { increment: &mirrored, ..input };
    let sums = Sums { internal: &mut internal, tangent: None };
    let error = setup.body.assemble(&setup.connection, input, sums).unwrap_err();
    assert_eq!(error.point, 0);
    assert!((error.determinant + 0.5).abs() < 1e-14);
}

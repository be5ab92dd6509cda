//! The sums over points against point-by-point scatter, finite differences and themselves on other
//! numbers of threads.

mod setup;

use mpm_assembly::{
    AdvanceError, Body, BodyLoads, Constraints, Converged, InadmissibleState, MaterialBody, PassInput, Sums,
    body_stiffness_error,
};
use mpm_basis::{ActiveNodes, Basis, Connectivity, Cpdi1, Gimp, Smpm, seed_cells};
use mpm_grid::{Axis, Layout, Mesh, NodeSpace, Vector};
use mpm_material::{Elasticity, Hencky};
use setup::{Setup, apart, field, flat, law, sum, times, wave};

fn setup<const D: usize, B: Basis<D> + 'static>(basis: B, cells: u32, stride: usize) -> Setup<D> {
    setup::setup(basis, law(), cells, stride, None)
}

fn tangent_is_the_derivative<const D: usize, B: Basis<D> + 'static>(basis: B, cells: u32) {
    let setup = setup(basis, cells, 3);
    let error = body_stiffness_error(&*setup.body, &setup.mesh, |x| wave(0.02, x)).unwrap();
    assert!(error < 1e-6, "D = {D}: {error:e}");
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
    let input = PassInput { pattern: &setup.pattern, constraints: &constraints, increment: &inwards, own: &[] };
    let sums = Sums { internal: &mut internal, own: &mut [], tangent: None };
    // ΔF = -½ I is a proper rotation and shrink in the plane: its determinant is positive.
    assert!(setup.body.assemble(&setup.plan, input, sums).is_ok());
    let mirrored: Vec<Vector<2>> = inwards.iter().map(|u| Vector::<2>::new(u.x, 0.0)).collect();
    let input = PassInput { increment: &mirrored, ..input };
    let sums = Sums { internal: &mut internal, own: &mut [], tangent: None };
    let error = setup.body.assemble(&setup.plan, input, sums).unwrap_err();
    assert_eq!(error.point, 0);
    assert!(
        matches!(error.reason, InadmissibleState::Inverted { determinant } if (determinant + 0.5).abs() < 1e-14)
    );
}

#[test]
fn a_displacement_longer_than_the_mesh_is_not_carried_out() {
    let mut setup = setup::<2, _>(Smpm, 5, 3);
    let reach = 3.0 * 2.0_f64.sqrt();
    for (length, is_carried) in [(0.99 * reach, true), (1.01 * reach, false), (737.3, false)] {
        let increment = vec![Vector::<2>::new(0.6, -0.8) * length; setup.active.len()];
        let step = Converged { mesh: &setup.mesh, active: &setup.active, increment: &increment, own: &[] };
        match setup.body.prepare(&setup.plan, step) {
            Ok(()) => assert!(is_carried, "{length}"),
            Err(AdvanceError::TooFar { point: 0, distance, reach: most, .. }) => {
                assert!(!is_carried && (distance - length).abs() < 1e-9 && (most - reach).abs() < 1e-12);
            }
            Err(other) => panic!("{other}"),
        }
    }
}

/// A body large enough to be summed in parts: its weight on every node is that of its points one after the other, up to rounding.
#[test]
fn parts_of_a_body_add_up_to_its_weight() {
    let axis = || Axis::uniform(0.0, 72.0, 72).unwrap();
    let mesh = Mesh::at_rest(&Layout::on_axes([axis(), axis()]).unwrap());
    let points = seed_cells(&Smpm, &mesh, mesh.cells(), 2);
    let law = Hencky(Elasticity::from_young_poisson(1000.0, 0.3).unwrap());
    let body = MaterialBody::new(Smpm, law, points).with_density(3.0);
    let stencils = body.stencils(&mesh).unwrap();
    let active = ActiveNodes::of(&NodeSpace::vertices(mesh.lattice().clone()), std::slice::from_ref(&stencils));
    let connectivity = Connectivity::of(stencils, &active);
    let acceleration = Vector::<2>::new(0.3, -9.81);
    let loads = BodyLoads { acceleration: Some(acceleration), ..BodyLoads::default() };
    // What other bodies have added stays.
    let mut found = vec![Vector::<2>::new(1.0, 2.0); active.len()];
    body.external_force(&connectivity, &loads, &mut found);
    let mut expected = vec![Vector::<2>::new(1.0, 2.0); active.len()];
    for group in (0..connectivity.n_groups()).map(|group| connectivity.group(group)) {
        for k in 0..group.points {
            for (&node, value) in group.nodes.iter().zip(group.point(k).0) {
                expected[node as usize] += acceleration * (3.0 * 0.25 * value);
            }
        }
    }
    assert!(body.n_points() > 2 * 8192);
    assert!(found.iter().zip(&expected).all(|(a, b)| (a - b).norm() < 1e-13 * b.norm()));
}

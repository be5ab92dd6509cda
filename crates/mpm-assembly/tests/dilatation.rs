//! Mean dilatation: force and tangent, what it must leave alone, and what points remember.

mod setup;

use mpm_assembly::{
    AssemblyPlan, BodyConnectivity, Constraints, Converged, GhostFaces, InadmissibleState, MeanDilatation,
    PassInput, SparsityPattern, Sums, TangentSums, body_stiffness_error, views,
};
use mpm_basis::{ActiveNodes, Basis, Connectivity, Cpdi1, Cpdi2Hexahedron, Cpdi2q, Cpdi2t, Gimp, Smpm};
use mpm_grid::{Block, NodeSpace, Vector};
use mpm_material::{Elasticity, MohrCoulomb, Undrained, VonMises};
use setup::{Setup, apart, connect, field, flat, law, sum, times, wave};

const MEANS: [MeanDilatation; 2] = [MeanDilatation::Points, MeanDilatation::Cell];

/// Never yields.
fn elastic() -> VonMises {
    VonMises::new(Elasticity::from_young_poisson(1e3, 0.45).unwrap(), 1e9).unwrap()
}

/// Carries the points through an increment and connects them again.
fn advanced<const D: usize>(mut setup: Setup<D>, increment: &[Vector<D>]) -> Setup<D> {
    let step = Converged { mesh: &setup.mesh, active: &setup.active, increment, own: &[] };
    setup.body.prepare(&setup.plan, step).unwrap();
    setup.body.commit();
    connect(setup.body, setup.mesh)
}

fn free<const D: usize>(setup: &Setup<D>) -> Constraints<D> {
    Constraints::none(setup.active.len())
}

fn tangent_is_the_derivative<const D: usize, B: Basis<D> + Clone + 'static>(basis: B, cells: u32) {
    for (mean, law) in MEANS.iter().flat_map(|mean| [(*mean, law()), (*mean, elastic())]) {
        // From points that are strained, some of them plastically, and stand nowhere in particular.
        let rest = setup::setup(basis.clone(), law, cells, 3, Some(mean));
        let before = field(&rest, 0.03);
        let setup = advanced(rest, &before);
        let plastic = views(&*setup.body).filter(|point| point.plastic).count();
        assert_eq!(plastic > 0, law.yield_radius() < 1e3);
        assert!(plastic < setup.body.n_points(), "{plastic}");

        let error = body_stiffness_error(&*setup.body, &setup.mesh, |x| wave(-0.02, x)).unwrap();
        println!("{} in {D} dimensions, {mean:?}: {error:e}", basis.name());
        assert!(error < 1e-6, "{} in {D} dimensions, {mean:?}: {error:e}", basis.name());
    }
}

#[test]
fn the_tangent_is_symmetric_and_the_derivative_of_the_internal_force() {
    tangent_is_the_derivative::<2, _>(Smpm, 7);
    tangent_is_the_derivative::<2, _>(Gimp::default(), 7);
    tangent_is_the_derivative::<2, _>(Cpdi1, 7);
    tangent_is_the_derivative::<2, _>(Cpdi2q::default(), 7);
    tangent_is_the_derivative::<2, _>(Cpdi2t::default(), 7);
    tangent_is_the_derivative::<3, _>(Smpm, 5);
    tangent_is_the_derivative::<3, _>(Gimp::default(), 5);
    tangent_is_the_derivative::<3, _>(Cpdi1, 5);
    tangent_is_the_derivative::<3, _>(Cpdi2Hexahedron, 5);
}

/// `(A - I) x` at the nodes.
fn affine<const D: usize>(setup: &Setup<D>, a: &Block<D>) -> Vec<Vector<D>> {
    setup.active.nodes().iter().map(|&node| (a - Block::identity()) * setup.mesh.position(node)).collect()
}

fn homogeneous<const D: usize, B: Basis<D> + Clone + 'static>(basis: B, cells: u32) {
    let a = Block::<D>::from_fn(|i, j| f64::from(u8::from(i == j)) + 0.03 * (i as f64 - 1.4 * j as f64 + 0.5));
    let plain = setup::setup(basis.clone(), law(), cells, 3, None);
    let increment = affine(&plain, &a);
    let (force, _, _) = sum(&plain, &increment, &free(&plain));
    let plain = advanced(plain, &increment);
    for mean in MEANS {
        let averaged = setup::setup(basis.clone(), law(), cells, 3, Some(mean));
        let (same, _, _) = sum(&averaged, &increment, &free(&averaged));
        assert!(apart(&flat(&force), &flat(&same)) < 1e-12, "{} {mean:?}", basis.name());
        let averaged = advanced(averaged, &increment);
        for (a, b) in views(&*plain.body).zip(views(&*averaged.body)) {
            assert!((a.deformation_gradient - b.deformation_gradient).norm() < 1e-13);
            assert!((a.elastic_excess.to_matrix() - b.elastic_excess.to_matrix()).norm() < 1e-13);
            assert!((a.position - b.position).norm() < 1e-13);
        }
    }
}

#[test]
fn homogeneous_deformation_stays_as_it_is() {
    homogeneous::<2, _>(Smpm, 7);
    homogeneous::<2, _>(Gimp::default(), 7);
    homogeneous::<2, _>(Cpdi1, 7);
    homogeneous::<3, _>(Smpm, 5);
    homogeneous::<3, _>(Cpdi1, 5);
}

#[test]
fn a_rotation_turns_the_forces_of_a_stressed_body() {
    let (sin, cos) = 2.3_f64.sin_cos();
    let q = Block::<2>::new(cos, -sin, sin, cos);
    for mean in MEANS {
        let rest = setup::setup(Cpdi1, law(), 7, 1, Some(mean));
        let before = field(&rest, 0.03);
        let setup = advanced(rest, &before);
        let (force, _, _) = sum(&setup, &vec![Vector::zeros(); setup.active.len()], &free(&setup));
        let (turned, _, _) = sum(&setup, &affine(&setup, &q), &free(&setup));
        let expected: Vec<Vector<2>> = force.iter().map(|force| q * force).collect();
        assert!(apart(&flat(&expected), &flat(&turned)) < 1e-12, "{mean:?}");
    }
}

#[test]
fn points_of_a_cell_share_its_volume_change() {
    // One cell of material in the middle of 3 × 4, so that nodes and corners are the same.
    for mean in MEANS {
        let setup = setup::setup::<2, _, _>(Smpm, elastic(), 3, 1, Some(mean));
        let increment = field(&setup, 0.1);
        let cells = setup.plan.dilatation().unwrap().cells();
        assert_eq!(cells.len(), 2);
        let volume = |moved: bool| {
            let at = |k: usize| {
                let node = cells.nodes(0)[k] as usize;
                let x = setup.mesh.position(setup.active.nodes()[node]);
                if moved { x + increment[node] } else { x }
            };
            let (a, b) = (at(3) - at(0), at(2) - at(1));
            0.5 * (a[0] * b[1] - a[1] * b[0])
        };
        let ratio = volume(true) / volume(false);
        let plain = advanced(setup::setup::<2, _, _>(Smpm, elastic(), 3, 1, None), &increment);
        let own: Vec<_> = views(&*plain.body).collect();
        let expected = match mean {
            MeanDilatation::Cell => ratio,
            MeanDilatation::Points => {
                let (mut sum, mut volume) = (0.0, 0.0);
                for point in &own[..4] {
                    sum += point.reference_volume * point.volume_ratio;
                    volume += point.reference_volume;
                }
                sum / volume
            }
        };
        let setup = advanced(setup, &increment);
        for (point, own) in views(&*setup.body).zip(&own).take(4) {
            assert!((point.volume_ratio - expected).abs() < 1e-14, "{mean:?}");
            assert!((own.volume_ratio - expected).abs() > 1e-3);
            assert_eq!(point.position, own.position);
            // Plane strain: the elastic state is that of an in-plane F.
            assert_eq!(point.elastic_excess.zz, 0.0);
            let b = point.deformation_gradient * point.deformation_gradient.transpose();
            assert!((point.elastic_excess.xx + 1.0 - b[(0, 0)]).abs() < 1e-14);
        }
    }
}

#[test]
fn the_order_of_points_changes_sums_by_rounding_only() {
    for mean in MEANS {
        let by = |stride| setup::setup::<2, _, _>(Gimp::default(), law(), 40, stride, Some(mean));
        let (sorted, shuffled) = (by(1), by(7));
        let increment = field(&sorted, 0.02);
        let (force, tangent, _) = sum(&sorted, &increment, &free(&sorted));
        let (other_force, other_tangent, _) = sum(&shuffled, &increment, &free(&shuffled));
        assert!(apart(&flat(&force), &flat(&other_force)) < 1e-13);
        assert!(apart(&tangent, &other_tangent) < 1e-13);
    }
}

#[test]
fn bits_do_not_depend_on_the_number_of_threads() {
    for mean in MEANS {
        let setup = setup::setup::<2, _, _>(Cpdi1, law(), 100, 5, Some(mean));
        let increment = field(&setup, 0.02);
        let mut gradient = vec![Vector::<2>::zeros(); setup.active.len()];
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| sum(&setup, &increment, &free(&setup)))
        };
        let one = on(1);
        for threads in [2, 3, 8] {
            assert!(on(threads) == one, "{threads} threads");
        }
        assert!(setup.body.dissipation(&setup.plan, (&increment, &[]), &mut gradient).unwrap() > 0.0);
    }
}

#[test]
fn the_gradient_of_the_dissipation_is_its_derivative() {
    for mean in MEANS {
        // Without elastic compressibility out of the plane the gradient is exact in space only.
        let rest = setup::setup::<3, _, _>(Smpm, law(), 4, 1, Some(mean));
        let before = field(&rest, 0.03);
        let setup = advanced(rest, &before);
        let (increment, direction) = (field(&setup, 0.05), field(&setup, 1.0));
        let energy = |by: f64| {
            let moved: Vec<Vector<3>> = increment.iter().zip(&direction).map(|(u, d)| u + d * by).collect();
            let mut gradient = vec![Vector::zeros(); increment.len()];
            let energy = setup.body.dissipation(&setup.plan, (&moved, &[]), &mut gradient).unwrap();
            (energy, gradient)
        };
        let gradient = energy(0.0).1;
        let slope: f64 = gradient.iter().zip(&direction).map(|(g, d)| g.dot(d)).sum();
        let difference = (energy(1e-6).0 - energy(-1e-6).0) / 2e-6;
        assert!((slope / difference - 1.0).abs() < 1e-6, "{slope} {difference}");
    }
}

/// Pore fluid stores all of its work.
#[test]
fn pore_fluid_dissipates_nothing() {
    let elasticity = Elasticity::from_young_poisson(1000.0, 0.3).unwrap();
    let sand = MohrCoulomb::new(elasticity, 1.0, 30.0, 20.0).unwrap();
    for mean in MEANS {
        let dry = setup::setup::<2, _, _>(Smpm, sand, 6, 1, Some(mean));
        let wet = setup::setup::<2, _, _>(Smpm, Undrained::new(sand, 1e5).unwrap(), 6, 1, Some(mean));
        let increment = field(&dry, 0.03);
        let energy = |setup: &Setup<2>| {
            let mut gradient = vec![Vector::zeros(); increment.len()];
            setup.body.dissipation(&setup.plan, (&increment, &[]), &mut gradient).unwrap()
        };
        let (dry, wet) = (energy(&dry), energy(&wet));
        assert!(dry > 0.0 && (wet - dry).abs() < 1e-9 * dry, "{dry} {wet}");
    }
}

#[test]
fn an_inverting_trial_names_a_point() {
    for mean in MEANS {
        let mut setup = setup::setup::<2, _, _>(Smpm, law(), 6, 1, Some(mean));
        let mirrored: Vec<Vector<2>> = setup
            .active
            .nodes()
            .iter()
            .map(|&node| Vector::<2>::new(-1.5 * setup.mesh.position(node).x, 0.0))
            .collect();
        let mut gradient = vec![Vector::zeros(); mirrored.len()];
        let error = setup.body.dissipation(&setup.plan, (&mirrored, &[]), &mut gradient).unwrap_err();
        assert_eq!(error.point, 0);
        assert!(
            matches!(error.reason, InadmissibleState::Inverted { determinant } if (determinant + 0.5).abs() < 1e-14)
        );
        let step = Converged { mesh: &setup.mesh, active: &setup.active, increment: &mirrored, own: &[] };
        assert!(setup.body.prepare(&setup.plan, step).is_err());
    }
}

/// Body and faces of its edge in one pattern, as a load step sums them.
fn goes_with_ghost_stabilisation<B: Basis<2> + Clone + 'static>(basis: B) {
    for mean in MEANS {
        let rest = setup::setup(basis.clone(), law(), 7, 3, Some(mean));
        let before = field(&rest, 0.03);
        let Setup { body, mesh, .. } = advanced(rest, &before);
        let stencils = body.stencils(&mesh).unwrap();
        let active =
            ActiveNodes::of(&NodeSpace::vertices(mesh.lattice().clone()), std::slice::from_ref(&stencils));
        let connectivity = Connectivity::of(stencils, &active);
        let mut cells = Vec::new();
        body.occupied_cells(&connectivity, &mesh, &active, &mut cells).unwrap();
        let faces = GhostFaces::of(&mesh, &active, cells, (1.0 / 30.0, body.space()));
        let dilatation = body.dilatation(&connectivity, &mesh, &active).unwrap();
        let linked = BodyConnectivity { connectivity, dilatation };
        let pattern = SparsityPattern::of(active.len(), body.symmetry(), &[&linked, &faces]);
        let (plan, slots) = (AssemblyPlan::new(linked, &pattern), faces.slots(&pattern));
        let setup = Setup { body, active, pattern, plan, mesh };
        let constraints = free(&setup);
        let both = |increment: &[Vector<2>]| {
            let (mut force, mut values, _) = sum(&setup, increment, &constraints);
            let body_alone = flat(&force);
            let tangent = Some(TangentSums { values: &mut values, lift: None, own_lift: &mut [] });
            let input = PassInput { pattern: &setup.pattern, constraints: &constraints, increment, own: &[] };
            faces.assemble(&slots, input, Sums { internal: &mut force, own: &mut [], tangent });
            (flat(&force), values, body_alone)
        };
        let (increment, direction) = (field(&setup, -0.02), field(&setup, 1.0));
        let (force, values, body_alone) = both(&increment);
        assert!(apart(&force, &body_alone) > 1e-6, "the faces resist nothing");
        let step = 1e-6;
        let moved = |by: f64| {
            let moved: Vec<Vector<2>> = increment.iter().zip(&direction).map(|(u, d)| u + d * by).collect();
            both(&moved).0
        };
        let difference: Vec<f64> =
            moved(step).iter().zip(&moved(-step)).map(|(a, b)| (a - b) / (2.0 * step)).collect();
        let error = apart(&times(&setup.pattern, &values, &direction), &difference);
        assert!(error < 1e-6, "{} {mean:?}: {error:e}", basis.name());
    }
}

#[test]
fn the_tangent_with_ghost_stabilisation_is_the_derivative_too() {
    goes_with_ghost_stabilisation(Smpm);
    goes_with_ghost_stabilisation(Gimp::default());
    goes_with_ghost_stabilisation(Cpdi1);
    goes_with_ghost_stabilisation(Cpdi2q::default());
}

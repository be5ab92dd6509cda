//! Bodies of revolution that turn about their axis: torsion against a table, rigid turns, tangents, and what they have in
//! common with bodies that do not turn.

#[allow(dead_code)] // this binary uses its part
mod setup;

use mpm_assembly::{
    Body, BodyLoads, Constraints, Converged, InadmissibleState, MaterialBody, MeanDilatation, PassInput, Sums,
    body_stiffness_error, views,
};
use mpm_basis::{Basis, Cpdi1, Cpdi2q, Cpdi2t, DomainControl, Gimp, Smpm, seed_cells};
use mpm_grid::{Axis, Layout, Mesh, Vector, raised};
use mpm_material::{Elasticity, Hencky, Material, MohrCoulomb, VonMises};
use setup::{Setup, apart, connect, flat, law, wave};

const MEANS: [Option<MeanDilatation>; 2] = [None, Some(MeanDilatation::Points)];

fn elasticity() -> Elasticity {
    Elasticity::from_young_poisson(1e3, 0.3).unwrap()
}

/// A mesh of the half plane, and its layer.
fn meshes(r: (f64, f64, u32), z: (f64, f64, u32)) -> (Mesh<2>, Mesh<3>) {
    let axis = |(from, to, cells)| Axis::uniform(from, to, cells).unwrap();
    let layout = Layout::<2>::on_axes([axis(r), axis(z)]).unwrap();
    (Mesh::at_rest(&layout), Mesh::at_rest(&layout.as_layer().unwrap()))
}

/// A body of revolution in some cells of a mesh.
fn ring<B: Basis<2> + 'static, M: Material + 'static>(
    (basis, law): (B, M),
    mesh: &Mesh<2>,
    cells: impl Fn([u32; 2]) -> bool,
    mean: Option<MeanDilatation>,
) -> MaterialBody<2> {
    let seeds = seed_cells(&basis, mesh, mesh.cells().filter(|index| cells(*index)), 2);
    MaterialBody::axisymmetric(basis, law, seeds).with_mean_dilatation(mean)
}

fn boxed<const D: usize>(body: MaterialBody<D>) -> Box<dyn Body<D>> {
    Box::new(body)
}

fn force<const D: usize>(setup: &Setup<D>, increment: &[Vector<D>]) -> Vec<Vector<D>> {
    let mut internal = vec![Vector::zeros(); increment.len()];
    let constraints = Constraints::none(setup.active.len());
    let input = PassInput { pattern: &setup.pattern, constraints: &constraints, increment, own: &[] };
    setup
        .body
        .assemble(&setup.plan, input, Sums { internal: &mut internal, own: &mut [], tangent: None })
        .unwrap();
    internal
}

fn advanced<const D: usize>(mut setup: Setup<D>, increment: &[Vector<D>]) -> Setup<D> {
    let step = Converged { mesh: &setup.mesh, active: &setup.active, increment, own: &[] };
    setup.body.prepare(&setup.plan, step).unwrap();
    setup.body.commit();
    connect(setup.body, setup.mesh)
}

/// A displacement of every active node by its position.
fn field<const D: usize>(setup: &Setup<D>, of: impl Fn(&Vector<D>) -> Vector<D>) -> Vec<Vector<D>> {
    setup.active.nodes().iter().map(|&node| of(&setup.mesh.position(node))).collect()
}

/// Torque and axial force at the end of a cylinder that is turned by 0.4 in `steps` steps.
fn torsion<B: Basis<2> + 'static>(basis: B, cells: u32, steps: u32, mean: Option<MeanDilatation>) -> [f64; 2] {
    let (section, layer) = meshes((0.0, 1.0, cells), (0.0, 1.0, cells));
    let mut setup =
        connect(boxed(ring((basis, Hencky(elasticity())), &section, |_| true, mean).with_twist()), layer);
    let turn = 0.4 / f64::from(steps);
    let twisted = |x: &Vector<3>| Vector::<3>::new(0.0, 0.0, turn * x[1]);
    for _ in 1..steps {
        let increment = field(&setup, twisted);
        setup = advanced(setup, &increment);
    }
    let forces = force(&setup, &field(&setup, twisted));
    let mut end = Vector::<3>::zeros();
    for (&node, force) in setup.active.nodes().iter().zip(&forces) {
        let x = setup.mesh.position(node);
        if x[1] > 1.0 - 1e-9 {
            end += force;
        } else if x[1] > 1e-9 {
            // Along z every section is in the same state.
            assert!(force[1].abs() + force[2].abs() < 1e-11 * 237.0, "{x}: {force}");
        }
    }
    [end[2], end[1]]
}

#[test]
fn the_torque_of_a_cylinder_is_that_of_the_table() {
    const EXACT: f64 = 237.465140095449;
    let of = |basis: &str, cells, steps| match basis {
        "smpm" => torsion(Smpm, cells, steps, None),
        "gimp" => torsion(Gimp::default(), cells, steps, None),
        "cpdi1" => torsion(Cpdi1, cells, steps, None),
        _ => torsion(Cpdi2q::default(), cells, steps, None),
    };
    let mut rows = 0;
    for line in include_str!("tables/torsion.csv").lines().skip(2).filter(|line| !line.starts_with("exact")) {
        let columns: Vec<&str> = line.split(',').collect();
        let number = |k: usize| columns[k].parse::<f64>().unwrap();
        for steps in [1, 4] {
            let [torque, axial] = of(columns[0], columns[1].parse().unwrap(), steps);
            assert!((torque / number(3) - 1.0).abs() < 1e-11, "{line}: {torque}");
            assert!((axial / number(4) - 1.0).abs() < 1e-11, "{line}: {axial}");
        }
        rows += 1;
    }
    assert_eq!(rows, 8);
    // Second order; triangles are more points.
    let of_squares = [4, 8, 16].map(|cells| 1.0 - torsion(Cpdi1, cells, 1, None)[0] / EXACT);
    for (error, expected) in of_squares.iter().zip([7.6e-3, 1.9e-3, 4.8e-4]) {
        assert!((error / expected - 1.0).abs() < 0.02, "{of_squares:?}");
    }
    let errors = [4, 8, 16].map(|cells| 1.0 - torsion(Cpdi2t::default(), cells, 1, None)[0] / EXACT);
    assert!(errors[0] / errors[1] > 3.8 && errors[1] / errors[2] > 3.8, "{errors:?}");
    // Torsion keeps volumes, so that their mean changes nothing of first order.
    let mean = torsion(Cpdi1, 8, 1, MEANS[1])[0];
    assert!((mean / EXACT - 1.0).abs() < 3e-3, "{mean}");
}

#[test]
fn a_rigid_turn_of_any_size_changes_nothing() {
    for mean in MEANS {
        let (section, layer) = meshes((0.0, 2.0, 6), (0.0, 2.0, 5));
        let body = ring((Cpdi2q::default(), law()), &section, |index| index[0] < 4 && index[1] > 0, mean);
        let strained = connect(boxed(body.with_twist()), layer);
        let increment = field(&strained, |x| wave(0.02, x) * x[0]);
        let setup = advanced(strained, &increment);
        let before: Vec<_> = views(&*setup.body).collect();
        let n = setup.active.len();
        let forces = force(&setup, &vec![Vector::zeros(); n]);
        let turn = vec![Vector::<3>::new(0.0, 0.0, 100.0); n];
        // Rounding of the angle's gradient is a strain of some 1e-13, and the yield strain is 0.02.
        assert!(apart(&flat(&forces), &flat(&force(&setup, &turn))) < 1e-10);
        let after = advanced(setup, &turn);
        for (now, then) in views(&*after.body).zip(&before) {
            let change = now.elastic_excess.to_matrix() - then.elastic_excess.to_matrix();
            assert!(change.norm() < 3e-13, "{change}");
            assert!((now.deformation_gradient - then.deformation_gradient).norm() < 3e-13);
            assert!((now.angle.unwrap() - then.angle.unwrap() - 100.0).abs() < 1e-12);
            assert!((now.position - then.position).norm() < 1e-15);
        }
    }
}

fn tangent_is_the_derivative<B: Basis<2> + Clone + 'static>(basis: B) {
    let (section, layer) = meshes((0.0, 2.0, 6), (0.0, 2.0, 5));
    let cells = |index: [u32; 2]| index[0] < 4 && (1..4).contains(&index[1]);
    for mean in MEANS {
        let check = |body: MaterialBody<2>| {
            // From points that are strained and twisted, and stand nowhere in particular.
            let rest = connect(boxed(body.with_twist()), layer.clone());
            let onto = |x: &Vector<3>| Vector::<3>::new(0.05 * x[0], 0.0, 0.2) + wave(0.02, x) * x[0];
            let before = field(&rest, onto);
            let setup = advanced(rest, &before);
            let error = body_stiffness_error(&*setup.body, &layer, |x| wave(-0.01, x) * x[0]).unwrap();
            let symmetry = setup.body.symmetry();
            println!("{} {mean:?} {symmetry:?}: {error:e}", basis.name());
            assert!(error < 2e-6, "{} {mean:?} {symmetry:?}: {error:e}", basis.name());
            views(&*setup.body).filter(|point| point.plastic).count() as f64 / setup.body.n_points() as f64
        };
        let yielding = check(ring((basis.clone(), law()), &section, cells, mean));
        assert!(yielding > 0.1, "{yielding}");
        check(ring((basis.clone(), Hencky(elasticity())), &section, cells, mean));
        let dilating = MohrCoulomb::new(elasticity(), 5.0, 30.0, 5.0).unwrap();
        check(ring((basis.clone(), dilating), &section, cells, mean));
    }
}

#[test]
fn the_tangent_is_the_derivative_of_the_internal_force() {
    tangent_is_the_derivative(Smpm);
    tangent_is_the_derivative(Gimp::default());
    tangent_is_the_derivative(Cpdi1);
    tangent_is_the_derivative(Cpdi2q::default());
    tangent_is_the_derivative(Cpdi2t::default());
}

/// A body that turns as one is in the state of one that does not.
fn agrees_without_twist<B: Basis<2> + Clone + 'static>(basis: B, law: impl Material + Clone + 'static) {
    for mean in MEANS {
        let (section, layer) = meshes((0.0, 2.0, 6), (0.0, 2.0, 5));
        let make = || {
            ring((basis.clone(), law.clone()), &section, |index| index[0] < 4 && index[1] > 0, mean)
                .with_density(2.0)
                .with_reference_positions()
        };
        let mut plane = connect(boxed(make()), section.clone());
        let mut turning = connect(boxed(make().with_twist()), layer);
        for step in 1..=3 {
            let size = 0.01 * f64::from(step);
            let increment = field(&plane, |x| wave(size, x) * x[0]);
            let turned: Vec<Vector<3>> =
                increment.iter().map(|u| raised(u) + Vector::<3>::new(0.0, 0.0, 0.7)).collect();
            let (expected, found) = (force(&plane, &increment), force(&turning, &turned));
            let expected: Vec<Vector<3>> = expected.iter().map(raised).collect();
            assert!(apart(&flat(&expected), &flat(&found)) < 1e-12, "{} {mean:?}", basis.name());
            (plane, turning) = (advanced(plane, &increment), advanced(turning, &turned));
        }
        let (mut of_plane, mut of_turning) = (Vec::new(), Vec::new());
        for (point, (a, b)) in views(&*plane.body).zip(views(&*turning.body)).enumerate() {
            assert!((raised(&a.position) - b.position).norm() < 1e-14);
            assert!((b.angle.unwrap() - 2.1).abs() < 1e-12 && a.plastic == b.plastic);
            let [tau, of_ring] = [plane.body.kirchhoff(point), turning.body.kirchhoff(point)];
            assert!((tau.to_matrix() - of_ring.to_matrix()).norm() < 1e-10 * tau.norm());
            let numbers = [(a.volume_ratio, b.volume_ratio), (a.reference_size, b.reference_size)];
            assert!(numbers.iter().all(|(a, b)| (a / b - 1.0).abs() < 1e-13));
            assert!((a.hoop_stretch.unwrap() - b.deformation_gradient[(2, 2)]).abs() < 1e-13);
            plane.body.history(point, &mut of_plane);
            turning.body.history(point, &mut of_turning);
        }
        assert!(of_plane.iter().zip(&of_turning).all(|(a, b)| (a - b).abs() < 1e-12));
        assert_eq!(of_plane.len(), of_turning.len());
        // Weight is that of the same rings.
        let weight = |acceleration| BodyLoads { acceleration: Some(acceleration), ..BodyLoads::default() };
        let mut expected = vec![Vector::<2>::zeros(); plane.active.len()];
        let down = Vector::<2>::new(0.0, -9.81);
        plane.body.external_force(plane.plan.connectivity(), &weight(down), &mut expected);
        let mut found = vec![Vector::<3>::zeros(); turning.active.len()];
        let loads = BodyLoads { acceleration: Some(raised(&down)), ..BodyLoads::default() };
        turning.body.external_force(turning.plan.connectivity(), &loads, &mut found);
        let expected: Vec<Vector<3>> = expected.iter().map(raised).collect();
        assert!(apart(&flat(&expected), &flat(&found)) < 1e-12);
    }
}

#[test]
fn what_turns_as_one_is_in_the_state_of_what_does_not_turn() {
    agrees_without_twist(Smpm, law());
    agrees_without_twist(Gimp::default(), law());
    agrees_without_twist(Cpdi1, law());
    agrees_without_twist(Cpdi2q::default(), MohrCoulomb::new(elasticity(), 5.0, 30.0, 5.0).unwrap());
    agrees_without_twist(Cpdi2t::default(), law());
}

#[test]
fn points_that_turn_are_stored_and_restored() {
    let (section, layer) = meshes((0.0, 1.0, 4), (0.0, 1.0, 4));
    let make = || ring((Cpdi2q::default(), law()), &section, |_| true, None).with_twist();
    let rest = connect(boxed(make()), layer);
    let twisted = field(&rest, |x| Vector::<3>::new(0.0, 0.0, 0.3 * x[1] * x[0]));
    let mut setup = advanced(rest, &twisted);
    let stored = setup.body.store();
    let mut other = make();
    other.restore(&stored).unwrap();
    assert_eq!(other.store(), stored);
    assert!(stored.columns.iter().all(|column| column.name != "hoop_stretch"));
    assert!(views(&other).any(|view| view.plastic), "it yields");
    // Splitting keeps the angle of the point.
    let control = DomainControl::Split { cells: 0.3 };
    let done = setup.body.control(&setup.mesh, control, 1000).unwrap();
    assert!(done.split > 0);
    let before: Vec<_> = views(&other).map(|view| view.angle).collect();
    assert!(before.iter().all(|angle| angle.is_some_and(|angle| angle > 0.0)));
    for (view, &(parent, _)) in views(&*setup.body).zip(&done.parts) {
        assert_eq!((view.position[2], view.angle), (0.0, before[parent]));
    }
}

#[test]
fn nothing_reaches_the_axis() {
    let (section, layer) = meshes((0.0, 1.0, 4), (0.0, 1.0, 4));
    let body = ring((Smpm, Hencky(elasticity())), &section, |_| true, None);
    let setup = connect(boxed(body.with_twist()), layer);
    let increment = field(&setup, |x| Vector::<3>::new(-1.2 * x[0], -1.2 * x[1], 0.5));
    let constraints = Constraints::none(setup.active.len());
    let input =
        PassInput { pattern: &setup.pattern, constraints: &constraints, increment: &increment, own: &[] };
    let mut internal = vec![Vector::zeros(); increment.len()];
    let refused =
        setup.body.assemble(&setup.plan, input, Sums { internal: &mut internal, own: &mut [], tangent: None });
    assert!(matches!(refused.unwrap_err().reason, InadmissibleState::ReachesAxis { .. }));
    // Bodies of the plane do not turn.
    let plane = MaterialBody::new(Smpm, Hencky(elasticity()), seed_cells(&Smpm, &section, section.cells(), 1));
    assert!(boxed(plane).with_twist().is_none());
    let von_mises = VonMises::new(elasticity(), 5.0).unwrap();
    assert!(boxed(ring((Smpm, von_mises), &section, |_| true, None)).with_twist().is_some());
}
